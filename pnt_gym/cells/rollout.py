"""One way to roll out a batch of throws that end at different times, and to hear the engine's warnings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from pnt_gym.engine import mujoco
from pnt_gym.planning.arrays import Floats, Ints

STAGES: Final = (0.25, 0.5, 0.75, 1.0)
"""Shares of the throws that are over after each stage of a rollout."""
_INPUTS = int(mujoco.mjtState.mjSTATE_CTRL.value) | int(mujoco.mjtState.mjSTATE_EQ_ACTIVE.value)


class PhysicsError(RuntimeError):
    """The engine warned or stopped: the throw's numbers would be worthless."""


def staged_rollout(batch: Any, control: Floats, steps: Ints, widths: Sequence[tuple[str, int]]) -> dict[str, Floats]:
    """Roll out every simulation for its own number of steps; recorded rows are zero after their last step.

    The batch runs in stages, each with the throws that are not over yet, which saves steps and changes no result.

    Args:
        batch: N simulations.
        control: controls and equality bits of every step (N, M, nu + neq).
        steps: of each simulation (N,).
        widths: what is recorded, each with its number of columns.

    Returns:
        The records by name, (N, M, columns) each.

    Raises:
        PhysicsError: the engine warned, or stopped a simulation.
    """
    names = tuple(name for name, _ in widths)
    record = {name: np.zeros((*control.shape[:2], width)) for name, width in widths}
    batch.warning[:] = 0
    start = 0
    for end in np.unique(np.quantile(steps, STAGES, method="higher")):
        rows = np.flatnonzero(steps > start)
        part = batch.rollout(int(end) - start, control[rows, start:end], control_spec=_INPUTS, record=names, ids=rows)
        for name in names:
            record[name][rows, start:end] = part[name]
        start = int(end)
    check_warnings(batch)
    return record


def check_warnings(batch: Any) -> None:
    """Make sure that the engine warned of nothing.

    Raises:
        PhysicsError: it did.
    """
    if batch.warning.any():
        row, kind = (int(i) for i in np.argwhere(batch.warning)[0][:2])
        raise PhysicsError(f"MuJoCo warned in simulation {row}: {mujoco.mjtWarning(kind).name}")
