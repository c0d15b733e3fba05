"""What stands behind every environment: a cell whose robots throw in step, actions in, observations and rewards out.

A robot is one subclass of `Cell`; environments, evaluation, training and benchmark know only `Core`.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral
from typing import Any, ClassVar, Final, Generic, Protocol, Self, TypeVar, final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replaced
from pnt_gym.cells.base.action import Correction, Modes, Plans, corrected, limited_actions, mode_of
from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.base.episodes import Episodes
from pnt_gym.cells.base.features import CLIP, FeatureTable, Quantity
from pnt_gym.cells.base.request import ANYTHING, Request, lead
from pnt_gym.cells.base.restoring import restoring
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.engine import unheard
from pnt_gym.errors import ConfigError, PhysicsError, one_sentence

Generators = list[np.random.Generator]

MOST_CELLS: Final = 100_000
MOST_THREADS: Final = 1024

COMMON_INFO: Final = ("is_success", "landing_error", "cycle_time", "residual_clipped", "item", "kind")
"""What every cell tells of a throw; the errors of its `Correction` and what only it knows come on top."""


class Throws(Protocol):
    """N coming throws: a record of arrays."""

    @property
    def kind(self) -> Ints:
        """What the cell's classifier says of the things to throw: index into `Cell.item_names` (N,)."""
        ...


class Verdict(Protocol):
    """What became of N throws: a record of arrays, made once and complete."""

    @property
    def is_success(self) -> Bools:
        """It crossed its target's opening and lies at rest in it; without a bin: it passed its goal (N,)."""
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
    """What no observation tells of a throw, for those who study it afterwards."""

    table: FeatureTable
    """What is seen of the coming throws; who sees otherwise has `features` and `observe` of its own."""
    item_names: Sequence[str]
    """What `kind` and `item` of the info are indices into."""
    target_names: Sequence[str] = ()
    """Targets that a first throw can be asked for; none where each throw has one of its own."""
    dwell: float = 0.0
    """Part of the cycle time in which the hand holds still to grip [s]."""
    episode: int = 1
    """Throws in an episode."""
    terminates: bool = True
    """Whether an episode that is over terminates, its task being done or lost; others are truncated."""
    planner: Any
    """What the action modes plan with."""
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
        """Which of `target_names` throws are for (N,); unless a cell says otherwise, each kind has its own."""
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
        """What the coming throws would do, without moving on.

        Args:
            plans: feasible plans, one per cell.
            jitter: whether what differs from throw to throw of one object is included, as `throw` will have it.
        """

    @abstractmethod
    def reward(self, outcome: VerdictT) -> Mapping[str, Floats]:
        """Weighted reward terms by the names of `reward_terms`, (N,) each; before weighting each is in [0, 1]."""

    @abstractmethod
    def info(self, outcome: VerdictT, thrown: ThrowsT) -> dict[str, NDArray[Any]]:
        """What else is told of throws beside `COMMON_INFO`, (N,) each."""

    def correction(self, mode: str) -> Correction | None:
        """What an action of a mode means to a controller that learns from errors; None where it is not one to one."""
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


@final
@dataclass(frozen=True)
class Step:
    """What one throw in every cell gave."""

    observation: NDArray[np.float32]
    """Of the next throws (N, D)."""
    reward: Floats
    """(N,)"""
    ended: Bools
    """Episodes that are over (N,)."""
    info: dict[str, NDArray[Any]]
    """Named results, (N,) each: `COMMON_INFO`, the reward's terms, and what the cell adds."""
    partial: Mapping[str, Bools] = field(default_factory=dict[str, Bools])
    """Of results that only some rows have, by name: which rows these are (N,). All rows have every other result."""


