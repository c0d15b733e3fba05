"""What a shift of grasps has taught so far: where the cup comes down, and how objects of a look were held and landed.

No hidden kind is read. Objects are alike as far as their measured extents, shapes and colours are; what is recalled of
earlier objects is a mean with weights by that likeness.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple, Protocol, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.grasp.config import PIXEL, PIXELS
from pnt_gym.rows import Columns, Pair, field

from .features import NAMES, PlaceFeatures

SCALES: Final = {"length": 0.10, "width": 0.10, "height": 0.10, "shape": 0.5, "gray": 0.06, "warm": 0.12}
"""Differences at which objects count as one unit apart: of the logarithms of extents, of the shape, and of colours."""
WIDTH: Final = 4.0
"""Squared distance of looks at which the likeness of two objects has fallen to 1/e."""
REACH: Final = 6
"""Largest error of the cup that is thought of, in pixels."""
SIDE: Final = 2 * REACH + 1
_WRAPS: Final = 64
"""Side of a picture with its border, of at least `REACH` on each side, for transforms."""
LANDING: Final = (0.040, 0.012)
"""Standard deviations of what landings say of the cup's error, along and across the throw, from practice [m]."""
LANDS: Final = 0.8
"""Displacement of a landing over the error of the cup, from practice."""
CHANCE: Final = 0.05
"""Share of tries and landings that say nothing of the cup's error; assumed."""
DOUBT: Final = 0.01
"""Doubt of the cup's error that counts as 1 among features [m]."""


