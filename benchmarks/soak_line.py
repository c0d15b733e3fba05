"""Work random shifts of lines for hours: does each begin, go on, end with books that agree, and leave memory flat?

`python -m benchmarks.soak_line` takes 100,000 decisions at lines of 1 to 4 robots that stand up to 100 km from the
origin, in shifts of a minute to four hours, at random and now and then what there is not. Exit code 1 at a find: a
reset or a thousand decisions that take too long, time that runs backwards, an object that was lifted twice, one that
is missing from a shift's figures or counted twice, a number that is none, or memory that grows.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import cache
from typing import Any, Final

import gymnasium as gym
import numpy as np

from agents.line.plan import line_up
from benchmarks.soak import RULED_OUT, lifts, memory
from pnt_gym.cells.line.chances import place_of
from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig
from pnt_gym.errors import PntGymError

SHORTEST, LONGEST = 60.0, 14400.0
"""Shifts last between these, as many between a minute and two as between two and four [s]."""
AWAY: Final = 1e5
"""Robots stand no farther from the origin [m]."""
SPREAD: Final = 3.0
"""Gaps between robots are up to so many times longer than those of the level."""
MOST: Final = 8000
"""Decisions of one shift; those of a longer one that come then are not taken."""
RESET: Final = 60.0
"""A shift that has not begun by then hangs [s]."""
THOUSAND: Final = 300.0
"""So do a thousand decisions that are not taken by then [s]."""
SETTLED: Final = 5
"""Shifts before memory has to stay as it is."""
GROWTH: Final = 32.0
"""What it may grow by, from shift to shift and within one [MB]."""
TRIED: Final = ("object", "picked", "sorted", "ended_in", "start", "cycle_time")
"""What is kept of an attempt."""
FATES: Final = ("sorted", "misplaced", "on_floor", "passed")


@cache
def shipped() -> list[LineConfig]:
    """Shipped levels whose tables are there."""
    levels = [LineConfig.load(name) for name in LineConfig.level_names()]
    return [level for level in levels if place_of(level).is_file()]


def random_level(random: np.random.Generator, longest: float = LONGEST) -> LineConfig:
    """A shipped level with other robots, places, arrivals and length of the shift."""
    base = shipped()[int(random.integers(len(shipped())))]
    robots = line_up(base, int(random.integers(1, MOST_ROBOTS + 1)))
    begin, stretch = random.uniform(-AWAY, AWAY), random.uniform(1.0, SPREAD)
    places = begin + stretch * np.array([robot.x - robots[0].x for robot in robots])
    places -= max(places[-1] - AWAY, 0.0)
    return LineConfig.load(
        base,
        robots=[{**robot.model_dump(mode="json"), "x": x} for robot, x in zip(robots, places.tolist(), strict=True)],
        arrivals={"rate": base.arrivals.rate * random.uniform(0.1, 1.0), "regularity": random.uniform(0.2, 3.0)},
        duration=SHORTEST * (longest / SHORTEST) ** random.random(),
    )


def worked(config: LineConfig, seed: int, most: int) -> tuple[list[str], int, bool]:
    """Work one shift.

    Args:
        config: the line.
        seed: of the stream and of what is chosen.
        most: decisions.

    Returns:
        What is wrong with the shift, how many decisions were taken, and whether it is over.
    """
    finds, taken, over = list[str](), 0, False
    try:
        with closing(gym.make("PnTLine-v0", level=config)) as env:
            began = time.monotonic()
            env.reset(seed=seed)
            finds += late("reset", began, RESET)
            for said, ended in decided(env.unwrapped, np.random.default_rng(seed), most):
                finds, taken, over = finds + said, taken + 1, ended
    except PntGymError as error:
        finds.append(f"{type(error).__name__}: {error}")
    return finds, taken, over


def decided(env: Any, random: np.random.Generator, most: int) -> Iterator[tuple[list[str], bool]]:
    """What is wrong with each decision of a shift, and whether the shift is over."""
    x, tried, lifted = env.core.cell.stream.x[0].copy(), list[Mapping[str, Any]](), [set[int]()]
    over, number, clock, used, start = False, 0, time.monotonic(), 0.0, 0.0
    while not over and number < most:
        number += 1
        step = stepped(env, random)
        (*_, over, info), finds = step, wrong(step)
        finds += lifts({"picked": [info["picked"]], "object": [info["object"]]}, lifted)
        tried += [] if info["invalid_action"] else [{name: info[name] for name in TRIED}]
        if not start <= info["start"]:
            finds.append(f"a decision at {start} s is followed by one at {info['start']} s")
        start = info["start"]
        if number % 1000 == 0:
            finds += late("a thousand decisions", clock, THOUSAND)
            clock, used = time.monotonic(), used or memory()
        if over:
            finds += counted(env.core.config, x, tried, info)
        if used and (over or number == most) and memory() - used > GROWTH:
            finds.append(f"memory grew from {used:.0f} to {memory():.0f} MB within a shift")
        yield finds, bool(over)


def stepped(env: Any, random: np.random.Generator) -> tuple[Any, ...]:
    """Decide something that there is, and now and then something that there is not; what the step returns."""
    there = env.core.masks()[0]
    score = random.random(len(there)) + there
    return env.step(int((-score if random.random() < RULED_OUT else score).argmax()))


def wrong(step: tuple[Any, ...]) -> list[str]:
    """What is wrong with the numbers of a step."""
    observation, reward, *_, info = step
    finds = [] if np.isfinite(observation).all() and np.isfinite(reward) else ["a number is none"]
    if not (info["dt"] >= 0.0 and info["cycle_time"] > 0.0):
        finds.append(f"a cycle takes {info['cycle_time']} s, and the next one begins {info['dt']} s later")
    return finds


def counted(config: LineConfig, x: np.ndarray, tried: list[Mapping[str, Any]], info: Mapping[str, Any]) -> list[str]:
    """What is wrong with the figures of a shift, by a count of what became of each of its objects.

    Args:
        config: the line.
        x: where each object lay when the shift began (M,) [m].
        tried: attempts, in their order.
        info: figures of the shift.
    """
    gone = x + config.cell.belt.speed * config.duration > config.reach[1]
    fates = np.where(gone, "passed", "rides").astype(object)
    for one in tried:
        if one["picked"]:
            bin_ = "misplaced" if one["ended_in"] >= 0 else "on_floor"
            ended = "sorted" if one["sorted"] else bin_
            fates[one["object"]] = ended if one["start"] + one["cycle_time"] <= config.duration else "held"
    count, said = Counter(fates), {name: int(info[f"shift_{name}"]) for name in FATES}
    finds = [f"{name} is {said[name]}, and {count[name]} by a count" for name in FATES if said[name] != count[name]]
    total = sum(count[name] for name in FATES)
    if info["shift_objects"] != total or total + count["rides"] + count["held"] != len(x):
        finds.append(f"of {len(x)} objects {total} have come and {info['shift_objects']:.0f} are told of")
    if info["shift_attempts"] != len(tried):
        finds.append(f"{info['shift_attempts']:.0f} attempts are told of, and {len(tried)} were made")
    return finds


def late(what: str, began: float, most: float) -> list[str]:
    """That something took too long, if it did."""
    seconds = time.monotonic() - began
    return [] if seconds <= most else [f"{what} took {seconds:.0f} s, more than {most:.0f} s"]


def soak(decisions: int, seed: int = 0, longest: float = LONGEST, most: int = MOST) -> tuple[list[str], str]:
    """Work shifts until so many decisions are taken.

    Args:
        decisions: in all.
        seed: of the first shift; the following ones have the following seeds.
        longest: shift [s].
        most: decisions of one shift.

    Returns:
        Finds, and one line about all.
    """
    finds, done, shifts, whole, used = list[str](), 0, 0, 0, list[float]()
    began, hours = time.monotonic(), 0.0
    while done < decisions:
        config = random_level(np.random.default_rng(seed + shifts), longest)
        said, taken, over = worked(config, seed + shifts, min(most, decisions - done))
        where = f"shift {seed + shifts}, {len(config.robots)} robots from x {config.robots[0].x:.0f} m"
        finds += [f"{where}, {config.duration:.0f} s: {one}" for one in said]
        done, shifts, whole, hours = done + max(taken, 1), shifts + 1, whole + over, hours + config.duration / 3600.0
        used.append(memory())
    grown = min(used[-SETTLED:]) - used[SETTLED - 1] if len(used) >= SETTLED else 0.0
    if grown > GROWTH:
        finds.append(f"memory grew by {grown:.0f} MB after {SETTLED} shifts")
    seconds = time.monotonic() - began
    return finds, (
        f"{done} decisions in {shifts} shifts of {hours / shifts:.1f} h on average, {whole} to their end: "
        f"{len(finds)} finds, {used[-1]:.0f} MB ({grown:+.0f} MB), {1e3 * seconds / done:.1f} ms a decision"
    )


def main() -> int:
    """Work; exit code 1 at a find."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--decisions", type=int, default=100_000, metavar="N")
    parser.add_argument("--seed", type=int, default=0, help="of the first shift")
    arguments = parser.parse_args()
    finds, summary = soak(arguments.decisions, arguments.seed)
    for said in finds:
        print(f"FIND {said}")
    print(summary)
    return int(bool(finds))


if __name__ == "__main__":
    sys.exit(main())
