"""What environments and videos ask of a picture of a cell, and what the pictures of all cells have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np

from pnt_gym.engine import MjData, MjModel
from pnt_gym.errors import ConfigError
from pnt_gym.planning.arrays import Floats
from pnt_gym.render.canvas import FPS, SIZE, Canvas, Frame, Marker, Window

_PLANNED: Final = np.array([0.10, 0.45, 0.90, 0.9])
_FLOWN: Final = np.array([0.95, 0.35, 0.10, 1.0])


class View(Protocol):
    """Pictures of N cells; row 0 is recorded as long as the view is open."""

    def frame(self, row: int = 0) -> Frame:
        """The coming throw of one cell, (height, width, 3)."""
        ...

    def last_throw(self, fps: int = FPS) -> list[Frame]:
        """Frames of the last throw of row 0 at true rate; empty before the first throw."""
        ...

    def render(self, mode: str) -> Frame | list[Frame]:
        """What Gymnasium's `render` returns for rgb_array and rgb_array_list."""
        ...

    def show(self) -> None:
        """Play the last throw in a window in real time.

        Raises:
            ConfigError: there is no display.
        """
        ...

    def close(self) -> None:
        """Free renderer and window; safe to call twice."""
        ...


class Playable(Protocol):
    """A recorded throw that can be stepped through again."""

    @property
    def model(self) -> MjModel:
        """The simulation's own model."""
        ...

    @property
    def plan(self) -> Floats:
        """The planned flight (K, 3) [m]."""
        ...

    def play(self, interval: float) -> Iterator[tuple[MjData, Floats]]:
        """Pause about every `interval` [s]: the simulation and the trail so far of what was thrown (K, 3) [m]."""
        ...


class ThrowView(ABC):
    """Abstract: a view that draws the planned flight in blue and the flown one in orange.

    Subclasses say where the simulations stand and what else is to be drawn.

    Args:
        camera: MuJoCo's camera.
        size: height and width of a frame [pixels].
    """

    dots: float = 1.0
    """Size of the flights' dots, 1 for a cell some metres wide."""

    def __init__(self, camera: Any, size: tuple[int, int] = SIZE) -> None:
        self._canvas = Canvas(camera, size)
        self._window: Window | None = None
        self._record(0)

    @abstractmethod
    def _record(self, row: int | None) -> None:
        """Keep the throws of a row from now on; None keeps nothing."""

    @abstractmethod
    def _recording(self) -> Playable | None:
        """The last throw that was kept."""

    @abstractmethod
    def _pose(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation as it stands before the coming throw."""

    @abstractmethod
    def _write_model(self, model: MjModel) -> None:
        """Write the model of row 0 into the given one, which has the same layout."""

    def _markers(self, row: int) -> list[Marker]:
        """What is drawn beside the simulation before the coming throw."""
        return []

    def _markers_at(self, time: float) -> list[Marker]:
        """What is drawn beside the simulation in the recorded throw, after a time [s]."""
        return []

    def frame(self, row: int = 0) -> Frame:
        """The coming throw of one cell, (height, width, 3).

        Raises:
            ConfigError: no OpenGL library could be loaded.
        """
        model, data = self._pose(row)
        return self._canvas.draw(model, data, self._markers(row))

    def last_throw(self, fps: int = FPS) -> list[Frame]:
        """Frames of the last throw of row 0 at true rate; empty before the first throw."""
        recording = self._recording()
        return [] if recording is None else list(self._frames(recording, 1.0 / fps))

    def render(self, mode: str) -> Frame | list[Frame]:
        """What Gymnasium's `render` returns for rgb_array and rgb_array_list."""
        return self.frame() if mode == "rgb_array" else self.last_throw()

    def show(self) -> None:
        """Play the last throw in a window in real time.

        Raises:
            ConfigError: there is no display.
        """
        recording = self._recording()
        model, data = self._pose(0)
        if self._window is None:
            self._window = Window(model, data)
        if recording is not None:
            self._window.play((shown for shown, _ in recording.play(1.0 / FPS)), self._write_model)

    def close(self) -> None:
        """Free renderer and window; safe to call twice."""
        self._canvas.close()
        if self._window is not None:
            self._window.close()
            self._window = None
        self._record(None)

    def _frames(self, recording: Playable, interval: float) -> Iterator[Frame]:
        planned = [Marker.dot(p, _PLANNED, 0.006 * self.dots) for p in recording.plan]
        for data, trail in recording.play(interval):
            flown = [Marker.dot(p, _FLOWN, 0.008 * self.dots) for p in trail]
            yield self._canvas.draw(recording.model, data, planned + flown + self._markers_at(float(data.time)))


def record_video(view: View, throws: Iterable[object], path: str | Path, fps: int = FPS, slow: int = 1) -> Path:
    """Write a video of throws, at true rate or slower.

    Args:
        view: films row 0 of its cells, e.g. `core.view()`; it is closed at the end.
        throws: an iterable that carries out one throw per item, e.g. a generator that steps an environment.
        path: the .mp4 file.
        fps: frames per second.
        slow: how many times slower than in truth it runs.

    Raises:
        ConfigError: no OpenGL library, or imageio with ffmpeg is not installed.
    """
    try:
        writer = _video_writer()
        frames = [frame for _ in throws for frame in view.last_throw(fps * slow)]
    finally:
        view.close()
    if not frames:
        raise ConfigError("a video needs at least one throw, got 0")
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    writer.imwrite(target, np.stack(frames), fps=fps, codec="libx264")
    return target


def _video_writer() -> Any:
    try:
        import imageio.v3 as iio  # noqa: PLC0415  # pyright: ignore[reportMissingTypeStubs]
    except ImportError:
        raise ConfigError("video needs imageio with ffmpeg: pip install 'pnt_gym[video]'") from None
    return iio
