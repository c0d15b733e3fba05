"""Features of depth and colour at the places of pictures where a cup could stand: the pixels that show an object."""

from __future__ import annotations

from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints, words
from pnt_gym.cells.grasp.images import pixel_places

from .rows import Place

NAMES: Final = tuple(Place.fields)
"""Names of the features."""
OF_KIND: Final = ("object_gray", "object_warm")
"""Colours of the whole object, by which a network recognises kinds; on unseen kinds such knowledge misleads."""
COLOURS: Final = (*OF_KIND, "gray_in", "warm_in", "gray_texture", "warm_texture", "gray_step", "warm_step")
"""Features that a camera of depths alone does not see."""
SIGHTS: Final = {
    "all": tuple(range(len(NAMES))),
    "local": tuple(k for k, name in enumerate(NAMES) if name not in OF_KIND),
    "depth": tuple(k for k, name in enumerate(NAMES) if name not in COLOURS),
}
"""Columns of the features that a network sees, by name."""
MOST_PIXELS: Final = 48 * 48
CHUNK: Final = 256
"""Pictures whose features are computed at once, to bound the memory."""


@final
class PlaceFeatures(NamedTuple):
    """Features of T places in N pictures; the places of a picture are neighbours in the arrays."""

    picture: Ints
    """Index of the picture, ascending (T,)."""
    pixel: Ints
    """Row and column (T, 2)."""
    values: Floats
    """(T, 26), in the order of `NAMES`."""
    pictures: int
    """Number of pictures N."""

    def column(self, name: str) -> Floats:
        """A feature by its name (T,)."""
        return self.values[:, NAMES.index(name)]

    def places(self) -> Floats:
        """The places from the middles of their pictures, along the world's axes (T, 2) [m]."""
        return pixel_places()[self.pixel[:, 0], self.pixel[:, 1]]

    def apart_from(self, places: Floats, radius: Floats) -> PlaceFeatures:
        """The places that are not within a radius (N,) [m] of a place (N, 2) [m] in each picture, NaN for no place.

        A picture whose places are all within the radius keeps all of them.
        """
        away = self.places() - places[self.picture]
        is_apart = ~(np.hypot(away[:, 0], away[:, 1]) < radius[self.picture])
        is_apart |= (np.bincount(self.picture[is_apart], minlength=self.pictures) == 0)[self.picture]
        return PlaceFeatures(self.picture[is_apart], self.pixel[is_apart], self.values[is_apart], self.pictures)

    def ranked_rows(self, score: Floats) -> Ints:
        """Rows (T,), those of each picture together, by falling score (T,)."""
        return np.lexsort((-score, self.picture))

    def best_rows(self, score: Floats) -> Ints:
        """Rows of the highest score (T,) in each picture that has places, in the order of the pictures."""
        order = self.ranked_rows(score)
        first = np.flatnonzero(
            np.diff(self.picture, prepend=-1)
        )  # the pictures ascend, so their rows keep their places
        return order[first]

    def best(self, score: Floats) -> Floats:
        """The place with the highest score (T,) in each picture (N, 2) [m]; the middle without an object."""
        chosen, rows = np.zeros((self.pictures, 2)), self.best_rows(score)
        chosen[self.picture[rows]] = self.places()[rows]
        return chosen

    def highest(self, score: Floats) -> Floats:
        """The highest score (T,) in each picture (N,); -inf without an object."""
        most, rows = np.full(self.pictures, -np.inf), self.best_rows(score)
        most[self.picture[rows]] = score[rows]
        return most

    def maps(self, score: Floats, empty: float = np.nan) -> Floats:
        """Scores (T,) as maps (N, 48, 48)."""
        maps = np.full((self.pictures, 48, 48), empty)
        maps[self.picture, self.pixel[:, 0], self.pixel[:, 1]] = score
        return maps


def place_features(images: NDArray[np.uint8], radius: Floats, *, of_all: bool = False) -> PlaceFeatures:
    """Features of the places in pictures.

    Args:
        images: pictures (N, 5, 48, 48), see `pnt_gym.cells.grasp.images`.
        radius: radii of the cups (N,) [m].
        of_all: whether to give the places on all objects, or on the object nearest to the picture's middle.
    """
    from .feature_kernel import write_features  # noqa: PLC0415 - numba takes a while

    chunks: list[tuple[Ints, Floats]] = []
    for begin in range(0, len(images), CHUNK):
        part = np.ascontiguousarray(images[begin : begin + CHUNK])
        most = len(part) * MOST_PIXELS
        pixels, rows = np.empty((most, 3), dtype=np.int64), Place.empty(most)
        total = write_features(part, np.ascontiguousarray(radius[begin : begin + CHUNK]), of_all, pixels, rows)
        chunks.append((pixels[:total].copy(), words(rows[:total]).copy()))
    picture = np.concatenate([pixels[:, 0] + CHUNK * k for k, (pixels, _) in enumerate(chunks)])
    pixel = np.concatenate([pixels[:, 1:] for pixels, _ in chunks])
    return PlaceFeatures(picture, pixel, np.concatenate([values for _, values in chunks]), len(images))


BLUR: Final = 0.0045
"""Standard deviation of the blur of a map: about the error of the cup's place [m]."""


def blur_maps(maps: Floats, deviation: float | tuple[float, float] = BLUR) -> Floats:
    """Maps (N, 48, 48) averaged over errors with a standard deviation [m], across and along the belt; 0 outside."""
    across, along = deviation if isinstance(deviation, tuple) else (deviation, deviation)
    return _blur(_blur(maps, along, 2), across, 1)


def _blur(maps: Floats, deviation: float, axis: int) -> Floats:
    """Maps averaged along an axis by a normal distribution's weights."""
    pixel = pixel_places()[0, 1, 0] - pixel_places()[0, 0, 0]
    reach = int(np.ceil(3.0 * deviation / pixel))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) * pixel / deviation) ** 2)
    padded = np.pad(maps, [(reach, reach) if axis == k else (0, 0) for k in range(3)])
    size = maps.shape[axis]
    parts = (weight * np.take(padded, np.arange(k, k + size), axis) for k, weight in enumerate(weights / weights.sum()))
    return np.asarray(sum(parts))


def best_places(maps: Floats) -> Floats:
    """Places (N, 2) [m] of the highest values of maps (N, 48, 48), from the middles of the pictures."""
    pixel = maps.reshape(len(maps), -1).argmax(axis=1)
    return pixel_places().reshape(-1, 2)[pixel]
