"""What the agent sees of a pick: measured values, the nominal plan, and the ratios that matter.

One table names every feature with its unit and scale; the environments' docs, their spaces and `decode` are all
made from it. Nothing hidden enters: `Context` hands over measurements only.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.context import Context
from pnt_gym.cells.features import CLIP, Feature, FeatureTable
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.ballistics import GRAVITY

__all__ = ["CLIP", "FEATURES", "Feature", "decode", "observe"]

FEATURES: Final = (
    Feature("pick_x", "m", 0.0, 0.30, "pick point, cup centre"),
    Feature("pick_y", "m", -0.33, 0.15, "pick point, cup centre"),
    Feature("target_x", "m", 0.0, 0.40, "centre of the bin's opening"),
    Feature("target_y", "m", 0.50, 0.25, "centre of the bin's opening"),
    Feature("distance", "m", 0.85, 0.25, "horizontal distance from pick to target"),
    Feature("opening", "m", 0.15, 0.05, "smaller side of the opening"),
    Feature("belt_speed", "m/s", 0.25, 0.25, "nominal belt speed"),
    Feature("release_speed", "m/s", 2.2, 0.5, "of the nominal plan"),
    Feature("elevation", "rad", 0.45, 0.30, "of the nominal plan"),
    Feature("release_distance", "m", 0.35, 0.20, "pick to release, of the nominal plan"),
    Feature("flight_time", "s", 0.28, 0.10, "of the nominal plan, without drag"),
    Feature("length", "m", 0.12, 0.06, "measured, along the object"),
    Feature("width", "m", 0.07, 0.03, "measured, across the object"),
    Feature("height", "m", 0.05, 0.03, "measured"),
    Feature("is_ellipsoid", "-", 0.5, 0.5, "shape, one-hot"),
    Feature("is_cylinder", "-", 0.5, 0.5, "shape, one-hot"),
    Feature("is_box", "-", 0.5, 0.5, "shape, one-hot"),
    Feature("ln_mass", "ln kg", -4.2, 0.8, "logarithm of the measured mass"),
    Feature("ln_seal", "ln N", 2.4, 0.6, "logarithm of the measured vacuum force F0"),
    Feature("ln_grip_ratio", "-", 4.3, 0.8, "ln(F0 / (m g)): release delay is linear in it"),
    Feature("frontal_area_per_mass", "m2/kg", 0.35, 0.20, "area facing the throw over mass: drag"),
    Feature("plan_area_per_mass", "m2/kg", 0.50, 0.30, "horizontal area over mass: lift"),
    Feature("cos_2yaw", "-", 0.0, 1.0, "yaw of the object against the throw, doubled"),
    Feature("sin_2yaw", "-", 0.0, 1.0, "yaw of the object against the throw, doubled"),
    Feature("grasp_along", "m", 0.0, 0.010, "measured centre of mass from the cup, along the throw"),
    Feature("grasp_across", "m", 0.0, 0.010, "measured centre of mass from the cup, left of the throw"),
)
_TABLE: Final = FeatureTable(FEATURES)


def observe(context: Context) -> NDArray[np.float32]:
    """Observations (N, 26) of the coming picks, float32 within [-CLIP, CLIP]."""
    return _TABLE.encode([*_geometry(context), *_plan(context), *_object(context)])


def decode(observation: NDArray[np.floating]) -> dict[str, Floats]:
    """Physical values by feature name from observations (..., 26); clipped entries stay clipped."""
    return _TABLE.decode(observation)


def _geometry(context: Context) -> list[Floats]:
    pick, target = context.pick, context.target
    belt = np.full(len(pick), context.belt_speed)
    opening = context.opening.min(axis=-1)
    return [pick[:, 0], pick[:, 1], target[:, 0], target[:, 1], context.distance, opening, belt]


def _plan(context: Context) -> list[Floats]:
    plan = context.plan
    return [plan.speed, plan.angle, plan.distance, plan.flight_time]


def _object(context: Context) -> list[Floats]:
    seen = context.measured
    length, width, height = seen.size[:, 0], seen.size[:, 1], seen.size[:, 2]
    relative = seen.yaw - context.azimuth
    frontal = height * (length * np.abs(np.sin(relative)) + width * np.abs(np.cos(relative)))
    along, across = context.to_throw_frame(seen.grasp)
    shapes = [(seen.shape == k).astype(np.float64) for k in range(3)]
    return [
        length,
        width,
        height,
        *shapes,
        np.log(seen.mass),
        np.log(seen.seal),
        np.log(seen.seal / (seen.mass * GRAVITY)),
        frontal / seen.mass,
        length * width / seen.mass,
        np.cos(2.0 * relative),
        np.sin(2.0 * relative),
        along,
        across,
    ]
