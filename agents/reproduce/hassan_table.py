"""Table I of Hassan et al. 2022: picks per minute of three methods, by one protocol for all cells."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any, Final

from agents.reproduce.findings import Findings, Part, Row, Verdict
from agents.reproduce.hassan_cases import (
    FOLD,
    METHODS,
    PERCENTAGES,
    PROTOCOLS,
    PUBLISHED,
    TARGETS,
    Key,
    cell_cycle,
    picks_per_min,
)
from agents.reproduce.hassan_figures import table_figure
from agents.reproduce.hassan_simulated import ByMismatch, simulated, simulated_details, simulated_rows
from agents.reproduce.simulation import Measured
from pnt_gym.planning import InfeasibleThrow, MotionLimits

DWELLS = (0.1, 0.2)
"""Waits of the gripper at every pick [s], to show what is left of the differences."""

CLOSE, CLOSE_FOLD = 0.06, 0.10
"""Relative differences up to which a cell counts as reproduced; the cell on the fold jumps for small causes."""

KEPT = 1e-6
"""Relative excess of a limit that is rounding or the solver's tolerance."""

SIMULATED: Final = ("paper-clock", "limits-respected")
"""Protocols whose cycles are executed by the robot."""

PRINTED_MEAN = 0.03
"""Mean absolute relative difference up to which the table as a whole does."""


def table_findings() -> Findings:
    """All cells by all protocols, with what holds across the table."""
    reproduced = {name: {cell: picks_per_min(cell_cycle(name, *cell)) for cell in PUBLISHED} for name in PROTOCOLS}
    rows: list[Row] = []
    for name, values in reproduced.items():
        measured = _measured(name) if name in SIMULATED else {}
        cells = [cell_row(name, cell, measured.get(cell)) for cell in PUBLISHED]
        rows += [*cells, *_summary(name, values), *_peaks(name, cells), *_simulated_rows(name, measured)]
    rows.append(_place_outside())
    return Findings(tuple(rows), figures={"hassan_table1.svg": table_figure(reproduced)})


def cell_row(protocol: str, cell: Key, measured: ByMismatch | None = None) -> Row:
    """One cell by one protocol, with what the simulator gave if it was run."""
    cycle = cell_cycle(protocol, *cell).require()
    value, published = picks_per_min(cycle), PUBLISHED[cell]
    difference = value / published - 1.0
    peaks = cycle.peak_ratios(MotionLimits.t3kr(cell[2]))
    details: dict[str, Any] = {
        "relative_difference": difference,
        "peak_velocity_ratio": float(peaks.velocity.max()),
        "peak_acceleration_ratio": float(peaks.acceleration.max()),
        "peak_jerk_ratio": float(peaks.jerk.max()),
        "cycle_times_s": cycle.duration.tolist(),
        "release_times_s": cycle.release_time.tolist(),
    }
    for dwell in DWELLS:
        details[f"picks_per_min_dwell_{dwell}"] = picks_per_min(cycle, dwell)
    details |= {} if measured is None else simulated_details(measured)
    verdict: Verdict = "reproduced" if abs(difference) <= (CLOSE_FOLD if cell == FOLD else CLOSE) else "differs"
    return Row(_name(protocol, *cell), float(published), value, "picks/min", verdict, PROTOCOLS[protocol].note, details)


def _measured(protocol: str) -> dict[Key, dict[float, Measured]]:
    plans = {_name(protocol, *cell): (cell_cycle(protocol, *cell), cell[1]) for cell in PUBLISHED}
    return dict(zip(PUBLISHED, simulated(plans).values(), strict=True))


def _simulated_rows(protocol: str, measured: dict[Key, dict[float, Measured]]) -> list[Row]:
    rows: list[Row] = []
    for method in METHODS if measured else ():
        found = [by for cell, by in measured.items() if cell[0] == method]
        rows += simulated_rows(f"table1/{protocol}/{method}", found)
    return rows


def _name(protocol: str, method: str, zone: str, percent: int) -> str:
    return f"table1/{protocol}/{method}/{zone}/{percent}"


