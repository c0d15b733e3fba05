"""Within what bounds rows that were made on another processor count as the same."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Bools

BOUNDS: Final = {"along_m": 1e-4, "across_m": 1e-4, "error_m": 1e-4, "cycle_s": 1e-3}
"""Largest difference of a column's values that another processor explains, landings in m and times in s."""
FEW: Final = 0.01
"""Share of the throws that may differ by more, or have another outcome: a throw at a rim may fall to either side."""


def is_near(old: Mapping[str, Any], new: Mapping[str, Any]) -> bool:
    """Whether the columns of two rows agree within the bounds: the same objects, and all but few throws the same.

    Columns without a bound must be equal; totals of all throws are not compared, which follow from the throws.
    """
    far: Bools | None = None
    for name, before in old.items():
        now = new.get(name)
        if not isinstance(before, list | str):
            continue
        if not isinstance(now, type(before)) or len(now) != len(before):
            return False
        if name not in BOUNDS and name != "outcome":
            if before != now:
                return False
            continue
        differs = _differences(before, now, BOUNDS.get(name))
        far = differs if far is None else far | differs
    return far is not None and float(far.mean()) <= FEW


def _differences(before: Any, now: Any, bound: float | None) -> Bools:
    """Which throws differ, by more than the bound if there is one."""
    if bound is None:
        return np.array([x != y for x, y in zip(before, now, strict=True)], dtype=np.bool_)
    left, right = (np.array([np.nan if x is None else x for x in side], dtype=np.float64) for side in (before, now))
    is_far = np.abs(left - right) > bound + 1e-9  # the bound itself is within, however its decimals round
    return is_far | (np.isnan(left) != np.isnan(right))
