"""The batched simulation behind every environment: takes actions, returns observations, rewards and infos of N cells.

Environments, evaluation, training and benchmark use cells only through `Core`.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from typing import Any, Final, Protocol, final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take
from pnt_gym.cells.base.action import clip_actions, corrected, mode_of
from pnt_gym.cells.base.cell import Cell, Generators
from pnt_gym.cells.base.features import CLIP
from pnt_gym.cells.base.request import NO_REQUEST, Request, advance_to_request
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.engine import mute_warnings
from pnt_gym.errors import ConfigError, PhysicsError

EPISODE_SUCCESS: Final = "episode_success"
"""Key of the info at the end of an episode of several throws or decisions: the share of them that succeeded."""
COMMON_INFO: Final = ("is_success", "landing_error", "cycle_time", "residual_clipped", "item", "kind")
"""Info keys that every cell reports of a throw; a cell adds the errors of its `Correction` and further keys."""


@final
@dataclass(frozen=True)
class Step:
    """Results of one throw in every cell."""

    observation: Any
    """Observations of the next throws (N, D), or several arrays (N, ...) by name."""
    reward: Floats
    """Sum of the reward terms (N,)."""
    ended: Bools
    """Whether the cells' episodes are over (N,)."""
    info: dict[str, NDArray[Any]]
    """Named results, (N,) each: `COMMON_INFO`, the reward's terms, and the cell's further keys."""
    partial: Mapping[str, Bools] = field(default_factory=dict[str, Bools])
    """Rows (N,) that have a result, by the result's name; a result that is not named here exists in all rows."""


class RandomCell(Protocol):
    """A cell of N rows with one random generator per row."""

    context: Any
    """The coming throws (N,)."""
    generators: list[np.random.Generator]


@contextmanager
def restore_rows(cell: RandomCell, waiting: Bools) -> Generator[None]:
    """Context that restores the coming throws and the generators of waiting rows at its end.

    Args:
        cell: the cell that steps in the context.
        waiting: the waiting rows (N,).
    """
    before, generators = take(cell.context, waiting), [cell.generators[row] for row in waiting.nonzero()[0]]
    states = [generator.bit_generator.state for generator in generators]
    yield
    cell.context = replace_rows(cell.context, waiting, before)
    for generator, state in zip(generators, states, strict=True):
        generator.bit_generator.state = state


@final
class Episodes:
    """Counts the throws and successes of N cells, and marks those that need a new draw when their episode begins.

    Args:
        count: number of cells N.
        length: throws in an episode.
        drawn: whether the cell itself draws the next episode's first throw after the last throw of an episode.
    """

    def __init__(self, count: int, length: int, drawn: bool) -> None:
        self._length, self._drawn = length, drawn
        self._throws, self._successes = np.zeros((2, count), dtype=np.int64)
        self._fresh = np.zeros(count, dtype=np.bool_)

    def begin(self, rows: Ints, seeded: Bools | bool) -> Ints:
        """Begin new episodes in some rows; returns the positions in `rows` whose first throw must be drawn.

        Args:
            rows: the cells.
            seeded: which of these cells, or whether all, have a new generator.
        """
        self._throws[rows] = self._successes[rows] = 0
        draw = seeded | ~self._fresh[rows]
        self._fresh[rows] = False
        return draw.nonzero()[0]

    def count(
        self, is_success: Bools, early: Bools | None = None, waiting: Bools | None = None
    ) -> tuple[Bools, Floats | None]:
        """Count one throw in every cell; returns which episodes are over (N,), and the shares of their successes.

        The shares (N,) are those of episodes of several throws, NaN in cells whose episode goes on; None stands for no
        such episode that is over.

        Args:
            is_success: whether each throw succeeded (N,).
            early: which episodes this throw ends before their length (N,); None: no episode.
            waiting: which cells' throws do not count (N,); None: no cell's.
        """
        counted = np.ones_like(self._fresh) if waiting is None else ~waiting
        self._throws += counted
        self._successes += is_success & counted
        ended = self._throws >= self._length
        if early is not None:
            ended = ended | early
        self._fresh = np.where(counted, ended & self._drawn, self._fresh)
        if self._length == 1 or self._drawn or not ended.any():
            return ended, None
        return ended, np.where(ended, self._successes / np.maximum(self._throws, 1), np.nan)