def _summary(protocol: str, values: dict[Key, float]) -> list[Row]:
    difference = {cell: abs(value / PUBLISHED[cell] - 1.0) for cell, value in values.items()}
    rest = {cell: value for cell, value in difference.items() if cell != FOLD}
    ours = protocol != "paper-clock"
    mean = sum(difference.values()) / len(difference)
    return [
        _share(protocol, "mean-difference", mean, PRINTED_MEAN, ours, "mean absolute relative difference of all cells"),
        _share(protocol, "worst-difference", max(difference.values()), CLOSE_FOLD, ours, _worst(difference)),
        _share(protocol, "worst-difference-off-the-fold", max(rest.values()), CLOSE, ours, _worst(rest)),
        _count(
            protocol,
            "ordered-columns",
            list(_columns(values)),
            _falling,
            "columns in which the proposed throw is quickest and pick-and-place slowest",
        ),
        _count(
            protocol,
            "rising-rows",
            list(_rows(values)),
            _rising,
            "rows in which every higher percentage brings more picks",
        ),
    ]


def _peaks(protocol: str, cells: list[Row]) -> list[Row]:
    """Greatest shares of the limits in any cell; the paper takes its motions to stay at 1."""
    rows: list[Row] = []
    for name in ("velocity", "acceleration", "jerk"):
        worst = max(float(cell.details[f"peak_{name}_ratio"]) for cell in cells)
        verdict: Verdict = "reproduced" if worst <= 1.0 + KEPT else "differs"
        note = f"greatest {name} of all cells as a share of its limit"
        rows.append(Row(f"table1/{protocol}/peak-{name}", 1.0, worst, "-", verdict, note))
    return rows


def _share(protocol: str, name: str, value: float, bound: float, ours: bool, note: str) -> Row:
    verdict: Verdict = "ours" if ours else "reproduced" if value <= bound else "differs"
    return Row(f"table1/{protocol}/{name}", None, 100.0 * value, "%", verdict, note)


def _worst(difference: dict[Key, float]) -> str:
    cell = max(difference, key=lambda key: difference[key])
    return "largest absolute relative difference, at " + "/".join(map(str, cell))


def _count(protocol: str, name: str, lines: list[list[float]], holds: Callable[[list[float]], bool], note: str) -> Row:
    count = sum(holds(line) for line in lines)
    verdict: Verdict = "reproduced" if count == len(lines) else "differs"
    return Row(f"table1/{protocol}/{name}", float(len(lines)), float(count), "-", verdict, note)


def _columns(values: dict[Key, float]) -> Iterable[list[float]]:
    """Cells of each zone and percentage, the proposed throw first."""
    for zone, percents in PERCENTAGES.items():
        for percent in percents:
            line = [(method, zone, percent) for method in reversed(METHODS)]
            yield [values[cell] for cell in line if cell in values]


def _rows(values: dict[Key, float]) -> Iterable[list[float]]:
    """Cells of each method and zone by percentage."""
    for method in METHODS:
        for zone, percents in PERCENTAGES.items():
            line = [values[(method, zone, p)] for p in percents if (method, zone, p) in values]
            if line:
                yield line


def _falling(line: list[float]) -> bool:
    return all(first > second for first, second in pairwise(line))


def _rising(line: list[float]) -> bool:
    return all(first < second for first, second in pairwise(line))


def _place_outside() -> Row:
    """The cells the paper leaves empty: nothing can be placed where the hand cannot go."""
    refused = 0
    for percent in PERCENTAGES["outside"]:
        try:
            cell_cycle("paper-clock", "pick-and-place", "outside", percent).require()
        except InfeasibleThrow:
            refused += 1
    return Row(
        "hassan/pick-and-place-outside",
        "-",
        None,
        "picks/min",
        "infeasible",
        f"the target {TARGETS['outside']} lies outside the workspace: no plan at {refused} of 3 percentages",
        {"refused": refused},
    )


PARTS = (Part("table1", table_findings),)