def turned(x: Floats, y: Floats, direction: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Vectors of x and y along a throw and to its left, by the horizontal unit vector of the throw."""
    ex, ey = direction
    return x * ex + y * ey, y * ex - x * ey


@final
class Event(Columns):
    """An earlier object of a shift."""

    tried: Bools = field("-", "whether the cup tried")
    held: Bools = field("-", "whether the object hung under the cup in the end")
    surprise: Floats = field("-", "gauge label of the last try, less that foretold")
    thrown: Bools = field("-", "whether the object was thrown")
    dropped: Bools = field("-", "whether the cup lost the object")
    hit: Bools = field("-", "whether the bin's camera saw the object land near its target")
    landed: Bools = field("-", "whether the bin's camera saw the landing")
    off: Pair = field("m", "landing that the usual correction would have given, along and left of the throw")
    direction: Pair = field("-", "horizontal unit vector of the throw")


@final
class Recalled(NamedTuple):
    """Means over earlier objects of a look, and their weights (N,) each, as numbers of the order of 1."""

    tries: Floats
    """Weight of the tries."""
    held: Floats
    """Held minus `USUAL`, summed, over the weight and 1."""
    surprise: Floats
    throws: Floats
    dropped: Floats
    hit: Floats
    landings: Floats
    along: Floats
    """Landing without the part of the cup's error [m], summed, over the weight and 1/2."""
    across: Floats

    def columns(self) -> Floats:
        """The values as features (N, 9)."""
        scaled = (np.log1p(self.tries), self.held, self.surprise, np.log1p(self.throws), self.dropped, self.hit)
        return np.stack([*scaled, np.log1p(self.landings), self.along / 0.05, self.across / 0.05], axis=1)


USUAL: Final = 0.7
"""Chance to be held, and to be hit, of a look of which nothing is known; assumed."""
MEMORIES: Final = len(Recalled._fields) + 1
"""Numbers in which a memory tells what it knows: means over objects of a look, and the doubt of the cup's error."""


def looks(values: dict[str, Floats], features: PlaceFeatures) -> Floats:
    """Looks of objects (N, 8), in units in which equal kinds are about 1 apart.

    Args:
        values: decoded vectors of the observations.
        features: features of the places in their pictures.
    """
    first = np.flatnonzero(np.diff(features.picture, prepend=-1))
    colours = np.zeros((features.pictures, 2))
    index = [NAMES.index(name) for name in ("object_gray", "object_warm")]
    colours[features.picture[first]] = features.values[first][:, index]
    extents = [np.log(np.maximum(values[name], 0.005)) / SCALES[name] for name in ("length", "width", "height")]
    shapes = [values[name] / SCALES["shape"] for name in ("is_ellipsoid", "is_cylinder", "is_box")]
    return np.stack([*extents, *shapes, colours[:, 0] / SCALES["gray"], colours[:, 1] / SCALES["warm"]], axis=1)


class ShiftMemory:
    """Memory of N rows, each of the shift in which it is.

    Subclasses remember in other ways.

    Args:
        count: number of rows N.
        length: picks of a shift.
        spread: standard deviation of the cup's error before anything is known of it, per axis [m].
    """

    attends = True
    """Whether the gauge is foretold with attention to the earlier tries."""

    def __init__(self, count: int, length: int, spread: float) -> None:
        line = PIXEL * np.arange(-REACH, REACH + 1)
        self.offsets: Floats = np.stack(np.broadcast_arrays(line[None, :], -line[:, None]), axis=-1)
        """Errors that are thought of (SIDE, SIDE, 2) [m]; rows go towards smaller y, as in pictures."""
        self._prior = -0.5 * (self.offsets**2).sum(axis=-1) / max(spread, 1e-4) ** 2
        first = np.exp(self._prior)
        self.first: Floats = first / first.sum()
        """Probabilities of the errors before anything is known (SIDE, SIDE)."""
        self._log = np.tile(self._prior, (count, 1, 1))
        self._looks = np.zeros((count, length, 8))
        self._events = Event.of(count * length)
        self._length, self._known = length, np.zeros(count, dtype=np.int64)

    def begin(self, rows: Ints) -> None:
        """Forget the former shifts of some rows."""
        self._log[rows], self._known[rows] = self._prior, 0

    def weights(self, rows: Ints) -> Floats:
        """Probabilities of the cup's errors (K, SIDE, SIDE)."""
        log = self._log[rows]
        weights = np.exp(log - log.max(axis=(1, 2), keepdims=True))
        return weights / weights.sum(axis=(1, 2), keepdims=True)

    def error(self, rows: Ints) -> Floats:
        """Expected errors of the cup (K, 2) [m]."""
        return np.einsum("kij,ijc->kc", self.weights(rows), self.offsets)

    def doubt(self, rows: Ints) -> Floats:
        """Standard deviations of the cup's error (K,) [m]."""
        weights = self.weights(rows)
        mean = np.einsum("kij,ijc->kc", weights, self.offsets)
        square = np.einsum("kij,ij->k", weights, (self.offsets**2).sum(axis=-1))
        return np.sqrt(np.maximum(square - (mean**2).sum(axis=1), 0.0))

    def watch(self, rows: Ints, likelihood: Floats) -> None:
        """Learn from tries with likelihoods of their readings for each error (K, SIDE, SIDE)."""
        self._log[rows] += np.log(likelihood + CHANCE * likelihood.mean(axis=(1, 2), keepdims=True) + 1e-9)

    def add(self, rows: Ints, looks: Floats, events: Event) -> None:
        """Keep objects (K,) of some rows, and learn of the cup's errors from their landings."""
        slot = np.minimum(self._known[rows], self._length - 1)
        self._looks[rows, slot] = looks
        self._events.put(rows * self._length + slot, events)
        self._known[rows] += 1
        landed = events.landed
        if landed.any():
            ex, ey = events.direction[landed].T[:, :, None, None]
            # An object that the cup met off its middle lands as far off, the other way.
            along, across = (-LANDS * part for part in turned(self.offsets[..., 0], self.offsets[..., 1], (ex, ey)))
            off = events.off[landed][:, :, None, None]
            square = ((off[:, 0] - along) / LANDING[0]) ** 2 + ((off[:, 1] - across) / LANDING[1]) ** 2
            self._log[rows[landed]] += np.log(np.exp(-0.5 * square) + CHANCE)

    def known(self, rows: Ints, looks: Floats) -> Floats:
        """What is known of objects of looks (K, 8) in some rows, as features (K, `MEMORIES`)."""
        return np.column_stack([self.recall(rows, looks).columns(), self.doubt(rows) / DOUBT])

    def recall(self, rows: Ints, looks: Floats) -> Recalled:
        """What is known of objects of looks (K, 8) in some rows."""
        events = self._events
        slots = rows[:, None] * self._length + np.arange(self._length)
        distance = ((self._looks[rows] - looks[:, None]) ** 2).sum(axis=-1)
        like = np.where(np.arange(self._length) < self._known[rows, None], np.exp(-distance / WIDTH), 0.0)

        def mean(of: Floats, among: Bools, prior: float) -> Floats:
            # Mean of the values of similar objects, by their likeness, with a prior of 0.
            weight = like * among[slots]
            return (weight * of[slots]).sum(axis=1) / (weight.sum(axis=1) + prior)

        ones, error = np.ones(len(events.held)), self.error(rows)
        direction = events.direction[slots]
        part = np.zeros((len(ones), 2))
        directions = direction[..., 0], direction[..., 1]
        part[slots] = -LANDS * np.stack(turned(error[:, :1], error[:, 1:], directions), axis=-1)
        off = events.off - part
        held, dropped, hit = (values.astype(np.float64) for values in (events.held, events.dropped, events.hit))
        return Recalled(
            (like * events.tried[slots]).sum(axis=1),
            mean(held - USUAL, events.tried, 1.0),
            mean(events.surprise, events.tried, 1.0),
            (like * events.thrown[slots]).sum(axis=1),
            mean(dropped, events.thrown, 1.0),
            mean(hit - USUAL, events.thrown, 1.0),
            (like * events.landed[slots]).sum(axis=1),
            mean(off[:, 0], events.landed, 0.5),
            mean(off[:, 1], events.landed, 0.5),
        )


@final
class NoMemory(ShiftMemory):
    """Forgets every object at once; the cup's error stays as unknown as before the shift."""

    attends = False

    def watch(self, rows: Ints, likelihood: Floats) -> None:
        """Learn nothing."""

    def add(self, rows: Ints, looks: Floats, events: Event) -> None:
        """Keep nothing."""

    def known(self, rows: Ints, looks: Floats) -> Floats:
        """Zeros (K, `MEMORIES`)."""
        return np.zeros((len(rows), MEMORIES))


class MakesMemory(Protocol):
    """Makes a memory of shifts."""

    def __call__(self, count: int, length: int, spread: float) -> ShiftMemory:
        """Make the memory of N rows, see `ShiftMemory`."""
        ...


def around(maps: NDArray[np.float32] | Floats, places: Floats, beside: float) -> Floats:
    """Values of maps (K, 48, 48) at places (K, 2) [m] moved by each error that is thought of (K, SIDE, SIDE).

    Args:
        maps: maps of pictures.
        places: places from the pictures' middles.
        beside: value outside of the picture.
    """
    padded: Any = np.pad(maps, [(0, 0), (REACH, REACH), (REACH, REACH)], constant_values=beside)
    column, row = (np.clip(np.rint(s * v / PIXEL + (PIXELS - 1) / 2.0), 0, PIXELS - 1).astype(np.int64)
                   for s, v in ((1.0, places[:, 0]), (-1.0, places[:, 1])))  # fmt: skip
    steps = np.arange(SIDE)
    k = np.arange(len(maps))[:, None, None]
    return padded[k, row[:, None, None] + steps[:, None], column[:, None, None] + steps]


def expected(maps: Floats, weights: Floats) -> Floats:
    """Means of maps (K, 48, 48) where a cup is sent to each pixel, over its errors with weights (K, SIDE, SIDE)."""
    kernel, steps = np.zeros((len(maps), _WRAPS, _WRAPS)), np.arange(-REACH, REACH + 1)
    kernel[:, steps[:, None], steps] = weights
    # A correlation is a product of transforms; the pictures' border is wide enough that nothing wraps around into them.
    spectrum = np.fft.rfft2(maps, (_WRAPS, _WRAPS)) * np.conj(np.fft.rfft2(kernel))
    return np.fft.irfft2(spectrum, (_WRAPS, _WRAPS))[:, :PIXELS, :PIXELS]
