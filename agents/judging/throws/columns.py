"""Throws as a benchmark keeps them: columns, rounded."""

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
"""Letter of each outcome: sorted; a success in a bin of another kind; not picked; lost on the way to the release;
touched again by the robot; crossed the opening only; or missed it, which every failure counts as in a cell that does
not tell how a throw failed."""


def columns(throws: Throws) -> dict[str, Any]:
    """Throws as columns, rounded to 0.01 mm and 0.1 ms; cells without an along and across tell the error alone."""
    told = {"along_m": "landing_along", "across_m": "landing_across"}
    places = {column: throws.told[name] for column, name in told.items() if name in throws.told}
    return {
        "item": throws.item.tolist(),
        **{column: _rounded(values, 5) for column, values in (places or {"error_m": throws.landing_error}).items()},
        "cycle_s": _rounded(throws.cycle_time, 4),
        "outcome": _outcomes(throws),
        **({"pick": throws.told["pick_in_shift"].tolist()} if "pick_in_shift" in throws.told else {}),
        "clipped": int(throws.clipped.sum()),
        "recontact": int(_flag(throws, "recontact").sum()),
        **_counts(throws),
    }


def _counts(throws: Throws) -> dict[str, float]:
    """Of all throws together, as far as the cell tells: objects in any bin and where they belong, passed, and joules.

    Those that were lost on the way are counted beside the letters, which tell of none that was sorted nevertheless.
    """
    told, counts = throws.told, dict[str, float]()
    if "belongs" in told:
        counts |= {"ended": int((told["ended_in"] >= 0).sum()), "belong": int(told["belongs"].sum())}
    for name in ("passed", "dropped"):
        if name in told:
            counts[name] = int(told[name].sum())
    return counts | ({"energy_j": round(float(told["energy"].sum()), 1)} if "energy" in told else {})


def _outcomes(throws: Throws) -> str:
    """One letter of `OUTCOMES` per throw."""
    *letters, missed = OUTCOMES.values()
    kinds = [throws.sorted, throws.is_success, *(_flag(throws, name) for name in FAILURES)]
    return "".join(np.select(kinds, letters, missed))


def _flag(throws: Throws, name: str) -> Bools:
    flag = throws.flag(name)
    return np.zeros(len(throws), dtype=np.bool_) if flag is None else flag


def _rounded(values: np.ndarray, digits: int) -> list[float | None]:
    return [round(float(v), digits) if np.isfinite(v) else None for v in values]
