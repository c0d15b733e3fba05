"""Tables of the benchmark."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from typing import Any, Final

import numpy as np

from ..ground import metrics
from ..ground.environments import config_of
from ..ground.tables import Grid, percent
from ..judging.figures import Figure
from ..judging.throw_record import ThrowRecord
from ..judging.throws import OUTCOMES

Data = Mapping[str, Any]

Cell = Callable[[Sequence[Data], int], str]
"""Text for a kind's objects in the results of one controller."""


def kind_table(data: Data, level: str) -> Grid:
    """Shares by kind of what each controller held, lost on the way and sorted; no rows where nothing is grasped."""
    note = (
        "Three shares of the kind's objects in each cell, in percent: held by the cup / lost on the way / sorted. The "
        "last share is the recovery of the kind."
    )
    return _table(f"Held, lost and sorted by kind, level {level}", data, level, _shares, note)


def landings(data: Data, level: str) -> Grid:
    """Landing errors by kind; no rows where nothing is grasped."""
    note = (
        "Three figures of the kind's thrown objects in each cell, in mm: mean landing error / median landing error / "
        "mean landing along the throw, which is negative for objects that land short."
    )
    return _table(f"Landing error by kind, level {level}", data, level, _landings, note)


def _table(title: str, data: Data, level: str, cell: Cell, note: str) -> Grid:
    """A row for each controller, of which there are many, and a column for each kind; no rows without a grasp."""
    results = [r for r in data["results"] if r["level"] == level and "tries" in r["columns"]]
    plan, kinds = data["plan"], list[str]()
    if results:
        kinds += config_of(plan["env"], plan["inline"].get(level, level)).items
    of_label: dict[str, list[Data]] = {}
    for result in results:
        of_label.setdefault(str(result["label"]), []).append(result)
    rows = [[label, *(cell(runs, kind) for kind in range(len(kinds)))] for label, runs in of_label.items()]
    return Grid(title, ["controller", *kinds], rows, note)


def _shares(results: Sequence[Data], kind: int) -> str:
    """Three shares of a kind's objects in the results of one controller, as text."""
    is_kind = np.concatenate([np.array(r["columns"]["item"]) == kind for r in results])
    letters = np.concatenate([list(r["columns"]["outcome"]) for r in results])[is_kind]
    if letters.size == 0:
        return "-"
    shares = (
        (letters != OUTCOMES["unpicked"]).mean(),
        (letters == OUTCOMES["dropped"]).mean(),
        (letters == OUTCOMES["sorted"]).mean(),
    )
    return "/".join(f"{100.0 * share:.0f}" for share in shares)


def _landings(results: Sequence[Data], kind: int) -> str:
    """Mean and median landing error of a kind's objects, and their mean landing along the throw, as text."""
    is_kind = np.concatenate([np.array(r["columns"]["item"]) == kind for r in results])
    along, across = (
        np.concatenate([np.array(r["columns"][name], dtype=np.float64) for r in results])[is_kind]
        for name in ("along_m", "across_m")
    )
    flew = np.isfinite(along)
    if not flew.any():
        return "-"
    error = 1000.0 * np.hypot(along, across)[flew]
    return f"{error.mean():.0f}/{np.median(error):.0f}/{1000.0 * along[flew].mean():+.0f}"


WHO = ("controller", "throws to learn")
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
SHARES = {"recovery": "recovery", "purity": "purity", "pick_rate": "picks that sealed", "drop_rate": "lost on the way"}
"""Shares by which a sorter is judged, where its cell tells them."""


def grids(data: Data) -> list[Grid]:
    """Every table of a benchmark."""
    columns = {name: show for name, show in FIGURES.items() if name != "x floor"}
    grids = [table(data), *other_level_tables(data, columns)]
    grids += [shift_table(data)] if is_of_shifts(data) else []
    for level in data["plan"]["levels"]:
        grids += [
            comparison(data, level, ThrowRecord.figures),
            failures(data, level),
            sorting_table(data, level),
            kind_table(data, level),
            landings(data, level),
        ]
    return [grid for grid in grids if grid.rows]


def table(data: Data) -> Grid:
    """Every controller on the levels of the plan, side by side."""
    levels = data["plan"]["levels"]
    meaning = "errors are of thrown objects; success is a share of all picks, failed picks and dropped objects included"
    if any(row.get("times_floor") is not None for row in data["table"]):
        meaning += "; *x floor* is the error divided by that of a large network trained on very many throws"
    other_counts = ", ".join(f"{count} on {level}" for level, count in data["plan"].get("picks_on", {}).items())
    count = f"{data['plan']['picks']} held-out throws" + (f" ({other_counts})" if other_counts else "")
    note = conditions(data, count, meaning)
    return side_by_side("Every controller on the same held-out throws", data, levels, FIGURES, note)


