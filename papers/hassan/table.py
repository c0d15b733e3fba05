"""Table I of Hassan et al. 2022: picks per minute of three methods, by one protocol for all cells."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import Any, Final

from agents.ground.drawings import COLOURS, dress, subplots, svg
from agents.ground.tables import Grid
from agents.reproduce.finding import Findings, Row, share
from agents.reproduce.grids import by_quantity, value
from pnt_gym.planning import InfeasibleThrow

from .cases import (
    CELLS,
    CHOSEN,
    CLOSE,
    CLOSE_FOLD,
    FOLD,
    KEPT,
    METHODS,
    PERCENTAGES,
    PROTOCOLS,
    PUBLISHED,
    SHOWN,
    TARGETS,
    TITLES,
    ByCell,
    Key,
    cell_cycle,
    cycle_details,
    differences,
    picks_per_min,
)
from .simulated import ByMismatch, simulated, simulated_details, simulated_rows

STYLES: Final = dict(zip(SHOWN, ("-", "--", ":"), strict=True))
"""Line styles of the protocols in the drawing."""


def table_findings() -> Findings:
    """All cells of Table I by all protocols, with differences, orders and peaks over the whole table."""
    reproduced = {name: {cell: picks_per_min(cell_cycle(name, *cell)) for cell in PUBLISHED} for name in PROTOCOLS}
    rows: list[Row] = []
    for name, values in reproduced.items():
        measured = _measured(name) if name in SHOWN else {}
        cells = [cell_row(name, cell, measured.get(cell)) for cell in PUBLISHED]
        rows += [*cells, *_differences(name, values), *_orders(name, values), *_peaks(name, cells)]
        rows += _simulated_rows(name, measured)
    rows.append(_place_outside())
    return Findings(tuple(rows), figures={"hassan_table1.svg": table_figure(reproduced)}, grids=(_as_a_whole(rows),))


def cell_row(protocol: str, cell: Key, measured: ByMismatch | None = None) -> Row:
    """Row of one cell by one protocol, with the simulated figures if the cell was simulated."""
    own, cycle = PROTOCOLS[protocol], cell_cycle(protocol, *cell).require()
    found, published = picks_per_min(cycle), float(PUBLISHED[cell])
    peaks = cycle.peak_ratios(own.limits(cell[2]))
    part = CLOSE_FOLD if cell == FOLD else CLOSE
    reading = f"; a reading of what the paper leaves open, judged within {100 * part:.0f} %" if own.reading else ""
    return _judged(
        protocol,
        "/".join(map(str, cell)),
        published,
        found,
        "picks/min",
        own.note + reading,
        share(published, part),
        relative_difference=found / published - 1.0,
        peak_velocity_ratio=float(peaks.velocity.max()),
        peak_acceleration_ratio=float(peaks.acceleration.max()),
        peak_jerk_ratio=float(peaks.jerk.max()),
        **cycle_details(cycle),
        **({} if measured is None else simulated_details(measured)),
    )


def _judged(
    protocol: str, name: str, published: float, found: float, unit: str, note: str, within: float = 0.0, **details: Any
) -> Row:
    """Row of a protocol's figure: compared with the published figure if the protocol is a reading, else `ours`."""
    quantity = f"table1/{protocol}/{name}"
    if PROTOCOLS[protocol].reading:
        return Row.compared(quantity, published, found, unit, within=within, note=note, **details)
    return Row.ours(quantity, found, unit, beside=published, note=note, **details)


def _measured(protocol: str) -> dict[Key, ByMismatch]:
    """Simulated figures of every cell by one protocol."""
    plans = {"/".join(map(str, cell)): (cell_cycle(protocol, *cell), TARGETS[cell[1]]) for cell in PUBLISHED}
    return dict(zip(PUBLISHED, simulated(plans).values(), strict=True))


def _simulated_rows(protocol: str, measured: Mapping[Key, ByMismatch]) -> list[Row]:
    rows: list[Row] = []
    for method in METHODS if measured else ():
        found = [by for cell, by in measured.items() if cell[0] == method]
        rows += simulated_rows(f"table1/{protocol}/{method}", found)
    return rows


def _differences(protocol: str, values: ByCell) -> list[Row]:
    """Rows with the mean and the largest difference of all cells to Table I; the paper gives no such figures."""
    found = differences(values)
    rest = {cell: one for cell, one in found.items() if cell != FOLD}
    mean = sum(found.values()) / len(found)
    fitted = f"; {CHOSEN}" if protocol == "paper-clock" else ""
    shares = {
        "mean-difference": (mean, f"mean absolute relative difference of all cells{fitted}"),
        "worst-difference": (max(found.values()), _worst(found)),
        "worst-difference-off-the-fold": (max(rest.values()), _worst(rest)),
    }
    return [Row.ours(f"table1/{protocol}/{name}", 100.0 * one, "%", note=note) for name, (one, note) in shares.items()]


