"""Tables of the benchmark."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from typing import Any, Final

from ..ground.tables import Grid, percent

Data = Mapping[str, Any]
WHO = ("controller", "throws to learn")
OF_LINE = ("controller", "decisions to learn")
"""Of a benchmark of lines."""
FAILED = {
    "share_missed": "missed the opening",
    "share_rim": "crossed it, not in the bin",
    "share_recontact": "touched by the cup",
    "share_dropped": "lost on the way",
    "share_unpicked": "not picked",
    "share_astray": "in a bin of another kind",
}
"""Outcomes, and what they are called."""
USUAL = ("share_missed", "share_rim", "share_recontact")
"""Those that every table has."""
SHARES = {"recovery": "recovery", "purity": "purity", "pick_rate": "picks that held", "drop_rate": "lost on the way"}
"""Shares by which a sorter is judged, where its cell tells them."""
DIFFERENCES: Final = {
    "landing_error_m": ("landing error", 1000, "mm"),
    "value_per_min": ("value/min", 1, ""),
    "sorted_per_min": ("sorted/min", 1, ""),
    "recovery": ("recovery", 100, "%"),
    "value_recovery": ("recovery of value", 100, "%"),
}
"""What controllers are compared by, of throws or of shifts: its name, scale and unit."""


def benchmark_grids(data: Data) -> list[Grid]:
    """Every table of a benchmark."""
    grids = [benchmark_table(data), other_levels_table(data)]
    grids += [shift_table(data)] if is_of_shifts(data) else []
    for level in data["plan"]["levels"]:
        grids += [comparison_table(data, level), failure_table(data, level), sorting_table(data, level)]
    return [grid for grid in grids if grid.rows]


def benchmark_table(data: Data) -> Grid:
    """Every controller on the levels of the plan, side by side."""
    columns, levels = ("error", "x floor", "under 30 mm", "success", "sorted/min"), data["plan"]["levels"]
    return side_by_side("Every controller on the same held-out throws", data, levels, columns, _conditions(data))


def is_of_line(data: Data) -> bool:
    """Whether what was compared are shifts of a line."""
    return any("value_per_min" in row for row in data["table"])


def is_of_shifts(data: Data) -> bool:
    """Whether what a throw teaches pays later in its shift."""
    return any("landing_error_first_10_m" in row for row in data["table"])


def shift_table(data: Data) -> Grid:
    """Landing error over the shift, level by level, and against the static policy of that level."""
    static = {(row["level"], row["throws"]): row for row in data["table"] if row["controller"] == "static"}
    parts = ("mean", "first_10", "second_half")
    rows = [
        [
            row["level"],
            row["controller"],
            who(row)[1],
            str(row["shifts"]),
            *(f"{1000 * row[f'landing_error_{part}_m']:.1f} mm" for part in parts),
            _over(row, static),
            percent(row["landing_near_share"]),
        ]
        for row in sorted(data["table"], key=lambda row: row["level"])
    ]
    header = ["level", *WHO, "shifts", "landing error", "first 10 throws", "second half", "over static", "under 30 mm"]
    note = (
        "Over static: the error over that of the level's static policy, the one that has learned from as many throws "
        "where there are two. Who is told without throws ships with what it knows, or learns as it goes, or not at all."
    )
    return Grid("What adapting is worth", header, rows, note)


def _over(row: Data, static: Mapping[tuple[str, int], Data]) -> str:
    """A row's error over that of the static policy of its level, and of its throws if there is one."""
    like = [found for (level, _), found in static.items() if level == row["level"]]
    base = static.get((row["level"], row["throws"]), like[0] if like else None)
    return "-" if base is None else f"{row['landing_error_mean_m'] / base['landing_error_mean_m']:.2f}"


def _conditions(data: Data) -> str:
    said = (
        "errors are of what was thrown, success is of all picks, failed ones and drops included; "
        "x floor is the error over that of a large network trained on very many throws"
    )
    more = ", ".join(f"{count} on {level}" for level, count in data["plan"].get("picks_on", {}).items())
    return conditions(data, f"{data['plan']['picks']} held-out throws" + (f" ({more})" if more else ""), said)


def conditions(data: Data, count: str, said: str) -> str:
    """Count, seeds and versions behind the tables, and what else is to be said of them."""
    plan = data["plan"]
    where = "the level itself" if plan["train_level"] == "each" else f"{plan['train_level']}{_learned_elsewhere(data)}"
    return (
        f"{count} per seed and level on {plan['env']}, seeds {plan['seeds']} of the learning, learned on {where}; "
        f"{said}. Versions: " + ", ".join(f"{package} {version}" for package, version in data["versions"].items()) + "."
    )


def _learned_elsewhere(data: Data) -> str:
    """Who learned on another level than the others, and on which, in brackets."""
    found: dict[str, dict[str, None]] = {}
    for row in data["table"]:
        if row["throws"] > 0 and row["train_level"] != data["plan"]["train_level"]:
            found.setdefault(row["train_level"], {})[row["label"]] = None
    said = "; ".join(f"{', '.join(who)} on {level}" for level, who in found.items())
    return f" ({said})" if said else ""


def other_levels(data: Data) -> list[str]:
    """Levels that only some controllers were evaluated on."""
    return sorted({row["level"] for row in data["table"]} - {*data["plan"]["levels"]})


