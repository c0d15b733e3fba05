"""Pictures of the gripper robot's cell."""

from __future__ import annotations

from typing import Any, Final, final

from pnt_gym.cells.recording import Recording
from pnt_gym.cells.tray.cell import TrayCell
from pnt_gym.cells.tray.config import TrayConfig
from pnt_gym.engine import MjData, MjModel, mujoco
from pnt_gym.render.canvas import SIZE
from pnt_gym.render.view import ThrowView

_DOTS: Final = 0.4
"""Size of the flights' dots for the prototype, as in `ThrowView.dots`."""


def camera(config: TrayConfig) -> Any:
    """The standard view: robot, table and tray from the front left, from as far as the robot is large."""
    size = config.robot.size
    view = mujoco.MjvCamera()
    view.lookat[:] = [0.05 * size, 0.0, -0.26 * size]
    view.distance, view.azimuth, view.elevation = 0.84 * size, 118.0, -14.0
    return view


@final
class TrayView(ThrowView):
    """Offscreen pictures and the interactive window of the gripper robot's cells.

    Args:
        cell: the cells; row 0 is recorded from now on.
        size: height and width of a frame [pixels].
    """

    def __init__(self, cell: TrayCell, size: tuple[int, int] = SIZE) -> None:
        self._cell = cell
        self.dots = _DOTS * cell.config.robot.size
        super().__init__(camera(cell.config), size)

    def _record(self, row: int | None) -> None:
        self._cell.plant.record_row = row

    def _recording(self) -> Recording | None:
        return self._cell.plant.recording

    def _pose(self, row: int) -> tuple[MjModel, MjData]:
        return self._cell.pose(row)

    def _write_model(self, model: MjModel) -> None:
        self._cell.plant.batch.get_model(0, model)
