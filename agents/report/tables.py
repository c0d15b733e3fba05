"""Results of the benchmark as Markdown tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

Row = Mapping[str, Any]
ALIGNED_RIGHT = "---:"


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]], words: Sequence[str] = ()) -> str:
    """A Markdown table; the first column and those named in `words` are text, the others are figures."""
    lines = [
        "| " + " | ".join(header) + " |",
        "| " + " | ".join(["---", *("---" if name in words else ALIGNED_RIGHT for name in header[1:])]) + " |",
        *("| " + " | ".join(row) + " |" for row in rows),
    ]
    return "\n".join(lines)


def escaped(rows: Iterable[Sequence[str]]) -> list[list[str]]:
    """Cells whose text may hold the sign that parts cells."""
    return [[cell.replace("|", "\\|") for cell in row] for row in rows]


def benchmark_table(data: Mapping[str, Any]) -> str:
    """Every controller on the levels of the plan, side by side."""
    levels = data["plan"]["levels"]
    header = ["controller", "throws to learn"]
    for level in levels:
        header += [f"{level}: error", "x floor", "success", "sorted/min"]
    rows = [
        [
            label,
            str(throws) if throws else "-",
            *(cell for level in levels for cell in _figures(data, label, throws, level)),
        ]
        for label, throws in _lines(data, levels)
    ]
    return markdown(header, rows)


def benchmark_note(data: Mapping[str, Any]) -> str:
    """Throw count, seeds and versions behind the table."""
    plan = data["plan"]
    return (
        f"{plan['picks']} held-out throws per seed and level on {plan['env']}, seeds {plan['seeds']} of the learning, "
        f"learned on {plan['train_level']} unless the label says otherwise; "
        "x floor is the error over that of a large network trained on very many throws. Versions: "
        + ", ".join(f"{package} {version}" for package, version in data["versions"].items())
        + "."
    )


def other_levels_table(data: Mapping[str, Any]) -> str | None:
    """Levels that only some controllers were evaluated on; None if there are none."""
    planned = data["plan"]["levels"]
    levels = sorted({row["level"] for row in data["table"]} - set(planned))
    if not levels:
        return None
    header = ["controller", "throws to learn"]
    for level in levels:
        header += [f"{level}: error", "success", "sorted/min"]
    rows = []
    for label, throws in _lines(data, levels):
        figures = [_figures(data, label, throws, level) for level in levels]
        rows.append([label, str(throws) if throws else "-", *(c for f in figures for c in (f[0], f[2], f[3]))])
    return markdown(header, rows)


def failure_table(data: Mapping[str, Any], level: str) -> str:
    """What stood between an object and its bin."""
    header = ["controller", "throws to learn", "missed the opening", "crossed it, not in the bin", "touched by the cup"]
    rows = []
    for row in _of_level(data, level):
        shares = [f"{100 * row[f'share_{name}']:.1f} %" for name in ("missed", "rim", "recontact")]
        rows.append([row["label"], str(row["throws"] or "-"), *shares])
    return markdown(header, rows)


def comparison_table(data: Mapping[str, Any], level: str) -> str:
    """Learned less reference with 95 % intervals, paired throw by throw."""
    header = ["learned", "less", "landing error", "sorted/min"]
    rows = [
        [
            _choice(c["learned"]),
            _choice(c["reference"]),
            _interval(c["landing_error_m"], 1000, "mm"),
            _interval(c["sorted_per_min"], 1, ""),
        ]
        for c in data["comparisons"]
        if c["level"] == level and c["learned"] != c["reference"]
    ]
    return markdown(header, rows)


def published_table(data: Mapping[str, Any]) -> str:
    """Published beside reproduced figures."""
    header = ["quantity", "published", "reproduced", "unit", "verdict", "note"]
    return markdown(header, escaped([_text(row.get(name)) for name in header] for row in data["rows"]))


def _lines(data: Mapping[str, Any], levels: Sequence[str]) -> list[tuple[str, int]]:
    """Labels and throws in the plan's order, those that were evaluated on one of the levels."""
    order = [entry["label"] for entry in data["plan"]["entries"]]
    found = {(row["label"], row["throws"]) for row in data["table"] if row["level"] in levels}
    return sorted(found, key=lambda line: (order.index(line[0]), line[1]))


def _of_level(data: Mapping[str, Any], level: str) -> list[Row]:
    rows = {(row["label"], row["throws"]): row for row in data["table"] if row["level"] == level}
    return [rows[line] for line in _lines(data, [level])]


def _figures(data: Mapping[str, Any], label: str, throws: int, level: str) -> list[str]:
    for row in data["table"]:
        if (row["label"], row["throws"], row["level"]) == (label, throws, level):
            floor = row.get("times_floor")
            return [
                f"{1000 * row['landing_error_mean_m']:.1f} mm",
                "-" if floor is None else f"{floor:.2f}",
                f"{100 * row['success_rate']:.1f} %",
                f"{row['sorted_per_min']:.1f}",
            ]
    return ["-"] * 4


def _choice(choice: Mapping[str, Any]) -> str:
    return f"{choice['label']} ({choice['throws']})" if choice["throws"] else str(choice["label"])


def _interval(interval: Mapping[str, Any], scale: float, unit: str) -> str:
    value, low, high = (scale * interval[name] for name in ("value", "low", "high"))
    text = f"{value:+.1f} ({low:+.1f}..{high:+.1f}) {unit}".rstrip()
    return text if interval["excludes_zero"] else f"{text}, not distinguishable"


def _text(value: object) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
