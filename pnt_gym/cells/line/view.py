"""Pictures of a line: robots, belt and bins, and all objects on the belt, in the air and at rest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.base.bodies import lying_size, yaw_attitude
from pnt_gym.cells.base.canvas import FPS, SIZE, Canvas, Frame, Marker, Picture
from pnt_gym.cells.base.view import Scene, View
from pnt_gym.cells.conveyor.view import object_markers
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.scene import belt_extent, build_scene
from pnt_gym.engine import mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.palette import FLIGHT, SLAT

SLATS: Final = 0.20
"""Distance of the marks that show the belt's motion [m]."""
CLOSEST: Final = 3.4
"""Distance of the picture's camera from a single robot [m]."""
TRAIL: Final = 1.0 / 30.0
"""Time between the dots behind flying objects [s]."""
_SLAT: Final = np.array(SLAT)


def camera(config: LineConfig) -> Any:
    """The standard view: the whole line from the side of the bins, far enough away for all of the belt."""
    low, high = belt_extent(config)
    view = mujoco.MjvCamera()
    view.lookat[:] = [(low + high) / 2, 0.05, -0.18]
    view.distance, view.azimuth, view.elevation = max(CLOSEST, 0.76 * (high - low)), 279.0, -36.0
    return view


@final
class LineView(View):
    """Offscreen pictures of one line, with its first robot at x 0.

    Args:
        cell: one line; its robots' cycles are recorded from now on.
        size: height and width of a frame [pixels].

    Raises:
        ConfigError: there are several lines.
    """

    def __init__(self, cell: LineCell, size: tuple[int, int] = SIZE) -> None:
        if cell.count != 1:
            raise ConfigError(f"num_envs is {cell.count}; pictures show a single line: set num_envs to 1")
        cell.watch()
        self._cell = cell
        # The line with its first robot at x 0, where the renderer's single precision is sharp.
        self._origin = origin = cell.config.robots[0].x
        self._robot_x: Floats = cell.config.robot_x() - origin
        robots = tuple(robot.model_copy(update={"x": robot.x - origin}) for robot in cell.config.robots)
        near = cell.config.model_copy(update={"robots": robots})
        self._scene = build_scene(near)
        self._canvas = Canvas(camera(near), size, cell.item_names)

    def aim(self, picture: Picture, samples: int = 1) -> None:
        """Set size and camera of all pictures from now on, and the number of drawings whose mean a picture is."""
        self._canvas.aim(picture, samples)

    def draw(self, scene: Scene) -> Frame:
        """Picture of a scene (height, width, 3)."""
        return self._canvas.draw(*scene)

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

    def show(self) -> None:
        """There is no window.

        Raises:
            ConfigError: always.
        """
        raise ConfigError("a line cannot be shown in a window; make a film or a picture of the line")

    def close(self) -> None:
        """Free the renderer and stop recording cycles; safe to call twice."""
        self._canvas.close()
        self._cell.watched = None

    def scenes(self, fps: int = FPS) -> Iterator[Scene]:
        """Scenes of the frames since the previous decision; each scene is valid until the next one is drawn."""
        first, last = np.ceil(fps * np.array([self._cell.acts.since, self._cell.state.clock[0]]) - 1e-9)
        for number in range(int(first), int(last)):
            yield self.scene(number / fps)

    def scene(self, time: float) -> Scene:
        """Scene at a time between the previous decision and the coming one [s]."""
        acts = self._cell.acts
        self._scene.pose(acts.tips(time))
        self._scene.data.time = time
        # Markers of objects on the belt.
        cell, (low, high) = self._cell, self._scene.belt
        stream, belt = cell.stream, cell.config.cell.belt
        ride_times = np.where(np.isinf(cell.state.accounts["since"][0]), -np.inf, time)
        for cycle in cell.acts.cycles:
            if cycle.object_track is not None:
                ride_times[cycle.number] = min(time, cycle.off_belt) if time < cycle.lift else -np.inf
        ride = belt.speed * np.where(np.isinf(ride_times), 0.0, ride_times) - self._origin
        x = stream.x[0] + ride + stream.objects.grasp[0, :, 0]
        objects_index = np.flatnonzero(np.isfinite(ride_times) & (x >= low) & (x <= high))
        objects = take(stream.objects, (0, objects_index))
        y, tall = objects.draws.lane_y + objects.grasp[:, 1], lying_size(objects.shape, objects.size)[:, 2]
        places = np.stack([x[objects_index], y, belt.height + tall / 2], axis=1)
        riding = object_markers(objects, places, yaw_attitude(objects.yaw))
        # Slats mark how the belt moves.
        size = np.array([0.004, (belt.y[1] - belt.y[0]) / 2, 0.0006])
        kind, middle = int(mujoco.mjtGeom.mjGEOM_BOX.value), sum(belt.y) / 2
        slats = [
            Marker(kind, size, np.array([slat, middle, belt.height]), np.eye(3).ravel(), _SLAT)
            for slat in np.arange(low + belt.speed * time % SLATS, high, SLATS)
        ]
        markers = [*slats, *riding, *self.markers_at(time)]
        return self._scene.model, self._scene.data, markers

    def markers_at(self, time: float) -> list[Marker]:
        """Markers of objects in hands, in the air and at rest, and dots along the past paths of the moving ones."""
        cycles = [(cycle, pose) for cycle in self._cell.acts.cycles if (pose := cycle.object_pose(time)) is not None]
        markers = list[Marker]()
        if cycles:
            objects_index: Ints = np.array([cycle.number for cycle, _ in cycles])
            poses: Floats = np.stack([pose for _, pose in cycles])
            poses[:, 0] += self._robot_x[[cycle.robot for cycle, _ in cycles]]
            markers += object_markers(take(self._cell.stream.objects, (0, objects_index)), poses[:, :3], poses[:, 3:])
        for cycle in self._cell.acts.cycles:
            if cycle.object_track is None or not cycle.lift <= time < cycle.object_track.time[-1]:
                continue
            for moment in np.arange(cycle.lift, time, TRAIL):
                middle = cycle.object_track.at(moment)[:3] + np.array([self._robot_x[cycle.robot], 0.0, 0.0])
                markers.append(Marker.dot(middle, np.array(FLIGHT), 0.011))
        return markers
