"""A controller at work on a line, watched in a browser: `pnt-gym play --viewer web`."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from html import escape
from time import monotonic, sleep
from typing import Any, Final

from pnt_gym.cells.line.config import LineConfig

from ..pictures.door import open_front
from ..pictures.stage import Stage
from . import figures, films
from .gate import announce, close_server, new_token, open_server
from .scene import BeltScene

TITLE: Final = "pnt-gym play"
VIEWS: Final = ("3D", "from above")


def show(address: str, controller: str, open_stage: Callable[[], Stage]) -> None:
    """Show shift after shift of a line in real time, until the command is ended.

    Args:
        address: address of this machine at which the page is served.
        controller: name of the controller.
        open_stage: opens one line with the controller, after its practice.

    Raises:
        UsageError: nothing can be served at the address.
    """
    with ExitStack() as ends:
        stage = ends.enter_context(closing(open_stage()))
        front, token = ends.enter_context(open_front(address)), new_token()
        server = open_server(front, token, TITLE)
        ends.callback(close_server, server)
        line: LineConfig = stage.core.config
        scene = BeltScene(server, lambda change: None)
        scene.draw(line)
        scene.show_handles(False)
        server.gui.add_html(figures.page_part(f"{escape(line.name)}, {escape(controller)}"))
        views = server.gui.add_button_group("view", VIEWS)

        def turn(event: Any) -> None:
            if event.client is not None:
                scene.look(line, event.client.camera, event.target.value == VIEWS[1])

        views.on_click(turn)
        announce(front, token, "line", True)
        begin = monotonic()
        for number, moment in enumerate(films.frames(stage)):
            scene.show(moment)
            sleep(max(begin + number / films.RATE - monotonic(), 0.0))
