"""Bins that stand in the way of a hand which carries an object."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Bools, Floats

BESIDE: Final = 0.02
"""Distance from a bin at which a carried object counts as in its way: walls and what swings under the cup [m]."""
ABOVE: Final = 0.02
"""Least height of a carried object above the rim of a bin below it [m]."""


def hits_bin(pick: Floats, stop: Floats, centre: Floats, opening: Floats, width: Floats, rise: float) -> Bools:
    """Which straight ways of a hand lead a carried object into the wall of a bin, below its rim (N,).

    A bin is taken as the circle around its opening, which errs on the safe side. The hand rises evenly on its way.

    Args:
        pick: starts of the ways (N, 3) [m].
        stop: ends of the ways (N, 3) [m].
        centre: centres of the bins' openings along x and y (N, B, 2) [m], or (1, B, 2) where all picks have the same.
        opening: inner sizes of the openings along x and y, in the same form [m].
        width: largest extents of the objects (N,) [m].
        rise: height of the bins' rims above the objects' undersides at the pick [m].
    """
    way = stop - pick
    length = np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-9)[:, None]
    gap = centre - pick[:, None, :2]
    along = (gap * (way[:, :2] / length)[:, None]).sum(axis=-1)
    beside_squared = (gap**2).sum(axis=-1) - along**2
    radius = np.hypot(opening[..., 0], opening[..., 1]) / 2.0 + width[:, None] / 2.0 + BESIDE
    entry = np.maximum(along - np.sqrt(np.maximum(radius**2 - beside_squared, 0.0)), 0.0)
    meets = (beside_squared < radius**2) & (along > 0.0) & (entry < length)
    is_low = way[:, 2:] * entry / length < rise + ABOVE
    return (meets & is_low).any(axis=1)
