"""Shifts of lines with hostile places and lengths, and what is wrong with a shift by a count of all of its objects."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import cache
from typing import Any, Final

import gymnasium as gym
import numpy as np

from agents.line.plans import line_up
from benchmarks.checks import choices, memory
from pnt_gym.arrays import Floats
from pnt_gym.cells.line.chances import table_path
from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig
from pnt_gym.errors import PntGymError

SHORTEST, LONGEST = 60.0, 14400.0
"""Shifts last between these, as many between a minute and two as between two and four [s]."""
AWAY: Final = 1e5
"""Robots stand no farther from the origin [m]."""
SPREAD: Final = 3.0
"""Gaps between robots are up to so many times longer than those of the level."""
RULED_OUT: Final = 0.1
"""Share of decisions that the mask rules out."""
RESET: Final = 60.0
"""A shift that has not begun by then hangs [s]."""
THOUSAND: Final = 300.0
"""So do a thousand decisions that are not taken by then [s]."""
GROWTH: Final = 32.0
"""What memory may grow by, from shift to shift and within one [MB]."""
FATES: Final = ("sorted", "misplaced", "on_floor", "passed")


@cache
def shipped_levels() -> list[LineConfig]:
    """Shipped levels whose tables are there."""
    levels = [LineConfig.load(name) for name in LineConfig.level_names()]
    return [level for level in levels if table_path(level).is_file()]


def random_level(random: np.random.Generator, longest: float = LONGEST) -> LineConfig:
    """A shipped level with other robots, places, arrivals and length of the shift."""
    base = shipped_levels()[int(random.integers(len(shipped_levels())))]
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


class Books:
    """What became of the objects of one line's shift, counted from its decisions.

    Args:
        config: the line.
        x: where each object lay when the shift began (M,) [m].
    """

    def __init__(self, config: LineConfig, x: Floats) -> None:
        self._config, self._attempts, self._start = config, 0, 0.0
        passes = x + config.cell.belt.speed * config.duration > config.reach[1]
        self._fates = np.where(passes, "passed", "rides").astype(object)
        self._lifted = set[int]()

    def after(self, info: Mapping[str, Any]) -> Iterator[str]:
        """What is wrong with a decision, by its info."""
        if not (info["dt"] >= 0.0 and info["cycle_time"] > 0.0):
            yield f"a cycle takes {info['cycle_time']} s, and the next one begins {info['dt']} s later"
        if not self._start <= info["start"]:
            yield f"a decision at {self._start} s is followed by one at {info['start']} s"
        self._start = info["start"]
        self._attempts += not info["invalid_action"]
        if info["picked"]:
            if int(info["object"]) in self._lifted:
                yield f"object {int(info['object'])} was lifted twice"
            self._lifted.add(int(info["object"]))
            self._fates[int(info["object"])] = self._fate(info)

    def _fate(self, info: Mapping[str, Any]) -> str:
        """What becomes of an object that a robot lifted."""
        if info["start"] + info["cycle_time"] > self._config.duration:
            return "held"
        return "sorted" if info["sorted"] else "misplaced" if info["ended_in"] >= 0 else "on_floor"

    def at_the_end(self, info: Mapping[str, Any]) -> Iterator[str]:
        """What is wrong with the figures of the shift."""
        count, objects = Counter(self._fates), len(self._fates)
        for name in FATES:
            if info[f"shift_{name}"] != count[name]:
                yield f"{name} is {info[f'shift_{name}']:.0f}, and {count[name]} by a count"
        total = sum(count[name] for name in FATES)
        if info["shift_objects"] != total or total + count["rides"] + count["held"] != objects:
            yield f"of {objects} objects {total} have come and {info['shift_objects']:.0f} are told of"
        if info["shift_attempts"] != self._attempts:
            yield f"{info['shift_attempts']:.0f} attempts are told of, and {self._attempts} were made"
        busy = np.asarray(info["shift_utilisation"])
        if not ((busy >= 0.0) & (busy <= 1.0)).all():
            yield f"robots work {busy.tolist()} of their time"


def work(config: LineConfig, seed: int, limit: int) -> tuple[list[str], int, bool]:
    """Work one shift.

    Args:
        config: the line.
        seed: of the stream and of what is chosen.
        limit: largest number of decisions.

    Returns:
        What is wrong with the shift, how many decisions were taken, and whether it is over.
    """
    finds, count, over = list[str](), 0, False
    try:
        with closing(gym.make("PnTLine-v0", level=config)) as env:
            began = time.monotonic()
            env.reset(seed=seed)
            finds += late("reset", began, RESET)
            for faults, ended in decisions(env.unwrapped, np.random.default_rng(seed), limit):
                finds, count, over = finds + faults, count + 1, ended
    except PntGymError as error:
        finds.append(f"{type(error).__name__}: {error}")
    return finds, count, over


def decisions(env: Any, random: np.random.Generator, limit: int) -> Iterator[tuple[list[str], bool]]:
    """What is wrong with each decision of a shift, and whether the shift is over."""
    books = Books(env.core.config, env.core.cell.stream.x[0])
    over, number, clock, used = False, 0, time.monotonic(), 0.0
    while not over and number < limit:
        number += 1
        observation, reward, _, over, info = env.step(int(choices(env.core.masks(), random, RULED_OUT)[0]))
        finds = [*no_numbers(observation, reward), *books.after(info), *(books.at_the_end(info) if over else ())]
        if number % 1000 == 0:
            finds += late("a thousand decisions", clock, THOUSAND)
            clock, used = time.monotonic(), used or memory()
        if used and (over or number == limit) and memory() - used > GROWTH:
            finds.append(f"memory grew from {used:.0f} to {memory():.0f} MB within a shift")
        yield finds, bool(over)


def no_numbers(observation: Any, reward: Any) -> list[str]:
    """The finding that an entry of an observation or a reward is not finite; nothing if all are."""
    parts = observation.values() if isinstance(observation, dict) else [observation]
    return [] if all(np.isfinite(part).all() for part in parts) and np.isfinite(reward).all() else ["a number is none"]


def late(subject: str, began: float, limit: float) -> list[str]:
    """The finding that a reset or decisions took too long; nothing if they did not."""
    seconds = time.monotonic() - began
    return [] if seconds <= limit else [f"{subject} took {seconds:.0f} s, more than {limit:.0f} s"]
