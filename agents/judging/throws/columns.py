"""Throws as the rounded columns that a benchmark keeps."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Bools

from .data import FAILURES, Throws

OUTCOMES: Final = {
    "sorted": "s",
    "astray": "a",
    "unpicked": "p",
    "dropped": "d",
    "recontact": "t",
    "rim": "r",
    "missed": "m",
}
"""Letter of each outcome: sorted; success in a bin of another kind; not picked; dropped before the release; touched
again by the robot; crossed the opening without staying; or missed it. In a cell whose info has no failures every
failure counts as missed."""


def columns(throws: Throws) -> dict[str, Any]:
    """Throws as columns, rounded to 0.01 mm and 0.1 ms; cells without landing along and across have the error alone."""
    sources = {"along_m": "landing_along", "across_m": "landing_across"}
    places = {column: throws.info[name] for column, name in sources.items() if name in throws.info}
    return {
        "item": throws.item.tolist(),
        **{column: _round(values, 5) for column, values in (places or {"error_m": throws.landing_error}).items()},
        "cycle_s": _round(throws.cycle_time, 4),
        "outcome": _outcomes(throws),
        **({"pick": throws.info["pick_in_shift"].tolist()} if "pick_in_shift" in throws.info else {}),
        "clipped": int(throws.clipped.sum()),
        "recontact": int(_flag(throws, "recontact").sum()),
        **_counts(throws),
    }


def _counts(throws: Throws) -> dict[str, float]:
    """Totals of all throws, where the cell has them: objects in bins, in their own bins and passed, and energy [J].

    Dropped objects are counted here too, because a dropped object that was sorted nevertheless has another letter.
    """
    info, counts = throws.info, dict[str, float]()
    if "belongs" in info:
        counts |= {"ended": int((info["ended_in"] >= 0).sum()), "belong": int(info["belongs"].sum())}
    for name in ("passed", "dropped", "tries"):
        if name in info:
            counts[name] = int(info[name].sum())
    return counts | ({"energy_j": round(float(info["energy"].sum()), 1)} if "energy" in info else {})


def _outcomes(throws: Throws) -> str:
    """Outcomes of the throws, one letter of `OUTCOMES` per throw."""
    *letters, missed = OUTCOMES.values()
    kinds = [throws.sorted, throws.is_success, *(_flag(throws, name) for name in FAILURES)]
    return "".join(np.select(kinds, letters, missed))


def _flag(throws: Throws, name: str) -> Bools:
    flag = throws.flag(name)
    return np.zeros(len(throws), dtype=np.bool_) if flag is None else flag


def _round(values: np.ndarray, digits: int) -> list[float | None]:
    return [round(float(v), digits) if np.isfinite(v) else None for v in values]
