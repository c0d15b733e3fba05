"""Changes of a design that are worth trying, and what each of them brings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final, final

import numpy as np

from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig

from . import changes
from .answers import Answer, Gain
from .changes import Change

NEARER: Final = 0.10
"""Way by which bins are moved nearer to the belt [m]."""
SLOWER: Final = 0.8
"""Factor on the speed of the belt."""
STEP: Final = 10.0
"""Step of the speed limits [%]."""
SLOWEST: Final = 20.0
"""Least speed limit that is tried [%]."""


@final
@dataclass(frozen=True)
class Try:
    """A change that is worth trying."""

    words: str
    change: Change


@final
@dataclass(frozen=True)
class Tried:
    """A change that was tried on a design."""

    words: str
    line: LineConfig
    """The design with the change."""
    gain: Gain
    """What the change brings."""


def worth_trying(answer: Answer) -> Iterator[Try]:
    """Changes that may help a design; one that is impossible is refused like any other change."""
    line, percent = answer.line, max(answer.line.cell.limits.percent)
    if len(line.robots) < MOST_ROBOTS:
        yield Try("one more robot", partial(changes.set_robots, count=len(line.robots) + 1))
    yield Try(f"bins {1000 * NEARER:.0f} mm nearer to the belt", partial(changes.shift_bins, y=-NEARER))
    swap = _swap(answer)
    if swap is not None:
        yield swap
    if any(robot.skills for robot in line.robots):
        yield Try("all skills for every robot", changes.share_skills)
    speed = round(SLOWER * line.cell.belt.speed, 3)
    yield Try(f"a belt at {speed:g} m/s", partial(changes.set_belt_speed, speed=speed))
    for other in (percent - STEP, percent + STEP):
        if SLOWEST <= other <= 100.0 and not any(robot.percent for robot in line.robots):
            yield Try(f"limits at {other:g} %", partial(changes.set_limits, percent=other))


def _swap(answer: Answer) -> Try | None:
    """The bin of the item of which most objects are not sorted, changed with the bin nearest to the robot's middle."""
    line, fates = answer.line, answer.row["fates_by_item"]
    lost = np.array(answer.row["arrived"]) * [1.0 - fates[item]["sorted"] for item in line.cell.items]
    item, bins = line.cell.items[int(lost.argmax())], line.robots[0].bins or line.cell.bins.fixed
    own = next((number for number, bin_ in enumerate(bins) if bin_.takes(item)), None)
    middle = min(range(len(bins)), key=lambda number: abs(bins[number].x), default=None)
    if own is None or middle is None or own == middle:
        return None
    words = f"bins {bins[own].name} and {bins[middle].name} swapped"
    return Try(words, partial(changes.swap_bins, robot=0, first=own, second=middle))
