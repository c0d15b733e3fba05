"""The page: one server, one session, and threads that compute, paint and play."""

from __future__ import annotations

import socket
from collections.abc import Callable
from functools import partial
from time import monotonic, sleep
from typing import Any, Final, final

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import PntGymError

from ..ground.cli import UsageError
from . import films, level_files, report, share
from .gate import close_server, open_server
from .panel import PLACES, STEPS, VIEWS, Panel
from .scene import BeltScene
from .session import Session, State
from .worker import Worker

TITLE: Final = "pnt-gym design"
SHOWN: Final = 12.0
"""Time of a shift that is played [s]."""


@final
class Page:
    """A page that serves one design to all of its browsers.

    Args:
        line: the first design.
        front: listening socket.
        token: secret that browsers need.

    Raises:
        UsageError: this version of viser serves otherwise.
    """

    def __init__(self, line: LineConfig, front: socket.socket, token: str) -> None:
        self._painter, self._player = Worker(), Worker()
        self._is_ready = False
        self.session = Session(line, self._tell)
        self.server = open_server(front, token, TITLE)
        self._scene = BeltScene(self.server, self.session.change)
        self._panel = Panel(self.server, self.session)
        self._panel.views.on_click(self._view)
        self._panel.steps.on_click(self._step)
        self._panel.places.on_click(self._improve)
        with self._panel.files:
            self._add_files()
        self._is_ready = True
        self._tell(self.session.state)

    def close(self) -> None:
        """End the page and its threads; safe to call twice."""
        for worker in (self._player, self._painter):
            worker.close()
        self.session.close()
        close_server(self.server)

    def _tell(self, state: State) -> None:
        """Paint the newest state soon."""
        del state
        if self._is_ready:
            self._painter.ask(self._paint)

    def _paint(self, is_stale: Callable[[], bool]) -> None:
        del is_stale
        state = self.session.state
        self._scene.draw(state.line)
        self._scene.landings(state.answer if state.is_current else None)
        self._panel.show(state)

    def _view(self, event: Any) -> None:
        if event.target.value == VIEWS[-1]:
            self._player.ask(self._play)
        elif event.client is not None:
            self._scene.look(self.session.state.line, event.client.camera, event.target.value == VIEWS[1])

    def _step(self, event: Any) -> None:
        dict(zip(STEPS, (self.session.undo, self.session.redo, self.session.keep), strict=True))[event.target.value]()

    def _improve(self, event: Any) -> None:
        what = event.target.value
        if what == PLACES[-1]:
            self.session.end_search()
        else:
            self.session.improve(what)

    def _add_files(self) -> None:
        """Add the buttons of files: what is saved goes through the browser's download."""
        gui = self.server.gui
        self._button(
            "save as YAML",
            lambda state: (f"{state.line.name}.yaml", level_files.text_of_line(state.line).encode()),
            "a level file for `pnt-gym line plan --level FILE.yaml`",
        )
        upload = gui.add_upload_button("open YAML", mime_type=".yaml,.yml")
        upload.on_upload(lambda event: self._open(event.target.value))
        self._button(
            "share as one HTML file", self._share, "the scene and its figures, for any browser, without a server"
        )
        self._button(
            "report as HTML",
            lambda state: (f"{state.line.name}_report.html", report.html(state).encode()),
            "two pages: drawing, figures, settings and assumptions",
        )
        if report.browser() is not None:
            self._button(
                "report as PDF", lambda state: (f"{state.line.name}_report.pdf", report.pdf(report.html(state)))
            )

    def _button(self, label: str, make: Callable[[State], tuple[str, bytes]], hint: str | None = None) -> None:
        """Add a button that makes a file, which the browser that asked for it downloads."""

        def act(event: Any) -> None:
            try:
                name, content = make(self.session.state)
            except PntGymError as error:
                self.session.refuse(error)
            except ModuleNotFoundError as error:
                self.session.refuse(UsageError(f"this needs {error.name}: pip install 'pnt_gym[report]'"))
            else:
                event.client.send_file_download(name, content, save_immediately=True)

        self.server.gui.add_button(label, hint=hint).on_click(act)

    def _open(self, file: Any) -> None:
        self.session.begin(partial(level_files.line_of_file, file.content, file.name))

    def _share(self, state: State) -> tuple[str, bytes]:
        self._scene.show_handles(False)
        try:
            page = self.server.scene.as_html()
        finally:
            self._scene.show_handles(True)
        return f"{state.line.name}.html", share.html(page, state).encode()

    def _play(self, is_stale: Callable[[], bool]) -> None:
        """Play the begin of a shift of the design, until the design changes."""
        state, begin = self.session.state, monotonic()
        for number, moment in enumerate(films.play(state.line, SHOWN)):
            if is_stale() or self.session.state.number != state.number:
                break
            self._scene.show(moment)
            sleep(max(begin + number / films.RATE - monotonic(), 0.0))
        self._scene.rest()
