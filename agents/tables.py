"""Evaluations as tables on the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

Summary = Mapping[str, Any]
LONG = 24
"""Text longer than this is no figure."""


def console() -> Console:
    """The terminal; wide enough for a table when the output is a file."""
    found = Console()
    return found if found.is_terminal else Console(width=140)


def throws_bar(terminal: Console, *columns: str) -> Progress:
    """A progress bar over throws; `columns` name extra task fields to show."""
    extra = [TextColumn("{task.fields[" + name + "]}") for name in columns]
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        *extra,
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=terminal,
    )


def summary_table(title: str, summary: Summary) -> Table:
    """Every figure of one evaluation, one per line."""
    table = Table(title=title, show_header=False, title_justify="left")
    table.add_column("figure")
    table.add_column("value", justify="right")
    rows = [
        ("picks per minute, attempted", f"{summary['picks_per_min']:.1f}"),
        ("sorted per minute", f"{summary['sorted_per_min']:.1f}"),
        ("success", success_text(summary)),
        ("landing error, mean", millimetres(summary["landing_error_mean_m"])),
        ("landing error, 95th percentile", millimetres(summary["landing_error_p95_m"])),
        ("bias along / across", pair(summary, "bias")),
        ("spread along / across", pair(summary, "spread")),
        ("cycle time, mean", f"{summary['cycle_time_mean_s']:.3f} s"),
        ("failed: missed the target", f"{100 * summary['failed_missed']:.1f} %"),
        ("failed: reached it, did not stay", f"{100 * summary['failed_rim']:.1f} %"),
        ("failed: touched again by the robot", f"{100 * summary['failed_recontact']:.1f} %"),
        ("corrections clipped", f"{100 * summary['clipped_rate']:.1f} %"),
    ]
    for row in rows:
        table.add_row(*row)
    return table


def comparison_table(title: str, rows: Sequence[tuple[str, int, Summary]]) -> Table:
    """Controllers side by side; each row is a name, its throws of practice or training, and its summary."""
    table = Table(title=title, title_justify="left")
    table.add_column("controller")
    for name in (
        "learned from",
        "landing error",
        "95th pct",
        "success (95 % interval)",
        "picks/min",
        "sorted/min",
    ):
        table.add_column(name, justify="right")
    for name, throws, summary in rows:
        table.add_row(
            name,
            f"{throws} throws" if throws else "-",
            millimetres(summary["landing_error_mean_m"]),
            millimetres(summary["landing_error_p95_m"]),
            success_text(summary),
            f"{summary['picks_per_min']:.1f}",
            f"{summary['sorted_per_min']:.1f}",
        )
    return table


def grid_table(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    """Any table of text: the first column to the left, figures to the right, long text to the left."""
    table = Table(title=title, title_justify="left")
    for index, name in enumerate(header):
        long = any(len(row[index]) > LONG for row in rows)
        table.add_column(name, justify="left" if index == 0 or long else "right")
    for row in rows:
        table.add_row(*map(escape, row))
    return table


def millimetres(metres: float) -> str:
    """A length for people."""
    return f"{1000 * metres:.1f} mm"


def pair(summary: Summary, what: str) -> str:
    """Bias or spread along and across."""
    return f"{1000 * summary[f'{what}_along_m']:.1f} / {1000 * summary[f'{what}_across_m']:.1f} mm"


def success_text(summary: Summary) -> str:
    """A success rate with its interval."""
    low, high = summary["success_low"], summary["success_high"]
    return f"{100 * summary['success_rate']:.1f} % ({100 * low:.1f}..{100 * high:.1f})"
