"""Observation of a coming throw of the one-joint arm: goal, nominal plan, and the part that lies in the pallet.

One table names every feature; the environments' docs, their spaces and `decode` use this table. Nothing hidden enters:
true radius, delay, friction and drag are not among the features.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.features import Feature, FeatureTable, Quantity

FEATURES: Final = (
    Feature("goal_x", "m", -0.15, 0.20, "where the centre of mass has to pass", lambda c: c.goal[:, 0]),
    Feature("goal_y", "m", 0.25, 0.15, "up from the pivot", lambda c: c.goal[:, 1]),
    Feature("goal_phi", "rad", 3.0, 0.60, "angle to have there, not wrapped", lambda c: c.goal[:, 2]),
    Feature("goal_dy", "m/s", -0.9, 0.70, "vertical speed to have there", lambda c: c.goal[:, 3]),
    Feature("release_angle", "rad", 0.5, 0.40, "theta_t, arm angle at the nominal release", lambda c: c.plans.u[:, 0]),
    Feature("release_speed", "rad/s", 9.5, 2.0, "dtheta_t, arm speed at that release", lambda c: c.plans.u[:, 1]),
    Feature("radius", "m", 0.25, 0.04, "l_t, centre of mass from the pivot, nominal plan", lambda c: c.plans.u[:, 2]),
    Feature("flight_time", "s", 0.28, 0.08, "t_f, flight time of the nominal plan", lambda c: c.plans.u[:, 3]),
    Feature(
        "arm_time", "s", 0.15, 0.10, "time from rest to the release in the nominal plan",
        lambda c: c.plans.motion.duration,
    ),
    Feature(
        "braking", "rad/s2", -200.0, 60.0, "arm acceleration after the nominal release",
        lambda c: c.plans.motion.braking,
    ),
    Feature("is_first", "-", 0.5, 0.5, "kind of throw, one-hot", lambda c: c.kind == 0),
    Feature("is_second", "-", 0.5, 0.5, "kind of throw, one-hot", lambda c: c.kind == 1),
    Feature("is_third", "-", 0.5, 0.5, "kind of throw, one-hot", lambda c: c.kind == 2),
    Feature(
        "tilt", "rad", 0.0, 0.10, "of the goal against the kind's nominal goal: how the part below lies",
        lambda c: np.where(np.isnan(c.lying[:, 0, 2]), 0.0, c.goal[:, 2] - c.nominal[:, 2]),
    ),
)  # fmt: skip
TABLE: Final = FeatureTable(FEATURES)
HIDDEN: Final = (
    Quantity("radius_error", "m", "true minus planned radius of the part on the arm", lambda c: c.hidden.radius),
    Quantity("delay", "s", "from the planned release to the moment the part comes free", lambda c: c.hidden.delay),
)
"""Hidden quantities. The noise of the camera's frames is not among them, because it changes the measured errors and not
the throw."""


def decode(observation: ArrayLike) -> dict[str, Floats]:
    """Physical values by feature name from observations (..., 14); clipped entries stay clipped."""
    return TABLE.decode(observation)
