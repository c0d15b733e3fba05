"""The abstract cell, the interface between a robot and the environments, and the records that a cell returns.

Each robot is one subclass of `Cell`.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from enum import IntEnum
from numbers import Integral
from typing import Any, ClassVar, Final, Generic, Protocol, Self, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows
from pnt_gym.cells.base.action import Correction, Modes, Plans
from pnt_gym.cells.base.canvas import Marker
from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.base.features import FeatureTable, Quantity
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.errors import ConfigError, one_sentence

Generators = list[np.random.Generator]
ResultT = TypeVar("ResultT")

MOST_CELLS: Final = 100_000
MOST_THREADS: Final = 1024
JUMPS_PER_PURPOSE: Final = 8192
"""Jumps of the bit generator between two purposes; requests jump fewer times (`cells.base.request`)."""
_JUMP: Final = 210306068529402873165736369884012333109
"""Steps of a jump of numpy's `PCG64`: its period times the golden ratio's fraction."""
_PERIOD: Final = 2**128


@final
class Purpose(IntEnum):
    """Purposes for which a generator draws numbers outside of its sequence."""

    PICK = 1
    """Whether a cup seals."""
    CLASS = 2
    """The item that the classifier sees in an object."""
    FILL = 3
    """How much lies in bins."""
    SHIFT = 4
    """How a cell drifts during a shift of picks, and what the sensors measure of the drift."""
    ARRIVAL = 5
    """Where objects lie on a line's belt, and what each is worth."""
    SPREAD = 6
    """How an object rebounds and slides, how fast blown air makes the object, and how much is left in it."""
    CELL = 7
    """How a cell differs from other cells."""
    HAND = 8
    """How far a robot's hand is from its planned place in a throw."""
    KINDS = 9
    """Which kinds come in a shift."""


class UpcomingThrows(Protocol):
    """N coming throws: a record of arrays."""

    @property
    def kind(self) -> Ints:
        """Item that the cell's classifier sees in each object: index into `Cell.item_names` (N,)."""
        ...


class Verdict(Protocol):
    """Outcome of N throws: a record of arrays, built once and complete."""

    @property
    def is_success(self) -> Bools:
        """Whether the object crossed its target's opening and lies at rest in the target (N,).

        Without a bin: whether the object passed its goal.
        """
        ...

    @property
    def landing_error(self) -> Floats:
        """Distance of the landing from the target (N,) [m]."""
        ...

    @property
    def cycle_time(self) -> Floats:
        """Time from one throw to the next, dwell included (N,) [s]."""
        ...


