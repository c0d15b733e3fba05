"""Rows of a line: what each robot, object, choice and attempt is in arrays, and the tables that a level gives."""

from __future__ import annotations

from enum import IntEnum
from typing import Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, copy_rows, take
from pnt_gym.rows import Bools2, Floats1, Floats3, Pair, Row, Rows, Rows1, Rows2, Triple, field, put

CHOICES: Final = 16
"""Choices that a robot has at most."""
IDLE_TIME: Final = 0.1
"""Time after which a robot looks again if it has nothing to take or takes nothing [s]."""
UNAVAILABLE_X: Final = 1e6
"""Position along the belt of objects that the robot cannot take [m]."""
NOBODY: Final = -1
"""Robot of an object that no robot took, and bin of an object that lies in no bin."""


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


@final
class LineNumbers(Row):
    """What is the same for all robots and objects of a line."""

    speed: float = field("m/s", "speed of the belt")
    height: float = field("m", "height of the belt")
    rides: bool = field("-", "whether hands ride with the belt")
    sight_low: float = field("m", "upstream end of the sight")
    sight_high: float = field("m", "downstream end of the sight")
    near_low: float = field("m", "from a robot's base, place from which an object comes into the window in time")
    window_low: float = field("m", "from a robot's base, upstream end of its window")
    window_high: float = field("m", "from a robot's base, downstream end of its window")
    duration: float = field("s", "length of a work shift")
    price: float = field("1/s", "value of a second of a robot's time")
    clearance: float = field("m", "height above an object at which a hand ends its way")
    horizon: float = field("s", "latest meeting of a hand and an object")
    dwell: float = field("s", "time in which the cup grips")
    ceiling: float = field("m", "height above the pick that a hand does not leave")
    coast: float = field("s", "time at constant velocity after the release")
    gravity_share: float = field("-", "share of gravity with which a hand falls while it brakes; 0 without a bound")
    reserve: float = field("m", "displacement of the target with which a throw has to be possible")


@final
class Station(Row):
    """One robot of a line, as the level places it."""

    base: float = field("m", "place along the belt")
    first_site: int = field("-", "first of the robot's bins among all sites")
    end_site: int = field("-", "index after the last of the robot's bins")
    first_setting: int = field("-", "first of the robot's speed settings")
    end_setting: int = field("-", "index after the last of the robot's speed settings")


@final
class Standstill(Row):
    """A time in which one robot stands still."""

    robot: int = field("-", "index of the robot")
    start: float = field("s", "begin")
    end: float = field("s", "end")


@final
class Site(Row):
    """A bin of one kind of robots."""

    centre: Triple = field("m", "middle of the opening, from the robot's base")
    bin: int = field("-", "index among the robot's bins")


@final
class Setting(Row):
    """A speed setting, with the motions that depend on it alone."""

    percent: float = field("%", "share of the full limits")
    velocity: float = field("m/s", "limit of the speed")
    acceleration: float = field("m/s2", "limit of the acceleration")
    jerk: float = field("m/s3", "limit of the jerk")
    way_acceleration: float = field("m/s2", "acceleration that is left for the way to an object")
    way_jerk: float = field("m/s3", "jerk that is left for the way to an object")
    least_time: float = field("s", "least time of a way to an object")
    early: float = field("m", "distance ahead of the object at which the way ends")
    behind: float = field("m", "distance from the end of the way to the lift")
    low: float = field("m", "upstream end of the ends of ways")
    high: float = field("m", "downstream end of the ends of ways")
    semi_x: float = field("m", "semi-axis of the robot's workspace along x, from its base as the next ones")
    semi_y: float = field("m", "semi-axis of the workspace along y")
    z_min: float = field("m", "least height of the workspace")
    z_max: float = field("m", "greatest height of the workspace")
    x: float = field("m", "centre of the workspace along x")
    y: float = field("m", "centre of the workspace along y")
    hole: float = field("m", "radius of the workspace's hole")


@final
class Rider(Row):
    """An object on the belt of a line, in the order of arrival: the most downstream first."""

    x: float = field("m", "position along the belt when the shift begins; 0 is the base of a robot at 0")
    lane_y: float = field("m", "position across the belt")
    height: float = field("m", "true height")
    measured_height: float = field("m", "height that the camera measures")
    known_depth: float = field("m", "known depth of the centre of mass")
    worth: float = field("-", "value in a bin that takes the object")
    kind: int = field("-", "true item")
    seen: int = field("-", "item as which the camera classifies the object")
    seal: float = field("-", "uniform draw of whether a cup seals; 1 for a cup that never fails")
    luck: float = field("-", "uniform draw of where a throw ends")