def is_of_shifts(data: Data) -> bool:
    """Whether what a throw teaches pays later in its shift."""
    return any("landing_error_first_10_m" in row for row in data["table"])


def first_shift_table(data: Data) -> Grid:
    """Landing error over the shift on the first level of the plan, whose name and shifts stand in the note."""
    level, rows = first_level(data)
    grid, counts = shift_table({**data, "table": rows}), sorted({row["shifts"] for row in rows})
    kept = [k for k, name in enumerate(grid.header) if name not in ("level", "shifts")]
    note = f"Level `{level}`, {' or '.join(map(str, counts))} shifts. {grid.note}"
    return Grid(grid.headline, [grid.header[k] for k in kept], [[row[k] for k in kept] for row in grid.rows], note)


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
            _share(row, static),
            percent(row["landing_near_share"]),
        ]
        for row in sorted(data["table"], key=lambda row: row["level"])
    ]
    header = ["level", *WHO, "shifts", "landing error", "first 10 throws", "second half", "over static", "under 30 mm"]
    note = (
        "*Over static*: the landing error divided by that of the level's static policy; of two static policies, that "
        "which has learned from as many throws. *First 10 throws* and *second half*: mean landing errors in these "
        "parts of a shift. Controllers without a number of throws ship pre-trained, learn online, or do not learn."
    )
    return Grid("What adapting is worth", header, rows, note)


def _share(row: Data, static: Mapping[tuple[str, int], Data]) -> str:
    """A row's error over that of the static policy of its level, and of its throws if there is one."""
    like = [static_row for (level, _), static_row in static.items() if level == row["level"]]
    base = static.get((row["level"], row["throws"]), like[0] if like else None)
    return "-" if base is None else f"{row['landing_error_mean_m'] / base['landing_error_mean_m']:.2f}"


def conditions(data: Data, count: str, meaning: str) -> str:
    """Count, seeds and versions behind the tables, and what else is to be said of them."""
    plan = data["plan"]
    where = "the level itself" if plan["train_level"] == "each" else f"{plan['train_level']}{_text(data)}"
    return (
        f"{count} per seed and level on {plan['env']}, {_seeds(plan['seeds'])} of the learning, learned on {where}; "
        f"{meaning}. Versions: "
        + ", ".join(f"{package} {version}" for package, version in data["versions"].items())
        + "."
    )


def _seeds(seeds: Sequence[int]) -> str:
    """Seeds in words: a range where they follow one another."""
    if len(seeds) > 2 and [*seeds] == [*range(seeds[0], seeds[-1] + 1)]:
        return f"seeds {seeds[0]} to {seeds[-1]}"
    return f"seed{'s' * (len(seeds) > 1)} {', '.join(map(str, seeds))}"


def _text(data: Data) -> str:
    """Controllers that learned on another level than most, with that level, in brackets."""
    labels_by_level: dict[str, dict[str, None]] = {}
    for row in data["table"]:
        if row["throws"] > 0 and row["train_level"] != data["plan"]["train_level"]:
            labels_by_level.setdefault(row["train_level"], {})[row["label"]] = None
    text = "; ".join(f"{', '.join(names)} on {level}" for level, names in labels_by_level.items())
    return f" ({text})" if text else ""


def other_level_tables(
    data: Data, columns: Mapping[str, Callable[[Data], str]], who: Sequence[str] = WHO
) -> list[Grid]:
    """A table for each level that only some controllers were evaluated on; arguments as in `side_by_side`."""
    others = sorted({row["level"] for row in data["table"]} - {*data["plan"]["levels"]})
    return [side_by_side(f"Further level {level}", data, [level], columns, "", who) for level in others]


def failures(data: Data, level: str) -> Grid:
    """What stood between an object and its bin, of what happened on this level."""
    level_rows = rows_of(data, [level])
    shares = {name: text for name, text in FAILED.items() if name in USUAL or any(row.get(name) for row in level_rows)}
    header = [*WHO, *shares.values()]
    rows = [[*who(row), *(percent(row.get(name, 0.0)) for name in shares)] for row in level_rows]
    note = f"Shares of all picks on `{level}`."
    return Grid(f"What failed, level {level}", header, rows, note)


