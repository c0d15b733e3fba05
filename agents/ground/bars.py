"""Progress of long commands: a bar on a terminal, elsewhere a line on stderr now and then."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager, nullcontext
from threading import Event, Thread
from typing import Final

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from .tables import console

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
    """Lines on stderr while the block runs."""
    over = Event()
    # A thread, because one throw, one shift or one row may take minutes.
    thread = Thread(target=_give_signs, args=(bar, over), daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def _give_signs(bar: Progress, over: Event) -> None:
    """Print the tasks that are not done, or else the last one, until the work is over."""
    pause = FIRST
    while not over.wait(pause):
        tasks = [task for task in bar.tasks if not task.finished] or bar.tasks[-1:]
        if tasks:
            console(stderr=True).print(bar.make_tasks_table(tasks))
        pause = min(2.0 * pause, LONGEST)
