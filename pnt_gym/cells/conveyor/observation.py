"""Observation of a pick: measured values, the nominal plan and the ratios that matter; and the list of hidden values.

One table names every feature with its unit, scale and value; the environments' docs, their spaces and `decode` are
generated from the table. No feature reads a hidden value: all read measurements in `Context`.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, numbers
from pnt_gym.cells.base.features import Feature, FeatureTable, Quantity
from pnt_gym.cells.base.items import BOX, CYLINDER, ELLIPSOID
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.constants import GRAVITY


def _frontal(context: Context) -> Floats:
    """Measured area that faces the throw (N,) [m2]."""
    length, width, height = context.objects.measured.size.T
    turned = context.relative_yaw
    return height * (length * np.abs(np.sin(turned)) + width * np.abs(np.cos(turned)))


FEATURES: Final = (
    Feature("pick_x", "m", 0.0, 0.30, "pick point, cup centre", lambda c: c.pick[:, 0]),
    Feature("pick_y", "m", -0.33, 0.15, "pick point, cup centre", lambda c: c.pick[:, 1]),
    Feature("target_x", "m", 0.0, 0.40, "centre of the bin's opening", lambda c: c.target[:, 0]),
    Feature("target_y", "m", 0.50, 0.25, "centre of the bin's opening", lambda c: c.target[:, 1]),
    Feature("distance", "m", 0.85, 0.25, "horizontal distance from pick to target", lambda c: c.distance),
    Feature("opening", "m", 0.15, 0.05, "smaller side of the opening", lambda c: c.opening.min(axis=-1)),
    Feature("belt_speed", "m/s", 0.25, 0.25, "nominal belt speed", lambda c: c.belt_speed),
    Feature("release_speed", "m/s", 2.2, 0.5, "release speed of the nominal plan", lambda c: c.plan.speed),
    Feature("elevation", "rad", 0.45, 0.30, "elevation of the nominal throw", lambda c: c.plan.angle),
    Feature("release_distance", "m", 0.35, 0.20, "way to the release in the nominal plan", lambda c: c.plan.distance),
    Feature("flight_time", "s", 0.28, 0.10, "nominal flight time, without drag", lambda c: c.plan.flight_time),
    Feature("length", "m", 0.12, 0.06, "measured extent along the object", lambda c: c.objects.measured.size[:, 0]),
    Feature("width", "m", 0.07, 0.03, "measured extent across the object", lambda c: c.objects.measured.size[:, 1]),
    Feature("height", "m", 0.05, 0.03, "measured vertical extent", lambda c: c.objects.measured.size[:, 2]),
    Feature("is_ellipsoid", "-", 0.5, 0.5, "shape, one-hot", lambda c: c.objects.measured.shape == ELLIPSOID),
    Feature("is_cylinder", "-", 0.5, 0.5, "shape, one-hot", lambda c: c.objects.measured.shape == CYLINDER),
    Feature("is_box", "-", 0.5, 0.5, "shape, one-hot", lambda c: c.objects.measured.shape == BOX),
    Feature("ln_mass", "ln kg", -4.2, 0.8, "logarithm of the measured mass", lambda c: np.log(c.objects.measured.mass)),
    Feature(
        "ln_seal", "ln N", 2.4, 0.6, "logarithm of the measured vacuum force F0",
        lambda c: np.log(c.objects.measured.seal),
    ),
    Feature(
        "ln_grip_ratio", "-", 4.3, 0.8, "ln(F0 / (m g)): release delay is linear in it",
        lambda c: np.log(c.objects.measured.seal / (c.objects.measured.mass * GRAVITY)),
    ),
    Feature(
        "frontal_area_per_mass", "m2/kg", 0.35, 0.20, "area facing the throw over mass: drag",
        lambda c: _frontal(c) / c.objects.measured.mass,
    ),
    Feature(
        "plan_area_per_mass", "m2/kg", 0.50, 0.30, "horizontal area over mass: lift",
        lambda c: c.objects.measured.size[:, 0] * c.objects.measured.size[:, 1] / c.objects.measured.mass,
    ),
    Feature(
        "cos_2yaw", "-", 0.0, 1.0, "yaw of the object against the throw, doubled",
        lambda c: np.cos(2.0 * c.relative_yaw),
    ),
    Feature(
        "sin_2yaw", "-", 0.0, 1.0, "yaw of the object against the throw, doubled",
        lambda c: np.sin(2.0 * c.relative_yaw),
    ),
    Feature(
        "grasp_along", "m", 0.0, 0.010, "measured centre of mass from the cup, along the throw",
        lambda c: c.measured_grasp_in_throw[0],
    ),
    Feature(
        "grasp_across", "m", 0.0, 0.010, "measured centre of mass from the cup, left of the throw",
        lambda c: c.measured_grasp_in_throw[1],
    ),
)  # fmt: skip
TABLE: Final = FeatureTable(FEATURES)
FEEDBACK: Final = (
    Feature("last_seen", "-", 0.0, 1.0, "1 where the bin's camera saw the last landing", lambda c: c.before.seen),
    Feature(
        "last_along", "m", 0.0, 0.05, "last landing against its target, along that throw; 0 if unseen",
        lambda c: c.before.error[:, 0],
    ),
    Feature(
        "last_across", "m", 0.0, 0.05, "last landing against its target, left of that throw; 0 if unseen",
        lambda c: c.before.error[:, 1],
    ),
    Feature(
        "last_shift_along", "m", 0.0, 0.05, "what the last action asked for, as carried out, drag-free",
        lambda c: c.before.shift[:, 0],
    ),
    Feature(
        "last_shift_across", "m", 0.0, 0.05, "what the last action asked for, as carried out, drag-free",
        lambda c: c.before.shift[:, 1],
    ),
    Feature(
        "last_direction_x", "-", 0.0, 1.0, "horizontal heading of the last throw",
        lambda c: c.before.direction[:, 0],
    ),
    Feature(
        "last_direction_y", "-", 0.0, 1.0, "horizontal heading of the last throw",
        lambda c: c.before.direction[:, 1],
    ),
    Feature(
        "shift_gone", "-", 0.0, 1.0, "share of the shift that is over; 0 before its first throw",
        lambda c: c.before.gone,
    ),
)  # fmt: skip
"""Further features of a cell with a camera over its bins."""
SHIFT_TABLE: Final = FeatureTable((*FEATURES, *FEEDBACK))
HIDDEN: Final = (
    Quantity("length", "m", "true extent along the object", lambda c: c.objects.size[:, 0]),
    Quantity("width", "m", "true extent across the object", lambda c: c.objects.size[:, 1]),
    Quantity("height", "m", "true extent", lambda c: c.objects.size[:, 2]),
    Quantity("mass", "kg", "true mass", lambda c: c.objects.mass),
    Quantity("drag", "-", "drag coefficient Cd on the area facing the flow", lambda c: c.objects.drag),
    Quantity("com_depth", "m", "centre of mass below the cup", lambda c: c.objects.com_depth),
    Quantity("seal", "N", "true vacuum force F0 before the release", lambda c: c.objects.seal),
    Quantity("delay", "s", "release later than commanded", lambda c: c.objects.delay),
    Quantity("jitter", "s", "part of the delay that differs from throw to throw", lambda c: c.objects.jitter),
    Quantity("friction", "-", "sliding friction of its surface", lambda c: c.objects.friction),
    Quantity("rolling_friction", "m", "rolling friction of its surface", lambda c: c.objects.rolling_friction),
    Quantity("restitution", "-", "rebound speed over impact speed", lambda c: c.objects.restitution),
    Quantity("yaw", "rad", "true direction of the object on the belt", lambda c: c.objects.yaw),
    Quantity("grasp_x", "m", "true centre of mass from the cup axis, along the belt", lambda c: c.grasp[:, 0]),
    Quantity("grasp_y", "m", "true centre of mass from the cup axis, across the belt", lambda c: c.grasp[:, 1]),
    Quantity("belt_error", "-", "true belt speed over the nominal one, less 1", lambda c: c.objects.belt_error),
    Quantity("spin_x", "rad/s", "angular velocity gained at the release", lambda c: c.objects.spin[:, 0]),
    Quantity("spin_y", "rad/s", "angular velocity gained at the release", lambda c: c.objects.spin[:, 1]),
    Quantity("spin_z", "rad/s", "angular velocity gained at the release", lambda c: c.objects.spin[:, 2]),
)
"""Hidden values, which no observation has."""
DRIFT: Final = (
    Quantity("drift_delay", "s", "part of the delay that drifts", lambda c: c.drift.delay),
    Quantity("camera_x", "m", "true place against the camera's, along the belt", lambda c: c.drift.camera[:, 0]),
    Quantity("camera_y", "m", "true place against the camera's, across the belt", lambda c: c.drift.camera[:, 1]),
    Quantity("encoder", "-", "true belt speed over the encoder's, less 1", lambda c: c.drift.encoder),
    Quantity("draught_x", "m/s", "velocity of the air along the belt", lambda c: c.drift.draught[:, 0]),
    Quantity("draught_y", "m/s", "velocity of the air across the belt", lambda c: c.drift.draught[:, 1]),
)
"""Further hidden values of a cell that drifts."""
CELL: Final = (
    Quantity("cell_valve", "s", "delay of the cell's valve", lambda c: c.cell.valve),
    Quantity("cell_tau", "s", "time constant of the cell's vacuum", lambda c: c.cell.tau),
    Quantity("cell_blow_off", "m/s", "speed that the cell's blown air gives an object", lambda c: c.cell.blow_off),
    Quantity("cell_stiffness", "N m/rad", "stiffness of the cell's lip", lambda c: c.cell.stiffness),
    Quantity("cell_drag", "-", "the cell's factor of drag", lambda c: c.cell.drag),
    Quantity("cell_restitution", "-", "the cell's factor of restitution", lambda c: c.cell.restitution),
    Quantity("cell_seal", "-", "difference of the chance that the cell's cup seals", lambda c: c.cell.seal),
    Quantity("cell_camera", "-", "scale of the cell's camera across the belt, less 1", lambda c: c.cell.camera),
    Quantity("cell_encoder", "-", "true belt speed over the cell's encoder's, less 1", lambda c: c.cell.encoder),
)
"""Further hidden values where each episode has a cell of its own."""


def decode(observation: ArrayLike) -> dict[str, Floats]:
    """Physical values by feature name from observations (..., 26), or (..., 34) with measurements of the last throw.

    Clipped entries stay clipped.
    """
    entries = numbers(observation, "observation")
    return (SHIFT_TABLE if entries.shape[-1:] == (len(SHIFT_TABLE),) else TABLE).decode(entries)
