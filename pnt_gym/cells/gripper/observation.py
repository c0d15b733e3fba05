"""Observation of a coming throw of the gripper robot: the object as a camera measures it, and the nominal plan.

One table names every feature; the environment's docs, its space and `decode` use this table. A cell of another size
sets its own centres and scales. Nothing hidden enters: true size, mass, friction, the belt's true speed and the delay
of the opening are not among the features.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, length
from pnt_gym.cells.base.features import Feature, FeatureTable, Quantity
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.errors import ConfigError
from pnt_gym.names import unknown_name

_PLACE: Final = "where the object lies; on a belt, as the claws begin to close"
FEATURES: Final = (
    Feature("place_x", "m", -0.040, 0.020, _PLACE, lambda c: c.place[:, 0]),
    Feature("place_y", "m", 0.0, 0.030, _PLACE, lambda c: c.place[:, 1]),
    Feature("target_x", "m", 0.185, 0.10, "middle of the compartment's opening", lambda c: c.target[:, 0]),
    Feature("target_y", "m", 0.0, 0.056, "middle of the compartment's opening", lambda c: c.target[:, 1]),
    Feature("length", "m", 0.033, 0.013, "measured extent along the object's first axis", lambda c: c.measured[:, 0]),
    Feature("width", "m", 0.024, 0.004, "measured extent between the claws", lambda c: c.measured[:, 1]),
    Feature("height", "m", 0.022, 0.007, "measured extent along the object's third axis", lambda c: c.measured[:, 2]),
    Feature("release_x", "m", 0.065, 0.020, "x of the nominal release", lambda c: c.plans.release[:, 0]),
    Feature("release_y", "m", 0.0, 0.034, "y of the nominal release", lambda c: c.plans.release[:, 1]),
    Feature(
        "release_speed", "m/s", 0.60, 0.20, "release speed of the nominal plan", lambda c: length(c.plans.velocity)
    ),
    Feature(
        "elevation", "rad", 0.15, 0.15, "elevation of the nominal throw; 0 for a drop",
        lambda c: np.arcsin(c.plans.velocity[:, 2] / np.maximum(length(c.plans.velocity), 1e-9)),
    ),
    Feature(
        "flight_time", "s", 0.22, 0.04, "flight time of the nominal plan, without drag", lambda c: c.plans.flight_time
    ),
    Feature("is_first", "-", 0.5, 0.5, "kind of object, one-hot", lambda c: c.kind == 0),
    Feature("is_second", "-", 0.5, 0.5, "kind of object, one-hot", lambda c: c.kind == 1),
    Feature("is_third", "-", 0.5, 0.5, "kind of object, one-hot", lambda c: c.kind == 2),
)  # fmt: skip
TABLE: Final = FeatureTable(FEATURES)
HIDDEN: Final = (
    Quantity("length", "m", "true extent along the object's first axis", lambda c: c.hidden.size[:, 0]),
    Quantity("width", "m", "true extent between the claws", lambda c: c.hidden.size[:, 1]),
    Quantity("height", "m", "true extent along the object's third axis", lambda c: c.hidden.size[:, 2]),
    Quantity("mass", "kg", "true mass", lambda c: c.hidden.mass),
    Quantity("friction", "-", "friction against the pads", lambda c: c.hidden.friction),
    Quantity("drag", "-", "drag coefficient Cd on the area facing the flow", lambda c: c.hidden.drag),
    Quantity("offset_x", "m", "place on the table, true less measured", lambda c: c.hidden.offset[:, 0]),
    Quantity("offset_y", "m", "place on the table, true less measured", lambda c: c.hidden.offset[:, 1]),
    Quantity("yaw", "rad", "direction about the vertical, true less planned", lambda c: c.hidden.yaw),
    Quantity("delay", "s", "delay of the claws' opening", lambda c: c.hidden.delay),
    Quantity(
        "belt_speed",
        "m/s",
        "true speed of the belt; 0 where nothing moves",
        lambda c: np.zeros(len(c.kind)) if c.hidden.belt_speed is None else c.hidden.belt_speed,
    ),
)
"""Hidden quantities."""


def feature_table(config: GripperConfig) -> FeatureTable:
    """Features of a cell, with the level's own centres and scales where given.

    Raises:
        ConfigError: the level names a feature that does not exist.
    """
    custom_spans, names = config.observation, [feature.name for feature in FEATURES]
    for name in custom_spans:
        if name not in names:
            raise ConfigError(f"observation: {unknown_name('feature', name, names)}")
    spans = [custom_spans.get(feature.name, (feature.centre, feature.scale)) for feature in FEATURES]
    return FeatureTable([replace(f, centre=c, scale=s) for f, (c, s) in zip(FEATURES, spans, strict=True)])


def decode(observation: ArrayLike, table: FeatureTable = TABLE) -> dict[str, Floats]:
    """Physical values by feature name from observations (..., 15); clipped entries stay clipped.

    Args:
        observation: observations of a cell.
        table: the cell's table, see `feature_table`.
    """
    return table.decode(observation)
