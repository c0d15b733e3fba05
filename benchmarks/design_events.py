"""Thousands of random events on a session of the design page, how long its answers take, and how far they hold.

`python -m benchmarks.design_events --events 10000` ends with 1 after a fault, or after a design that cannot be saved
and opened again. `--answers N` measures N answers of each kind. `--designs N` compares the answers to N random designs
with those of `pnt-gym line plan` in the full physics.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Final

import numpy as np
import tyro

from agents.design import changes, figures, level_files
from agents.design.answers import Judge
from agents.design.changes import Change
from agents.design.session import Session, opened
from agents.line.plans import Conditions, Sweep, judge, make_plans
from pnt_gym.cells.conveyor.robot import sheet_names
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import PntGymError

WILD: Final = 0.1
"""Share of changes that are far out of their range."""


@dataclass(frozen=True)
class Arguments:
    """Random events of designing, and times of answers."""

    events: int = 10_000
    """Events of a session."""
    answers: int = 0
    """Answers of each kind to measure."""
    designs: int = 0
    """Random designs to compare with the full physics."""
    throws: int = 1000
    """Throws in the full physics behind each table."""
    seed: int = 0
    """Seed of the events."""


def random_change(line: LineConfig, rng: np.random.Generator, wild: float = WILD) -> Change:
    """A change as a hand on sliders makes them, now and then far out of its range."""
    scale = 50.0 if rng.random() < wild else 1.0
    robot, item = int(rng.integers(len(line.robots))), str(rng.choice(line.cell.items))
    owner = int(rng.choice(changes.bin_owners(line)))
    number = int(rng.integers(len(changes.fixed_bins(line, owner))))
    x, y = rng.normal([0.0, 0.4], [0.5, 0.3]).tolist()
    return [
        partial(changes.set_robots, count=int(rng.integers(0, 6))),
        partial(changes.set_belt_speed, speed=float(rng.uniform(-0.1, 1.5) * scale)),
        partial(changes.set_rate, per_minute=float(rng.uniform(-5.0, 480.0) * scale)),
        partial(changes.set_limits, percent=float(rng.uniform(0.0, 110.0))),
        partial(changes.move_robot, robot=robot, x=float(rng.uniform(-2.0, 6.0) * scale)),
        partial(changes.choose_sheet, robot=robot, name=str(rng.choice(sheet_names()))),
        partial(changes.move_bin, robot=owner, number=number, x=x, y=y),
        partial(changes.set_share, item=item, percent=float(rng.uniform(0.0, 101.0))),
        partial(changes.set_value, item=item, value=float(rng.uniform(-0.1, 5.0))),
        partial(changes.set_standstill, robot=line.robots[robot].name, seconds=float(rng.uniform(-5.0, 70.0))),
    ][int(rng.integers(10))]


def act(session: Session, rng: np.random.Generator) -> bool:
    """Let a random event happen; whether it was possible."""
    kind = rng.random()
    if kind < 0.05:
        session.undo()
    elif kind < 0.08:
        session.redo()
    elif kind < 0.10:
        session.keep()
    elif kind < 0.11:
        return session.begin(lambda: LineConfig.load("skills3"))
    else:
        return session.change(random_change(session.state.line, rng))
    return True


def run_events(count: int, seed: int) -> None:
    """Let events happen while the session's thread judges, and tell what came of it."""
    session, rng, refused = Session(LineConfig.load("skills3")), np.random.default_rng(seed), 0
    for event in range(count):
        refused += not act(session, rng)
        figures.panel(session.state)
        if event % 100 == 0:
            line = session.state.line
            assert level_files.line_of_text(level_files.text_of_line(line), "again") == line
        if event % 1000 == 0:
            print(f"{event} events, {refused} refused, {session.worker.faults} faults", flush=True)
    session.worker.wait(120.0)
    session.close()
    print(f"{count} events, {refused} refused, {session.worker.faults} faults")
    if session.worker.faults:
        sys.exit(1)


def time_answers(count: int, seed: int) -> None:
    """Print quantiles of the time of answers: provisional ones with a valid table, settled ones without.

    A settled answer is timed from the change on, with the provisional answer before it, as the page gives both.
    """
    rng, base, judge = np.random.default_rng(seed), opened(LineConfig.load("skills3")), Judge()
    for is_settled in (False, True, False, True):
        judge.answer(base, is_settled)  # compiles, and counts the table
    times: dict[str, list[float]] = {"provisional after a slider": [], "settled after a dragged bin": []}
    while min(map(len, times.values())) < count:
        slid = partial(changes.set_rate, per_minute=float(rng.uniform(60.0, 300.0)))
        x, y = rng.uniform(-0.42, -0.38), rng.uniform(0.26, 0.5)
        dragged = partial(changes.move_bin, robot=0, number=0, x=float(x), y=float(y))
        for taken, change, stages in zip(times.values(), (slid, dragged), ([False], [False, True]), strict=True):
            begin = perf_counter()
            try:
                line = change(base)
                for is_settled in stages:
                    judge.answer(line, is_settled)
            except PntGymError:
                continue
            taken.append(perf_counter() - begin)
    for name, taken in times.items():
        median, high = np.quantile(taken, [0.5, 0.95])
        print(f"{name}: median {1000 * median:.0f} ms, p95 {1000 * high:.0f} ms, {len(taken)} answers")


def random_design(rng: np.random.Generator) -> LineConfig:
    """A design that some changes make of `skills3`, that can be judged, and whose robots have a model."""
    while True:
        line, left = opened(LineConfig.load("skills3")), int(rng.integers(2, 6))
        try:
            while left:
                change = random_change(line, rng, wild=0.0)
                try:
                    line, left = change(line), left - 1
                except PntGymError:
                    continue
            Judge().answer(line, False)
        except PntGymError:
            continue
        if line.finest == "full":
            return line


def compare_designs(count: int, throws: int, seed: int) -> None:
    """Print the recovery of random designs by the page, and by `pnt-gym line plan` in the full physics."""
    rng, over = np.random.default_rng(seed), list[float]()
    with TemporaryDirectory() as folder:
        conditions = Conditions(throws=throws, tables=Path(folder), check=0, quiet=True)
        for number in range(count):
            line = random_design(rng)
            page = Judge().answer(line, True).row
            sweep = Sweep(robots=(len(line.robots),), minutes=line.duration / 60.0)
            plan = judge(*next(make_plans(line, sweep)), conditions).row
            over.append(100.0 * (page["recovery"] - plan["recovery"]))
            counts = 100.0 * plan["recovery_counts"]
            print(
                f"{number}: page {100 * page['recovery']:.1f} %, plan {100 * plan['recovery']:.1f} % +- {counts:.1f} "
                f"by its counts, page over plan {over[-1]:+.2f} points",
                flush=True,
            )
    far = np.abs(over)
    print(f"{count} designs: mean {np.mean(over):+.2f}, {(far <= 1.0).sum()} within 1 point, farthest {far.max():.2f}")


def main(arguments: Arguments) -> None:
    """Measure answers, compare designs, or let events happen."""
    if arguments.designs:
        compare_designs(arguments.designs, arguments.throws, arguments.seed)
    if arguments.answers:
        time_answers(arguments.answers, arguments.seed)
    if arguments.events:
        run_events(arguments.events, arguments.seed)


if __name__ == "__main__":
    main(tyro.cli(Arguments))
