"""Tables of text as Markdown, as HTML and on the terminal, formats of their figures, and the progress of commands."""

from __future__ import annotations

import re
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from html import escape as escape_html
from threading import Event, Thread
from typing import Any, Final, NamedTuple

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from . import metrics

Summary = Mapping[str, Any]
FIGURE: Final = re.compile(r"[^\w`]*\d")
"""Beginning of a figure, with any sign or bracket before its first digit."""
MARKUP: Final = re.compile(r"(\\*)(\||<(?=[A-Za-z/!?])|\](?=[(\[:]))")
"""Characters that begin a tag, end a link's text or separate cells in Markdown, with the backslashes before them."""
EMPHASIS: Final = re.compile(r"(?<![\w*])\*(\w[^*]*)\*(?![\w*])")
"""Words between asterisks, as Markdown emphasises them."""
NONE: Final = ("-", "")
"""Cells without a figure."""


class Grid(NamedTuple):
    """A table of text; columns of figures are aligned to the right, except the first column.

    Attributes:
        headline: title of the table.
        header: names of the columns.
        rows: cells, as many in each row as there are columns.
        note: text under the table.
    """

    headline: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""

    def markdown(self) -> str:
        """The table as Markdown, without its headline; separators and tags in cells are escaped."""
        dashes = ["---:" if right else "---" for right in self._right()]
        lines = (map(markdown_text, self.header), dashes, *(map(markdown_text, row) for row in self.rows))
        return "\n".join(f"| {' | '.join(line)} |" for line in lines)

    def html(self) -> str:
        """The table as HTML, without its headline; markup in cells is escaped."""
        sides = ["" if right else ' class="left"' for right in self._right()]

        def line(tag: str, row: Sequence[str]) -> str:
            cells = zip(sides, row, strict=True)
            return "<tr>" + "".join(f"<{tag}{side}>{html_text(cell)}</{tag}>" for side, cell in cells) + "</tr>"

        body = "\n".join(line("td", row) for row in self.rows)
        return f"<table>\n<thead>{line('th', self.header)}</thead>\n<tbody>\n{body}\n</tbody>\n</table>"

    def terminal(self) -> Table:
        """The table as a rich table for a console."""
        table = Table(title=escape(self.headline), title_justify="left")
        for name, right in zip(self.header, self._right(), strict=True):
            table.add_column(escape(name), justify="right" if right else "left", overflow="fold")
        for row in self.rows:
            table.add_row(*map(escape, row))
        return table

    def _right(self) -> list[bool]:
        """Which columns hold figures: at least half of the cells that are not empty are figures."""
        right = [False]
        for _, *cells in list(zip(self.header, *self.rows, strict=True))[1:]:
            filled = [cell for cell in cells if cell not in NONE]
            right.append(2 * sum(FIGURE.match(cell) is not None for cell in filled) >= len(filled))
        return right


def markdown_text(text: str) -> str:
    """Text on one line of Markdown, with tags, links and separators of cells escaped."""
    return MARKUP.sub(lambda match: rf"{2 * match[1]}\{match[2]}", " ".join(text.split()))


def html_text(text: str) -> str:
    """Text as HTML with markup escaped; text between backticks becomes code, text between asterisks is emphasised."""
    return EMPHASIS.sub(r"<em>\1</em>", re.sub("`([^`]+)`", r"<code>\1</code>", escape_html(text)))


def console(*, stderr: bool = False) -> Console:
    """The terminal; wide enough for a table when the output, or stderr, is a file."""
    terminal = Console(stderr=stderr)
    return terminal if terminal.is_terminal else Console(stderr=stderr, width=140)


def settings_table(title: str, rows: Sequence[tuple[str, Mapping[str, Any], Any, Any]]) -> Table:
    """Table of a line's controllers: best settings, value per minute, and paired gain over the tuned ATC rule."""
    lines = [
        [name, settings_text(settings), interval_text(metrics.interval(value)), gain_text(value, base)]
        for name, settings, value, base in rows
    ]
    return Grid(title, ("controller", "settings", "value/min (95 % interval)", "over tuned atc"), lines).terminal()


def value_table(title: str, rows: Sequence[tuple[str, str]]) -> Table:
    """Figures by name, one per line, for a console."""
    table = Grid(title, ("figure", "value"), rows).terminal()
    table.show_header = False
    return table


def gain_text(value: Any, base: Any) -> str:
    """Mean gain of values over base values of the same units, for the units that both have; "-" without a base."""
    if base is None or value is base:
        return "-"
    shared = min(len(value), len(base))
    return interval_text(metrics.difference(value[:shared], base[:shared]), "+")


def settings_text(settings: Mapping[str, Any]) -> str:
    """Settings as text on one line."""
    return ", ".join(f"{name} {_text(value)}" for name, value in settings.items())


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"({settings_text(value)})"
    return value if isinstance(value, str) else f"{value:g}"


def interval_text(interval: metrics.Interval, sign: str = "") -> str:
    """Text of a figure with its interval."""
    return f"{interval.value:{sign}.1f} ({interval.low:{sign}.1f}..{interval.high:{sign}.1f})"


def percent(share: float | None) -> str:
    """Text of a share in percent; "-" for None."""
    return "-" if share is None else f"{100 * share:.1f} %"


def millimetres(metres: float) -> str:
    """Text of a length [m] in millimetres."""
    return f"{1000 * metres:.1f} mm"


FIRST: Final = 30.0
"""Time until the first line of a bar that nobody sees [s]; each further line takes twice as long."""
LONGEST: Final = 600.0
"""Longest time between two of these lines [s]."""


@contextmanager
def throws_bar(*columns: str, quiet: bool = False) -> Generator[Progress, None, None]:
    """A progress bar over throws; where the output is no terminal, lines on stderr show that the work goes on.

    Args:
        columns: names of further task fields to show.
        quiet: show nothing.
    """
    extra = [TextColumn("{task.fields[" + name + "]}") for name in columns]
    terminal = console()
    is_seen = terminal.is_interactive or terminal.is_jupyter
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        *extra,
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        console=terminal,
        auto_refresh=is_seen,
        disable=quiet or not is_seen,
    )
    with bar, nullcontext() if is_seen or quiet else _signs(bar):
        yield bar


@contextmanager
def _signs(bar: Progress) -> Generator[None, None, None]:
    """Lines on stderr while the block runs: the tasks that are not done, or else the last one."""
    over = Event()

    def watch() -> None:
        pause = FIRST
        while not over.wait(pause):
            tasks = [task for task in bar.tasks if not task.finished] or bar.tasks[-1:]
            if tasks:
                console(stderr=True).print(bar.make_tasks_table(tasks))
            pause = min(2.0 * pause, LONGEST)

    # A thread, because one throw, one shift or one row may take minutes.
    thread = Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
