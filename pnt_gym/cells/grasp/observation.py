"""Observation of an object before its grasp and before its throw: a picture, and a vector of measurements."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from gymnasium.spaces import Box, Dict
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.features import CLIP, Feature, FeatureTable
from pnt_gym.cells.conveyor import observation as conveyor
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.grasp.attempts import Attempts, LastTry
from pnt_gym.cells.grasp.config import CHANNELS, MOST_TRIES, PIXELS, GraspConfig


class GraspSight(NamedTuple):
    """N objects, and the tries to grasp them."""

    context: Context
    """The picks: of cups in the pictures' middles, or of the cups that hold their objects."""
    attempts: Attempts
    left: Ints
    """Numbers of tries that are left (N,)."""

    @property
    def place(self) -> Floats:
        """Places of the cups that hold their objects, from the outlines' middles (N, 2) [m]; 0 for others."""
        return np.where(self.attempts.holds[:, None], self.attempts.last, 0.0)


class Recall(NamedTuple):
    """What N cells measured last."""

    context: Context
    """The coming picks, with the measurements of the last throws."""
    step: LastTry
    """What the last steps did."""


def _of_pick(name: str) -> Feature:
    """A feature of the conveyor's observation."""
    feature = next(feature for feature in (*conveyor.FEATURES, *conveyor.FEEDBACK) if feature.name == name)
    value = feature.value
    return Feature(
        feature.name, feature.unit, feature.centre, feature.scale, feature.meaning, lambda s: value(s.context)
    )


_PLAN: Final = (
    "pick_x", "pick_y", "target_x", "target_y", "distance", "opening", "belt_speed", "release_speed", "elevation",
    "release_distance", "flight_time", "length", "width", "height", "is_ellipsoid", "is_cylinder", "is_box",
)  # fmt: skip
_GAUGE: Final = ("ln_mass", "ln_seal", "ln_grip_ratio", "frontal_area_per_mass", "plan_area_per_mass")
"""Features that only an object under the cup has."""
_PLACE: Final = 0.05
FEATURES: Final = (
    *map(_of_pick, _PLAN),
    Feature("cup_radius", "m", 0.015, 0.003, "radius of the cup", lambda s: s.context.objects.cup_radius),
    Feature("percent", "%", 40.0, 20.0, "speed setting of the hand", lambda s: s.context.objects.percent),
    Feature("holds", "-", 0.0, 1.0, "1 where the object hangs under the cup, else 0", lambda s: s.attempts.holds),
    Feature("tries_left", "-", 0.0, float(MOST_TRIES), "tries to grasp that are left", lambda s: s.left),
    Feature("place_x", "m", 0.0, _PLACE, "cup from the outline's middle; 0 before", lambda s: s.place[:, 0]),
    Feature("place_y", "m", 0.0, _PLACE, "cup from the outline's middle; 0 before", lambda s: s.place[:, 1]),
    Feature("failed_x", "m", 0.0, _PLACE, "last place that failed; 0 for none", lambda s: s.attempts.failed[:, 0]),
    Feature("failed_y", "m", 0.0, _PLACE, "last place that failed; 0 for none", lambda s: s.attempts.failed[:, 1]),
    *map(_of_pick, (*_GAUGE, "cos_2yaw", "sin_2yaw")),
)
TABLE: Final = FeatureTable(FEATURES)
_GAUGED: Final = np.array([name in _GAUGE for name in TABLE.names])
LAST: Final = FeatureTable(
    (
        Feature("tried", "-", 0.0, 1.0, "1 where the last step was a try, else 0", lambda r: r.step.tried),
        Feature("held", "-", 0.0, 1.0, "1 where the object hung after the last step, else 0", lambda r: r.step.held),
        Feature("vacuum", "N", 0.0, 20.0, "vacuum by the gauge in that try; 0 without", lambda r: r.step.vacuum),
        Feature("tried_x", "m", 0.0, _PLACE, "cup in that try, from the picture's middle; 0 without",
                lambda r: r.step.place[:, 0]),
        Feature("tried_y", "m", 0.0, _PLACE, "cup in that try, from the picture's middle; 0 without",
                lambda r: r.step.place[:, 1]),
        Feature("thrown", "-", 0.0, 1.0, "1 where the last step threw an object, else 0", lambda r: r.step.thrown),
        Feature("pace", "-", 0.0, 1.0, "pace of that throw; 0 without", lambda r: r.step.pace),
        Feature("dropped", "-", 0.0, 1.0, "1 where the cup lost the object on its way, else 0",
                lambda r: r.step.dropped),
        *map(_of_pick, (feature.name for feature in conveyor.FEEDBACK)),
    )
)  # fmt: skip
"""Entries of the last try and the last landing, in shifts."""
_VIEWS: Final = {
    "image": Box(0, 255, (CHANNELS, PIXELS, PIXELS), np.uint8),
    "vector": Box(-CLIP, CLIP, (len(TABLE),), np.float32),
}


def space_of(config: GraspConfig) -> Dict:
    """Observations of a level."""
    last: dict[str, Any] = {"last": Box(-CLIP, CLIP, (len(LAST),), np.float32)} if config.remembers else {}
    return Dict({**_VIEWS, **last})


def encode(sight: GraspSight) -> NDArray[np.float32]:
    """Vectors (N, D) of objects; what the gauge and the scales measure is 0 before the object hangs."""
    vector = TABLE.encode(sight)
    vector[np.ix_(~sight.attempts.holds, _GAUGED)] = 0.0
    return vector
