"""Pictures of the conveyor cell."""

from __future__ import annotations

from typing import Any, Final, final

import numpy as np

from pnt_gym.cells.conveyor import ConveyorCell
from pnt_gym.cells.fluid import geom_placement
from pnt_gym.cells.objects import Objects
from pnt_gym.cells.recording import Recording
from pnt_gym.engine import MjData, MjModel, mujoco
from pnt_gym.planning.arrays import Floats
from pnt_gym.render.canvas import SIZE, Marker
from pnt_gym.render.view import ThrowView

_WAITING: Final = np.array([0.93, 0.80, 0.36, 1.0])


def camera() -> Any:
    """The standard view: belt, robot and bins from the front left."""
    view = mujoco.MjvCamera()
    view.lookat[:] = [-0.02, 0.10, -0.38]
    view.distance, view.azimuth, view.elevation = 3.3, 146.0, -19.0
    return view


@final
class CellView(ThrowView):
    """Offscreen pictures and the interactive window of conveyor cells.

    Args:
        cell: the cells; row 0 is recorded from now on.
        size: height and width of a frame [pixels].
    """

    def __init__(self, cell: ConveyorCell, size: tuple[int, int] = SIZE) -> None:
        self._cell = cell
        super().__init__(camera(), size)

    def _record(self, row: int | None) -> None:
        self._cell.plant.record_row = row

    def _recording(self) -> Recording | None:
        return self._cell.plant.recording

    def _pose(self, row: int) -> tuple[MjModel, MjData]:
        return self._cell.plant.pose(self._cell.context, row)

    def _write_model(self, model: MjModel) -> None:
        self._cell.plant.batch.get_model(0, model)

    def _markers(self, row: int) -> list[Marker]:
        return self._belt(self._cell.waiting(row), 0.0)

    def _markers_at(self, time: float) -> list[Marker]:
        return self._belt(self._cell.upstream, time)

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
