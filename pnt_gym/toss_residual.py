"""The gripper robot's residual: an action in [-1, 1] corrects a planned toss; zero is the plan itself.

Two modes, on the same planner:

* `release` (3 numbers): the release point moves along the throw and to its left, with it the landing, and the claws
  open earlier or later. Each number moves one measured error one to one: the landing along and across, and the moment
  at which the object comes free.
* `release_point` (2 numbers): the release point alone; the claws open when the planner says.
"""

from __future__ import annotations

from functools import partial
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.tray.cell import TrayCell
from pnt_gym.cells.tray.config import TrayConfig
from pnt_gym.cells.tray.motion import TossPlans
from pnt_gym.correction import Correction
from pnt_gym.planning.arrays import Bools, Floats, Ints

TossMode: TypeAlias = Literal["release", "release_point"]
TOSS_MODES: Final[tuple[TossMode, ...]] = ("release", "release_point")
ACTION_SIZE: Final = {"release": 3, "release_point": 2}
SHIFT_MODES: Final[tuple[TossMode, ...]] = TOSS_MODES
"""Modes in which an action moves the errors of the drag-free throw one to one: both."""

ERRORS: Final = ("landing_along", "landing_across", "release_delay")
_EXPLORATION: Final = 0.1
"""Standard deviation of what a learner adds in practice, as a share of an action of 1."""
_ALIKE: Final = np.array([0.010, 0.010, 0.005])
"""Errors that count alike: landing [m], moment of the release [s]."""


def corrected_plans(actions: Floats, cell: TrayCell) -> tuple[TossPlans, Bools]:
    """Feasible plans nearest to what actions (N, 2 or 3) ask for, and which actions had to be shortened (N,)."""
    correction = np.zeros((len(actions), 3))
    correction[:, : actions.shape[1]] = actions
    return cell.corrected(correction * cell.config.action.scale())


def toss_correction(config: TrayConfig, mode: TossMode) -> Correction:
    """How an action shifts the landing and, with three numbers, the moment of the release."""
    size = ACTION_SIZE[mode]
    scale = config.action.scale()[:size]
    return Correction(
        errors=ERRORS[:size],
        scale=scale,
        exploration=_EXPLORATION * scale,
        tolerance=_ALIKE[:size],
        cells=partial(_table_cells, config),
    )


def _table_cells(config: TrayConfig, features: NDArray[np.float32], kind: Ints) -> list[tuple[str, str]]:
    """The kind of each object; each has its own compartment, so there is one place."""
    return [(config.things[int(k)].name, "tray") for k in kind]
