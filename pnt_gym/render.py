"""Pictures: a frame of the cell, the last throw at its true rate, a video with the planned and the flown path.

Rendering is offscreen (EGL on machines without a display). Physics needs none of this.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.conveyor import ConveyorCell
from pnt_gym.cells.fluid import geom_placement
from pnt_gym.cells.objects import Objects
from pnt_gym.cells.recording import Recording
from pnt_gym.engine import MjData, MjModel, has_display, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.planning.arrays import Floats

Frame = NDArray[np.uint8]

RENDER_MODES: Final = ("rgb_array", "rgb_array_list", "human")
FPS: Final = 30
_SIZE: Final = (720, 1280)
_PLANNED: Final = np.array([0.10, 0.45, 0.90, 0.9])
_FLOWN: Final = np.array([0.95, 0.35, 0.10, 1.0])
_WAITING: Final = np.array([0.93, 0.80, 0.36, 1.0])
_LIBRARIES: Final = (
    "rendering needs an OpenGL library: install EGL (Debian and Ubuntu: apt-get install libegl1 libgl1-mesa-dri), "
    "or set MUJOCO_GL=osmesa with libosmesa6"
)


def camera() -> Any:
    """The standard view: belt, robot and bins from the front left."""
    view = mujoco.MjvCamera()
    view.lookat[:] = [-0.02, 0.10, -0.38]
    view.distance, view.azimuth, view.elevation = 3.3, 146.0, -19.0
    return view


@final
@dataclass(frozen=True)
class Marker:
    """A shape that is drawn and not simulated."""

    type: int
    size: Floats
    position: Floats
    frame: Floats
    """Rotation matrix (9,)."""
    rgba: Floats

    def add_to(self, scene: Any) -> None:
        """Add the shape to a scene that has room for it."""
        if scene.ngeom >= scene.maxgeom:
            return
        geom = scene.geoms[scene.ngeom]
        mujoco.mjv_initGeom(geom, self.type, self.size, self.position, self.frame, self.rgba.astype(np.float32))
        scene.ngeom += 1


@final
class CellView:
    """Offscreen pictures and the interactive window of one conveyor cell.

    Args:
        cell: the cell; row 0 is recorded from now on.
        size: height and width of a frame [pixels].

    Raises:
        ConfigError: no OpenGL library could be loaded.
    """

    def __init__(self, cell: ConveyorCell, size: tuple[int, int] = _SIZE) -> None:
        self._cell = cell
        self._camera = camera()
        self._size = size
        self._renderer: Any = None
        self._window: Any = None
        self._window_threads: set[threading.Thread] = set()
        cell.plant.record_row = 0

    def frame(self, row: int = 0) -> Frame:
        """The coming pick of one cell, (height, width, 3)."""
        model, data = self._cell.plant.pose(self._cell.context, row)
        return self._draw(model, data, self._belt(self._cell.waiting(row), 0.0))

    def last_throw(self, fps: int = FPS) -> list[Frame]:
        """Frames of the last throw of row 0 at true rate; empty before the first throw."""
        recording = self._cell.plant.recording
        return [] if recording is None else list(self._frames(recording, 1.0 / fps))

    def render(self, mode: str) -> Frame | list[Frame]:
        """What Gymnasium's `render` returns for rgb_array and rgb_array_list."""
        return self.frame() if mode == "rgb_array" else self.last_throw()

    def show(self) -> None:
        """Play the last throw in a window in real time.

        Raises:
            ConfigError: there is no display.
        """
        recording = self._cell.plant.recording
        model, data = self._cell.plant.pose(self._cell.context, 0)
        if self._window is None:
            others = set(threading.enumerate())
            self._window = _open_window(model, data)
            self._window_threads = set(threading.enumerate()) - others
            self._window_model, self._window_data = model, data
        if recording is None:
            return
        for shown, _ in recording.play(1.0 / FPS):
            started = time.perf_counter()
            with self._window.lock():
                self._cell.plant.batch.get_model(0, self._window_model)
                self._window_data.qpos[:] = shown.qpos
                mujoco.mj_forward(self._window_model, self._window_data)
            self._window.sync()
            time.sleep(max(1.0 / FPS - (time.perf_counter() - started), 0.0))

    def close(self) -> None:
        """Free renderer and window; safe to call twice."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
        if self._window is not None:
            self._window.close()
            for thread in self._window_threads:  # one that still draws when Python ends crashes the process
                thread.join(timeout=5.0)
            self._window = None
        self._cell.plant.record_row = None

    def _frames(self, recording: Recording, interval: float) -> Iterator[Frame]:
        planned = [_dot(p, _PLANNED, 0.006) for p in recording.plan]
        for data, trail in recording.play(interval):
            flown = [_dot(p, _FLOWN, 0.008) for p in trail]
            belt = self._belt(self._cell.upstream, float(data.time))
            yield self._draw(recording.model, data, planned + flown + belt)

    def _belt(self, upstream: tuple[Objects, Floats] | None, time: float) -> list[Marker]:
        """The objects on the belt after a time [s], which the physics does not simulate before they are picked."""
        if upstream is None:
            return []
        objects, centre = upstream
        belt = self._cell.config.belt
        moved = centre + np.array([belt.speed * time, 0.0, 0.0])
        place = geom_placement(objects.shape, objects.size)
        turned, frame = np.zeros(4), np.zeros(9)
        markers: list[Marker] = []
        for k in np.flatnonzero((moved[:, 0] >= belt.x[0]) & (moved[:, 0] <= belt.x[1])):
            half = objects.yaw[k] / 2
            mujoco.mju_mulQuat(turned, np.array([np.cos(half), 0.0, 0.0, np.sin(half)]), place.quat[k])
            mujoco.mju_quat2Mat(frame, turned)
            markers.append(Marker(int(place.type[k]), place.size[k], moved[k], frame.copy(), _WAITING))
        return markers

    def _draw(self, model: MjModel, data: MjData, markers: Iterable[Marker]) -> Frame:
        renderer = self._opened(model)
        renderer.update_scene(data, self._camera)
        for marker in markers:
            marker.add_to(renderer.scene)
        return renderer.render().copy()

    def _opened(self, model: MjModel) -> Any:
        """The renderer for this model; every simulation's model has the same layout and is drawn by the same one."""
        if self._renderer is None:
            self._renderer = _new_renderer(model, self._size)
            self._renderer._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        self._renderer._model = model
        return self._renderer


