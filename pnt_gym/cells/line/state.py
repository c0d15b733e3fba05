"""State of N lines in their shifts: the deciding robots, their choices, and the fate of every object."""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.line.books import Accounts, Books

CHOICES: Final = 16
"""Choices that a robot has at most."""
COLUMNS: Final = 19
"""Numbers of a choice; those of a pick and throw come first."""


@final
class Fate(IntEnum):
    """Fate of an object."""

    RIDES = 0
    """On the belt, or past its end."""
    HELD = 1
    """In a hand when the shift ended."""
    SORTED = 2
    """In a bin that takes the object."""
    MISPLACED = 3
    """In a bin that takes other items."""
    FLOOR = 4
    """In no bin."""


@dataclass(frozen=True)
class PicksAndThrows(ABC):
    """Picks and throws as planned, S, each by the deciding robot of its line; times from now on."""

    bin: Ints
    """Index of the robot's bin."""
    numbers: Floats
    """All numbers of the picks and throws, S + (columns,); the properties are views of the columns."""

    @property
    def percent(self) -> Floats:
        """Speed setting [%]."""
        return self.numbers[..., 0]

    @property
    def pick(self) -> Floats:
        """Place where the object is lifted, from the robot's base, S + (3,) [m]."""
        return self.numbers[..., 1:4]

    @property
    def away(self) -> Floats:
        """Vector from the pick to the middle of the bin, along x and y, S + (2,) [m]."""
        return self.numbers[..., 4:6]

    @property
    def lift(self) -> Floats:
        """Time until the object is lifted, dwell included [s]."""
        return self.numbers[..., 6]

    @property
    def wait(self) -> Floats:
        """Part of `lift` in which the hand stands still above the belt [s]."""
        return self.numbers[..., 7]

    @property
    def leave(self) -> Floats:
        """Time until the object can no longer be lifted [s]."""
        return self.numbers[..., 8]

    @property
    def throwing(self) -> Floats:
        """Time from the lift until the hand stands still after the throw [s]."""
        return self.numbers[..., 9]

    @property
    def stop(self) -> Floats:
        """Place where the hand stops after the throw, from the robot's base, S + (3,) [m]."""
        return self.numbers[..., 10:13]

    @property
    def cycle(self) -> Floats:
        """Time until the robot is free again, S [s]."""
        return self.lift + self.throwing


@final
@dataclass(frozen=True)
class Choices(PicksAndThrows):
    """Choices of N deciding robots: `CHOICES` places each, S = (N, CHOICES).

    The first places are real, ordered by value less the price of the choice's time, the best first; the other places
    hold arbitrary values.
    """

    real: Bools
    """Whether each choice exists."""
    index: Ints
    """Index of the object in the stream."""

    def at(self, index: Any) -> Choices:
        """Choices at an index of lines and places, as `take` gives them in three times the time."""
        return Choices(self.bin[index], self.numbers[index], self.real[index], self.index[index])

    @property
    def value(self) -> Floats:
        """Value of the object in its bin, as the camera classifies the object."""
        return self.numbers[..., 13]

    @property
    def chance(self) -> Floats:
        """Chance that the attempt brings the object into the bin, by the table for the classified item."""
        return self.numbers[..., 14]

    @property
    def crowd(self) -> Floats:
        """Other objects that the robot can take near the place where its hand will stop, as they lie then."""
        return self.numbers[..., 15]

    @property
    def heirs(self) -> Floats:
        """Robots downstream that can take the object."""
        return self.numbers[..., 16]

    @property
    def reaches(self) -> Floats:
        """Time until the object enters the window of the first heir [s]; 0 without an heir."""
        return self.numbers[..., 17]

    @property
    def queue(self) -> Floats:
        """Objects between the object and that window that the heir can take."""
        return self.numbers[..., 18]


@final
@dataclass(frozen=True)
class LineState:
    """State of N lines in the middle of their shifts, with R robots and M objects each."""

    clock: Floats
    """Time since the begin of the shift (N,) [s]."""
    robot: Ints
    """Index of the deciding robot (N,)."""
    free: Floats
    """Time at which each robot is free again (N, R) [s]."""
    expected: Floats
    """Planned value of `free` at the decision; a robot whose cup does not seal is free earlier (N, R) [s]."""
    hand: Floats
    """Positions of the hands at `free`, from the bases (N, R, 3) [m]."""
    busy: Floats
    """Working time of each robot, without waiting above the belt (N, R) [s]."""
    choices: Choices
    """Choices of the deciding robot."""
    books: Books
    """Books of every object (N, M)."""

    def copy(self) -> LineState:
        """The state with arrays of its own, which its maker may overwrite; books need no copy."""
        choices = self.choices
        return LineState(
            clock=self.clock.copy(),
            robot=self.robot.copy(),
            free=self.free.copy(),
            expected=self.expected.copy(),
            hand=self.hand.copy(),
            busy=self.busy.copy(),
            choices=Choices(choices.bin.copy(), choices.numbers.copy(), choices.real.copy(), choices.index.copy()),
            books=self.books,
        )

    def overwrite(self, rows: Ints, state: LineState) -> None:
        """Write the states of some lines from one line's state, in place, apart from the books."""
        pairs = (self, state), (self.choices, state.choices)
        for (target, source), names in zip(pairs, (_OF_ROBOTS, _OF_CHOICES), strict=True):
            for name in names:
                getattr(target, name)[rows] = getattr(source, name)

    @classmethod
    def begin(cls, count: int, robots: int, objects: int, hand: Floats, choices: Choices) -> LineState:
        """State at the begin of shifts, with no choices computed yet."""
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


_OF_ROBOTS: Final = ("clock", "robot", "free", "expected", "hand", "busy")
_OF_CHOICES: Final = ("bin", "numbers", "real", "index")
