"""Rules for the place of a cup, on pictures or by the true surface."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.grasp.images import pixel_places

from .features import PlaceFeatures, best_places, blur_maps
from .scenes import Scenes


@final
class Weights(NamedTuple):
    """Weights of a rule; the score of a place is the sum of the negative terms."""

    rough_in: float = 0.0
    """Of the logarithm of the heights' deviation from a plane under the lip."""
    rough_out: float = 1.0
    """The same under the lip and 9 mm around."""
    distance: float = 2.0
    """Of the distance from the middle of what the picture shows, in 30 mm."""
    slope: float = 8.0
    """Of the slope of the plane under the lip."""
    belt: float = 0.0
    """Of the share of the belt under the lip and around."""
    matte: float = 0.0
    """Of the share of valid depths, which is higher on matte, porous surfaces."""
    odd: float = 0.0
    """Of the difference of brightness and warmth from the rest of the object."""


TUNED: Final = Weights(rough_in=0.527, rough_out=0.473, distance=2.22, slope=62.6, belt=98.0, matte=37.1)
"""Weights of a rule that sees depths alone, by tries on seen kinds (`agents.grasping.tuning`, seed 0)."""
COLOURED: Final = Weights(rough_in=0.276, rough_out=0.724, distance=1.94, slope=65.8, belt=96.9, matte=41.6, odd=-5.38)
"""Weights of a rule that sees colours too, by as many tries."""


def centroid(features: PlaceFeatures) -> Floats:
    """The place nearest to the middle of what each picture shows (N, 2) [m]."""
    return features.best(-features.column("distance"))


TERMS: Final = Weights._fields
"""Names of a score's terms."""


def terms(features: PlaceFeatures) -> tuple[Floats, ...]:
    """The terms of a score, (T,) each, in the order of the weights; the less, the better."""
    column = features.column
    odd = np.abs(column("gray_in") - column("object_gray")) + np.abs(column("warm_in") - column("object_warm"))
    return (
        column("rough_in"), column("rough_out"), column("distance"), column("slope_in"), column("belt_out"),
        column("valid_in"), odd,
    )  # fmt: skip


def scores(features: PlaceFeatures, weights: Weights) -> Floats:
    """Scores (T,) of places."""
    return -np.asarray(
        sum(weight * term for weight, term in zip(weights, terms(features), strict=True) if weight != 0.0)
    )


def mean_scores(features: PlaceFeatures, weights: Weights = TUNED) -> Floats:
    """Scores (T,) of places, averaged over the error of the cup's place."""
    row, column = features.pixel.T
    maps = blur_maps(features.maps(scores(features, weights), 0.0))
    # Places beside the object have no score, so a mean is one over the places that have.
    weight = blur_maps(features.maps(np.ones(len(row)), 0.0))
    return maps[features.picture, row, column] / weight[features.picture, row, column]


def places(features: PlaceFeatures, weights: Weights = TUNED) -> Floats:
    """The places with the highest mean scores (N, 2) [m]."""
    return features.best(mean_scores(features, weights))


def flattest(features: PlaceFeatures) -> Floats:
    """The flattest places under the lip (N, 2) [m], naively: no more than the least roughness."""
    return features.best(-features.column("rough_in"))


def maps(scenes: Scenes) -> Floats:
    """Exact expected worths (N, 48, 48) of tries with the cup sent to each pixel.

    The surface, the mass and the centre of mass are known; the error of the cup's place and the luck of a try are not.
    """
    places = pixel_places().reshape(1, -1, 2) - scenes.middle[:, None]
    worth = scenes.worth(places).reshape(-1, 48, 48)
    return blur_maps(worth, scenes.placing)


def surface_places(scenes: Scenes) -> Floats:
    """The places with the highest exact expected worths (N, 2) [m]."""
    return np.concatenate([best_places(maps(part)) for part in scenes.parts(100)])


PLACES: Final[dict[str, Callable[[Scenes, PlaceFeatures], Floats]]] = {
    "centre": lambda scenes, features: np.zeros_like(scenes.middle),
    "centroid": lambda scenes, features: centroid(features),
    "flattest, naive": lambda scenes, features: flattest(features),
    "flattest, tuned": lambda scenes, features: places(features, TUNED),
    "flattest, tuned with colour": lambda scenes, features: places(features, COLOURED),
    "true surface": lambda scenes, features: surface_places(scenes),
}
"""Places (N, 2) [m] by the rules, by the names of tables."""
