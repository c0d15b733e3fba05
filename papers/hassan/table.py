"""Table I of Hassan et al. 2022: picks per minute of three methods, by one protocol for all cells."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from typing import Any, Final

from agents.ground.drawings import COLOURS, WIDTH, dress, subplots, svg
from agents.ground.tables import Grid
from agents.reproduce.finding import Findings, Row, share
from agents.reproduce.grids import by_quantity, value
from pnt_gym.planning import InfeasibleThrow

from . import cases

STYLES: Final = dict(zip(cases.SHOWN, ("--", "-", ":"), strict=True))
"""Line styles in the drawing, by protocol."""


def table_findings() -> Findings:
    """All cells of Table I by all protocols, with differences, orders and peaks over the whole table."""
    reproduced = {
        name: {cell: cases.picks_per_min(cases.cell_cycle(name, *cell)) for cell in cases.PUBLISHED}
        for name in cases.SHOWN
    }
    rows: list[Row] = []
    for name, values in reproduced.items():
        cells = [cell_row(name, cell) for cell in cases.PUBLISHED]
        rows += [*cells, *_difference_rows(name, values), *_order_rows(name, values), *_peak_rows(name, cells)]
    rows.append(_place_outside_row())
    return Findings(
        tuple(rows), figures={"hassan_table1.svg": table_figure(reproduced)}, grids=(_whole_table_grid(rows),)
    )


def cell_row(protocol: str, cell: cases.Key) -> Row:
    """Row of one cell by one protocol."""
    settings, cycle = cases.PROTOCOLS[protocol], cases.cell_cycle(protocol, *cell).require()
    picks, published = cases.picks_per_min(cycle), float(cases.PUBLISHED[cell])
    peaks = cycle.peak_ratios(settings.limits(cell[2]))
    part = cases.CLOSE_FOLD if cell == cases.FOLD else cases.CLOSE
    bound = f"; a reading of what the paper leaves open, judged within {100 * part:.0f} %, which is our bound"
    reading = f"; {cases.CHOSEN}" if settings.fitted else bound if settings.reading else ""
    return _protocol_row(
        protocol,
        "/".join(map(str, cell)),
        published,
        picks,
        "picks/min",
        settings.note + reading,
        share(published, part),
        relative_difference=picks / published - 1.0,
        peak_velocity_ratio=float(peaks.velocity.max()),
        peak_acceleration_ratio=float(peaks.acceleration.max()),
        peak_jerk_ratio=float(peaks.jerk.max()),
        **cases.cycle_details(cycle),
    )


def _protocol_row(
    protocol: str, name: str, published: float, figure: float, unit: str, note: str, within: float = 0.0, **details: Any
) -> Row:
    """Row of a protocol's figure: compared with the table if the protocol is a reading and not fitted to it."""
    quantity, settings = f"table1/{protocol}/{name}", cases.PROTOCOLS[protocol]
    if settings.reading and not settings.fitted:
        statement = f"table1/{name}"
        return Row.compared(quantity, published, figure, unit, within=within, note=note, statement=statement, **details)
    return Row.ours(quantity, figure, unit, beside=published, note=note, **details)


def _difference_rows(protocol: str, values: cases.ByCell) -> list[Row]:
    """Rows with the mean and the largest difference of all cells to Table I; the paper gives no such figures."""
    by_cell = cases.differences(values)
    off_fold = {cell: difference for cell, difference in by_cell.items() if cell != cases.FOLD}
    mean = sum(by_cell.values()) / len(by_cell)
    fitted = f"; {cases.CHOSEN}" if protocol == "paper-clock" else ""
    shares = {
        "mean-difference": (mean, f"mean absolute relative difference of all cells{fitted}"),
        "worst-difference": (max(by_cell.values()), _worst(by_cell)),
        "worst-difference-off-the-fold": (max(off_fold.values()), _worst(off_fold)),
    }
    return [
        Row.ours(f"table1/{protocol}/{name}", 100.0 * difference, "%", note=note)
        for name, (difference, note) in shares.items()
    ]


def _worst(by_cell: cases.ByCell) -> str:
    cell = max(by_cell, key=lambda key: by_cell[key])
    return "largest absolute relative difference, at " + "/".join(map(str, cell))