def check_whole_number(name: str, value: object, largest: int) -> None:
    """Make sure that a user's value is a whole number, at least 1.

    Raises:
        ConfigError: the value is not, or is greater than `largest`.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or not 1 <= int(value) <= largest:
        raise ConfigError(f"{name} is {one_sentence(repr(value), 80)}; it must be a whole number from 1 to {largest}")


def draw_aside(
    generator: np.random.Generator, *draws: tuple[Purpose, Callable[[np.random.Generator], ResultT]]
) -> list[ResultT]:
    """Draw for purposes from a row's generator, a `PCG64`: for each purpose far ahead in the generator's sequence.

    The generator ends in the state in which it was, and the numbers are a function of that state. So a row draws the
    same alone and in a batch, and a copy of an environment needs only the row's generator. A further generator takes
    five times as long to make.

    Args:
        generator: the generator.
        draws: purposes, and functions that draw from the generator where it stands for the purpose.

    Returns:
        What the functions return.
    """
    bits: Any = generator.bit_generator
    state, drawn = bits.state, list[ResultT]()
    for purpose, draw in draws:
        bits.advance(_JUMP * JUMPS_PER_PURPOSE * purpose % _PERIOD)
        try:
            drawn.append(draw(generator))
        finally:
            bits.state = state
    return drawn


ConfigT = TypeVar("ConfigT", bound=LevelConfig)
ThrowsT = TypeVar("ThrowsT", bound=UpcomingThrows)
PlansT = TypeVar("PlansT", bound=Plans)
VerdictT = TypeVar("VerdictT", bound=Verdict)


class Cell(ABC, Generic[ConfigT, ThrowsT, PlansT, VerdictT]):
    """Abstract: N robots in their surroundings that throw at the same time.

    Args:
        config: description of the cell.
        count: number of cells N.
        threads: worker threads of the physics; results do not depend on it.

    Raises:
        ConfigError: a count or a number of threads out of its range.
    """

    modes: Modes
    """Action modes of the cell, the default first."""
    reward_terms: ClassVar[tuple[str, ...]]
    """Names of the reward's terms."""
    hidden: Sequence[Quantity] = ()
    """Hidden values of a throw, which no observation has; datasets contain them."""

    table: FeatureTable
    """Features of an observation; a cell with another kind of observation overrides `features` and `observe`."""
    item_names: Sequence[str]
    """Names of the items; `kind` and `item` of the info are indices into this sequence."""
    target_names: Sequence[str] = ()
    """Targets that a reset can request for the first throw; empty where every throw has a new target."""
    dwell: float = 0.0
    """Part of the cycle time in which the hand holds still to grip [s]."""
    episode: int = 1
    """Throws in an episode."""
    terminates: bool = True
    """Whether an episode ends as terminated, because its task is done or lost, and not as truncated."""
    planner: Any
    """Planner that is passed to the action modes."""
    context: ThrowsT
    """The coming throws."""

    def __init__(self, config: ConfigT, count: int, threads: int) -> None:
        check_whole_number("num_envs", count, MOST_CELLS)
        check_whole_number("threads", threads, MOST_THREADS)
        self.config = config
        self.count = count
        self.generators: Generators = [np.random.default_rng(0) for _ in range(count)]
        """One generator per row, so a row draws the same alone and in a batch."""

    def reset(self, rows: Ints, generators: Generators) -> None:
        """Begin new episodes in some rows, with one generator per row."""
        for row, generator in zip(rows, generators, strict=True):
            self.generators[int(row)] = generator
        self.context = replace_rows(self.context, rows, self.first(rows))

    @abstractmethod
    def first(self, rows: Ints) -> ThrowsT:
        """The first throws of an episode in some rows."""

    def target_of(self, throws: ThrowsT) -> Ints:
        """Index of each throw's target in `target_names` (N,); by default every kind has a target of the same index."""
        return throws.kind

    def scout(self, generators: Generators) -> Self:
        """A copy of this cell with one row per generator, to see which first throws the generators draw.

        The copy cannot throw. A cell whose `first` changes the cell's state must give the copy a separate state.
        """
        scout = copy.copy(self)
        scout.generators = generators
        return scout

    def following(self, outcome: VerdictT) -> ThrowsT:
        """The next throws after an outcome; by default new throws that do not depend on the outcome."""
        return self.first(np.arange(self.count))

    @property
    def features(self) -> int:
        """Numbers D in an observation."""
        return len(self.table)

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming throws (N, D)."""
        return self.table.encode(self.context)

    def throw(self, plans: PlansT) -> VerdictT:
        """Simulate feasible plans, one per cell, and advance to the next throws."""
        outcome = self.preview(plans, jitter=True)
        self.context = self.following(outcome)
        return outcome

    @abstractmethod
    def preview(self, plans: PlansT, jitter: bool = False) -> VerdictT:
        """Simulated outcome of the coming throws, without advancing to the next throws.

        Args:
            plans: feasible plans, one per cell.
            jitter: whether the values that differ from throw to throw of one object are included, as in `throw`.
        """

    @abstractmethod
    def reward(self, outcome: VerdictT) -> Mapping[str, Floats]:
        """Weighted reward terms by the names of `reward_terms`, (N,) each; before weighting each is in [0, 1]."""

    @abstractmethod
    def info(self, outcome: VerdictT, throws: ThrowsT) -> dict[str, NDArray[Any]]:
        """Info of throws beyond `COMMON_INFO`, (N,) each."""

    def correction(self, mode: str) -> Correction | None:
        """How an action of a mode moves the errors, for controllers that learn from errors; None if not one to one."""
        return None

    def ends_early(self, outcome: VerdictT, throws: ThrowsT) -> Bools | None:
        """Which episodes these throws end before their length (N,); None: no episode."""
        return None

    def view(self) -> ThrowView:
        """View that draws the cells; row 0 is recorded from now on.

        Raises:
            ConfigError: the cell has no pictures.
        """
        raise ConfigError(f"{type(self).__name__} has no pictures; it does not override `view`")

    def markers(self, row: int) -> list[Marker]:
        """Shapes that are drawn beside the simulation before the coming throw; none by default."""
        return []

    def markers_at(self, time: float) -> list[Marker]:
        """Shapes that are drawn beside the simulation in the recorded throw, after a time [s]; none by default."""
        return []
