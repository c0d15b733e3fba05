"""Tables and a figure of a benchmark of lines, whose controllers have worked the same shifts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Floats

from ..dispatchers.settings import PLANNERS
from ..ground import metrics
from ..ground.drawings import Figure, dress, tile_panels
from ..ground.looks import colours
from ..ground.tables import Grid, percent
from ..judging.shift_record import ShiftRecord
from . import tables
from .tables import conditions, name_of, other_level_tables, rows_of, side_by_side, who

Data = Mapping[str, Any]
WHO: Final = ("controller", "decisions to learn")
"""Names of the first columns."""
FIRST: Final = "fifo"
CLASS_BLIND: Final = ("spt", "value_rate", "atc")
"""Rules that do not look at what others can take."""
NOT_LEARNED: Final = ("random", FIRST, *CLASS_BLIND, "price", *PLANNERS)
"""All others were learned, or found by search."""
AGAINST: Final[Mapping[str, tuple[str, ...]]] = {
    "the best class-blind rule": CLASS_BLIND,
    "`price`": ("price",),
    "`beam`": ("beam",),
    "the best planner": PLANNERS,
}
"""With whom the worst seed of a learner is compared."""


def grids(data: Data) -> list[Grid]:
    """Every table of a benchmark of lines."""
    grids = [table(data), *other_level_tables(data, COLUMNS, WHO), gains_table(data), seeds_table(data)]
    for level in data["plan"]["levels"]:
        level_rows = rows_of(data, [level])
        items = level_rows[0]["items"] if level_rows else []
        rows = [[*who(row), *map(percent, row["recovery_by_item"])] for row in level_rows]
        grids += [
            tables.comparison(data, level, ShiftRecord.figures),
            _figures(data, level),
            Grid(f"Recovery by item, level {level}", [*WHO, *items], rows),
        ]
    return [grid for grid in grids if grid.rows]


def table(data: Data) -> Grid:
    """Every controller on the levels of the plan, side by side."""
    meaning = "value a minute, ± half of its 95 % interval over shifts"
    shifts = data["plan"]["shifts"]
    fewer = {f"{row['label']} {row['shifts']}": None for row in data["table"] if row["shifts"] < shifts}
    note = conditions(data, f"{shifts} held-out shifts" + (f" ({', '.join(fewer)})" if fewer else ""), meaning)
    return side_by_side(
        "Every controller on the same held-out shifts", data, data["plan"]["levels"], COLUMNS, note, WHO
    )


def gains_table(data: Data) -> Grid:
    """What the best of each sort is worth over first in, first out, and over the best class-blind rule."""
    rows: list[list[str]] = []
    for level in data["plan"]["levels"]:
        level_rows = rows_of(data, [level])
        first, blind, planner = (best(level_rows, names) for names in ((FIRST,), CLASS_BLIND, PLANNERS))
        if first is None or blind is None:
            continue
        top, won = best(level_rows) or first, best(learners(level_rows))
        rows.append(
            [
                f"`{level}`",
                f"`{blind['label']}` {gain(value(blind), value(first))}",
                f"`{name_of(top)}` {gain(value(top), value(first))}",
                gain(value(top), value(blind)),
                "-" if won is None or planner is None else f"`{name_of(won)}` {gain(value(won), value(planner))}",
            ]
        )
    header = ["level", "best class-blind rule over `fifo`", "best of all over `fifo`", "and over that rule"]
    note = (
        "Gains in mean value per minute on the same shifts, with 95 % intervals; the best controller is chosen by "
        "these shifts."
    )
    return Grid("What the order is worth", [*header, "best learned over best planner"], rows, note)


def seeds_table(data: Data) -> Grid:
    """Value of several seeds of each learner after all of its decisions; the worst seed against other controllers."""
    rows: list[list[str]] = []
    for level in data["plan"]["levels"]:
        level_rows = rows_of(data, [level])
        last = {row["label"]: row for row in level_rows if row["throws"] > 0}
        references = [(best(level_rows, names), len(names) > 1) for names in AGAINST.values()]
        for row in last.values():
            ends = sorted(by_seed(data, row), key=np.mean)
            low, high = ends[0].mean(), ends[-1].mean()
            against = [_against(ends[0], reference, named) for reference, named in references]
            value_text = f"{row['value_per_min']:.1f} ({low:.1f}..{high:.1f})"
            rows.append([f"`{level}`", f"`{name_of(row)}`", str(len(ends)), value_text, *against])
    header = ["level", "learner", "seeds", "value/min, mean (worst..best seed)"]
    against = [f"worst seed over {reference_name}" for reference_name in AGAINST]
    return Grid(
        "Learned, in several seeds",
        [*header, *against],
        rows,
        "Gains on the same shifts, with 95 % intervals; *worst seed*: the seed of the learning with the least value.",
    )


def _against(values: Floats, reference: Data | None, named: bool) -> str:
    """Gain over another controller, with the name of that controller where the header does not say it."""
    if reference is None:
        return "-"
    return (f"`{reference['label']}` " if named else "") + gain(values, value(reference))


def _figures(data: Data, level: str) -> Grid:
    """What a line is judged by beside its value a minute."""
    rows = [
        [
            *who(row),
            str(row["shifts"]),
            f"{row['sorted_per_min']:.1f}",
            *(percent(row[name]) for name in ("recovery", "value_recovery", "purity", "pick_rate")),
            ", ".join(percent(share) for share in row["utilisation"]),
            f"{row['ms_per_decision']:.3f}",
        ]
        for row in rows_of(data, [level])
    ]
    header = ["sorted/min", "recovery", "recovery of value", "purity", "picks that sealed", "robots at work"]
    note = (
        "*Purity*: share of the objects in bins that belong there. *Robots at work*: shares of the shift in which "
        "robots do not wait, upstream first."
    )
    header = [*WHO, "shifts", *header, "ms/decision"]
    return Grid(f"What a line is judged by, level {level}", header, rows, note)


def gains_figure(data: Data) -> Figure:
    """Gain over first in, first out, or over the first controller of the plan, by controller and level."""
    levels = data["plan"]["levels"]
    shown = [row for row in rows_of(data, levels) if row["controller"] not in ("random", FIRST)]
    names = list(dict.fromkeys(map(name_of, shown)))
    figure, panels = tile_panels(len(levels), 2, (3.4, 0.2 * len(names) + 0.8), sharey=True)
    for axes, level in zip(panels, levels, strict=True):
        base = best(rows_of(data, [level]), (FIRST,)) or rows_of(data, [level])[0]
        colour = colours(row["label"] for row in shown)
        for row in (row for row in shown if row["level"] == level):
            at, more = names.index(name_of(row)), interval(value(row), value(base))
            ends = [[more.value - more.low], [more.high - more.value]]
            axes.errorbar(more.value, at, xerr=ends, marker="o", color=colour[row["label"]])
        axes.axvline(0.0, color="black", linewidth=0.8)
        dress(axes, f"over {base['label']} [%]", "", level)
    panels[0].set_yticks(range(len(names)), labels=names)
    panels[0].invert_yaxis()
    return figure


def value(row: Data) -> Floats:
    """Value a minute of each shift (S,), averaged over the seeds."""
    return np.array(row["by_shift"]["value_per_min"], dtype=np.float64)


def by_seed(data: Data, row: Data) -> list[Floats]:
    """Value a minute in the shifts of each seed."""
    keys = ("label", "throws", "level")
    results = (result for result in data["results"] if all(result[name] == row[name] for name in keys))
    return [np.array(result["columns"]["value_per_min"], dtype=np.float64) for result in results]


def best(rows: Iterable[Data], names: Iterable[str] | None = None) -> Data | None:
    """Row of the controller, of some or of all, that earns most on average on the shifts that all have worked."""
    controllers = None if names is None else set(names)
    candidates = [row for row in rows if controllers is None or row["controller"] in controllers]
    shared = min((row["shifts"] for row in candidates), default=0)
    return max(candidates, key=lambda row: value(row)[:shared].mean(), default=None)


def learners(rows: Iterable[Data]) -> list[Data]:
    """Rows of controllers that were learned or tuned by black-box search."""
    return [row for row in rows if row["controller"] not in NOT_LEARNED]


def gain(values: Floats, base: Floats) -> str:
    """How much more one brings in than another on the shifts that both have worked, with its 95 % interval."""
    more = interval(values, base)
    return f"{more.value:+.1f} % ({more.low:+.1f}..{more.high:+.1f})"


def interval(values: Floats, base: Floats) -> metrics.Interval:
    """How much more one brings in than another on the shifts that both have worked [%]."""
    shared = min(len(values), len(base))
    mean = base[:shared].mean() / 100.0
    return metrics.difference(values[:shared] / mean, base[:shared] / mean)


def _value(row: Data) -> str:
    """Value a minute with half of its interval: a table has one of these for every level."""
    half = (row["value_per_min_high"] - row["value_per_min_low"]) / 2.0
    return f"{row['value_per_min']:.1f} ± {half:.1f}"


COLUMNS: Final = {"value/min": _value}
"""Columns of the tables of all levels side by side, and what they show of a row."""
