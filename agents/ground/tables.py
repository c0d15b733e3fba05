"""Tables: of text as Markdown, HTML and on the terminal, and of evaluations on the terminal."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from html import escape as escape_html
from typing import Any, Final, NamedTuple

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

from . import metrics

Summary = Mapping[str, Any]
FIGURE: Final = re.compile(r"[^\w`]*\d")
"""How a figure begins, whatever sign or bracket stands before it."""
MARKUP: Final = re.compile(r"(\\*)(\||<(?=[A-Za-z/!?])|\](?=[(\[:]))")
"""What begins a tag, ends a link's text or parts cells in Markdown, after backslashes that would escape an escape."""
NONE: Final = ("-", "")
"""Where there is no figure."""
SORTING: Final = {
    "recovery": "recovery: sorted of all that passed",
    "purity": "purity: share of what is in bins",
    "pick_rate": "picks that held",
    "drop_rate": "lost on the way, of those",
}
"""Shares by which a sorter is judged, where its cell tells them."""
SHIFT: Final = {
    "landing_error_first_10_m": "landing error, first 10 of a shift",
    "landing_error_second_half_m": "landing error, second half of a shift",
}
"""Figures of cells in which a throw teaches something for those after it."""
FAILURES: Final = {
    "failed_missed": "failed: missed the target",
    "failed_rim": "failed: reached it, did not stay",
    "failed_recontact": "failed: touched again by the robot",
    "failed_dropped": "failed: lost on the way to the release",
    "failed_unpicked": "failed: not picked",
}
"""Figures of some cells, and what they are called."""


class Grid(NamedTuple):
    """A table of text that prints itself; columns of figures are aligned to the right, the first one never.

    Attributes:
        headline: what it shows.
        header: names of the columns.
        rows: cells, as many in each row as there are columns.
        note: what stands under it.
    """

    headline: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""

    def markdown(self) -> str:
        """The table as Markdown, without its headline; nothing in a cell parts cells or is a tag."""
        dashes = ["---:" if right else "---" for right in self._right()]
        lines = (map(markdown_text, self.header), dashes, *(map(markdown_text, row) for row in self.rows))
        return "\n".join(f"| {' | '.join(line)} |" for line in lines)

    def html(self) -> str:
        """The table as HTML, without its headline; nothing in a cell is markup."""
        sides = ["" if right else ' class="left"' for right in self._right()]

        def line(tag: str, row: Sequence[str]) -> str:
            cells = zip(sides, row, strict=True)
            return "<tr>" + "".join(f"<{tag}{side}>{html_text(cell)}</{tag}>" for side, cell in cells) + "</tr>"

        body = "\n".join(line("td", row) for row in self.rows)
        return f"<table>\n<thead>{line('th', self.header)}</thead>\n<tbody>\n{body}\n</tbody>\n</table>"

    def terminal(self) -> Table:
        """The table for a console."""
        table = Table(title=escape(self.headline), title_justify="left")
        for name, right in zip(self.header, self._right(), strict=True):
            table.add_column(escape(name), justify="right" if right else "left", overflow="fold")
        for row in self.rows:
            table.add_row(*map(escape, row))
        return table

    def _right(self) -> list[bool]:
        """Which columns hold figures."""
        columns = list(zip(self.header, *self.rows, strict=True))
        return [False, *(_are_figures(cells) for _, *cells in columns[1:])]


def _are_figures(cells: Sequence[str]) -> bool:
    """Whether most of those are that are not empty."""
    told = [cell for cell in cells if cell not in NONE]
    return 2 * sum(FIGURE.match(cell) is not None for cell in told) >= len(told)


def markdown_text(text: str) -> str:
    """Text on one line of Markdown in which nothing is a tag or a link, or parts cells of a table."""
    return MARKUP.sub(lambda found: rf"{2 * found[1]}\{found[2]}", " ".join(text.split()))


def html_text(text: str) -> str:
    """Text as HTML in which nothing is markup but code between backticks."""
    return re.sub("`([^`]+)`", r"<code>\1</code>", escape_html(text))


def console() -> Console:
    """The terminal; wide enough for a table when the output is a file."""
    found = Console()
    return found if found.is_terminal else Console(width=140)