@final
class Core:
    """Steps a cell for the environments: takes actions, returns observations, rewards and infos; row i is cell i.

    Args:
        cell: N robots that throw at the same time.
        action_mode: how an action is read; None for the cell's default.

    Raises:
        ConfigError: an unknown action mode, or a user's level in which a throw gives NaN or infinite results.
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
        self._unseen = [cell.table.names.index(name) for name in mode.unseen if name in cell.table.names]
        self._episodes = Episodes(cell.count, cell.episode, drawn=cell.terminates)
        if not cell.config.ships():
            self._check_level()

    def _check_level(self) -> None:
        """Throw once in a user's level, without changing the state of the cell.

        Raises:
            ConfigError: the level cannot be simulated, or its results are not finite.
        """
        try:
            with mute_warnings():
                outcome = self.preview(np.zeros((self.count, *self.action_space.shape)), jitter=True)
        except PhysicsError as error:
            raise ConfigError(f"level {self.config.name!r} cannot be thrown in: {error}") from error
        if not all(np.isfinite(values).all() for values in (self.observe(), *self.cell.reward(outcome).values())):
            raise ConfigError(
                f"level {self.config.name!r} gives results that are not finite; one of its numbers is too extreme"
            )

    @property
    def context(self) -> Any:
        """The coming throws."""
        return self.cell.context

    def reset(self, rows: Ints, generators: Generators, seeded: Bools | bool, request: Request = NO_REQUEST) -> Ints:
        """Begin new episodes in some rows; returns the rows whose first throws are drawn by this call.

        Args:
            rows: the cells.
            generators: one generator per row; the row draws from this generator from now on.
            seeded: which generators are new (rows,), or whether all are; rows with an old generator keep a first throw
                that is already drawn.
            request: item and target that the first throws must have; a non-empty request draws every first throw anew.

        Raises:
            ConfigError: a row never draws the requested throw; the cell and all generators are unchanged.
        """
        if request:
            advance_to_request(self.cell, generators, request)
        chosen = self._episodes.begin(rows, seeded | bool(request))
        if chosen.size > 0:
            self.cell.reset(rows[chosen], [generators[i] for i in chosen])
        return rows[chosen]

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming throws (N, D)."""
        observation = self.cell.observe()
        if self._unseen:
            observation[:, self._unseen] = 0.0
        return observation

    def kinds(self) -> dict[str, NDArray[Any]]:
        """`kind`: item that the cell's classifier sees in each coming throw, index into `item_names` (N,)."""
        return {"kind": self.cell.context.kind.copy()}

    def hidden(self) -> dict[str, Floats]:
        """Values of the coming throws that no observation has, by the names of the cell's `hidden`, (N,) each."""
        context = self.cell.context
        return {quantity.name: np.array(quantity.value(context), dtype=np.float64) for quantity in self.cell.hidden}

    def plan(self, actions: object) -> tuple[Any, Bools]:
        """Feasible plans nearest to the residuals of actions (N, A), and which residuals were shortened (N,).

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        cell, mode = self.cell, self.cell.modes[self.action_mode]
        limited = clip_actions(actions, self.count, len(mode.numbers), mode.name)
        return corrected(mode, cell.planner, cell.context, limited, self._scale)

    def step(self, actions: object, waiting: Bools | None = None) -> Step:
        """Throw in every cell.

        Args:
            actions: (N, A) within [-1, 1]; values outside are clipped.
            waiting: which cells only fill the batch (N,): the step undoes the throws of these cells, and their results
                mean nothing; None: no cell.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        cell, throws = self.cell, self.cell.context
        with nullcontext() if waiting is None else restore_rows(cell, waiting):
            plans, clipped = self.plan(actions)
            outcome = cell.throw(plans)
            terms = cell.reward(outcome)
            info = {
                "is_success": outcome.is_success,
                "landing_error": outcome.landing_error,
                "cycle_time": outcome.cycle_time,
                "residual_clipped": clipped,
                "item": throws.kind.copy(),
                **cell.info(outcome, throws),
            }
            for name, term in terms.items():
                info[f"reward_{name}"] = term
            info["kind"] = cell.context.kind.copy()
            early = cell.ends_early(outcome, throws)
            ended, share = self._episodes.count(outcome.is_success, early, waiting)
            partial = {} if share is None else {EPISODE_SUCCESS: ended}
            info |= {} if share is None else {EPISODE_SUCCESS: share}
            return Step(self.observe(), sum(terms.values(), np.zeros(self.count)), ended, info, partial)

    def preview(self, actions: object, jitter: bool = False) -> Any:
        """Simulated outcome of the coming throws under actions, without advancing the cell.

        The preview uses hidden values, so only the oracle and figures may call it.

        Args:
            actions: residuals (N, A).
            jitter: whether the values that differ from throw to throw of one object are included.

        Returns:
            An outcome with the errors of `correction` among its attributes, (N,) each.
        """
        plans, _ = self.plan(actions)
        return self.cell.preview(plans, jitter)

    def view(self) -> ThrowView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return self.cell.view()