def rendering_problem() -> str | None:
    """Why this machine cannot draw, in one sentence; None if it can."""
    try:
        _new_renderer(mujoco.MjSpec().compile(), (8, 8)).close()
    except ConfigError as error:
        return str(error)
    return None


def record_video(cell: ConveyorCell, throws: Iterable[object], path: str | Path, fps: int = FPS) -> Path:
    """Write a true-rate video of throws.

    Args:
        cell: the cell whose row 0 is filmed.
        throws: an iterable that carries out one throw per item, e.g. a generator that steps an environment.
        path: the .mp4 file.
        fps: frames per second.

    Raises:
        ConfigError: no OpenGL library, or imageio with ffmpeg is not installed.
    """
    try:
        import imageio.v3 as iio  # noqa: PLC0415  # pyright: ignore[reportMissingTypeStubs]
    except ImportError:
        raise ConfigError("video needs imageio with ffmpeg: pip install 'pnt_gym[video]'") from None
    target = Path(path)
    view = CellView(cell)
    try:
        frames = [frame for _ in throws for frame in view.last_throw(fps)]
    finally:
        view.close()
    if not frames:
        raise ConfigError("a video needs at least one throw, got 0")
    writer: Any = iio
    target.parent.mkdir(parents=True, exist_ok=True)
    writer.imwrite(target, np.stack(frames), fps=fps, codec="libx264")
    return target


def _new_renderer(model: MjModel, size: tuple[int, int]) -> Any:
    """An offscreen renderer.

    Raises:
        ConfigError: no OpenGL library could be loaded.
    """
    if not has_display() and os.environ.get("MUJOCO_GL", "glfw") == "glfw":
        raise ConfigError(_LIBRARIES)  # asking GLFW here would abort the process
    try:
        return mujoco.Renderer(model, *size)
    except Exception as error:
        raise ConfigError(f"{_LIBRARIES} ({type(error).__name__}: {error})") from None


def _dot(position: Floats, rgba: Floats, radius: float) -> Marker:
    return Marker(int(mujoco.mjtGeom.mjGEOM_SPHERE.value), np.full(3, radius), position, np.eye(3).ravel(), rgba)


def _open_window(model: MjModel, data: MjData) -> Any:
    if not has_display():
        raise ConfigError("render_mode 'human' needs a display; use 'rgb_array' on a headless machine")
    from mujoco import viewer  # noqa: PLC0415  # pyright: ignore[reportMissingTypeStubs]

    window: Any = viewer
    return window.launch_passive(model, data, show_left_ui=False, show_right_ui=False)


if __name__ == "__main__":
    print(rendering_problem() or "rendering works on this machine")
