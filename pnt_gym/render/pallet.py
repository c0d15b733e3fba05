"""Pictures of the one-joint thrower's cell."""

from __future__ import annotations

from typing import Any, Final, final

import numpy as np

from pnt_gym.cells.pallet.cell import PalletCell
from pnt_gym.cells.pallet.recording import ThrowRecording
from pnt_gym.engine import MjData, MjModel, mujoco
from pnt_gym.render.canvas import SIZE, Marker
from pnt_gym.render.view import ThrowView

_GOAL: Final = np.array([0.20, 0.70, 0.35, 0.9])


def camera() -> Any:
    """The standard view: the plane of the throw from the front, a little from above."""
    view = mujoco.MjvCamera()
    view.lookat[:] = [0.0, 0.0, 0.14]
    view.distance, view.azimuth, view.elevation = 1.35, 90.0, -8.0
    return view


@final
class PalletView(ThrowView):
    """Offscreen pictures and the interactive window of cells of the one-joint thrower.

    Args:
        cell: the cells; row 0 is recorded from now on.
        size: height and width of a frame [pixels].
    """

    dots: float = 0.6

    def __init__(self, cell: PalletCell, size: tuple[int, int] = SIZE) -> None:
        self._cell = cell
        super().__init__(camera(), size)

    def _record(self, row: int | None) -> None:
        self._cell.plant.record_row = row

    def _recording(self) -> ThrowRecording | None:
        return self._cell.plant.recording

    def _pose(self, row: int) -> tuple[MjModel, MjData]:
        return self._cell.pose(row)

    def _write_model(self, model: MjModel) -> None:
        self._cell.plant.batch.get_model(0, model)

    def _markers(self, row: int) -> list[Marker]:
        x, y = self._cell.context.goal[row, :2]
        return [Marker.dot(np.array([x, 0.0, y]), _GOAL, 0.008)]

    def _markers_at(self, time: float) -> list[Marker]:
        recording = self._recording()
        return [] if recording is None else [Marker.dot(recording.target, _GOAL, 0.008)]
