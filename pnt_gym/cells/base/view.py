"""Pictures of a cell, playback of a throw in a window, and videos."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.canvas import FPS, SIZE, Canvas, Frame, Marker, Picture, Window
from pnt_gym.cells.base.plant import Plant, Recording
from pnt_gym.engine import MjData, MjModel
from pnt_gym.errors import ConfigError
from pnt_gym.palette import FLIGHT, PLAN, TARGET

Scene = tuple[MjModel, MjData, list[Marker]]
"""Model, state, and markers that are drawn beside them."""
_PLAN, _FLIGHT, _TARGET = (np.array(colour) for colour in (PLAN, FLIGHT, TARGET))


class Filmed(Protocol):
    """A simulated cell that can be drawn."""

    @property
    def item_names(self) -> Sequence[str]:
        """Names of the items, in the order of their kinds."""
        ...

    @property
    def plant(self) -> Plant[Any, Any, Any]:
        """The physics of the cell."""
        ...

    def pose(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation before the coming throw."""
        ...

    def target(self, row: int) -> Floats:
        """Target point of the coming throw (3,) [m]."""
        ...

    def markers(self, row: int) -> list[Marker]:
        """Shapes that are drawn beside the simulation before the coming throw."""
        ...

    def markers_at(self, time: float) -> list[Marker]:
        """Shapes that are drawn beside the simulation in the recorded throw, after a time [s]."""
        ...


class View(Protocol):
    """Pictures of a cell, as environments and films use them."""

    def aim(self, picture: Picture, samples: int = 1) -> None:
        """Set size and camera of all pictures from now on, and the number of drawings whose mean a picture is."""

    def draw(self, scene: Scene) -> Frame:
        """Picture of a scene (height, width, 3)."""
        ...

    def frame(self, row: int = 0) -> Frame:
        """Picture of one row before the coming step (height, width, 3)."""
        ...

    def last_throw(self, fps: int = FPS) -> list[Frame]:
        """Frames of the last step of row 0 at true rate."""
        ...

    def at(self, moment: float, fps: int = FPS) -> Frame:
        """Frame at a moment [s] of the last step of row 0."""
        ...

    def render(self, mode: str) -> Frame | list[Frame]:
        """Result of Gymnasium's `render` for rgb_array and rgb_array_list."""
        return self.frame() if mode == "rgb_array" else self.last_throw()

    def show(self) -> None:
        """Play the last step in a window in real time."""

    def close(self) -> None:
        """Free all resources of rendering; safe to call twice."""


