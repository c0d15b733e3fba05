"""Thousands of random events on a session of the design page, and how long its answers take.

`python -m benchmarks.design_events --events 10000` ends with 1 after a fault, or after a design that cannot be saved
and opened again; `--answers N` measures N answers of each kind in processor time.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import partial
from time import process_time
from typing import Final

import numpy as np
import tyro

from agents.design import changes, figures, level_files
from agents.design.answers import Judge
from agents.design.changes import Change
from agents.design.session import Session, opened
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
    seed: int = 0
    """Seed of the events."""


def random_change(line: LineConfig, rng: np.random.Generator) -> Change:
    """A change as a hand on sliders makes them, now and then far out of its range."""
    scale = 50.0 if rng.random() < WILD else 1.0
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
    """Print quantiles of the processor time of answers: provisional ones with a valid table, settled ones without."""
    rng, base, judge = np.random.default_rng(seed), opened(LineConfig.load("skills3")), Judge()
    for is_settled in (True, False, True):
        judge.answer(base, is_settled)  # compiles, and counts the table
    times: dict[str, list[float]] = {"provisional after a slider": [], "settled after a dragged bin": []}
    while min(map(len, times.values())) < count:
        slid = partial(changes.set_rate, per_minute=float(rng.uniform(60.0, 300.0)))
        x, y = rng.uniform(-0.42, -0.38), rng.uniform(0.26, 0.5)
        dragged = partial(changes.move_bin, robot=0, number=0, x=float(x), y=float(y))
        for taken, change, is_settled in zip(times.values(), (slid, dragged), (False, True), strict=True):
            begin = process_time()
            try:
                judge.answer(change(base), is_settled)
            except PntGymError:
                continue
            taken.append(process_time() - begin)
    for name, taken in times.items():
        median, high = np.quantile(taken, [0.5, 0.95])
        print(
            f"{name}: median {1000 * median:.0f} ms, p95 {1000 * high:.0f} ms of processor time, {len(taken)} answers"
        )


def main(arguments: Arguments) -> None:
    """Measure answers, or let events happen."""
    if arguments.answers:
        time_answers(arguments.answers, arguments.seed)
    if arguments.events:
        run_events(arguments.events, arguments.seed)


if __name__ == "__main__":
    main(tyro.cli(Arguments))
