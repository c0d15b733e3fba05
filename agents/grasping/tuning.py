"""Choice of a rule's weights by tries: all weights at once, every setting on the same objects.

A score is linear in the weights, and so is its mean over the error of the cup. So the terms are averaged once, and the
tries at all places are made once; a setting then costs a product of matrices. SciPy's differential evolution (Storn and
Price 1997) searches the weights. Labels are those of a gauge and of scales, see `Tries.worth`.
"""

from __future__ import annotations

import importlib
from typing import Any, Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.grasp.config import GraspConfig

from .features import blur_maps, place_features
from .rules import TERMS, Weights, terms
from .scenes import Scenes

PART: Final = 500
"""Objects that are prepared at once, to bound the memory."""
BOUNDS: Final = {
    "distance": (0.0, 10.0),
    "slope": (0.0, 100.0),
    "belt": (0.0, 100.0),
    "matte": (-20.0, 60.0),
    "odd": (-10.0, 10.0),
}
"""Ranges of the weights; the two roughnesses have shares of 1, because scores have no scale."""
FREE: Final = {"depth": ("distance", "slope", "belt", "matte"), "colour": ("distance", "slope", "belt", "matte", "odd")}
"""Weights beside those of the roughnesses, of a rule that sees depths alone and of one that sees colours too."""
POPULATION, GENERATIONS = 12, 60
"""Settings for each weight, and rounds, of the search."""


@final
class PlaceTable(NamedTuple):
    """Terms and worths of all T places of N objects."""

    begins: Ints
    """First place of each object (N,)."""
    terms: Any
    """Terms averaged over the error of the cup, as 32-bit numbers (T, 7)."""
    worth: Floats
    """Worth of a try at each place (T,), with the object's own error of the cup and luck."""

    @classmethod
    def draw(cls, level: str | GraspConfig, count: int, seed: int) -> Self:
        """The places of objects of a level; objects of whose pictures nothing stands out are left out."""
        scenes = Scenes.draw(level, count, seed)
        tables = [cls.of(part) for part in scenes.parts(PART)]
        sizes = np.concatenate([np.diff(one.begins, append=len(one.worth)) for one in tables])
        begins = np.cumsum(sizes) - sizes
        terms, worth = (np.concatenate([getattr(one, name) for one in tables]) for name in ("terms", "worth"))
        return cls(begins, terms, worth)

    @classmethod
    def of(cls, scenes: Scenes) -> Self:
        """The places of some objects."""
        features = place_features(scenes.images, scenes.radius)
        picture, (row, column) = features.picture, features.pixel.T
        weight = blur_maps(features.maps(np.ones(len(picture)), 0.0))[picture, row, column]
        means = [blur_maps(features.maps(term, 0.0))[picture, row, column] / weight for term in terms(features)]
        worth = scenes.worths_of_tries(picture, features.places())
        return cls(np.flatnonzero(np.diff(picture, prepend=-1)), np.stack(means, axis=1).astype(np.float32), worth)

    def worths(self, weights: Weights) -> Floats:
        """Worths of tries where a rule with these weights tries (N,)."""
        score = self.terms @ np.array(weights, dtype=np.float32)
        least = np.repeat(np.minimum.reduceat(score, self.begins), np.diff(self.begins, append=len(score)))
        first = np.flatnonzero(score == least)
        return self.worth[first[np.searchsorted(first, self.begins)]]


def tune(table: PlaceTable, free: tuple[str, ...], seed: int) -> Weights:
    """The weights whose tries on the objects of a table are worth the most.

    Args:
        table: practice objects.
        free: names of the weights that are searched, beside those of the roughnesses; the others are 0.
        seed: seed of the search.
    """
    search: Any = importlib.import_module("scipy.optimize")

    def weights(values: Floats) -> Weights:
        share, *others = (float(value) for value in values)
        return Weights(rough_in=share, rough_out=1.0 - share, **dict(zip(free, others, strict=True)))

    bounds = [(0.0, 1.0), *(BOUNDS[name] for name in free)]
    found = search.differential_evolution(
        lambda values: -table.worths(weights(values)).mean(), bounds, seed=seed, popsize=POPULATION,
        maxiter=GENERATIONS, tol=0.0, polish=False,
    )  # fmt: skip
    return weights(found.x)


assert set(TERMS) == {*BOUNDS, "rough_in", "rough_out"}
