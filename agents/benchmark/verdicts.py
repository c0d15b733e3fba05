"""Verdicts on rows that were thrown again: equal, within the bounds of another processor, or different."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Bools

EQUAL: Final = "equal"
NEAR: Final = "equal within the bounds"
"""Verdict on rows that differ by no more than another processor explains."""
DIFFERENT: Final = "different"
LEFT_OUT: Final = "left out"
VERDICTS: Final = (EQUAL, NEAR, DIFFERENT, LEFT_OUT)
"""Verdicts, the best one first."""
BOUNDS: Final = {"along_m": 1e-4, "across_m": 1e-4, "error_m": 1e-4, "cycle_s": 1e-3}
"""Largest difference of a column's values that another processor explains, landings in m and times in s."""
FEW: Final = 0.01
"""Share of the throws that may differ by more, or have another outcome: a throw at a rim may fall to either side."""


def judge(row: Mapping[str, Any], anew: Mapping[str, Any], others: Mapping[str, str]) -> dict[str, Any]:
    """Verdict on a row by the same row computed anew, and the first difference.

    What the file says of its making has no part in whether throws are equal.

    Args:
        row: the row of the file.
        anew: the row computed here.
        others: versions here that the file has otherwise.
    """
    code_here = anew["digests"]["code"]
    is_other_code = bool(others) or row.get("digests", {}).get("code", code_here) != code_here
    is_elsewhere = rounds_otherwise(row, anew)
    difference = row_difference(row, anew, is_same_code=not is_other_code and not is_elsewhere)
    is_of_throws = difference is not None and difference["column"] in row["columns"]
    is_within = is_of_throws and is_near(row["columns"], anew["columns"])
    return {
        "verdict": EQUAL if difference is None else NEAR if is_within else DIFFERENT,
        "difference": difference,
        "why": None,
        "elsewhere": is_elsewhere,
        "other_code": is_other_code,
    }


def row_difference(row: Mapping[str, Any], anew: Mapping[str, Any], *, is_same_code: bool) -> dict[str, Any] | None:
    """First difference of two rows; None if all throws agree, and under the same code level and policy as well.

    Another version may describe the same level or policy with other words, so that throws alone count there.
    """
    difference = first_difference(row["columns"], anew["columns"])
    if difference is not None or not is_same_code:
        return difference
    digests, digests_here = row.get("digests", {}), anew["digests"]
    for name in ("level", "policy"):
        if name in digests and digests[name] != digests_here[name]:
            return {"column": name, "at": None, "file": digests[name], "here": digests_here[name], "count": 1}
    return None


def rounds_otherwise(row: Mapping[str, Any], anew: Mapping[str, Any]) -> bool:
    """Whether a row is of a processor whose arithmetic, or whose torch where torch computed anew, is not that here."""
    made_on, here = row.get("digests", {}), anew["digests"]
    return any(name in here and made_on.get(name, here[name]) != here[name] for name in ("arithmetic", "torch"))


def first_difference(old: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any] | None:
    """First column that differs, at which throw, both values and the number of differing throws; None if all agree."""
    for name in (*old, *(name for name in new if name not in old)):
        before, now = old.get(name), new.get(name)
        if before == now:
            continue
        if not (isinstance(before, list | str) and isinstance(now, list | str) and len(before) == len(now)):
            return {"column": name, "at": None, "file": before, "here": now, "count": 1}
        places = [n for n, (x, y) in enumerate(zip(before, now, strict=True)) if x != y]
        return {
            "column": name,
            "at": places[0],
            "file": before[places[0]],
            "here": now[places[0]],
            "count": len(places),
        }
    return None


def is_near(old: Mapping[str, Any], new: Mapping[str, Any]) -> bool:
    """Whether the columns of two rows agree within the bounds: the same objects, and all but few throws the same.

    Columns without a bound must be equal; totals may differ by as many throws as may have another outcome.
    """
    count = len(old.get("outcome", ""))
    far: Bools | None = None
    for name, before in old.items():
        now = new.get(name)
        if isinstance(before, int | float):
            if not isinstance(now, int | float) or abs(before - now) > FEW * max(count, abs(now)):
                return False
            continue
        if not isinstance(before, list | str) or not isinstance(now, list | str) or len(now) != len(before):
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
