"""The abstract cell: a robot in its surroundings, as the core behind an environment sees it, and its records.

A robot is one subclass of `Cell`.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from numbers import Integral
from typing import Any, ClassVar, Final, Generic, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replaced
from pnt_gym.cells.base.action import Correction, Modes, Plans
from pnt_gym.cells.base.canvas import Marker
from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.base.features import FeatureTable, Quantity
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.errors import ConfigError, one_sentence

Generators = list[np.random.Generator]

MOST_CELLS: Final = 100_000
MOST_THREADS: Final = 1024


class Throws(Protocol):
    """N coming throws: a record of arrays."""

    @property
    def kind(self) -> Ints:
        """Seen class of the objects to throw: index into `Cell.item_names` (N,)."""
        ...


class Verdict(Protocol):
    """The outcome of N throws: a record of arrays, computed once and complete."""

    @property
    def is_success(self) -> Bools:
        """The object crossed its target's opening and lies at rest in it; without a bin: it passed the goal (N,)."""
        ...

    @property
    def landing_error(self) -> Floats:
        """Distance from the target (N,) [m]."""
        ...

    @property
    def cycle_time(self) -> Floats:
        """From one throw to the next, dwell included (N,) [s]."""
        ...


def whole_number(name: str, value: object, most: int) -> None:
    """Make sure that what a user gave is a whole number from 1 on.

    Raises:
        ConfigError: it is not, or greater than `most`.
    """
    if isinstance(value, bool) or not isinstance(value, Integral) or not 1 <= int(value) <= most:
        raise ConfigError(f"{name} is {one_sentence(repr(value), 80)}; it must be a whole number from 1 to {most}")


ConfigT = TypeVar("ConfigT", bound=LevelConfig)
ThrowsT = TypeVar("ThrowsT", bound=Throws)
PlansT = TypeVar("PlansT", bound=Plans)
VerdictT = TypeVar("VerdictT", bound=Verdict)


class Cell(ABC, Generic[ConfigT, ThrowsT, PlansT, VerdictT]):
    """Abstract: N robots in their surroundings, throwing in step.

    Args:
        config: the cell.
        count: number of cells N.
        threads: worker threads of the physics; results do not depend on it.

    Raises:
        ConfigError: a count or a number of threads out of its range.
    """

    modes: Modes
    """Its action modes, the default first."""
    reward_terms: ClassVar[tuple[str, ...]]
    """Names of the reward's terms."""
    hidden: Sequence[Quantity] = ()
    """Hidden values of a throw, which no observation contains, for datasets and studies."""

    table: FeatureTable
    """Features of an observation; a cell with other observations overrides `features` and `observe`."""
    item_names: Sequence[str]
    """Names of the items; `kind` and `item` of the info are indices into them."""
    target_names: Sequence[str] = ()
    """Names of the targets that a reset can ask for; empty where each throw draws its own target."""
    dwell: float = 0.0
    """Part of the cycle time in which the hand holds still to grip [s]."""
    episode: int = 1
    """Throws in an episode."""
    terminates: bool = True
    """Whether the end of an episode is a termination; if not, it is a truncation."""
    planner: Any
    """The planner of the action modes."""
    context: ThrowsT
    """The coming throws."""

    def __init__(self, config: ConfigT, count: int, threads: int) -> None:
        whole_number("num_envs", count, MOST_CELLS)
        whole_number("threads", threads, MOST_THREADS)
        self.config = config
        self.count = count
        self.generators: Generators = [np.random.default_rng(0) for _ in range(count)]
        """Each row draws from its own, so it gives the same alone and in a batch."""

    def reset(self, rows: Ints, generators: Generators) -> None:
        """Begin anew in some rows, each with its own generator."""
        for row, generator in zip(rows, generators, strict=True):
            self.generators[int(row)] = generator
        self.context = replaced(self.context, rows, self.first(rows))

    @abstractmethod
    def first(self, rows: Ints) -> ThrowsT:
        """The first throws of an episode in some rows."""

    def target_of(self, throws: ThrowsT) -> Ints:
        """Index into `target_names` of the target of each throw (N,); by default each kind has a target of its own."""
        return throws.kind

    def scout(self, generators: Generators) -> Self:
        """This cell with other rows, one per generator, to see which first throws they draw: it cannot throw.

        A cell whose `first` keeps anything beside what it returns gives the scout a place of its own for that.
        """
        scout = copy.copy(self)
        scout.generators = generators
        return scout

    def following(self, outcome: VerdictT) -> ThrowsT:
        """The throws after these; new ones where none depends on the one before."""
        return self.first(np.arange(self.count))

    @property
    def features(self) -> int:
        """Numbers D in an observation."""
        return len(self.table)

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming throws (N, D)."""
        return self.table.encode(self.context)

    def throw(self, plans: PlansT) -> VerdictT:
        """Carry out feasible plans, one per cell, and move on to the next throws."""
        outcome = self.preview(plans, jitter=True)
        self.context = self.following(outcome)
        return outcome

    @abstractmethod
    def preview(self, plans: PlansT, jitter: bool = False) -> VerdictT:
        """The outcome that the coming throws would have, without moving on.

        Args:
            plans: feasible plans, one per cell.
            jitter: whether the scatter of the release is included, with the draws that `throw` will use.
        """

    @abstractmethod
    def reward(self, outcome: VerdictT) -> Mapping[str, Floats]:
        """Weighted reward terms by the names of `reward_terms`, (N,) each; before weighting each is in [0, 1]."""

    @abstractmethod
    def info(self, outcome: VerdictT, thrown: ThrowsT) -> dict[str, NDArray[Any]]:
        """Entries of the info in addition to `COMMON_INFO`, (N,) each."""

    def correction(self, mode: str) -> Correction | None:
        """How an action of a mode shifts the errors of a throw; None where it does not shift them one to one."""
        return None

    def ended(self, outcome: VerdictT, thrown: ThrowsT) -> Bools | None:
        """Episodes that these throws end before their length (N,); None for none."""
        return None

    def view(self) -> ThrowView:
        """Pictures of the cells, or what has the same methods; row 0 is recorded from now on.

        Raises:
            ConfigError: nothing of this cell can be drawn.
        """
        raise ConfigError(f"{type(self).__name__} has no pictures; it does not say how it is drawn")

    def markers(self, row: int) -> list[Marker]:
        """What is drawn beside the simulation before the coming throw; nothing unless a cell says otherwise."""
        return []

    def markers_at(self, time: float) -> list[Marker]:
        """The same in the recorded throw, after a time [s]."""
        return []
