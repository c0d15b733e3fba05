"""What the agent sees of a coming throw of the gripper robot: the object as a camera measures it, and the nominal plan.

One table names every feature; the environment's docs, its space and `decode` are all made from it. A cell of another
size gives centres and scales of its own. Nothing hidden enters: true size, mass, friction, the belt's true speed and
the delay of the opening are not among them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.features import Feature, FeatureTable
from pnt_gym.cells.tray.cell import Context
from pnt_gym.cells.tray.config import TrayConfig
from pnt_gym.errors import ConfigError
from pnt_gym.planning.arrays import Floats, length

MOST_KINDS: Final = 3
"""Kinds of object that can be told apart."""

FEATURES: Final = (
    Feature("place_x", "m", -0.040, 0.020, "where the object lies; on a belt, as the claws begin to close"),
    Feature("place_y", "m", 0.0, 0.030, "where the object lies; on a belt, as the claws begin to close"),
    Feature("target_x", "m", 0.185, 0.10, "middle of the compartment's opening"),
    Feature("target_y", "m", 0.0, 0.056, "middle of the compartment's opening"),
    Feature("length", "m", 0.033, 0.013, "measured, along the object's first axis"),
    Feature("width", "m", 0.024, 0.004, "measured, between the claws"),
    Feature("height", "m", 0.022, 0.007, "measured, along the object's third axis"),
    Feature("release_x", "m", 0.065, 0.020, "of the nominal plan"),
    Feature("release_y", "m", 0.0, 0.034, "of the nominal plan"),
    Feature("release_speed", "m/s", 0.60, 0.20, "of the nominal plan"),
    Feature("elevation", "rad", 0.15, 0.15, "of the nominal plan; 0 for a drop"),
    Feature("flight_time", "s", 0.22, 0.04, "of the nominal plan, without drag"),
    Feature("is_first", "-", 0.5, 0.5, "kind of object, one-hot"),
    Feature("is_second", "-", 0.5, 0.5, "kind of object, one-hot"),
    Feature("is_third", "-", 0.5, 0.5, "kind of object, one-hot"),
)
_TABLE: Final = FeatureTable(FEATURES)


def features(config: TrayConfig) -> tuple[Feature, ...]:
    """The features of a cell, with its own centres and scales where it has some.

    Raises:
        ConfigError: the cell names a feature that does not exist.
    """
    own = config.observation
    known = [feature.name for feature in FEATURES]
    for name in own:
        if name not in known:
            raise ConfigError(f"observation: {name!r} is no feature; the features are {', '.join(known)}")
    spans = {feature.name: own.get(feature.name, (feature.centre, feature.scale)) for feature in FEATURES}
    return tuple(replace(f, centre=spans[f.name][0], scale=spans[f.name][1]) for f in FEATURES)


def feature_table(config: TrayConfig) -> FeatureTable:
    """The table of a cell's features.

    Raises:
        ConfigError: as for `features`.
    """
    return FeatureTable(features(config))


def observe(context: Context, table: FeatureTable = _TABLE) -> NDArray[np.float32]:
    """Observations (N, 15) of the coming throws, float32 within [-CLIP, CLIP].

    Args:
        context: the throws.
        table: the cell's own, see `feature_table`.
    """
    plans, size = context.plans, context.measured
    speed = length(plans.velocity)
    elevation = np.arcsin(plans.velocity[:, 2] / np.maximum(speed, 1e-9))
    where: list[Floats] = [*context.place.T, plans.target[:, 0], plans.target[:, 1], *size.T]
    plan = [plans.release[:, 0], plans.release[:, 1], speed, elevation, plans.flight_time]
    kinds = [(context.kind == k).astype(np.float64) for k in range(MOST_KINDS)]
    return table.encode([*where, *plan, *kinds])


def decode(observation: NDArray[np.floating], table: FeatureTable = _TABLE) -> dict[str, Floats]:
    """Physical values by feature name from observations (..., 15); clipped entries stay clipped.

    Args:
        observation: of a cell.
        table: that cell's own, see `feature_table`.
    """
    return table.decode(observation)
