"""Work shifts as columns that a benchmark keeps, and figures of controllers from these columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.core import LineCore

from ...ground import metrics
from ...ground.files import jsonable
from ..form import Amount, Columns, Count, Number
from ..record import Result, by_seed
from .data import LISTS, MEANS, Shifts, mean

COMPARED: Final = ("value_per_min", "sorted_per_min", "recovery", "value_recovery")
"""Figures of shifts by which controllers are compared."""
DIGITS: Final = 5
"""Decimals of the figures that are kept."""
BY_ROBOT: Final = ("utilisation", "picks_by_robot")
"""Columns with a value for each robot; the others of `LISTS` have one for each item."""


class ShiftColumns(Columns):
    """Form of the columns of S work shifts; figures by robot or item are lists, totals of all decisions are numbers."""

    names: ClassVar[frozenset[str]] = frozenset({"items", "robots"})

    value_per_min: list[Number]
    sorted_per_min: list[Number]
    recovery: list[Number | None]
    value_recovery: list[Number | None]
    purity: list[Number | None]
    passed_value_per_min: list[Number]
    passed_tried: list[Number | None]
    utilisation: list[list[Number]]
    picks_by_robot: list[list[Number]]
    recovery_by_item: list[list[Number | None]]
    passed_by_item: list[list[Number]]
    items: list[str]
    robots: list[str]
    picks: Annotated[Count, Field(ge=1)]
    picked: Count
    success: Count
    invalid: Count
    ms_per_decision: Amount

    @model_validator(mode="after")
    def _check_widths(self) -> Self:
        for name in LISTS:
            heads = self.robots if name in BY_ROBOT else self.items
            if any(len(row) != len(heads) for row in getattr(self, name)):
                raise ValueError(f"{name} must have {len(heads)} values of each shift")
        if not self.success <= self.picked <= self.picks:
            raise ValueError(f"{self.success} successes of {self.picked} picked objects in {self.picks} picks")
        return self


def columns(shifts: Shifts, core: LineCore) -> dict[str, Any]:
    """Shifts as rounded columns, and totals of all their decisions."""
    figures, picked = shifts.figures, shifts.decisions["picked"].astype(bool)
    success = shifts.decisions["is_success"].astype(bool)
    return {
        **{name: jsonable(np.round(figures[key], DIGITS)) for name, key in {**MEANS, **LISTS}.items()},
        "items": list(core.item_names),
        "robots": [robot.name for robot in core.config.robots],
        "picks": len(picked),
        "picked": int(picked.sum()),
        "success": int(success.sum()),
        "invalid": shifts.invalid,
        "ms_per_decision": round(1e3 * shifts.seconds / shifts.decision_count, 4),
    }


def summarise(results: Sequence[Result]) -> dict[str, Any]:
    """Figures of one controller over its seeds; all seeds worked the same shifts.

    The interval of the value is bootstrapped over shifts, averaged over the seeds.
    """
    first, all_of = results[0]["columns"], [result["columns"] for result in results]
    value = by_seed(results, "value_per_min")
    interval = metrics.mean_interval(value.mean(axis=0))
    picks, picked = (sum(seed_columns[name] for seed_columns in all_of) for name in ("picks", "picked"))
    return {
        "seeds": [result["seed"] for result in results],
        "shifts": value.shape[1],
        **{name: jsonable(mean(np.concatenate(by_seed(results, name)))) for name in (*MEANS, *LISTS)},
        "value_per_min_low": interval.low,
        "value_per_min_high": interval.high,
        "value_per_min_by_seed": value.mean(axis=1).tolist(),
        "by_shift": {name: jsonable(by_seed(results, name).mean(axis=0)) for name in COMPARED},
        "items": first["items"],
        "robots": first["robots"],
        "pick_rate": picked / picks,
        "success_rate": sum(seed_columns["success"] for seed_columns in all_of) / picks,
        "invalid_actions": sum(seed_columns["invalid"] for seed_columns in all_of),
        "ms_per_decision": float(np.mean([seed_columns["ms_per_decision"] for seed_columns in all_of])),
        "learn_seconds": float(np.mean([result["learn_seconds"] for result in results])),
    }


def paired_columns(results: Sequence[Result], shifts: int) -> dict[str, tuple[Floats]]:
    """Columns of the first shifts, for comparisons with controllers that worked fewer shifts, each (seeds, shifts)."""
    return {name: (by_seed(results, name)[:, :shifts],) for name in COMPARED}
