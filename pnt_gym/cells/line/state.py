"""Where N lines are in their shifts: whose turn it is, what it can do, and what has become of every object."""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.line.books import Accounts, Books

CHOICES: Final = 16
"""Things that a robot can choose between."""


@final
class Fate(IntEnum):
    """What has become of an object."""

    RIDES = 0
    """On the belt, or past its end."""
    HELD = 1
    """In a hand when the shift ended."""
    SORTED = 2
    """In a bin that takes it."""
    MISPLACED = 3
    """In a bin that takes other things."""
    FLOOR = 4
    """In none."""


@dataclass(frozen=True)
class PicksAndThrows(ABC):
    """Picks and throws as planned, S, each by the robot whose turn it is in its line; times from now on."""

    bin: Ints
    """Bin of the robot."""
    percent: Floats
    """Speed setting."""
    pick: Floats
    """Where the object is lifted, from the robot's base, S + (3,) [m]."""
    away: Floats
    """From there to the middle of the bin, along x, y, S + (2,) [m]."""
    lift: Floats
    """Until the object is lifted, dwell included [s]."""
    wait: Floats
    """Part of it in which the hand stands still above the belt [s]."""
    leave: Floats
    """Until it can no longer be lifted [s]."""
    throwing: Floats
    """From the lift until the hand stands still after the throw [s]."""
    stop: Floats
    """Where it does, from the robot's base, S + (3,) [m]."""

    @property
    def cycle(self) -> Floats:
        """Until the robot is free again, S [s]."""
        return self.lift + self.throwing


@final
@dataclass(frozen=True)
class Choices(PicksAndThrows):
    """What N robots whose turn it is can do: `CHOICES` places each, S = (N, CHOICES).

    The first places are real, the best first by value less the price of its time; others hold anything.
    """

    real: Bools
    """Which there are."""
    index: Ints
    """Object of the stream."""
    value: Floats
    """What the object is worth in its bin, as the camera sees it."""
    chance: Floats
    """That the attempt brings it there, by the table of what it is seen as."""
    crowd: Floats
    """Other objects near where the hand will stop that it could take, as they lie then."""
    heirs: Floats
    """Robots downstream that can take it."""
    reaches: Floats
    """Until it comes into the window of the first of them [s]; 0 where there is none."""
    queue: Floats
    """Objects between here and there that this one can take."""


@final
@dataclass(frozen=True)
class Shift:
    """N lines in the middle of their shifts, with R robots and M objects each."""

    clock: Floats
    """Since the begin of the shift (N,) [s]."""
    robot: Ints
    """Whose turn it is (N,)."""
    free: Floats
    """When each robot is free again (N, R) [s]."""
    expected: Floats
    """When it was to be when it began; a cup that does not seal is earlier (N, R) [s]."""
    hand: Floats
    """Where hands stand then, from the bases (N, R, 3) [m]."""
    busy: Floats
    """How long each robot has worked, waiting above the belt not included (N, R) [s]."""
    choices: Choices
    """What the robot whose turn it is can do."""
    books: Books
    """What has become of every object (N, M)."""

    @classmethod
    def begin(cls, count: int, robots: int, objects: int, hand: Floats, choices: Choices) -> Shift:
        """Shifts begin; no choice is looked for yet."""
        clear = np.zeros((count, robots))
        return cls(
            clock=np.zeros(count),
            robot=np.zeros(count, dtype=np.int64),
            free=clear,
            expected=clear.copy(),
            hand=np.tile(hand, (count, robots, 1)),
            busy=clear.copy(),
            choices=choices,
            books=Books(Accounts.fresh(count, objects)),
        )