def _order_rows(protocol: str, values: cases.ByCell) -> list[Row]:
    """Rows that count in how many columns and rows of the table the published order holds."""
    columns = [[values[m, *cell] for m in reversed(cases.METHODS) if (m, *cell) in values] for cell in cases.CELLS]
    lines = [
        [values[m, z, p] for p in cases.PERCENTAGES[z] if (m, z, p) in values]
        for m in cases.METHODS
        for z in cases.TARGETS
    ]
    ordered = "columns in which the proposed throw is quickest and pick-and-place slowest"
    rising = "rows in which every higher percentage brings more picks"
    return [
        _count_row(protocol, "ordered-columns", columns, lambda first, second: first > second, ordered),
        _count_row(protocol, "rising-rows", [line for line in lines if line], lambda low, high: low < high, rising),
    ]


def _count_row(
    protocol: str, name: str, lines: Iterable[list[float]], holds: Callable[[float, float], bool], note: str
) -> Row:
    holding = [all(holds(*pair) for pair in pairwise(line)) for line in lines]
    return _protocol_row(protocol, name, float(len(holding)), float(sum(holding)), "-", note)


def _peak_rows(protocol: str, cells: list[Row]) -> list[Row]:
    """Rows with the greatest shares of the limits in any cell; by section IV-C1 speed and acceleration attain theirs.

    The paper says nothing about the greatest jerk. Peaks of rules that the table itself chose do not test the paper.
    """
    worst = {
        name: max(float(cell.details[f"peak_{name}_ratio"]) for cell in cells)
        for name in ("velocity", "acceleration", "jerk")
    }
    rows: list[Row] = []
    for name, peak in worst.items():
        note = f"greatest {name} of all cells as a share of its limit"
        if name == "jerk" or cases.PROTOCOLS[protocol].fitted:
            rows.append(Row.ours(f"table1/{protocol}/peak-{name}", peak, "-", beside=1.0, note=note))
        else:
            rows.append(_protocol_row(protocol, f"peak-{name}", 1.0, peak, "-", note, cases.LIMIT_TOLERANCE))
    return rows


def _place_outside_row() -> Row:
    """Row of the cells that the paper leaves empty: the hand cannot place an object outside its workspace."""
    picks, refused = list[float](), 0
    for percent in cases.PERCENTAGES["outside"]:
        try:
            picks.append(cases.picks_per_min(cases.cell_cycle("paper-clock", "pick-and-place", "outside", percent)))
        except InfeasibleThrow:
            refused += 1
    note = f"the target {cases.TARGETS['outside']} lies outside the workspace: no plan at {refused} of 3 percentages"
    figure = max(picks) if picks else "impossible"
    return Row.compared("hassan/pick-and-place-outside", "impossible", figure, "picks/min", note=note, refused=refused)


def _whole_table_grid(rows: list[Row]) -> Grid:
    """Table of the protocols: difference to the published table, orders that hold, and peaks over the limits."""
    rows_by_quantity = by_quantity(rows)
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
        [settings.label, *(value(rows_by_quantity, f"table1/{name}/{entry}", form) for entry, form in forms.values())]
        for name, settings in ((name, cases.PROTOCOLS[name]) for name in cases.SHOWN)
    ]
    return Grid("Table I as a whole", ["difference to the published table", *forms], lines)


def table_figure(reproduced: Mapping[str, cases.ByCell]) -> str:
    """Drawing of picks per minute over the percentage as SVG, published and by the main protocols."""
    figure, panels = subplots(1, 2, (WIDTH, 6.4), sharey=True)
    for axes, (zone, percents) in zip(panels, cases.PERCENTAGES.items(), strict=True):
        for k, method in enumerate(cases.METHODS):
            cells = [(method, zone, percent) for percent in percents if (method, zone, percent) in cases.PUBLISHED]
            shares, name = [cell[2] for cell in cells], cases.TITLES[method]
            axes.plot(
                shares, [cases.PUBLISHED[cell] for cell in cells], "o", color=COLOURS[k], label=f"{name}, published"
            )
            for protocol, style in STYLES.items():
                picks = [reproduced[protocol][cell] for cell in cells]
                label = f"{name}, {cases.PROTOCOLS[protocol].label}"
                axes.plot(shares, picks, style, color=COLOURS[k], label=label)
        across, title = "share of the robot's limits [%]", f"target {zone} the workspace"
        dress(axes, across, "", title, xticks=percents, ylim=(0.0, 130.0))
    panels[0].set_ylabel("picks per minute")
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=1)
    return svg(figure)