@final
class Account(Row):
    """Entry of an object in the books of a shift."""

    since: float = field("s", "time from which the object may be taken; infinite for objects that are gone")
    attempts: int = field("-", "number of attempts to pick the object")
    fate: int = field("-", "value of `Fate`")
    taker: int = field("-", "robot that took the object; -1 for none")
    ended_in: int = field("-", "bin of the taker in which the object lies; -1 for none")
    planned: bool = field("-", "whether a robot has planned a throw of the object, and so reaches it")


@final
class Turn(Row):
    """The coming decision of a line."""

    clock: float = field("s", "time since the begin of the shift")
    robot: int = field("-", "deciding robot")


@final
class RobotState(Row):
    """A robot in the middle of a shift."""

    free: float = field("s", "time at which the robot is free again")
    expected: float = field("s", "the same as planned; a robot whose cup does not seal is free earlier")
    busy: float = field("s", "working time, without waiting above the belt")
    hand: Triple = field("m", "position of the hand when the robot is free, from its base")


@final
class Seen(Row):
    """An object in the sight of camera and encoder."""

    index: int = field("-", "index of the object in the stream")
    x: float = field("m", "position along the belt; `UNAVAILABLE_X` where the object may not be taken")
    kind: int = field("-", "item as which the camera classifies the object")


@final
class Candidate(Row):
    """An object near a robot, for one bin and one speed setting."""

    line: int = field("-", "line among the lines of a sight")
    place: int = field("-", "object among the objects in sight")
    site: int = field("-", "site of the bin")
    setting: int = field("-", "speed setting")
    x: float = field("m", "position of the object from the robot's base")


@final
class Meeting(Row):
    """A candidate that a hand meets in time."""

    candidate: int = field("-", "index of the candidate")
    time: float = field("s", "time of the meeting, from now on")
    wait: float = field("s", "standstill of the hand above the belt")
    pick: Triple = field("m", "place where the object is lifted")


@final
class Choice(Row):
    """A pick and throw as planned, by the deciding robot of a line; times are from now on."""

    real: bool = field("-", "whether the choice exists; other choices hold arbitrary values")
    line: int = field("-", "line among the lines of a sight")
    place: int = field("-", "object among the objects in sight")
    index: int = field("-", "index of the object in the stream")
    bin: int = field("-", "index of the robot's bin")
    percent: float = field("%", "speed setting")
    pick: Triple = field("m", "place where the object is lifted, from the robot's base")
    away: Pair = field("m", "from the pick to the middle of the bin, along x and y")
    lift: float = field("s", "time until the object is lifted, dwell included")
    wait: float = field("s", "part of `lift` in which the hand stands still above the belt")
    leave: float = field("s", "time until the object can no longer be lifted")
    fading: float = field("s", "time from the lift until an empty hand stands still that rides with the belt")
    throwing: float = field("s", "time from the lift until the hand stands still after the throw")
    cycle: float = field("s", "time until the robot is free again")
    stop: Triple = field("m", "place where the hand stops after the throw, from the robot's base")
    value: float = field("-", "value of the object in its bin, as the camera classifies the object")
    chance: float = field("-", "chance that the object ends in its bin, by the table for the classified item")
    crowd: float = field("-", "other objects that the robot can take near `stop`, as they lie then")
    heirs: float = field("-", "robots downstream that can take the object")
    reaches: float = field("s", "time until the object enters the window of the first heir; 0 without an heir")
    queue: float = field("-", "objects between the object and that window that the heir can take")


@final
class Result(Row):
    """Result of an attempt to throw; NaN where nothing was simulated, or nothing was picked."""

    picked: bool = field("-", "whether the cup sealed; otherwise the object stays on the belt")
    is_success: bool = field("-", "whether the object crossed the opening of its bin and lies in that bin")
    sorted: bool = field("-", "whether the attempt is a success and the bin takes the object's item")
    lost: bool = field("-", "whether the object left the cup before its release")
    ended_in: int = field("-", "bin in which the object lies; -1 for none")
    landing_error: float = field("m", "distance from the target")
    energy: float = field("J", "positive work of the motors for the throw and the way back")
    miss: Pair = field("m", "where a thrown object came down at the height of the opening, from its middle")

    @classmethod
    def none(cls, *shape: int) -> Rows[Self]:
        """Rows without any attempt."""
        return cls.zeros(*shape, ended_in=NOBODY, landing_error=np.nan, energy=np.nan, miss=np.nan)


