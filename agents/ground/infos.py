"""What the infos of vector environments say of the steps that were done, row by row."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

LANDING: Final = ("landing_error", "landing_along", "landing_across")
"""How far from its target a throw came down; an object that was lost on the way to its release was not thrown."""


def results(info: Mapping[str, Any], count: int) -> dict[str, NDArray[Any]]:
    """What N throws came to, number by number (N,), but for `kind`, which is of the coming ones.

    Gymnasium's own vector environments keep what ended an episode apart, in `final_info`. Where an object was lost on
    the way to its release, its landing is no throw's, and NaN.
    """
    final = info.get("final_info", {})
    over = np.asarray(info.get("_final_info", np.zeros(count, dtype=np.bool_)))
    found: dict[str, NDArray[Any]] = {}
    for name in {**info, **final}:
        if name != "kind" and not name.startswith("_"):
            values = np.asarray(info.get(name, final.get(name)))
            if values.shape == (count,) and values.dtype.kind in "biuf":
                found[name] = np.where(over, final.get(name, values), values)
    if "dropped" in found:
        lost = found["dropped"].astype(np.bool_)
        found |= {name: np.where(lost, np.nan, found[name]) for name in LANDING if name in found}
    return found
