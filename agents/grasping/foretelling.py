"""What the gauge will say of a try at a place, foretold from a picture, and how likely a reading is then.

Tries in a calibrated cell teach it: a regression foretells a label of the vacuum, and a table says how the labels are
spread where the regression foretells a value.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple, Protocol, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records
from pnt_gym.cells.grasp.config import GraspConfig, Surface
from pnt_gym.cells.grasp.images import pixel_places

from .features import NAMES, SIGHTS, PlaceFeatures, blur_maps, place_features
from .network import PlaceNetwork
from .scenes import Scenes

BINS: Final = 10
"""Parts of the range of labels, foretold and read."""
RANGE: Final = 6.0
"""Range of the logarithm of the vacuum over the least one, which labels from 0 to 1 stand for."""
RANDOM: Final = 0.4
"""Share of the tries that are at random places, before the first fit."""
ROUND: Final = 1600
"""About so many tries lie between two fits."""
EXPLORES: Final = 0.15
"""Share of the later tries that are random."""
TEMPERATURE: Final = 0.05
"""Of the other tries: a place is tried with a probability proportional to exp(chance to hold / temperature)."""
QUICK_STEPS, STEPS = 500, 2500
"""Gradient steps of a fit on the way, and of the last one."""
PART: Final = 2000
"""Objects whose pictures are seen at once, to bound the memory."""
BESIDE: Final = 0.15
"""Share of the tries that are anywhere around the object's middle, also beside the object."""
AROUND: Final = 0.08
"""Largest distance of these tries from the middle, along each axis [m]."""
PENALTY: Final = 1.0
"""Ridge penalty, per object."""


def labels(vacuum: Floats, radius: Floats, surface: Surface) -> Floats:
    """Labels from 0 to 1 of readings [N] under cups of radii [m], (N,) each; 1/2 is the least that counts as held."""
    least = surface.pressure * np.pi * radius**2
    return np.clip(0.5 + np.log(np.maximum(vacuum, 1e-6) / least) / RANGE, 0.0, 1.0)


