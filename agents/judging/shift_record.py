"""The record of a trial by work shifts: its figures, each declared once, tables, and the chart of a shift."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Final, final

import numpy as np
from rich.table import Table

from pnt_gym.cells.line.core import LineCore

from ..ground import metrics
from ..ground.drawings import COLOURS, WIDTH, dress, subplots, svg
from ..ground.files import jsonable
from ..ground.tables import Grid, gain_text, interval_text, percent
from ..ground.versions import versions
from . import losses
from .figures import Figure, count, mean, ratio, share, total
from .losses import fate_words
from .record import Card, Record, Result, Row, Summary, mappings
from .rows import Rows
from .shifts import LISTS, ShiftColumns, Shifts, kept_columns, kept_rows, live_rows

PERCENT: Final = ("%", 100.0)
VALUE: Final = Figure("value/min", cap=20.0, words="{a} earns {amount} a minute more than {b}")
PACE: Final = Figure("sorted/min", cap=20.0, words="{a} sorts {amount} a minute more than {b}")
PICKED: Final = Figure("picks that sealed", *PERCENT, kind=ratio, of=("picked", "decision"))
SUCCESS: Final = Figure(
    "success", *PERCENT, kind=share, of=("success", "decision"), ends=("success_low", "success_high")
)
MEASURED: Final = {
    "value_per_min": replace(VALUE, label="value per minute", ends=("value_per_min_low", "value_per_min_high")),
    "sorted_per_min": replace(PACE, label="sorted per minute"),
    "picks_per_min": Figure("picks per minute, attempted", kind=ratio, of=("decision", "minutes")),
    "success_rate": SUCCESS,
    "recovery": Figure("recovery: sorted of all that came", *PERCENT),
    "value_recovery": Figure("recovery of value", *PERCENT),
    "passed_value_per_min": Figure("value that passed the end, per minute"),
    "passed_tried": Figure("tried in vain, of what passed it", *PERCENT),
    "purity": Figure("purity: share of what is in bins", *PERCENT),
    "pick_rate": PICKED,
    "cycle_time_mean_s": Figure("cycle time, mean", "s", digits=3, of=("cycle_s",)),
    "wait_time_mean_s": Figure("standstill above the belt, mean", "s", digits=3, of=("wait_s",)),
    "ms_per_decision": Figure("time of a decision", "ms", digits=2),
    "invalid_actions": Figure("choices that were not there", digits=0, kind=total, of=("invalid",)),
    **{name: Figure() for name in LISTS},
}
"""Figures of evaluations and of benchmarks, those that the rows allow."""
FURTHER: Final = {
    "energy_per_pick_j": Figure("energy per pick", "J"),
    "energy_per_sorted_j": Figure("energy per sorted object", "J"),
}
"""Figures of energy, which a table without counts of energy lacks."""


@final
class ShiftRecord(Record):
    """Record of work shifts of lines.

    Args:
        shifts: the shifts and their results.
        core: core of the lines.
        settings: further entries of the report, such as the controller that corrected the throws.
    """

    figures: ClassVar[Mapping[str, Figure]] = {
        "value_per_min": VALUE,
        "sorted_per_min": PACE,
        # Paired shifts of good controllers differ by less than these caps.
        "recovery": Figure("recovery", *PERCENT, cap=0.10),
        "value_recovery": Figure("recovery of value", *PERCENT, cap=0.10),
    }
    shown: ClassVar[Mapping[str, Figure]] = {
        "shifts": Figure(kind=count, of=("value_per_min",)),
        "picks": Figure(kind=total, of=("decision",)),
        **MEASURED,
    }
    kept: ClassVar[Mapping[str, Figure]] = {
        "shifts": shown["shifts"],
        **MEASURED,
        "success_rate": replace(SUCCESS, ends=None),
    }
    step = "decisions"
    timings = frozenset({"ms_per_decision"})

    def __init__(self, shifts: Shifts, core: LineCore, settings: Mapping[str, Any]) -> None:
        self.shifts = shifts
        self._core, self._settings = core, settings
        self.rows = Rows.of(live_rows(shifts, core.config.duration))

    def summary(self) -> dict[str, Any]:
        """Figures of all shifts, by the names of the JSON contract."""
        core, decisions = self._core, self.shifts.decisions
        by_robot = [decisions["wait_time"][decisions["by"] == robot] for robot in range(len(core.config.robots))]
        by_shift = {name.removeprefix("shift_"): jsonable(column) for name, column in self.shifts.figures.items()}
        # Purity of each bin that is not empty at the end of a shift, by ROBOT/BIN.
        in_time = decisions["start"] + decisions["cycle_time"] <= core.config.duration
        purity: dict[str, float] = {}
        for index, robot in enumerate(core.config.robots):
            for number, bin_ in enumerate(core.config.cell_of(index).bins.fixed):
                rows = in_time & (decisions["by"] == index) & (decisions["ended_in"] == number)
                if rows.any():
                    purity[f"{robot.name}/{bin_.name}"] = float(decisions["sorted"][rows].astype(bool).mean())
        return {
            **super().summary(),
            "dwell_s": core.dwell,
            "wait_by_robot_s": [mean(waits) for waits in by_robot],
            "items": list(core.item_names),
            "robots": [robot.name for robot in core.config.robots],
            "purity_by_bin": purity,
            **losses.summary(self.shifts, core.config),
            "by_shift": by_shift,
        }

    def report(self) -> dict[str, Any]:
        """Summary, settings, and under `throws` a mapping for each decision."""
        throws = mappings(self.shifts.decisions)
        return {**self._settings, **self.summary(), "versions": versions(), "throws": throws}

    def columns(self) -> dict[str, Any]:
        """Figures of each shift, rounded, and totals of all decisions."""
        return kept_columns(self.shifts, self._core)

    @classmethod
    def form(cls) -> type[ShiftColumns]:
        """Form of the columns of shifts."""
        return ShiftColumns

    @classmethod
    def rows_of(cls, columns: Mapping[str, Any], num_envs: int) -> Rows:
        """Rows of the shifts that a benchmark keeps."""
        del num_envs
        return Rows.of(kept_rows(columns))

    @classmethod
    def further(cls, results: Sequence[Result], rows: Rows) -> dict[str, Any]:
        """Value by seed and by shift, names, and the time of a decision averaged over the seeds."""
        first = results[0]["columns"]
        return {
            "value_per_min_by_seed": rows["value_per_min"].mean(axis=1).tolist(),
            "by_shift": {"value_per_min": jsonable(rows["value_per_min"].mean(axis=0))},
            "items": first["items"],
            "robots": first["robots"],
        }

    def picture(self) -> str:
        """Chart of the first minute of the first shift."""
        return gantt(self.report())

    @classmethod
    def lines(cls, summary: Summary) -> list[tuple[str, str]]:
        """Lines of all figures, of the causes of losses, and of the bins that are not pure and the robots."""
        strays = "" if summary["simulated"] else ", without strays"
        lines = [(label + strays * label.startswith("purity"), text) for label, text in super().lines(summary)]
        energy = ((figure.label, figure.text(summary.get(name))) for name, figure in FURTHER.items())
        bins = ((f"purity of bin {name}", percent(part)) for name, part in summary["purity_by_bin"].items() if part < 1)
        return [
            *lines,
            *((label, text) for label, text in energy if text != "-"),
            *_losses(summary),
            *bins,
            *_lines(summary),
        ]

    @classmethod
    def comparison(cls, title: str, rows: Sequence[Row], base: str | None = None) -> Table:
        """Table of a line's controllers over the same shifts, one per line, with paired gains over controller `base`.

        A controller that worked fewer shifts is compared on these shifts alone.
        """
        compared = next((summary["by_shift"]["value_per_min"] for name, _, summary in rows if name == base), None)
        lines = [
            [
                name,
                cls.learned(steps),
                interval_text(metrics.interval(summary["by_shift"]["value_per_min"])),
                "-" if name == base else gain_text(summary["by_shift"]["value_per_min"], compared),
                *CARD.cells(summary)[1:3],
                f"{summary['ms_per_decision']:.2f}",
            ]
            for name, steps, summary in rows
        ]
        header = ("controller", "learned from", "value/min (95 % interval)", f"over {base}", "sorted/min", "recovery")
        return Grid(title, (*header, "ms/decision"), lines).terminal()


CARD: Final = Card(
    judged="shifts",
    figures={
        "value_per_min": replace(MEASURED["value_per_min"], head="value/min (95 % interval)"),
        "sorted_per_min": replace(PACE, head="sorted/min"),
        "recovery": Figure(*("", *PERCENT), head="recovery"),
        "value_recovery": Figure(*("", *PERCENT), head="recovery of value"),
        "ms_per_decision": Figure(digits=2, head="ms/decision"),
    },
    reward=lambda found: found["by_shift"]["value_per_min"],
    rewarded="value per minute of a shift",
    metrics={
        "sorted_per_min": "sorted picks per minute",
        "recovery": "share of all objects that came which was sorted",
        "value_recovery": "share of their value",
    },
    film="A film of the line at work",
    use=("pnt-gym evaluate --controller {name} --shifts 100", "pnt-gym play --controller {name} --video line.mp4"),
    graph="`observation` (N, D) to the choice `action` (N,) and the `scores` (N, C) of all that there are",
    actions="(N,) int64",
)
"""Texts and figures of the cards of policies that choose objects on lines."""


def _losses(summary: Summary) -> Iterator[tuple[str, str]]:
    """Lines of the causes for which objects were not sorted, and of the items, the worst one first."""
    for name, part in summary["fates"].items():
        if name != "sorted" and (name != "lost" or summary["fates_split"]):
            yield f"failed: {fate_words(name, summary['fates_split'])}", percent(part)
    for item, shares in sorted(summary["fates_by_item"].items(), key=lambda entry: entry[1]["sorted"]):
        loss = max((name for name in shares if name != "sorted"), key=shares.__getitem__)
        words = f"{percent(shares[loss])} {fate_words(loss, summary['fates_split'])}"
        yield f"{item}: recovery, largest loss", f"{percent(shares['sorted'])}, {words}"


def _lines(summary: Summary) -> Iterator[tuple[str, str]]:
    """Lines of the robots: time at work, picks and standstill."""
    columns = (summary[key] for key in ("robots", "utilisation", "picks_by_robot", "wait_by_robot_s"))
    for name, at_work, picks, wait in zip(*columns, strict=True):
        text = f"{percent(at_work)}, {picks:.0f}, {MEASURED['wait_time_mean_s'].text(wait)}"
        yield f"robot {name}: at work, picks in a shift, standstill for each", text


HIGH: Final = 0.8
"""Height of a bar as a share of the distance between rows."""
PALE: Final = 0.35
"""Opacity of failed cycles."""


def gantt(report: Mapping[str, Any], shift: int = 0, span: tuple[float, float] = (0.0, 60.0)) -> str:
    """Chart with a row for each robot and a bar for each of its cycles, as SVG.

    The colour is the item as which the robot took the object. A pale bar is an object that did not end in a bin of its
    kind. A bar begins when the robot's standstill above the belt ends.

    Args:
        report: report of an evaluation.
        shift: number of the shift.
        span: begin and end of the chart [s].
    """
    robots, items = report["robots"], report["items"]
    throws = [throw for throw in report["throws"] if throw["shift"] == shift]
    decisions = {name: np.array([throw[name] for throw in throws]) for name in throws[0]}
    begin, end = span
    figure, (axes,) = subplots(1, 1, (WIDTH, 0.7 * len(robots) + 1.4))
    for index in range(len(items)):
        for sorted_ in (True, False):
            rows = (decisions["item"] == index) & (decisions["sorted"].astype(bool) == sorted_)
            rows &= (decisions["start"] < end) & (decisions["start"] + decisions["cycle_time"] > begin)
            start = decisions["start"][rows] + decisions["wait_time"][rows]
            axes.barh(
                decisions["by"][rows],
                decisions["cycle_time"][rows] - decisions["wait_time"][rows],
                left=start,
                height=HIGH,
                color=COLOURS[index % len(COLOURS)],
                alpha=1.0 if sorted_ else PALE,
                edgecolor="white",
                linewidth=0.5,
                label=items[index] if sorted_ else None,
            )
    axes.set_yticks(np.arange(len(robots)), labels=list(robots))
    axes.invert_yaxis()
    dress(axes, "time since the begin of the shift [s]", "", xlim=span)
    figure.legend(*axes.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=4)
    return svg(figure)