def other_levels_table(data: Data) -> Grid:
    """Levels that only some controllers were evaluated on."""
    columns = ("error", "under 30 mm", "success", "sorted/min")
    return side_by_side("Further levels", data, other_levels(data), columns)


def failure_table(data: Data, level: str) -> Grid:
    """What stood between an object and its bin, of what happened on this level."""
    found = rows_of(data, [level])
    shares = {name: said for name, said in FAILED.items() if name in USUAL or any(row.get(name) for row in found)}
    header = [*WHO, *shares.values()]
    rows = [[*who(row), *(percent(row.get(name, 0.0)) for name in shares)] for row in found]
    return Grid(f"What failed, level {level}", header, rows)


def sorting_table(data: Data, level: str) -> Grid:
    """What a sorter is judged by beside its pace; no rows where the cell does not tell."""
    found = [row for row in rows_of(data, [level]) if any(name in row for name in SHARES)]
    shares = {name: said for name, said in SHARES.items() if any(name in row for row in found)}
    rows = [
        [*who(row), *(percent(row.get(name)) for name in shares), f"{row['energy_per_pick_j']:.1f} J"] for row in found
    ]
    note = "Purity is of what lies in any bin. Energy: positive work of the motors, without recuperation."
    return Grid(f"What a sorter is judged by, level {level}", [*WHO, *shares.values(), "energy per pick"], rows, note)


def who(row: Data) -> list[str]:
    """A label, and how many throws or decisions it learned from."""
    return [row["label"], _count(row["throws"])]


def _count(throws: int) -> str:
    return f"{throws:,}" if throws else "-"


def comparison_table(data: Data, level: str) -> Grid:
    """Learned less reference with 95 % intervals, paired throw by throw or shift by shift."""
    pairs = [c for c in data["comparisons"] if c["level"] == level and c["learned"] != c["reference"]]
    told = {name: said for name, said in DIFFERENCES.items() if pairs and name in pairs[0]}
    rows = [
        [
            name_of(c["learned"]),
            name_of(c["reference"]),
            *(_interval(c[name], scale, unit) for name, (_, scale, unit) in told.items()),
        ]
        for c in pairs
    ]
    header = ["learned", "less", *(said for said, _, _ in told.values())]
    return Grid(f"Paired differences, level {level} (95 % intervals)", header, rows)


def rows_of(data: Data, levels: Iterable[str]) -> list[Data]:
    """What was measured on levels, in the order of the plan's entries."""
    order = labels(data)
    found = [row for row in data["table"] if row["level"] in levels]
    return sorted(found, key=lambda row: (order.index(row["label"]), row["throws"]))


def labels(data: Data) -> list[str]:
    """Of what was measured, in the order of the plan's entries, as the table is."""
    return list(dict.fromkeys(row["label"] for row in data["table"]))


def name_of(choice: Data) -> str:
    """A label, and what it learned from."""
    return f"{choice['label']} ({_count(choice['throws'])})" if choice["throws"] else str(choice["label"])


def side_by_side(headline: str, data: Data, levels: Sequence[str], columns: Sequence[str], note: str = "") -> Grid:
    """Figures of every controller on some levels, level by level from left to right.

    Args:
        headline: of the table.
        data: of the benchmark.
        levels: which.
        columns: which of `FIGURES`.
        note: that stands under it.
    """
    who = OF_LINE if is_of_line(data) else WHO
    header = [*who, *(f"{level}: {name}" if name == columns[0] else name for level in levels for name in columns)]
    lines: dict[tuple[str, int], dict[str, list[str]]] = {}
    for row in rows_of(data, levels):
        line = lines.setdefault((row["label"], row["throws"]), {level: ["-"] * len(columns) for level in levels})
        line[row["level"]] = [FIGURES[name](row) for name in columns]
    rows = [[label, _count(throws), *chain(*line.values())] for (label, throws), line in lines.items()]
    return Grid(headline, header, rows, note)


def _times(row: Data) -> str:
    floor = row.get("times_floor")
    return "-" if floor is None else f"{floor:.2f}"


def _value(row: Data) -> str:
    """With half of its interval: a table has one of these for every level."""
    half = (row["value_per_min_high"] - row["value_per_min_low"]) / 2.0
    return f"{row['value_per_min']:.1f} ± {half:.1f}"


FIGURES: Final[Mapping[str, Callable[[Data], str]]] = {
    "error": lambda row: f"{1000 * row['landing_error_mean_m']:.1f} mm",
    "x floor": _times,
    "under 30 mm": lambda row: percent(row["landing_near_share"]),
    "success": lambda row: f"{100 * row['success_rate']:.1f} %",
    "sorted/min": lambda row: f"{row['sorted_per_min']:.1f}",
    "value/min": _value,
    "recovery": lambda row: percent(row["recovery"]),
}
"""Columns of tables, and what they show of a row."""


def _interval(interval: Data, scale: float, unit: str) -> str:
    value, low, high = (scale * interval[name] for name in ("value", "low", "high"))
    text = f"{value:+.1f} ({low:+.1f}..{high:+.1f}) {unit}".rstrip()
    return text if interval["excludes_zero"] else f"{text}, not distinguishable"
