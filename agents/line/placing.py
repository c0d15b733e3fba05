"""`line plan --place`: better places of a level's bins and robots, searched, judged, said and written."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from threading import Event
from types import FrameType
from typing import Any, Final

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.reading import yaml_text

from ..ground import levels
from ..ground.cli import UsageError, at_least
from ..ground.outputs import check_ending, check_writable, deliver_json, deliver_text
from ..ground.streams import handle_signals, interrupt
from ..ground.tables import console, percent, throws_bar, value_table
from ..ground.versions import versions
from . import reasons, verdict
from .estimate import estimate
from .flown import SETTLED
from .goal import Goal
from .layouts import What
from .places import Improvement, Progress, improve
from .plans import Conditions, Sweep, make_plans

SWEPT: Final = ("robots", "speeds", "percents", "skills")
"""Options of a sweep, which has no place beside a search."""
PLACED: Final[Mapping[str, Any]] = {"keep_out": (), "tries": 100, "write": None}
"""Options of a search for places, with their defaults."""


def check_absent(options: Mapping[str, Any]) -> None:
    """Make sure that a sweep has no option of a search for places.

    Raises:
        UsageError: there is one.
    """
    given = [f"--{name.replace('_', '-')}" for name, default in PLACED.items() if options[name] != default]
    if given:
        raise UsageError(f"{', '.join(given)} goes with --place bins, robots or all, which is not given")


def place(what: What, options: Mapping[str, Any]) -> None:
    """Search for better places of a level's bins and robots, say what they bring, and write the level that has them.

    With a goal the search goes on with one robot more until the line reaches the goal.

    Raises:
        UsageError: an option has no place beside `--place`, or is out of its range.
    """
    _check(what, options)
    sweep, conditions = verdict.read(options)
    goal = None if options["want"] is None else Goal.of(options["recovery"], options["want"])
    level = verdict.load(options["level"], None)
    levels.show(level)
    counts = (len(level.robots),) if goal is None else tuple(sorted(sweep.robots))
    for numbers, line in make_plans(level, replace(sweep, robots=counts)):
        found = _search(line, what, options, conditions)
        if numbers["robots"] != len(level.robots):
            robots = [robot.model_dump(mode="json", exclude_unset=True) for robot in found.config.robots]
            found = replace(found, differences={**found.differences, "robots": robots})
        is_enough, answer = _answer(found, conditions, goal)
        if is_enough or numbers["robots"] == counts[-1]:
            report(found, line, options)
            if answer:
                console().print(answer)
            return


def _answer(found: Improvement, conditions: Conditions, goal: Goal | None) -> tuple[bool, str]:
    """Whether the line with the places found reaches a goal by flights, and the answer in words, if there is a goal."""
    if goal is None:
        return True, ""
    plan = estimate(found.config, conditions, SETTLED).planned
    is_enough = goal.is_reached(plan.row)
    return is_enough, f"with these places, by flights: {reasons.answer(plan, is_enough, goal)}"


def _check(what: What, options: Mapping[str, Any]) -> None:
    """Make sure that the options go with a search for places.

    Raises:
        UsageError: they do not.
    """
    swept = [name for name in SWEPT if name != "robots" or options["want"] is None]
    changed = [f"--{name}" for name in swept if options[name] != getattr(Sweep(), name)]
    changed += [f"--{name}" for name in ("release", "picture") if options[name] is not None]
    if changed:
        raise UsageError(f"--place {what} keeps robots, speeds, limits, skills and throws: leave {changed[0]} out")
    at_least(options, tries=1)
    for x0, x1, y0, y1 in options["keep_out"]:
        if not (x0 < x1 and y0 < y1):
            raise UsageError(f"--keep-out is {x0:g} {x1:g} {y0:g} {y1:g}; it must be X0 X1 Y0 Y1 with X0 < X1, Y0 < Y1")
    check_ending("write", options["write"], (".yaml", ".yml"))
    check_writable(options["json"], options["write"])


def _search(line: LineConfig, what: What, options: Mapping[str, Any], conditions: Conditions) -> Improvement:
    """Search for better places of a line with progress on the terminal; Ctrl-C ends the search with the best so far."""
    stop, names = Stop(), (options["keep_out"], options["tries"])
    with handle_signals(stop), throws_bar("best") as bar:
        task = bar.add_task("layouts", total=options["tries"], best="")

        def tell(progress: Progress) -> None:
            best = f"{percent(progress.best)} instead of {percent(progress.today)} by estimate"
            bar.update(task, description=progress.stage, completed=progress.tried, best=best)

        return improve(line, conditions, what, *names, tell=tell, should_stop=stop.is_set)


def report(found: Improvement, line: LineConfig, options: Mapping[str, Any]) -> None:
    """Say what a search has found, and write the files that the options ask for."""
    console().print(value_table("places found, from today's", moves(line, found.config)))
    console().print(found.sentence)
    if options["json"] is not None:
        head = {"level": line.name, "place": options["place"], "versions": versions()}
        deliver_json(options["json"], {**head, **found.entries})
    if options["write"] is not None:
        base, folder = str(options["level"]), options["write"].parent
        # A level's file names the file of its base relative to itself.
        base = os.path.relpath(base, folder) if Path(base).suffix else base
        text = yaml_text(
            {"name": options["write"].stem, "base": base, **found.differences}, default_flow_style=None, width=110
        )
        deliver_text(options["write"], f"# {found.sentence}\n{text}")


def moves(before: LineConfig, after: LineConfig) -> list[tuple[str, str]]:
    """Bins and robots that stand elsewhere, with both places."""
    rows: list[tuple[str, str]] = []
    pairs = [("", before.cell.bins.fixed, after.cell.bins.fixed)]
    for old, new in zip(before.robots, after.robots, strict=True):
        pairs.append((f" of {old.name}", old.bins, new.bins))
        if old.x != new.x:
            rows.append((f"robot {old.name}", f"x {new.x:.3f} m, from {old.x:.3f} m"))
    for owner, old_bins, new_bins in pairs:
        for old, new in zip(old_bins, new_bins, strict=True):
            if (old.x, old.y) != (new.x, new.y):
                places = f"x {new.x:.3f} m, y {new.y:.3f} m, from x {old.x:.3f} m, y {old.y:.3f} m"
                rows.append((f"bin {old.name}{owner}", places))
    return rows


class Stop(Event):
    """Whether a search shall end: the first Ctrl-C says so, and each further signal ends the command."""

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal."""
        if number != signal.SIGINT or self.is_set():
            interrupt(number, frame)
        self.set()
