"""What the agent sees of a coming throw of the one-joint arm: goal, nominal plan, and what lies in the pallet already.

One table names every feature; the environments' docs, their spaces and `decode` are all made from it. Nothing hidden
enters: true radius, delay, friction and drag are not among them.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.features import Feature, FeatureTable
from pnt_gym.cells.pallet.context import Context
from pnt_gym.planning.arrays import Floats

MOST_KINDS: Final = 3
"""Kinds of throw that can be told apart."""

FEATURES: Final = (
    Feature("goal_x", "m", -0.15, 0.20, "where the centre of mass has to pass"),
    Feature("goal_y", "m", 0.25, 0.15, "up from the pivot"),
    Feature("goal_phi", "rad", 3.0, 0.60, "angle to have there, not wrapped"),
    Feature("goal_dy", "m/s", -0.9, 0.70, "vertical speed to have there"),
    Feature("release_angle", "rad", 0.5, 0.40, "theta_t of the nominal plan"),
    Feature("release_speed", "rad/s", 9.5, 2.0, "dtheta_t of the nominal plan"),
    Feature("radius", "m", 0.25, 0.04, "l_t of the nominal plan"),
    Feature("flight_time", "s", 0.28, 0.08, "t_f of the nominal plan"),
    Feature("arm_time", "s", 0.15, 0.10, "from rest to the release, of the nominal plan"),
    Feature("braking", "rad/s2", -200.0, 60.0, "acceleration of the arm after the release, of the nominal plan"),
    Feature("is_first", "-", 0.5, 0.5, "kind of throw, one-hot"),
    Feature("is_second", "-", 0.5, 0.5, "kind of throw, one-hot"),
    Feature("is_third", "-", 0.5, 0.5, "kind of throw, one-hot"),
    Feature("tilt", "rad", 0.0, 0.10, "of the goal against the kind's nominal goal: how the part below lies"),
)
_TABLE: Final = FeatureTable(FEATURES)


def observe(context: Context, nominal: Floats) -> NDArray[np.float32]:
    """Observations (N, 14) of the coming throws, float32 within [-CLIP, CLIP].

    Args:
        context: the N throws.
        nominal: goal of each throw's kind (N, 4); of no meaning where goals are drawn from a region.
    """
    plans = context.plans
    kinds = [(context.kind == k).astype(np.float64) for k in range(MOST_KINDS)]
    tilt = np.where(np.isnan(context.lying[:, 0, 2]), 0.0, context.goal[:, 2] - nominal[:, 2])
    arm = [plans.motion.duration, plans.motion.braking]
    return _TABLE.encode([*context.goal.T, *plans.u.T, *arm, *kinds, tilt])


def decode(observation: NDArray[np.floating]) -> dict[str, Floats]:
    """Physical values by feature name from observations (..., 14); clipped entries stay clipped."""
    return _TABLE.decode(observation)