@final
class LabelTable:
    """How labels that are read are spread where a value was foretold.

    Args:
        share: shares of the labels that were read (columns), by the label that was foretold (rows); None for all alike.
    """

    def __init__(self, share: Floats | None = None) -> None:
        self.share = np.full((BINS, BINS), 1.0 / BINS) if share is None else share

    @classmethod
    def counted(cls, foretold: Floats, read: Floats) -> Self:
        """The table of tries whose labels were foretold (N,) and read (N,)."""
        count = np.full((BINS, BINS), 0.2)
        np.add.at(count, (_bins(foretold), _bins(read)), 1.0)
        return cls(count / count.sum(axis=1, keepdims=True))

    def likelihood(self, foretold: Floats, read: Floats) -> Floats:
        """Likelihoods (K, ...) of labels that were read (K,), where (K, ...) were foretold."""
        shape = (len(read), *([1] * (foretold.ndim - 1)))
        return self.share[_bins(foretold), _bins(read).reshape(shape)]

    def held(self, foretold: Floats) -> Floats:
        """Probabilities that the vacuum is enough, where labels are foretold."""
        return self.share[:, BINS // 2 :].sum(axis=1)[_bins(foretold)]


class Foreteller(Protocol):
    """Fits labels to features of places."""

    def fit(self, features: Floats, worth: Floats, seed: int, steps: int) -> None:
        """Fit to features (N, D) and labels (N,)."""
        ...

    def predict(self, features: Floats) -> Floats:
        """Labels (T,) of places with features (T, D)."""
        ...

    def state(self) -> dict[str, Any]:
        """Arrays by name."""
        ...

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Load a fit."""
        ...


@final
class Straight:
    """A linear regression on features of depth: the small one, which a person could write down."""

    def __init__(self) -> None:
        self._columns = np.array(SIGHTS["depth"])
        self._weights = np.zeros(len(self._columns) + 1)

    def fit(self, features: Floats, worth: Floats, seed: int, steps: int) -> None:
        """Fit to features (N, D) and labels (N,); `seed` and `steps` are not used."""
        x = self._inputs(features)
        penalty = PENALTY * np.eye(x.shape[1])
        self._weights = np.linalg.solve(x.T @ x + penalty, x.T @ worth)

    def predict(self, features: Floats) -> Floats:
        """Labels (T,) of places with features (T, D)."""
        return np.clip(self._inputs(features) @ self._weights, 0.0, 1.0)

    def _inputs(self, features: Floats) -> Floats:
        return np.concatenate([features[:, self._columns], np.ones((len(features), 1))], axis=1)

    def state(self) -> dict[str, Any]:
        """The weights."""
        return {"weights": self._weights}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Load the weights."""
        self._weights = np.asarray(state["weights"], dtype=np.float64)


@final
class Foretold:
    """Foretells readings of the gauge at all places of pictures.

    Args:
        regressor: foretells labels.
    """

    def __init__(self, regressor: Foreteller) -> None:
        self._regressor = regressor
        self.table = LabelTable()

    def practise(self, level: str | GraspConfig, tries: int, seed: int) -> None:
        """Learn from tries at fresh objects in a cell without drift: at random first, then where a hold is likely.

        The table is of the last tries, before which the regression was fitted.
        """
        random, first = np.random.default_rng([seed, 5]), int(RANDOM * tries)
        tried, begin, rounds = _Tried.none(), 0, max((tries - first) // ROUND, 1)
        for number, size in enumerate((first, *[(tries - first) // rounds] * rounds)):
            scenes = Scenes.draw(level, size, 7919 * (seed + 1) + begin)
            parts = [self._try(part, random, is_random=begin == 0) for part in scenes.parts(PART)]
            fresh, begin = concatenate_records(parts), begin + size
            if number > 0:
                foretold = np.where(fresh.on, self._regressor.predict(fresh.values), 0.0)
                table = LabelTable.counted(foretold, fresh.label)
                self.table = table if number == 1 else LabelTable((self.table.share + table.share) / 2.0)
            tried = concatenate_records([tried, fresh])
            steps = STEPS if number == rounds else QUICK_STEPS
            self._regressor.fit(tried.values[tried.on], tried.label[tried.on], seed, steps)

    def _try(self, scenes: Scenes, random: np.random.Generator, *, is_random: bool) -> _Tried:
        """One try at each object."""
        features = place_features(scenes.images, scenes.radius)
        score = random.gumbel(size=len(features.picture))
        if not is_random:
            holds = blur_maps(self.table.held(self.maps(features)))
            worth = holds[features.picture, features.pixel[:, 0], features.pixel[:, 1]]
            score += (random.random(features.pictures) >= EXPLORES)[features.picture] * worth / TEMPERATURE
        places, rows = _places(features, score, random)
        label = labels(scenes.try_places(places).vacuum, scenes.radius, scenes.surface)
        return _Tried(rows >= 0, features.values[np.maximum(rows, 0)], label)

    def maps(self, features: PlaceFeatures) -> Floats:
        """Labels that are foretold (N, 48, 48); 0 beside the objects."""
        return features.maps(self._regressor.predict(features.values), 0.0)

    def predict(self, values: Floats) -> Floats:
        """Labels (T,) that are foretold of places with features (T, D)."""
        return self._regressor.predict(values)

    def state(self) -> dict[str, Any]:
        """Arrays by name."""
        return {**self._regressor.state(), "table": self.table.share}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Load a fit."""
        self._regressor.restore({name: array for name, array in state.items() if name != "table"})
        self.table = LabelTable(np.asarray(state["table"], dtype=np.float64))


def networks_foretell() -> Foretold:
    """A committee of networks that foretells."""
    return Foretold(PlaceNetwork(SIGHTS["local"], len(NAMES)))


def _bins(labels: Floats) -> Ints:
    return np.minimum((labels * BINS).astype(np.int64), BINS - 1)


class _Tried(NamedTuple):
    """N tries."""

    on: Bools
    """Whether the cup was sent to a pixel that shows the object (N,)."""
    values: Floats
    """Features of the place (N, D)."""
    label: Floats

    @classmethod
    def none(cls) -> _Tried:
        """No try yet."""
        return cls(np.zeros(0, dtype=np.bool_), np.zeros((0, len(NAMES))), np.zeros(0))


def _places(features: PlaceFeatures, score: Floats, random: np.random.Generator) -> tuple[Floats, Ints]:
    """A place for each picture (N, 2) [m], and its row in the features (N,), -1 beside the object."""
    places = features.best(score)
    anywhere = random.random(features.pictures) < BESIDE
    places[anywhere] = random.uniform(-AROUND, AROUND, (int(anywhere.sum()), 2))
    grid = features.maps(np.arange(len(features.picture), dtype=np.float64), -1.0)
    line = pixel_places()
    column = np.abs(places[:, :1] - line[0, :, 0]).argmin(axis=1)
    row = np.abs(places[:, 1:] - line[:, 0, 1]).argmin(axis=1)
    return places, grid[np.arange(features.pictures), row, column].astype(np.int64)
