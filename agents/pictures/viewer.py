"""Live viewer: controllers throw in MuJoCo's Studio, in a window or in a browser, until the viewer is closed."""

from __future__ import annotations

import copy
import socket
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Final, final

import numpy as np
from mujoco.studio import app, launch_passive, messages, plugin, viewer_protocol
from mujoco.studio.dear_imgui import dear_imgui as imgui

from pnt_gym.arrays import concatenate_records
from pnt_gym.cells.base.canvas import Frame, Marker
from pnt_gym.cells.base.look import write_shape
from pnt_gym.cells.base.view import Scene, ThrowView
from pnt_gym.engine import mujoco
from pnt_gym.errors import PntGymError

from ..controllers import NAMES
from ..ground import metrics
from ..ground.cli import UsageError
from ..ground.tables import console
from ..judging.throws import Throws
from . import door, web
from .stage import Stage

RATE: Final = 60
"""Scenes shown per second."""
TITLE: Final = "Sorting by throwing"
SIDE, ZOOM = 72, 1.5
"""Sides of the pictures of a grasp, in their own pixels, and the size of such a pixel on the screen."""
SHAPE: Final = ("geom_type", "geom_size", "geom_pos", "geom_quat", "geom_rgba")
"""Arrays of a MuJoCo model that may differ between throws."""
REFUSED: Final = "the viewer shows throws alone, and loads no model"
STATE: Final = int(mujoco.mjtState.mjSTATE_INTEGRATION)


@final
@dataclass(frozen=True)
class Choice(messages.Event):
    """Choice of the controller and the level."""

    controller: str
    level: str


@final
@dataclass(frozen=True)
class Shown(messages.Snapshot):
    """Markers, text and small pictures shown beside the simulation, and MuJoCo's camera on the cell."""

    shapes: Sequence[Marker]
    lines: Sequence[str]
    camera: Any
    pictures: Sequence[Frame] = ()


@final
class Panel(plugin.ViewerPlugin):
    """Panel with figures and menus of controllers and levels; runs in the drawing thread.

    Args:
        choice: first controller and level.
        levels: names of the levels in the menu.
    """

    def __init__(self, choice: Choice, levels: Sequence[str]) -> None:
        offered = {"controller": [choice.controller, *NAMES], "level": [choice.level, *levels]}
        self._offered = {name: list(dict.fromkeys(values)) for name, values in offered.items()}
        self._choice = choice
        self._shown: Shown | None = None

    @messages.handler
    def on_shown(self, shown: Shown) -> None:
        """Take over figures and markers of the last throw; the first time also the camera of the cell's pictures."""
        if self._shown is None:
            for name in ("lookat", "distance", "azimuth", "elevation"):
                setattr(self.viewer.camera, name, getattr(shown.camera, name))
        self._shown = shown

    @messages.handler
    def on_update(self, _: messages.UpdateEvent) -> None:
        """Draw the markers."""
        self.viewer.extra_geoms[:] = map(_make, self._shown.shapes if self._shown else ())

    @messages.handler
    def on_build_gui(self, _: messages.BuildGuiEvent) -> None:
        """Draw the panel."""
        imgui.SetNextWindowPos(imgui.Vec2(16, 70), imgui.Cond.Once)
        imgui.SetNextWindowSize(imgui.Vec2(360, 280), imgui.Cond.Once)
        if imgui.Begin(TITLE):
            for name, offered in self._offered.items():
                changed, index = imgui.Combo(name, offered.index(getattr(self._choice, name)), offered)
                if changed:
                    self._choice = replace(self._choice, **{name: offered[index]})
                    self.viewer.send_to_sim(self._choice)
            for line in self._shown.lines if self._shown else ():
                imgui.TextUnformatted(line)
            for number, picture in enumerate(self._shown.pictures if self._shown else ()):
                if number > 0:
                    imgui.SameLine()
                _draw(picture)
        imgui.End()


@final
class ViewerRequests(plugin.SimPlugin):
    """Requests of the viewer to the simulation: controller, level and speed.

    Args:
        choice: first controller and level.
    """

    def __init__(self, choice: Choice) -> None:
        self.choice = choice
        self.speed = 1.0
        """Speed relative to real time; 0 for a pause."""
        self.note = ""
        """What the viewer is told about its last request; empty for a request that was met."""

    @messages.handler
    def on_choice(self, choice: Choice) -> None:
        """Take over another controller or level."""
        self.choice = choice

    @messages.handler
    def on_load_model(self, _: messages.LoadModelEvent) -> bool:
        """Refuse a model that was dropped on the viewer: the request goes no further, and MuJoCo opens no file."""
        self.note = REFUSED
        return True

    @messages.handler
    def on_step_control(self, control: messages.StepControlSnapshot) -> None:
        """Take over pause and speed from Studio's buttons."""
        runs = control.pause_state == type(control.pause_state).UNPAUSED
        self.speed = control.speed / 100.0 if runs else 0.0


