"""The gripper robot's residual: an action in [-1, 1] corrects a planned toss; zero is the plan itself.

Two modes, on the same planner:

* `release` (3 numbers): the release point moves along the throw and to its left, with it the landing, and the claws
  open earlier or later. Each number moves one measured error one to one: the landing along and across, and the moment
  at which the object comes free.
* `release_point` (2 numbers): the release point alone; the claws open when the planner says.
"""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Ints
from pnt_gym.cells.base.action import ActionMode, Correction, by_name, mode_of, pad_residual
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.context import Context
from pnt_gym.cells.gripper.motion import TossPlans
from pnt_gym.cells.gripper.planner import TossPlanner

ERRORS: Final = ("landing_along", "landing_across", "release_delay")
EXPLORATION: Final = 0.1
"""Standard deviation of the noise that a learner adds in practice, as a share of an action of 1."""
ALIKE: Final = (0.010, 0.010, 0.005)
"""Errors of equal weight: landing [m], moment of the release [s]."""
NUMBERS: Final = (
    "release point along the throw",
    "release point to the left",
    "moment at which the claws begin to open",
)


MODES: Final = by_name(
    *(
        ActionMode[TossPlanner, Context, TossPlans](
            name,
            NUMBERS[:count],
            lambda config, count=count: config.action.scale()[:count],
            lambda planner, context, residual: planner.plan(context.kind, context.place, pad_residual(residual, 3)),
            ERRORS[:count],
        )
        for name, count in (("release", 3), ("release_point", 2))
    )
)


def correction(config: GripperConfig, mode: str) -> Correction:
    """Meaning of an action as an offset of the landing and, with three numbers, of the moment of the release."""
    own = mode_of(MODES, mode)
    errors, scale = own.errors, own.scale(config)
    return Correction(
        errors=errors,
        scale=scale,
        exploration=EXPLORATION * scale,
        tolerance=np.array(ALIKE[: len(errors)]),
        buckets=partial(_buckets, config),
    )


def _buckets(config: GripperConfig, features: NDArray[np.float32], kind: Ints) -> list[tuple[str, str]]:
    """Kind of each object; each kind has its own compartment, so there is one place."""
    return [(config.items[int(k)], "tray") for k in kind]
