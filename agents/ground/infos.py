"""Results of the throws of a step, from the infos of vector environments."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools
from pnt_gym.cells.base.core import EPISODE_SUCCESS

LANDING: Final = ("landing_error", "landing_along", "landing_across")
"""Info keys of landing errors; an object that was dropped before its release has none."""


def rows_thrown(info: Mapping[str, Any], count: int) -> Bools:
    """Which of N rows carried out a throw in a step (N,): those whose info has a `cycle_time`."""
    thrown = np.zeros(count, dtype=np.bool_)
    for part in (info, info.get("final_info", {})):
        if "cycle_time" in part:
            thrown |= np.asarray(part.get("_cycle_time", np.ones(count, dtype=np.bool_)))
    return thrown


def results(info: Mapping[str, Any], count: int) -> dict[str, NDArray[Any]]:
    """Results of N throws by info key (N,), without `kind` of the coming throws and what whole episodes have.

    Gymnasium's own vector environments return the info of an episode's last step separately, in `final_info`. Where an
    object was dropped before its release, the landing errors are NaN.
    """
    final = info.get("final_info", {})
    over = np.asarray(info.get("_final_info", np.zeros(count, dtype=np.bool_)))
    columns, has_ended = dict[str, NDArray[Any]](), bool(over.any())
    for name in {**info, **final}:
        if name not in ("kind", EPISODE_SUCCESS) and not name.startswith("_"):
            values = np.asarray(info.get(name, final.get(name)))
            if values.shape == (count,) and values.dtype.kind in "biuf":
                columns[name] = np.where(over, final.get(name, values), values) if has_ended else values.copy()
    if "dropped" in columns:
        lost = columns["dropped"].astype(np.bool_)
        columns |= {name: np.where(lost, np.nan, columns[name]) for name in LANDING if name in columns}
    return columns