@final
class Outcome(Row):
    """What a decision brought."""

    end: float = field("s", "time at which the robot is free again")
    value: float = field("-", "value brought into a bin; 0 for a throw that ends after the shift")


@final
class Tally(Row):
    """Objects of one item in a work shift, by their fate, in numbers."""

    in_right: int = field("-", "objects in a bin that takes the item")
    in_wrong: int = field("-", "objects in another bin")
    on_floor: int = field("-", "objects in no bin")
    passed: int = field("-", "objects past the last window")
    tried: int = field("-", "objects past the last window that a robot has tried to pick")
    unreached: int = field("-", "objects past the last window that no robot can throw into a bin that takes them")


@final
class Worth(Row):
    """What one object of a work shift was worth, by its fate; 0 where it has another one."""

    sorted: float = field("-", "value of an object in a bin that takes it")
    arrived: float = field("-", "value of an object that was lifted or is past the last window")
    passed: float = field("-", "value of an object past the last window")


class ChanceTable(NamedTuple):
    """Shares of a table of throws, by item K, speed setting P and class of distance D."""

    percent: Floats1
    """Speed settings (P,) [%]."""
    edges: Floats1
    """Borders between the classes of distance (D - 1,) [m]."""
    picked: Floats1
    """Share of picks in which the cup seals (K,)."""
    landed: Floats3
    """Share of held objects that end in their bin (K, P, D)."""


class Tables(NamedTuple):
    """What a level says of a line, for compiled functions."""

    line: Rows1[LineNumbers]
    """The line (1,)."""
    stations: Rows1[Station]
    """The robots (R,)."""
    can_take: Bools2
    """Whether each robot takes each item (R, K)."""
    standstills: Rows1[Standstill]
    """Standstills of robots (D,)."""
    sites: Rows1[Site]
    """Bins of all kinds of robots (B,)."""
    accepts: Bools2
    """Whether each site takes each item (B, K)."""
    settings: Rows1[Setting]
    """Speed settings of all kinds of robots (S,)."""
    chances: ChanceTable
    """Table of throws."""
    blank: Rows1[Choice]
    """The choice that fills rows without a choice (1,)."""


class LineState(NamedTuple):
    """State of N lines in the middle of their shifts, with R robots and M objects each."""

    turns: Rows1[Turn]
    """The coming decisions (N,)."""
    arms: Rows2[RobotState]
    """The robots (N, R)."""
    choices: Rows2[Choice]
    """Choices of the deciding robots (N, CHOICES): the real ones first, by value less the price of their time."""
    accounts: Rows2[Account]
    """Books of every object (N, M). A decision overwrites these rows, and no other rows of a state."""

    @property
    def clock(self) -> Floats:
        """Time since the begin of the shift (N,) [s]."""
        return self.turns["clock"]

    @property
    def robot(self) -> Ints:
        """Index of the deciding robot (N,)."""
        return self.turns["robot"]

    def copy(self) -> Self:
        """The state with arrays of its own."""
        return self.next()._replace(accounts=copy_rows(self.accounts))

    def next(self) -> Self:
        """The state for the next decisions: with arrays of its own, but for the books."""
        return self._replace(turns=copy_rows(self.turns), arms=copy_rows(self.arms), choices=copy_rows(self.choices))

    def take(self, lines: Ints) -> Self:
        """The states of some lines (K,), with arrays of their own."""
        return self._replace(**{name: take(rows, lines) for name, rows in self._asdict().items()})

    def put(self, lines: Ints, states: LineState) -> None:
        """Write the states of some lines (K,), in place."""
        for rows, source in zip(self, states, strict=True):
            put(rows, lines, source)

    @classmethod
    def begin(cls, count: int, objects: int, hands: Floats, blank: Rows1[Choice]) -> Self:
        """State at the begin of shifts, with no choices computed yet.

        Args:
            count: number of lines N.
            objects: number of objects of each line M.
            hands: positions of the robots' hands (R, 3) [m].
            blank: a choice that does not exist (1,).
        """
        return cls(
            turns=Turn.zeros(count),
            arms=RobotState.zeros(count, len(hands), hand=hands),
            choices=take(blank, np.zeros((count, CHOICES), dtype=np.int64)),
            accounts=Account.zeros(count, objects, taker=NOBODY, ended_in=NOBODY),
        )
