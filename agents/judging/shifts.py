"""Work shifts of lines as rows: carried out, as the rounded columns that a benchmark keeps, and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Final, Self, final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.core import LineCore

from ..controllers.protocol import Controller
from ..dispatchers.decisions import work_shifts
from ..dispatchers.registry import line_core
from ..ground.environments import Env
from ..ground.files import jsonable
from ..ground.infos import results
from .rows import Amount, Columns, Count, Number

MEANS: Final = {
    "value_per_min": "shift_value_per_min",
    "sorted_per_min": "shift_sorted_per_min",
    "recovery": "shift_recovery",
    "value_recovery": "shift_value_recovery",
    "purity": "shift_purity",
    "passed_value_per_min": "shift_passed_value_per_min",
    "passed_tried": "shift_passed_tried",
}
"""Info keys of the figures that are averaged over shifts, by name."""
LISTS: Final = {
    "utilisation": "shift_utilisation",
    "picks_by_robot": "shift_picks_by_robot",
    "recovery_by_item": "shift_recovery_by_item",
    "passed_by_item": "shift_passed_by_item",
}
"""Info keys of the figures by robot or item that are averaged over shifts, by name."""
RECORDED: Final = (
    "by", "object", "item", "true_kind", "bin", "percent", "start", "cycle_time", "wait_time", "value", "picked",
    "is_success", "sorted", "ended_in",
)  # fmt: skip
"""Info keys that are kept for each decision."""
BY_ROBOT: Final = ("utilisation", "picks_by_robot")
"""Figures of `LISTS` with a value for each robot; the others have one for each item."""
DIGITS: Final = 5
"""Decimals of the figures that a benchmark keeps."""
SIMULATED: Final = ("energy", "lost", "miss_x", "miss_y")
"""Columns of decisions that only simulated throws have."""


@final
@dataclass(frozen=True)
class Shifts:
    """S work shifts, and the T decisions in them."""

    figures: dict[str, NDArray[Any]]
    """Figures of the shifts by info key, (S, ...) each."""
    decisions: dict[str, NDArray[Any]]
    """Values of the decisions by info key (T,), and `shift`, the number of the decision's shift."""
    invalid: int
    """Number of decisions that chose no object on offer."""
    decision_count: int
    """Number of all decisions, including those in shifts that are not counted."""
    seconds: float
    """Computing time of all decisions [s]."""

    @property
    def value(self) -> Floats:
        """Value per minute of each shift (S,)."""
        return self.figures["shift_value_per_min"]


def run_shifts(
    controller: Controller, env: Env, shifts: int, env_seed: int, progress: Callable[[int], object] | None = None
) -> Shifts:
    """Let a controller work whole shifts on lines.

    Each row works its shifts one after the other, so the streams depend on the seed and the number of rows alone.

    Args:
        controller: decides.
        env: vector environment of lines.
        shifts: number of shifts.
        env_seed: seed of the environment.
        progress: called with the number of shifts just ended.
    """
    rows = env.num_envs
    figures_by_shift, decisions = dict[str, dict[int, Any]](), list[dict[str, Any]]()
    seconds, invalid, core = 0.0, 0, line_core(env)
    for step in work_shifts(controller.act, env, env_seed, -(-shifts // rows)):
        number = np.arange(rows) + rows * step.shift
        info, counted = results(step.info, rows), number < shifts
        seconds += step.seconds
        invalid += int(info["invalid_action"][counted].sum())
        valid = counted & ~info["invalid_action"]
        if "energy" in info and core.last is not None:  # simulated throws; a table gives no further results
            thrown = core.last.results
            info |= {"lost": thrown["lost"], "miss_x": thrown["miss"][:, 0], "miss_y": thrown["miss"][:, 1]}
        names = [name for name in (*RECORDED, *SIMULATED) if name in info]
        decisions.append({"shift": number[valid], **{name: info[name][valid] for name in names}})
        ended = np.flatnonzero(step.over & counted)
        for row in ended:
            for name, values in step.info["final_info"].items():
                if name.startswith("shift_"):
                    figures_by_shift.setdefault(name, {})[int(number[row])] = values[row]
        if progress is not None:
            progress(len(ended))
    columns = {name: np.concatenate([part[name] for part in decisions]) for name in decisions[0]}
    figures = {name: np.array([of[k] for k in sorted(of)]) for name, of in figures_by_shift.items()}
    return Shifts(figures, columns, invalid, len(decisions) * rows, seconds)


def live_rows(shifts: Shifts, duration: float) -> dict[str, NDArray[Any]]:
    """Columns of shifts that have just been worked, of their decisions (T,), and of totals (1,).

    Args:
        shifts: the shifts.
        duration: length of a shift [s].
    """
    decisions = shifts.decisions
    return {
        **{name: shifts.figures[key] for name, key in {**MEANS, **LISTS}.items()},
        "decision": np.ones(len(decisions["picked"])),
        "picked": decisions["picked"].astype(np.bool_),
        "success": decisions["is_success"].astype(np.bool_),
        "cycle_s": decisions["cycle_time"],
        "wait_s": decisions["wait_time"],
        "minutes": np.array([duration / 60.0 * len(shifts.value)]),
        "invalid": np.array([shifts.invalid]),
        "ms_per_decision": np.array([1e3 * shifts.seconds / shifts.decision_count]),
    }


def kept_columns(shifts: Shifts, core: LineCore) -> dict[str, Any]:
    """Shifts as rounded columns, and totals of all their decisions."""
    picked, success = (shifts.decisions[name].astype(np.bool_) for name in ("picked", "is_success"))
    return {
        **{name: jsonable(shifts.figures[key], DIGITS) for name, key in {**MEANS, **LISTS}.items()},
        "items": list(core.item_names),
        "robots": [robot.name for robot in core.config.robots],
        "picks": len(picked),
        "picked": int(picked.sum()),
        "success": int(success.sum()),
        "invalid": shifts.invalid,
        "ms_per_decision": round(1e3 * shifts.seconds / shifts.decision_count, 4),
    }


def kept_rows(columns: Mapping[str, Any]) -> dict[str, Any]:
    """Columns of the shifts that a benchmark keeps (U,), and of their totals (1,)."""
    totals = {"decision": "picks", **{name: name for name in ("picked", "success", "invalid", "ms_per_decision")}}
    rows = {name: columns[name] for name in (*MEANS, *LISTS)}
    return rows | {name: [columns[key]] for name, key in totals.items()}


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
    def _check_together(self) -> Self:
        for name in LISTS:
            heads = self.robots if name in BY_ROBOT else self.items
            if any(len(row) != len(heads) for row in getattr(self, name)):
                raise ValueError(f"{name} must have {len(heads)} values of each shift")
        if not self.success <= self.picked <= self.picks:
            raise ValueError(f"{self.success} successes of {self.picked} picked objects in {self.picks} picks")
        return self