def throws_bar(*columns: str) -> Progress:
    """A progress bar over throws; `columns` name extra task fields to show."""
    extra = [TextColumn("{task.fields[" + name + "]}") for name in columns]
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        *extra,
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=console(),
    )


def summary_table(title: str, summary: Summary) -> Table:
    """Every figure of one evaluation that its cell tells, one per line."""
    rows = [
        ("picks per minute, attempted", f"{summary['picks_per_min']:.1f}"),
        ("sorted per minute", f"{summary['sorted_per_min']:.1f}"),
        ("success", success_text(summary)),
        ("landing error, mean", millimetres(summary["landing_error_mean_m"])),
        ("landing error, 95th percentile", millimetres(summary["landing_error_p95_m"])),
        ("landings within 30 mm", percent(summary["landing_near_share"])),
        *((text, millimetres(summary[key])) for key, text in SHIFT.items() if summary.get(key) is not None),
        *(scatter_row(summary, key) for key in summary if key.startswith("bias_") and "seen" not in key),
        ("cycle time, mean", f"{summary['cycle_time_mean_s']:.3f} s"),
        *((text, percent(summary[key])) for key, text in SORTING.items() if key in summary),
        *((f"purity of bin {name}", percent(share)) for name, share in summary.get("purity_by_bin", {}).items()),
        *([("energy per pick", f"{summary['energy_per_pick_j']:.1f} J")] if "energy_per_pick_j" in summary else []),
        *((text, percent(summary[key])) for key, text in FAILURES.items() if key in summary),
        ("corrections clipped", f"{100 * summary['clipped_rate']:.1f} %"),
    ]
    table = Grid(title, ("figure", "value"), rows).terminal()
    table.show_header = False
    return table


def shifts_table(title: str, summary: Summary) -> Table:
    """Every figure of shifts at a line, one per line."""
    low, high = summary["value_per_min_low"], summary["value_per_min_high"]
    rows = [
        ("value per minute", f"{summary['value_per_min']:.1f} ({low:.1f} .. {high:.1f})"),
        ("sorted per minute", f"{summary['sorted_per_min']:.1f}"),
        ("picks per minute, attempted", f"{summary['picks_per_min']:.1f}"),
        ("success", success_text(summary)),
        ("recovery: sorted of all that came", percent(summary["recovery"])),
        ("recovery of value", percent(summary["value_recovery"])),
        *(
            (f"{item}: recovery, passed the end in a shift", f"{percent(share)}, {passed:.1f}")
            for item, share, passed in _together(summary, "items", "recovery_by_item", "passed_by_item")
        ),
        ("value that passed the end, per minute", f"{summary['passed_value_per_min']:.1f}"),
        ("tried in vain, of what passed it", percent(summary["passed_tried"])),
        ("purity: share of what is in bins", percent(summary["purity"])),
        *((f"purity of bin {name}", percent(share)) for name, share in summary["purity_by_bin"].items() if share < 1.0),
        ("picks that held", percent(summary["pick_rate"])),
        *(
            (
                f"robot {name}: at work, picks in a shift, standstill for each",
                f"{percent(share)}, {picks:.0f}, {_seconds(wait)}",
            )
            for name, share, picks, wait in _together(
                summary, "robots", "utilisation", "picks_by_robot", "wait_by_robot_s"
            )
        ),
        ("cycle time, mean", f"{summary['cycle_time_mean_s']:.3f} s"),
        ("standstill above the belt, mean", f"{summary['wait_time_mean_s']:.3f} s"),
        ("time of a decision", f"{summary['ms_per_decision']:.2f} ms"),
        ("choices that were not there", str(summary["invalid_actions"])),
    ]
    table = Grid(title, ("figure", "value"), rows).terminal()
    table.show_header = False
    return table


def _together(summary: Summary, *names: str) -> Iterator[tuple[Any, ...]]:
    """Lists of an evaluation side by side."""
    return zip(*(summary[name] for name in names), strict=True)


def _seconds(time: float | None) -> str:
    """A time for people; "-" where there is none."""
    return "-" if time is None else f"{time:.3f} s"


