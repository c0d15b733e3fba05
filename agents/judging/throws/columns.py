"""Throws as the rounded columns that a benchmark keeps."""

from __future__ import annotations

from typing import Annotated, Any, Final, Self

import numpy as np
from pydantic import Field, model_validator

from pnt_gym.arrays import Bools

from ..form import LARGEST, Amount, Columns, Count, Number
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

PLACES: Final = {"along_m": "landing_along", "across_m": "landing_across"}
"""Columns with the landing along and across the throw [m], and their `info` keys."""


class ThrowColumns(Columns):
    """Form of the columns of N throws; totals of all throws are single numbers."""

    item: list[Count]
    along_m: list[Number | None] = Field(default_factory=list)
    across_m: list[Number | None] = Field(default_factory=list)
    error_m: list[Amount | None] = Field(default_factory=list)
    cycle_s: list[Annotated[float, Field(gt=0.0, le=LARGEST)]]
    outcome: Annotated[str, Field(pattern=f"^[{''.join(OUTCOMES.values())}]*$")]
    pick: list[Count] = Field(default_factory=list)
    clipped: Count
    recontact: Count
    ended: Count = 0
    belong: Count = 0
    passed: Count = 0
    dropped: Count = 0
    tries: Count = 0
    energy_j: Amount = 0.0

    @model_validator(mode="after")
    def _check_totals(self) -> Self:
        given = self.model_fields_set
        if given & {*PLACES, "error_m"} not in ({*PLACES}, {"error_m"}):
            raise ValueError("landings are the columns along_m and across_m, or the column error_m")
        if len(given & {"ended", "belong"}) == 1:
            raise ValueError("of the totals ended and belong one is missing")
        for name in ("clipped", "recontact", "ended", "belong", "dropped"):
            if getattr(self, name) > len(self.outcome):
                raise ValueError(f"{name} is {getattr(self, name)}; there are {len(self.outcome)} throws")
        return self


def columns(throws: Throws) -> dict[str, Any]:
    """Throws as columns, rounded to 0.01 mm and 0.1 ms; cells without landing along and across have the error alone."""
    places = {column: throws.info[name] for column, name in PLACES.items() if name in throws.info}
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