@final
class ThrowView(View):
    """Offscreen pictures and the interactive window of a cell.

    The planned flight is blue, the simulated flight orange, and the target green.

    Args:
        cell: the simulated cells; row 0 is recorded from now on.
        camera: MuJoCo's camera.
        dots: size of the flights' dots, 1 for a cell some metres wide.
        size: height and width of a frame [pixels].
        around: what stands around the cell in offscreen pictures.
    """

    def __init__(
        self,
        cell: Filmed,
        camera: Any,
        dots: float = 1.0,
        size: tuple[int, int] = SIZE,
        around: Sequence[Marker] = (),
    ) -> None:
        self._cell, self._dots, self._around = cell, dots, list(around)
        self._canvas = Canvas(camera, size, cell.item_names)
        self._window: Window | None = None
        cell.plant.record_row = 0

    def aim(self, picture: Picture, samples: int = 1) -> None:
        """Set size and camera of all pictures from now on, and the number of drawings whose mean a picture is."""
        self._canvas.aim(picture, samples)

    def draw(self, scene: Scene) -> Frame:
        """Picture of a scene (height, width, 3)."""
        return self._canvas.draw(*scene)

    def frame(self, row: int = 0) -> Frame:
        """Picture of one cell before the coming throw (height, width, 3).

        Raises:
            ConfigError: no OpenGL library could be loaded.
        """
        model, data = self._cell.pose(row)
        return self._canvas.draw(
            model, data, [self._goal(self._cell.target(row)), *self._cell.markers(row), *self._around]
        )

    def last_throw(self, fps: int = FPS) -> list[Frame]:
        """Frames of the last throw of row 0 at true rate; empty before the first throw."""
        return [self._canvas.draw(*scene) for scene in self.scenes(fps)]

    def at(self, moment: float, fps: int = FPS) -> Frame:
        """Frame at a moment [s] of the last throw of row 0; the last frame if the moment is after the throw.

        Only this frame is drawn: drawing takes far longer than simulating the throw twice.

        Raises:
            ConfigError: nothing was thrown yet, or no OpenGL library could be loaded.
        """
        recording = self._cell.plant.recording
        if recording is None:
            raise ConfigError("there is no throw to draw yet; step the environment first")
        last = sum(1 for _ in recording.play(1.0 / fps)) - 1
        number = round(min(last, fps * moment))
        return self._canvas.draw(*next(islice(self.scenes(fps), number, None)))

    def show(self) -> None:
        """Play the last throw in a window in real time.

        Raises:
            ConfigError: there is no display.
        """
        recording = self._cell.plant.recording
        model, data = self._cell.pose(0)
        if self._window is None:
            self._window = Window(model, data)
        if recording is not None:
            self._window.play(
                (state for state, _ in recording.play(1.0 / FPS)), partial(self._cell.plant.batch.get_model, 0)
            )

    def close(self) -> None:
        """Free renderer and window; safe to call twice."""
        self._canvas.close()
        if self._window is not None:
            self._window.close()
            self._window = None
        self._cell.plant.record_row = None

    @property
    def camera(self) -> Any:
        """MuJoCo's camera on the cell."""
        return self._canvas.camera

    @property
    def recording(self) -> Recording | None:
        """The last throw of row 0; None before the first."""
        return self._cell.plant.recording

    def scenes(self, fps: int = FPS) -> Iterator[Scene]:
        """Model, state and markers of every frame of the last throw of row 0; each is valid until the next is taken."""
        recording = self._cell.plant.recording
        if recording is None:
            return
        goal = [self._goal(recording.target)]
        plan = [Marker.dot(p, _PLAN, 0.006 * self._dots) for p in recording.plan]
        for data, trail in recording.play(1.0 / fps):
            flight = [Marker.dot(p, _FLIGHT, 0.008 * self._dots) for p in trail]
            yield recording.model, data, goal + plan + flight + self._cell.markers_at(float(data.time)) + self._around

    def _goal(self, target: Floats) -> Marker:
        return Marker.dot(target, _TARGET, 0.016 * self._dots)


def record_video(view: View, throws: Iterable[object], path: str | Path, fps: int = FPS, slow: int = 1) -> Path:
    """Write a video of throws, at true rate or slower.

    Args:
        view: films row 0 of its cells, e.g. `core.view()`; it is closed at the end.
        throws: an iterable that carries out one throw per item, e.g. a generator that steps an environment.
        path: the .mp4 file.
        fps: frames per second.
        slow: factor by which the video is slower than real time.

    Raises:
        ConfigError: no OpenGL library, or imageio with ffmpeg is not installed.
    """
    try:
        check_video()
        frames = [frame for _ in throws for frame in view.last_throw(fps * slow)]
    finally:
        view.close()
    if not frames:
        raise ConfigError("a video needs at least one throw, got 0")
    return write_video(frames, path, fps)


def check_video() -> None:
    """Make sure that a video can be written, before the first frame is drawn.

    Raises:
        ConfigError: imageio with ffmpeg is not installed.
    """
    _video_writer()


def write_video(frames: Sequence[Frame], path: str | Path, fps: int) -> Path:
    """Write a video.

    Args:
        frames: pictures of one size.
        path: the .mp4 file.
        fps: frames per second.

    Raises:
        ConfigError: imageio with ffmpeg is not installed.
    """
    writer, target = _video_writer(), Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    # H.264 needs even sizes; imageio would stretch a frame to whole blocks of 16 pixels.
    # At its quality of 4.5, of ten, half the bytes of its usual 5 show the same to the eye: x264's factor 28, not 25.
    writer.imwrite(target, frames, fps=fps, codec="libx264", macro_block_size=2, quality=4.5)
    return target


def _video_writer() -> Any:
    try:
        import imageio.v3 as iio  # noqa: PLC0415  # pyright: ignore[reportMissingTypeStubs]
    except ImportError:
        raise ConfigError("video needs imageio with ffmpeg: pip install 'pnt_gym[video]'") from None
    return iio