def _worst(found: ByCell) -> str:
    cell = max(found, key=lambda key: found[key])
    return "largest absolute relative difference, at " + "/".join(map(str, cell))


def _orders(protocol: str, values: ByCell) -> list[Row]:
    """Rows that count in how many columns and rows of the table the published order holds."""
    columns = [[values[m, *cell] for m in reversed(METHODS) if (m, *cell) in values] for cell in CELLS]
    lines = [[values[m, z, p] for p in PERCENTAGES[z] if (m, z, p) in values] for m in METHODS for z in TARGETS]
    ordered = "columns in which the proposed throw is quickest and pick-and-place slowest"
    rising = "rows in which every higher percentage brings more picks"
    return [
        _count(protocol, "ordered-columns", columns, lambda first, second: first > second, ordered),
        _count(protocol, "rising-rows", [line for line in lines if line], lambda one, two: one < two, rising),
    ]


def _count(
    protocol: str, name: str, lines: Iterable[list[float]], holds: Callable[[float, float], bool], note: str
) -> Row:
    good = [all(holds(*pair) for pair in pairwise(line)) for line in lines]
    return _judged(protocol, name, float(len(good)), float(sum(good)), "-", note)


def _peaks(protocol: str, cells: list[Row]) -> list[Row]:
    """Rows with the greatest shares of the limits in any cell; by section IV-C1 the motions attain and keep limits."""
    worst = {
        name: max(float(cell.details[f"peak_{name}_ratio"]) for cell in cells)
        for name in ("velocity", "acceleration", "jerk")
    }
    return [
        _judged(protocol, f"peak-{name}", 1.0, peak, "-", f"greatest {name} of all cells as a share of its limit", KEPT)
        for name, peak in worst.items()
    ]


def _place_outside() -> Row:
    """Row of the cells that the paper leaves empty: the hand cannot place an object outside its workspace."""
    name, found, refused = "hassan/pick-and-place-outside", list[float](), 0
    for percent in PERCENTAGES["outside"]:
        try:
            found.append(picks_per_min(cell_cycle("paper-clock", "pick-and-place", "outside", percent)))
        except InfeasibleThrow:
            refused += 1
    note = f"the target {TARGETS['outside']} lies outside the workspace: no plan at {refused} of 3 percentages"
    if found:
        return Row.compared(name, "-", max(found), "picks/min", note=note, refused=refused)
    return Row.missing(name, "-", "picks/min", "infeasible", note=note, refused=refused)


def _as_a_whole(rows: list[Row]) -> Grid:
    """Table of the protocols: difference to the published table, orders that hold, and peaks over the limits."""
    known = by_quantity(rows)
    forms = {
        "mean": ("mean-difference", "{:.1f} %"),
        "worst": ("worst-difference", "{:.1f} %"),
        "off the fold": ("worst-difference-off-the-fold", "{:.1f} %"),
        "ordered columns": ("ordered-columns", "{:.0f} of 6"),
        "rising rows": ("rising-rows", "{:.0f} of 5"),
        "peak v": ("peak-velocity", "{:.2f}"),
        "peak a": ("peak-acceleration", "{:.2f}"),
        "peak j": ("peak-jerk", "{:.2f}"),
    }
    lines = [
        [own.label, *(value(known, f"table1/{name}/{entry}", form) for entry, form in forms.values())]
        for name, own in PROTOCOLS.items()
    ]
    return Grid("Table I as a whole", ["difference to the published table", *forms], lines)


def table_figure(reproduced: Mapping[str, ByCell]) -> str:
    """Drawing of picks per minute over the percentage as SVG, published and by the main protocols."""
    figure, panels = subplots(1, 2, (10.5, 4.6))
    for axes, (zone, percents) in zip(panels, PERCENTAGES.items(), strict=True):
        for k, method in enumerate(METHODS):
            cells = [(method, zone, percent) for percent in percents if (method, zone, percent) in PUBLISHED]
            shares, name = [cell[2] for cell in cells], TITLES[method]
            axes.plot(shares, [PUBLISHED[cell] for cell in cells], "o", color=COLOURS[k], label=f"{name}, published")
            for protocol, style in STYLES.items():
                found = [reproduced[protocol][cell] for cell in cells]
                label = f"{name}, {PROTOCOLS[protocol].label}"
                axes.plot(shares, found, style, color=COLOURS[k], label=label)
        across, title = "share of the robot's limits [%]", f"target {zone} the workspace"
        dress(axes, across, "picks per minute", title, xticks=percents, ylim=(0.0, 130.0))
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, loc="outside right center")
    return svg(figure)