@final
class Core:
    """A cell behind the environments: actions in, observations, rewards and infos out.

    Args:
        cell: N robots that throw in step.
        action_mode: how an action is read; None for the cell's default.

    Raises:
        ConfigError: an unknown action mode, or a level of the user's in which a throw gives no numbers.
    """

    def __init__(self, cell: Cell[Any, Any, Any, Any], action_mode: str | None = None) -> None:
        self.cell = cell
        self.action_mode = next(iter(cell.modes)) if action_mode is None else action_mode
        mode = mode_of(cell.modes, self.action_mode)
        self.config, self.count = cell.config, cell.count
        self.item_names, self.dwell, self.terminates = cell.item_names, cell.dwell, cell.terminates
        self.action_sizes: Mapping[str, int] = {name: len(mode.numbers) for name, mode in cell.modes.items()}
        self.shift_modes: Sequence[str] = tuple(name for name, mode in cell.modes.items() if mode.errors)
        self.correction = cell.correction(self.action_mode)
        self.observation_space = Box(-CLIP, CLIP, (cell.features,), np.float32)
        self.action_space = Box(-1.0, 1.0, (len(mode.numbers),), np.float32)
        self._scale = mode.scale(cell.config)
        self._episodes = Episodes(cell.count, cell.episode, drawn=cell.terminates)
        if not cell.config.ships():
            self._try()

    def _try(self) -> None:
        """Throw once, without moving on."""
        try:
            with unheard():
                outcome = self.preview(np.zeros((self.count, *self.action_space.shape)), jitter=True)
        except PhysicsError as error:
            raise ConfigError(f"level {self.config.name!r} cannot be thrown in: {error}") from error
        if not all(np.isfinite(found).all() for found in (self.observe(), *self.cell.reward(outcome).values())):
            raise ConfigError(
                f"level {self.config.name!r} gives results that are no numbers; one of its values is absurd"
            )

    @property
    def context(self) -> Any:
        """The coming throws."""
        return self.cell.context

    def reset(self, rows: Ints, generators: Generators, seeded: Bools | bool, request: Request = ANYTHING) -> None:
        """Begin new episodes in some rows.

        Args:
            rows: which cells.
            generators: one per row; the row keeps drawing from it.
            seeded: which generators are new (rows,), or whether all are; of others a throw already drawn is kept.
            request: what the first throws have to be; none that is already drawn is kept then.

        Raises:
            ConfigError: a row does not come to what is asked for; everything is as it was.
        """
        if request:
            lead(self.cell, generators, request)
        chosen = self._episodes.begin(rows, seeded | bool(request))
        if chosen.size > 0:
            self.cell.reset(rows[chosen], [generators[i] for i in chosen])

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming throws (N, D)."""
        return self.cell.observe()

    def kinds(self) -> dict[str, NDArray[Any]]:
        """`kind`: what the cell's classifier says of the coming things to throw, index into `item_names`, (N,)."""
        return {"kind": self.cell.context.kind.copy()}

    def hidden(self) -> dict[str, Floats]:
        """What no observation tells of the coming throws, by the names of the cell's `hidden`, (N,) each."""
        context = self.cell.context
        return {one.name: np.array(one.value(context), dtype=np.float64) for one in self.cell.hidden}

    def plan(self, actions: object) -> tuple[Any, Bools]:
        """Feasible plans nearest to what actions (N, A) ask for, and which actions had to be shortened (N,).

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        cell, mode = self.cell, self.cell.modes[self.action_mode]
        limited = limited_actions(actions, self.count, len(mode.numbers), mode.name)
        return corrected(mode, cell.planner, cell.context, limited, self._scale)

    def step(self, actions: object, waiting: Bools | None = None) -> Step:
        """Throw in every cell.

        Args:
            actions: (N, A) within [-1, 1]; values outside are clipped.
            waiting: cells that only fill the batch (N,): the step takes their throws back, and their results mean
                nothing; None for none.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        with restoring(self.cell, waiting):
            return self._step(actions, waiting)

    def _step(self, actions: object, waiting: Bools | None) -> Step:
        """Throw in every cell, those that wait included."""
        cell, thrown = self.cell, self.cell.context
        plans, clipped = self.plan(actions)
        outcome = cell.throw(plans)
        terms = cell.reward(outcome)
        info = {
            "is_success": outcome.is_success,
            "landing_error": outcome.landing_error,
            "cycle_time": outcome.cycle_time,
            "residual_clipped": clipped,
            "item": thrown.kind.copy(),
            **cell.info(outcome, thrown),
        }
        for name, term in terms.items():
            info[f"reward_{name}"] = term
        info["kind"] = cell.context.kind.copy()
        ended = self._episodes.thrown(cell.ended(outcome, thrown), waiting)
        return Step(cell.observe(), sum(terms.values(), np.zeros(self.count)), ended, info)

    def preview(self, actions: object, jitter: bool = False) -> Any:
        """What actions would do to the coming throws, hidden values included, without advancing.

        This is privileged: the oracle uses it, and figures do.

        Args:
            actions: (N, A).
            jitter: whether what is drawn anew in every throw takes part.

        Returns:
            An outcome with the errors of `correction` among its attributes, (N,) each.
        """
        plans, _ = self.plan(actions)
        return self.cell.preview(plans, jitter)

    def view(self) -> ThrowView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return self.cell.view()
