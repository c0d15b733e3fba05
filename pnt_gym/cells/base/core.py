"""The core behind every environment: N robots that throw in step, actions in, observations and rewards out.

Environments, evaluation, training and benchmark know only `Core`.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from typing import Any, Final, Protocol, final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replaced, take
from pnt_gym.cells.base.action import corrected, limited_actions, mode_of
from pnt_gym.cells.base.cell import Cell, Generators
from pnt_gym.cells.base.features import CLIP
from pnt_gym.cells.base.request import ANYTHING, Request, lead
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.engine import unheard
from pnt_gym.errors import ConfigError, PhysicsError

COMMON_INFO: Final = ("is_success", "landing_error", "cycle_time", "residual_clipped", "item", "kind")
"""Entries of the info that every cell has; a cell adds the errors of its `Correction` and entries of its own."""


@final
@dataclass(frozen=True)
class Step:
    """The result of one throw in every cell."""

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


class Drawing(Protocol):
    """A cell of N rows, each of which draws from a generator of its own."""

    context: Any
    """The coming throws (N,)."""
    generators: list[np.random.Generator]


@contextmanager
def restoring(cell: Drawing, waiting: Bools) -> Generator[None]:
    """At the end of the block, give rows that wait the coming throws and the random numbers of its begin.

    Args:
        cell: steps in the block.
        waiting: these rows (N,).
    """
    context, generators = cell.context, [cell.generators[row] for row in np.flatnonzero(waiting)]
    states = [generator.bit_generator.state for generator in generators]
    yield
    cell.context = replaced(cell.context, waiting, take(context, waiting))
    for generator, state in zip(generators, states, strict=True):
        generator.bit_generator.state = state


@final
class Episodes:
    """Counts the throws of N cells, and knows which of them need a new draw when their episode begins.

    Args:
        count: number of cells N.
        length: throws in an episode.
        drawn: whether the cell draws the next episode's first throw by itself after the last one of an episode.
    """

    def __init__(self, count: int, length: int, drawn: bool) -> None:
        self._length, self._drawn = length, drawn
        self._throws = np.zeros(count, dtype=np.int64)
        self._fresh = np.zeros(count, dtype=np.bool_)

    def begin(self, rows: Ints, seeded: Bools | bool) -> Ints:
        """Begin new episodes in some rows, seeded or not; returns the positions in `rows` that must be drawn anew."""
        self._throws[rows] = 0
        draw = seeded | ~self._fresh[rows]
        self._fresh[rows] = False
        return np.flatnonzero(draw)

    def thrown(self, early: Bools | None = None, waiting: Bools | None = None) -> Bools:
        """Count one throw in every cell; returns the episodes that are over (N,).

        Args:
            early: episodes that this throw ends before their length (N,); None for none.
            waiting: cells whose throw does not count (N,); None for none.
        """
        counted = np.ones_like(self._fresh) if waiting is None else ~waiting
        self._throws += counted
        ended = self._throws >= self._length
        if early is not None:
            ended = ended | early
        self._fresh = np.where(counted, ended & self._drawn, self._fresh)
        return ended


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
        """`kind`: seen class of the coming objects, index into `item_names`, (N,)."""
        return {"kind": self.cell.context.kind.copy()}

    def hidden(self) -> dict[str, Floats]:
        """Hidden values of the coming throws, by the names of the cell's `hidden`, (N,) each."""
        context = self.cell.context
        return {one.name: np.array(one.value(context), dtype=np.float64) for one in self.cell.hidden}

    def plan(self, actions: object) -> tuple[Any, Bools]:
        """Feasible plans nearest to the actions (N, A), and a mask of the actions that had to be shortened (N,).

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
        cell, thrown = self.cell, self.cell.context
        with nullcontext() if waiting is None else restoring(cell, waiting):
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
        """The outcome that actions would have for the coming throws, hidden values included, without advancing.

        This is privileged: the oracle uses it, and figures do.

        Args:
            actions: (N, A).
            jitter: whether the scatter of the release is included.

        Returns:
            An outcome with the errors of `correction` among its attributes, (N,) each.
        """
        plans, _ = self.plan(actions)
        return self.cell.preview(plans, jitter)

    def view(self) -> ThrowView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return self.cell.view()