def sorting_table(data: Data, level: str) -> Grid:
    """What a sorter is judged by beside its pace; no rows where the cell does not tell."""
    level_rows = [row for row in rows_of(data, [level]) if any(name in row for name in SHARES)]
    shares = {name: text for name, text in SHARES.items() if any(name in row for row in level_rows)}
    has_tries = any("tries_per_pick" in row for row in level_rows)
    rows = [
        [
            *who(row),
            *(percent(row.get(name)) for name in shares),
            *([f"{row['tries_per_pick']:.2f}"] if has_tries else []),
            f"{row['energy_per_pick_j']:.1f} J",
        ]
        for row in level_rows
    ]
    note = (
        "*Purity*: share of the objects in bins that belong there. *Energy*: positive work of the motors, without "
        "recuperation."
    )
    header = [*WHO, *shares.values(), *(["tries a pick"] if has_tries else []), "energy per pick"]
    return Grid(f"What a sorter is judged by, level {level}", header, rows, note)


def who(row: Data) -> list[str]:
    """A label, and how many throws or decisions it learned from."""
    return [row["label"], _count(row["throws"])]


def _count(throws: int) -> str:
    return f"{throws:,}" if throws else "-"


def comparison(data: Data, level: str, figures: Mapping[str, Figure]) -> Grid:
    """Learned less reference with 95 % intervals, paired throw by throw or shift by shift.

    Args:
        data: of the benchmark.
        level: which.
        figures: by which controllers are compared.
    """
    pairs = [c for c in data["comparisons"] if c["level"] == level and c["learned"] != c["reference"]]
    shown_figures = {name: figure for name, figure in figures.items() if pairs and name in pairs[0]}
    rows = [
        [
            name_of(c["learned"]),
            name_of(c["reference"]),
            *(_interval(c[name], shown_figures[name]) for name in shown_figures),
        ]
        for c in pairs
    ]
    header = ["learned", "less", *(figure.label for figure in shown_figures.values())]
    return Grid(f"Paired differences, level {level} (95 % intervals)", header, rows)


def rows_of(data: Data, levels: Iterable[str]) -> list[Data]:
    """What was measured on levels, in the order of the plan's entries."""
    order = labels(data)
    rows = [row for row in data["table"] if row["level"] in levels]
    return sorted(rows, key=lambda row: (order.index(row["label"]), row["throws"]))


def first_level(data: Data) -> tuple[str, list[Data]]:
    """The first level of the plan, and what was measured on this level."""
    level = data["plan"]["levels"][0]
    return level, rows_of(data, [level])


def labels(data: Data) -> list[str]:
    """Labels of the measured controllers, in the order of the table, which is that of the plan's entries."""
    return list(dict.fromkeys(row["label"] for row in data["table"]))


def name_of(choice: Data) -> str:
    """A label, and what it learned from."""
    return f"{choice['label']} ({_count(choice['throws'])})" if choice["throws"] else str(choice["label"])


def side_by_side(
    headline: str,
    data: Data,
    levels: Sequence[str],
    columns: Mapping[str, Callable[[Data], str]],
    note: str = "",
    who: Sequence[str] = WHO,
) -> Grid:
    """Figures of every controller on some levels, level by level from left to right, without empty columns.

    Args:
        headline: of the table.
        data: of the benchmark.
        levels: which.
        columns: names of the columns, and what each shows of a row.
        note: that stands under it.
        who: names of the first two columns.
    """
    first = next(iter(columns))
    header = [*who, *(f"{level}: {name}" if name == first else name for level in levels for name in columns)]
    lines: dict[tuple[str, int], dict[str, list[str]]] = {}
    for row in rows_of(data, levels):
        line = lines.setdefault((row["label"], row["throws"]), {level: ["-"] * len(columns) for level in levels})
        line[row["level"]] = [text(row) for text in columns.values()]
    rows = [[label, _count(throws), *chain(*line.values())] for (label, throws), line in lines.items()]
    kept = [k for k in range(len(header)) if k == 0 or any(row[k] != "-" for row in rows)]
    return Grid(headline, [header[k] for k in kept], [[row[k] for k in kept] for row in rows], note)


FIGURES: Final[Mapping[str, Callable[[Data], str]]] = {
    "error": lambda row: f"{1000 * row['landing_error_mean_m']:.1f} mm",
    "x floor": lambda row: "-" if row.get("times_floor") is None else f"{row['times_floor']:.2f}",
    "under 30 mm": lambda row: percent(row["landing_near_share"]),
    "success": lambda row: f"{100 * row['success_rate']:.1f} %",
    "sorted/min": lambda row: f"{row['sorted_per_min']:.1f}",
}
"""Columns of tables of throws, and what they show of a row."""


def _interval(interval: Data, figure: Figure) -> str:
    value, low, high = (interval[name] for name in ("value", "low", "high"))
    text = figure.interval(metrics.Interval(value, low, high), "+")
    return text if interval["excludes_zero"] else f"{text}, not distinguishable"