def tuned_table(title: str, rows: Sequence[tuple[str, Mapping[str, Any], Any, Any]]) -> Table:
    """Controllers of a line, their best settings, value per minute, and how much that is over a rule in pairs."""
    lines = [
        [name, settings_text(settings), interval_text(metrics.mean_interval(value)), _over(value, base)]
        for name, settings, value, base in rows
    ]
    return Grid(title, ("controller", "settings", "value/min (95 % interval)", "over tuned atc"), lines).terminal()


def shifts_comparison(title: str, rows: Sequence[tuple[str, int, Summary]], base: str) -> Table:
    """Controllers of a line side by side over the same shifts, as `comparison_table`; `base` is whom they are over.

    Who has worked fewer shifts is compared on those.
    """
    compared = next((summary["by_shift"]["value_per_min"] for name, _, summary in rows if name == base), None)
    values = [summary["by_shift"]["value_per_min"] for _, _, summary in rows]
    lines = [
        [
            name,
            f"{count} decisions" if count else "-",
            interval_text(metrics.mean_interval(value)),
            "-" if name == base else _over(value, compared),
            f"{summary['sorted_per_min']:.1f}",
            percent(summary["recovery"]),
            f"{summary['ms_per_decision']:.2f}",
        ]
        for (name, count, summary), value in zip(rows, values, strict=True)
    ]
    header = ("controller", "learned from", "value/min (95 % interval)", f"over {base}", "sorted/min", "recovery")
    return Grid(title, (*header, "ms/decision"), lines).terminal()


def _over(value: Any, base: Any) -> str:
    """How much more values of shifts are than others of the same shifts, as far as both go; "-" of nothing."""
    if base is None or value is base:
        return "-"
    shared = min(len(value), len(base))
    return interval_text(metrics.paired_mean(value[:shared], base[:shared]), "+")


def settings_text(settings: Mapping[str, Any]) -> str:
    """Settings on one line."""
    return ", ".join(f"{name} {_setting_text(value)}" for name, value in settings.items())


def _setting_text(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"({settings_text(value)})"
    return value if isinstance(value, str) else f"{value:g}"


def interval_text(interval: metrics.Interval, sign: str = "") -> str:
    """A figure with its interval."""
    return f"{interval.value:{sign}.1f} ({interval.low:{sign}.1f}..{interval.high:{sign}.1f})"


def comparison_table(title: str, rows: Sequence[tuple[str, int, Summary]]) -> Table:
    """Controllers side by side; each row is a name, its throws of practice or training, and its summary."""
    header = ("controller", "learned from", "landing error", "95th pct", "under 30 mm", "success (95 % interval)")
    lines = [
        [
            name,
            f"{throws} throws" if throws else "-",
            *landing_cells(summary),
            f"{summary['picks_per_min']:.1f}",
            f"{summary['sorted_per_min']:.1f}",
        ]
        for name, throws, summary in rows
    ]
    return Grid(title, (*header, "picks/min", "sorted/min"), lines).terminal()


def landing_cells(summary: Summary) -> list[str]:
    """Landing error, its 95th percentile, the share of landings within 30 mm, and success."""
    errors = (summary["landing_error_mean_m"], summary["landing_error_p95_m"])
    return [*map(millimetres, errors), percent(summary["landing_near_share"]), success_text(summary)]


def percent(share: float | None) -> str:
    """A share for people; "-" where there is none."""
    return "-" if share is None else f"{100 * share:.1f} %"


def millimetres(metres: float) -> str:
    """A length for people."""
    return f"{1000 * metres:.1f} mm"


def scatter_row(summary: Summary, bias: str) -> tuple[str, str]:
    """Bias and spread of one error; in millimetres where its name says that it is in metres."""
    name = bias.removeprefix("bias_")
    values = [summary[bias], summary[f"spread_{name}"]]
    label, metres = f"bias / spread {name.removesuffix('_m').replace('_', ' ')}", name.endswith("_m")
    return label, " / ".join(f"{1000 * v:.1f}" if metres else f"{v:.3g}" for v in values) + " mm" * metres


def success_text(summary: Summary) -> str:
    """A success rate with its interval."""
    low, high = summary["success_low"], summary["success_high"]
    return f"{100 * summary['success_rate']:.1f} % ({100 * low:.1f}..{100 * high:.1f})"
