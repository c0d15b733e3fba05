"""What the gauge will say of a try at a place, foretold from a picture, and how likely a reading is then.

Tries in a calibrated cell teach it: a regression foretells a label of the vacuum, and a table says how the labels are
spread where the regression foretells a value.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, Protocol, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.grasp.config import GraspConfig, Surface
from pnt_gym.cells.grasp.images import pixel_places

from .features import NAMES, SIGHTS, PlaceFeatures, place_features
from .network import PlaceNetwork
from .scenes import Scenes

BINS: Final = 10
"""Parts of the range of labels, foretold and read."""
RANGE: Final = 6.0
"""Range of the logarithm of the vacuum over the least one, which labels from 0 to 1 stand for."""
STEPS: Final = 3000
PART: Final = 2000
"""Objects whose pictures are seen at once, to bound the memory."""
BESIDE: Final = 0.3
"""Share of the tries that are anywhere around the object's middle, also beside the object."""
AROUND: Final = 0.08
"""Largest distance of these tries from the middle, along each axis [m]."""
PENALTY: Final = 1.0
"""Ridge penalty, per object."""


def labels(vacuum: Floats, radius: Floats, surface: Surface) -> Floats:
    """Labels from 0 to 1 of readings [N] under cups of radii [m], (N,) each; 1/2 is the least that counts as held."""
    least = surface.pressure * np.pi * radius**2
    return np.clip(0.5 + np.log(np.maximum(vacuum, 1e-6) / least) / RANGE, 0.0, 1.0)


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
        self._table = np.full((BINS, BINS), 1.0 / BINS)
        """Shares of the labels that were read (columns), by the label that was foretold (rows)."""

    def practise(self, level: str | GraspConfig, tries: int, seed: int) -> None:
        """Learn from tries at fresh objects of a level, in a cell without drift."""
        random = np.random.default_rng([seed, 5])
        scenes = Scenes.draw(level, tries, 7919 * (seed + 1))
        seen, values, read = list[Any](), list[Floats](), list[Floats]()
        for part in scenes.parts(PART):
            features = place_features(part.images, part.radius)
            places, rows = _places(features, random)
            read.append(labels(part.try_places(places).vacuum, part.radius, part.surface))
            seen.append(rows >= 0)
            values.append(features.values[np.maximum(rows, 0)])
        on, x, y = np.concatenate(seen), np.concatenate(values), np.concatenate(read)
        half = np.arange(len(y)) < len(y) // 2
        self._regressor.fit(x[on & half], y[on & half], seed, STEPS)
        foretold = np.where(on, self._regressor.predict(x), 0.0)
        rest = ~half  # of other objects than those of the fit
        count = np.full((BINS, BINS), 0.5)
        np.add.at(count, (_bins(foretold[rest]), _bins(y[rest])), 1.0)
        self._table = count / count.sum(axis=1, keepdims=True)

    def maps(self, features: PlaceFeatures) -> Floats:
        """Labels that are foretold (N, 48, 48); 0 beside the objects."""
        return features.maps(self._regressor.predict(features.values), 0.0)

    def likelihood(self, foretold: Floats, read: Floats) -> Floats:
        """Likelihoods (K, ...) of labels that were read (K,), where (K, ...) were foretold."""
        shape = (len(read), *([1] * (foretold.ndim - 1)))
        return self._table[_bins(foretold), _bins(read).reshape(shape)]

    def held(self, foretold: Floats) -> Floats:
        """Probabilities that the vacuum is enough, where labels are foretold."""
        return self._table[:, BINS // 2 :].sum(axis=1)[_bins(foretold)]

    def state(self) -> dict[str, Any]:
        """Arrays by name."""
        return {**self._regressor.state(), "table": self._table}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Load a fit."""
        self._regressor.restore({name: array for name, array in state.items() if name != "table"})
        self._table = np.asarray(state["table"], dtype=np.float64)


def networks_foretell() -> Foretold:
    """A committee of networks that foretells."""
    return Foretold(PlaceNetwork(SIGHTS["local"], len(NAMES)))


def _bins(labels: Floats) -> Ints:
    return np.minimum((labels * BINS).astype(np.int64), BINS - 1)


def _places(features: PlaceFeatures, random: np.random.Generator) -> tuple[Floats, Ints]:
    """A place for each picture (N, 2) [m], and its row in the features (N,), -1 beside the object."""
    places = features.best(random.gumbel(size=len(features.picture)))
    anywhere = random.random(features.pictures) < BESIDE
    places[anywhere] = random.uniform(-AROUND, AROUND, (int(anywhere.sum()), 2))
    grid = features.maps(np.arange(len(features.picture), dtype=np.float64), -1.0)
    line = pixel_places()
    column = np.abs(places[:, :1] - line[0, :, 0]).argmin(axis=1)
    row = np.abs(places[:, 1:] - line[:, 0, 1]).argmin(axis=1)
    return places, grid[np.arange(features.pictures), row, column].astype(np.int64)
