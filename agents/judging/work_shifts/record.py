"""The record of a trial by work shifts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.core import LineCore

from ...ground import metrics
from ...ground.files import jsonable
from ...ground.versions import versions
from ..figure import Figure
from ..measures import Measure
from ..record import Record, Result, Row, Summary
from .data import LISTS, MEANS, Shifts, mean
from .gantt import gantt
from .losses import losses_summary
from .results import ShiftColumns, columns, paired_columns, summarise
from .tables import shifts_comparison, shifts_table

FIGURES: Final = {
    "value_per_min": Figure("value/min"),
    "sorted_per_min": Figure("sorted/min"),
    "recovery": Figure("recovery", "%", 100.0),
    "value_recovery": Figure("recovery of value", "%", 100.0),
}
MEASURES: Final = {
    "value_per_min": Measure(FIGURES["value_per_min"], 20.0, "{a} earns {amount} a minute more than {b}"),
    "sorted_per_min": Measure(FIGURES["sorted_per_min"], 20.0, "{a} sorts {amount} a minute more than {b}"),
    "recovery": Measure(FIGURES["recovery"], 0.10),
    "value_recovery": Measure(FIGURES["value_recovery"], 0.10),
}
"""Measures of work shifts; paired shifts of good controllers differ by less than these caps."""


@final
class ShiftRecord(Record):
    """Record of work shifts of lines.

    Args:
        shifts: the shifts and their results.
        core: core of the lines.
        settings: further entries of the report, such as the controller that corrected the throws.
    """

    figures = FIGURES
    timings = frozenset({"ms_per_decision"})

    def __init__(self, shifts: Shifts, core: LineCore, settings: Mapping[str, Any]) -> None:
        self.shifts = shifts
        self._core, self._settings = core, settings

    def values(self) -> Mapping[str, Floats]:
        """Each figure of every shift (S,)."""
        return {name: self.shifts.figures[MEANS[name]].astype(np.float64) for name in self.figures}

    @classmethod
    def measures(cls) -> Mapping[str, Measure]:
        """Value and sorted objects per minute, and recovery, of shifts."""
        return MEASURES

    def summary(self) -> dict[str, Any]:
        """Figures of all shifts, by the names of the JSON contract."""
        record, core = self.shifts, self._core
        figures, decisions = record.figures, record.decisions
        picked, success = decisions["picked"].astype(bool), decisions["is_success"].astype(bool)
        rate = metrics.wilson(int(success.sum()), len(success))
        value = metrics.mean_interval(record.value)
        minutes = core.config.duration / 60.0 * len(record.value)
        head = {
            "shifts": len(record.value),
            "picks": len(success),
            "picks_per_min": len(success) / minutes,
            **{name: jsonable(mean(figures[key])) for name, key in MEANS.items()},
            "value_per_min_low": value.low,
            "value_per_min_high": value.high,
            "success_rate": rate.value,
            "success_low": rate.low,
            "success_high": rate.high,
            "pick_rate": float(picked.mean()),
            "cycle_time_mean_s": float(decisions["cycle_time"].mean()),
            "wait_time_mean_s": float(decisions["wait_time"].mean()),
            "dwell_s": core.dwell,
            "invalid_actions": record.invalid,
            "ms_per_decision": 1e3 * record.seconds / record.decision_count,
        }
        lists = {name: jsonable(mean(figures[key])) for name, key in LISTS.items()}
        by_robot = [decisions["wait_time"][decisions["by"] == robot] for robot in range(len(core.config.robots))]
        lists["wait_by_robot_s"] = [float(waits.mean()) if waits.size else None for waits in by_robot]
        names = {"items": list(core.item_names), "robots": [robot.name for robot in core.config.robots]}
        shifts = {name.removeprefix("shift_"): jsonable(values) for name, values in figures.items()}
        losses = losses_summary(record, core.config)
        return {**head, **lists, **names, **_bins(decisions, core), **losses, "by_shift": shifts}

    def report(self) -> dict[str, Any]:
        """Summary, settings, and under `throws` a mapping for each decision."""
        decisions = self.shifts.decisions
        rows = zip(*map(jsonable, decisions.values()), strict=True)
        entries = [dict(zip(decisions, row, strict=True)) for row in rows]
        return {**self._settings, **self.summary(), "versions": versions(), "throws": entries}

    def columns(self) -> dict[str, Any]:
        """Figures of each shift, rounded, and totals of all decisions."""
        return columns(self.shifts, self._core)

    @classmethod
    def form(cls) -> type[ShiftColumns]:
        """Form of the columns of shifts."""
        return ShiftColumns

    def picture(self) -> str:
        """Chart of the first minute of the first shift."""
        return gantt(self.report())

    @classmethod
    def table(cls, title: str, summary: Summary) -> Table:
        """Table of all figures, one per line."""
        return shifts_table(title, summary)

    @classmethod
    def comparison(cls, title: str, rows: Sequence[Row], base: str | None = None) -> Table:
        """Table of controllers over the same shifts, one per line."""
        return shifts_comparison(title, rows, base)

    @classmethod
    def summarise(cls, results: Sequence[Result], num_envs: int) -> dict[str, Any]:
        """Figures of one controller over its seeds."""
        del num_envs
        return summarise(results)

    @classmethod
    def paired_columns(
        cls, results: Sequence[Result], sides: Sequence[Sequence[Result]], num_envs: int
    ) -> dict[str, tuple[Floats, ...]]:
        """Figures of the shifts that both controllers have worked."""
        del num_envs
        return paired_columns(results, min(len(side[0]["columns"]["value_per_min"]) for side in sides))


def _bins(decisions: Mapping[str, NDArray[Any]], core: LineCore) -> dict[str, Any]:
    """Purity of each bin that is not empty at the end of a shift, by ROBOT/BIN."""
    in_time = decisions["start"] + decisions["cycle_time"] <= core.config.duration
    purity: dict[str, float] = {}
    for index, robot in enumerate(core.config.robots):
        for number, bin_ in enumerate(core.config.cell_of(index).bins.fixed):
            rows = in_time & (decisions["by"] == index) & (decisions["ended_in"] == number)
            if rows.any():
                purity[f"{robot.name}/{bin_.name}"] = float(decisions["sorted"][rows].astype(bool).mean())
    return {"purity_by_bin": purity}
