"""Pictures of a line: robots, belt and bins, and all objects on the belt, in the air and at rest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.base.canvas import FPS, SIZE, Canvas, Frame, Marker, Picture
from pnt_gym.cells.base.fluid import lying_size
from pnt_gym.cells.base.rotations import upright
from pnt_gym.cells.base.view import FLOWN, Scene
from pnt_gym.cells.conveyor.view import drawn
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.scene import build_scene, extent
from pnt_gym.engine import mujoco
from pnt_gym.errors import ConfigError

SLATS: Final = 0.20
"""Distance of the marks that show the belt's motion [m]."""
CLOSEST: Final = 3.4
"""Distance of the picture's camera from a single robot [m]."""
TRAIL: Final = 1.0 / 30.0
"""Time between the dots behind flying objects [s]."""
_SLAT: Final = np.array([0.29, 0.31, 0.34, 1.0])


def camera(config: LineConfig) -> Any:
    """The standard view: the whole line from the side of the bins, far enough away for all of the belt."""
    low, high = extent(config)
    view = mujoco.MjvCamera()
    view.lookat[:] = [(low + high) / 2, 0.05, -0.18]
    view.distance, view.azimuth, view.elevation = max(CLOSEST, 0.76 * (high - low)), 279.0, -36.0
    return view


def _at_the_origin(config: LineConfig) -> LineConfig:
    """The line with its first robot at x 0, where the renderer's single precision is sharp."""
    origin = config.robots[0].x
    robots = tuple(robot.model_copy(update={"x": robot.x - origin}) for robot in config.robots)
    return config.model_copy(update={"robots": robots})


@final
class LineView:
    """Offscreen pictures of one line, with its first robot at x 0.

    Args:
        cell: one line; its robots' cycles are recorded from now on.
        size: height and width of a frame [pixels].

    Raises:
        ConfigError: there are several lines.
    """

    def __init__(self, cell: LineCell, size: tuple[int, int] = SIZE) -> None:
        if cell.count != 1:
            raise ConfigError(f"pictures are of one line, and there are {cell.count}; set num_envs to 1")
        cell.watch()
        self._cell, self._origin = cell, cell.config.robots[0].x
        near = _at_the_origin(cell.config)
        self._scene = build_scene(near)
        self._canvas = Canvas(camera(near), size)

    def aim(self, picture: Picture) -> None:
        """Set the camera and the size of the following pictures."""
        self._canvas.close()
        self._canvas.size = (picture.height, picture.width)
        picture.aim(self._canvas.camera)

    def frame(self, row: int = 0) -> Frame:
        """The line at the moment of the coming decision (height, width, 3).

        Raises:
            ConfigError: no OpenGL library could be loaded.
        """
        return self._canvas.draw(*self.scene(float(self._cell.state.clock[row])))

    def last_throw(self, fps: int = FPS) -> list[Frame]:
        """Frames since the previous decision, at true rate; frames of successive decisions form one film."""
        return [self._canvas.draw(*scene) for scene in self.scenes(fps)]

    def at(self, moment: float, fps: int = FPS) -> Frame:
        """Frame of a moment of the shift [s], between the previous decision and the coming one."""
        since, now = self._cell.acts.since, float(self._cell.state.clock[0])
        return self._canvas.draw(*self.scene(np.floor(fps * min(max(moment, since), now) + 1e-9) / fps))

    def render(self, mode: str) -> Frame | list[Frame]:
        """What Gymnasium's `render` returns for rgb_array and rgb_array_list."""
        return self.frame() if mode == "rgb_array" else self.last_throw()

    def show(self) -> None:
        """There is no window.

        Raises:
            ConfigError: always.
        """
        raise ConfigError("a line is not shown in a window; film it")

    def close(self) -> None:
        """Free the renderer and stop recording cycles; safe to call twice."""
        self._canvas.close()
        self._cell.unwatch()

    def scenes(self, fps: int = FPS) -> Iterator[Scene]:
        """Scenes of the frames since the previous decision; each scene is valid until the next one is drawn."""
        first, last = np.ceil(fps * np.array([self._cell.acts.since, self._cell.state.clock[0]]) - 1e-9)
        for number in range(int(first), int(last)):
            yield self.scene(number / fps)

    def scene(self, time: float) -> Scene:
        """Scene at a time between the previous decision and the coming one [s]."""
        acts = self._cell.acts
        self._scene.pose(acts.tips(time))
        seen = [*self._slats(time), *self._riding(time), *self._thrown(time), *self._trails(time)]
        return self._scene.model, self._scene.data, seen

    def _riding(self, time: float) -> list[Marker]:
        """Markers of objects on the belt."""
        cell, (low, high) = self._cell, self._scene.belt
        stream, belt = cell.stream, cell.config.cell.belt
        until = np.where(np.isinf(cell.state.books.since(np.s_[0])), -np.inf, time)
        for one in cell.acts.made:
            if one.thing is not None:
                until[one.number] = min(time, one.taken) if time < one.lift else -np.inf
        way = belt.speed * np.where(np.isinf(until), 0.0, until) - self._origin
        x = stream.x[0] + way + stream.objects.grasp[0, :, 0]
        which = np.flatnonzero(np.isfinite(until) & (x >= low) & (x <= high))
        objects = take(stream.objects, (0, which))
        y, high = objects.draws.lane_y + objects.grasp[:, 1], lying_size(objects.shape, objects.size)[:, 2]
        return drawn(objects, np.stack([x[which], y, belt.height + high / 2], axis=1), upright(objects.yaw))

    def _thrown(self, time: float) -> list[Marker]:
        """Markers of objects in hands, in the air and at rest."""
        shown = [(one, pose) for one in self._cell.acts.made if (pose := one.seen(time)) is not None]
        if not shown:
            return []
        which: Ints = np.array([one.number for one, _ in shown])
        poses: Floats = np.stack([pose for _, pose in shown])
        places = self._places()[[one.robot for one, _ in shown]]
        poses[:, 0] += places
        return drawn(take(self._cell.stream.objects, (0, which)), poses[:, :3], poses[:, 3:])

    def _trails(self, time: float) -> list[Marker]:
        """Dots along the past path of objects that are in hands or in the air."""
        places, dots = self._places(), list[Marker]()
        for one in self._cell.acts.made:
            if one.thing is None or not one.lift <= time < one.thing.time[-1]:
                continue
            for moment in np.arange(one.lift, time, TRAIL):
                middle = one.thing.at(moment)[:3] + np.array([places[one.robot], 0.0, 0.0])
                dots.append(Marker.dot(middle, FLOWN, 0.011))
        return dots

    def _places(self) -> Floats:
        """Where the robots stand along the belt in the picture (R,) [m]."""
        return self._cell.config.places() - self._origin

    def _slats(self, time: float) -> list[Marker]:
        """Marks that move with the belt."""
        belt, (low, high) = self._cell.config.cell.belt, self._scene.belt
        first = low + belt.speed * time % SLATS
        size = np.array([0.004, (belt.y[1] - belt.y[0]) / 2, 0.0006])
        kind, middle = int(mujoco.mjtGeom.mjGEOM_BOX.value), sum(belt.y) / 2
        return [
            Marker(kind, size, np.array([x, middle, belt.height]), np.eye(3).ravel(), _SLAT)
            for x in np.arange(first, high, SLATS)
        ]