@final
class Film:
    """Display of throws with one model: geoms that differ between throws are hidden in it and drawn as markers.

    A new model for each throw would make a browser reload its page every second.

    Args:
        viewer: viewer of MuJoCo's Studio.
        camera: MuJoCo's camera on the cell.
    """

    def __init__(self, viewer: Any, camera: Any) -> None:
        self._viewer, self._camera = viewer, camera
        self._first: Any = None
        self._hidden: Any = None

    def show(self, scene: Scene, lines: Sequence[str], pictures: Sequence[Frame] = ()) -> None:
        """Show one moment of a throw, with lines of text and small pictures."""
        model, data, markers = scene
        # Hide the geoms that differ from the first throw's model.
        begins = self._first is None
        if begins:
            self._first, self._hidden = copy.copy(model), np.zeros(model.ngeom, dtype=np.bool_)
        differs = [getattr(model, name) != getattr(self._first, name) for name in SHAPE]
        hidden = self._hidden | np.any([column.reshape(model.ngeom, -1).any(axis=1) for column in differs], axis=0)
        if begins or (hidden != self._hidden).any():
            self._hidden, shown = hidden, copy.copy(self._first)
            shown.geom_rgba[hidden, 3] = 0.0
            self._viewer.set_model(shown)
        separate = np.flatnonzero(self._hidden & (model.geom_rgba[:, 3] > 0.0))
        shapes = [*markers, *(_shape(model, data, int(geom)) for geom in separate)]
        self._viewer.send_to_viewer(Shown(shapes, lines, self._camera, pictures))
        state = np.empty(mujoco.mj_stateSize(model, STATE))
        mujoco.mj_getState(model, data, state, STATE)
        mujoco.mj_setState(self._viewer.model, self._viewer.data, state, STATE)
        self._viewer.sync()


def watch(make: Callable[[Choice], Stage], choice: Choice, front: socket.socket | None) -> None:
    """Show throws until the viewer is closed.

    Args:
        make: returns the stage of a choice.
        choice: first controller and level.
        front: listening socket at which a page for browsers is served; None opens a window.

    Raises:
        PntGymError: the first choice cannot be shown.
    """
    stage, requests = make(choice), ViewerRequests(choice)
    try:
        if not isinstance(stage.view, ThrowView):
            raise UsageError("only pictures by pnt_gym.cells.base.view.ThrowView can be shown live")
        with _launch(front, [Panel(choice, stage.core.config.level_names()), requests]) as viewer:
            while _play(viewer, stage, requests):
                try:
                    following, requests.note = make(requests.choice), ""
                except PntGymError as error:
                    requests.note = f"{error}; still showing the one before"
                else:
                    stage.close()
                    stage = following
    finally:
        stage.close()


def _launch(front: socket.socket | None, plugins: Sequence[plugin.Plugin]) -> Any:
    """MuJoCo's viewer with its toolbar and with plugins: a page at a socket, or a window."""
    studio = app.App(app.Config(show_options=False, show_inspector=False, show_toolbar=True))
    config = viewer_protocol.ViewerConfig(title=TITLE)
    if front is None:
        return launch_passive.launch(config, plugins=[studio, *plugins])
    console().print(f"page at {door.page_url(front)}")
    return web.launch(front, config, plugins=[studio, *plugins])


def _play(viewer: Any, stage: Stage, requests: ViewerRequests) -> bool:
    """Show throws until the viewer is closed (False) or another choice is made (True)."""
    film, chosen, throws, credit = Film(viewer, stage.view.camera), requests.choice, list[Throws](), 0.0
    for throw in stage.steps:
        throws.append(throw)
        # Lines of text about the last throw and about all throws.
        last, every = throws[-1], concatenate_records(throws)
        rate = metrics.wilson(int(every.is_success.sum()), len(every))
        pace = metrics.throughput(every.sorted, every.cycle_time)
        off = f"{1000.0 * last.landing_error[0]:.1f} mm off" if last.picked[0] else "not picked"
        success = "a success" if last.is_success[0] else "no success"
        summary = [
            f"throw {len(throws)}: {stage.core.item_names[last.item[0]]}, {off}, {success}",
            f"success {rate.value:.0%} ({rate.low:.0%} to {rate.high:.0%})",
            f"{pace.attempted:.1f} picks/min, {pace.sorted:.1f} sorted/min",
        ]
        grasp = None if stage.seen is None else stage.seen.grasp
        pictures = [] if grasp is None else grasp.panels(SIDE)
        for scene in stage.view.scenes(RATE):
            credit -= 1.0
            while credit < 0.0:
                began = time.perf_counter()
                film.show(scene, [*summary, requests.note], pictures)
                if not viewer.is_running() or requests.choice != chosen:
                    return viewer.is_running()
                time.sleep(max(1.0 / RATE - (time.perf_counter() - began), 0.0))
                credit += requests.speed
    return False


def _draw(picture: Frame) -> None:
    """Draw a picture in the panel, neighbours of one colour in a row as one rectangle."""
    corner, drawing = imgui.GetCursorScreenPos(), imgui.GetWindowDrawList()
    colours = picture.astype(np.int64) @ [1, 256, 65536] + 0xFF000000
    for row, line in enumerate(colours):
        edges = [0, *(np.flatnonzero(np.diff(line)) + 1).tolist(), len(line)]
        for begin, end in pairwise(edges):
            drawing.AddRectFilled(
                imgui.Vec2(corner.x + ZOOM * begin, corner.y + ZOOM * row),
                imgui.Vec2(corner.x + ZOOM * end, corner.y + ZOOM * (row + 1)),
                int(line[begin]),
            )
    imgui.Dummy(imgui.Vec2(ZOOM * picture.shape[1], ZOOM * len(picture)))


def _make(marker: Marker) -> Any:
    geom = mujoco.MjvGeom()
    write_shape(geom, *marker.shape)
    return geom


def _shape(model: Any, data: Any, geom: int) -> Marker:
    frame, rgba = data.geom_xmat[geom].copy(), model.geom_rgba[geom].copy()
    return Marker(int(model.geom_type[geom]), model.geom_size[geom].copy(), data.geom_xpos[geom].copy(), frame, rgba)
