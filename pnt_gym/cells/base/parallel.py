"""A core whose rows are split into parts, which step at the same time: one plans while another is in the engine.

A row's result does not depend on the other rows, so the split does not change a bit of the results.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records
from pnt_gym.cells.base.action import clip_actions
from pnt_gym.cells.base.cell import MOST_CELLS, MOST_THREADS, Generators, check_whole_number
from pnt_gym.cells.base.core import Core, Step
from pnt_gym.cells.base.features import Quantity
from pnt_gym.cells.base.request import NO_REQUEST, Request, advance_to_request
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.errors import ConfigError, PhysicsError

LEAST_ROWS: Final = 16
"""Fewest rows of a part: in smaller parts the fixed cost of a step, which every part pays, outweighs the gain."""

ResultT = TypeVar("ResultT")


def split_cells(count: int, threads: int) -> list[tuple[int, int]]:
    """Cells and threads of each part, for a number of cells and threads in all.

    Raises:
        ConfigError: a count or a number of threads out of its range.
    """
    check_whole_number("num_envs", count, MOST_CELLS)
    check_whole_number("threads", threads, MOST_THREADS)
    parts = max(min(threads, count // LEAST_ROWS), 1)
    return [((count + k) // parts, (threads + k) // parts) for k in reversed(range(parts))]


@final
@dataclass(frozen=True)
class CellFacts:
    """What all parts' cells have in common; throws and physics are in `ParallelCore.parts`, as `parts[k].cell`."""

    config: Any
    item_names: Sequence[str]
    target_names: Sequence[str]
    """Targets that a reset can request for the first throw."""
    episode: int
    """Throws in an episode."""
    hidden: Sequence[Quantity]
    """Hidden values of a throw, which no observation has."""


@final
class ParallelCore:
    """Several cores as one core: their rows one after the other. Each core steps in a thread of its own.

    The threads live for one step. A step ends, also with an error, when all parts have ended.

    Args:
        parts: at least one core; all of one level and one action mode.
    """

    def __init__(self, parts: Sequence[Core]) -> None:
        self.parts = tuple(parts)
        first, sizes = self.parts[0], [part.count for part in self.parts]
        ends = np.cumsum([0, *sizes]).tolist()
        self._rows = [slice(begin, end) for begin, end in pairwise(ends)]
        self.count: int = ends[-1]
        self.action_mode, self.config = first.action_mode, first.config
        self.item_names, self.dwell, self.terminates = first.item_names, first.dwell, first.terminates
        self.action_sizes, self.shift_modes, self.correction = first.action_sizes, first.shift_modes, first.correction
        self.observation_space, self.action_space = first.observation_space, first.action_space

    @property
    def cell(self) -> CellFacts:
        """What the cells of all parts have in common."""
        cell = self.parts[0].cell
        return CellFacts(cell.config, cell.item_names, cell.target_names, cell.episode, cell.hidden)

    @property
    def context(self) -> Any:
        """The coming throws."""
        return concatenate_records([part.context for part in self.parts])

    def reset(self, rows: Ints, generators: Generators, seeded: Bools | bool, request: Request = NO_REQUEST) -> None:
        """Begin new episodes in some rows; see `Core.reset`.

        Raises:
            ConfigError: a row never draws the requested throw; the cells and all generators are unchanged.
        """
        draw = np.broadcast_to(seeded, len(rows)) | bool(request)
        if request:  # for all rows before the first row changes
            advance_to_request(self.parts[0].cell, generators, request)
        for part, mine in zip(self.parts, self._rows, strict=True):
            chosen = np.flatnonzero((rows >= mine.start) & (rows < mine.stop))
            if chosen.size > 0:
                part.reset(rows[chosen] - mine.start, [generators[i] for i in chosen], draw[chosen])

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming throws (N, D)."""
        return np.concatenate([part.observe() for part in self.parts])

    def kinds(self) -> dict[str, NDArray[Any]]:
        """`kind`: item that the cell's classifier sees in each coming throw, index into `item_names` (N,)."""
        return concatenate_records([part.kinds() for part in self.parts])

    def hidden(self) -> dict[str, Floats]:
        """Values of the coming throws that no observation has, by the names of the cell's `hidden`, (N,) each."""
        return concatenate_records([part.hidden() for part in self.parts])

    def plan(self, actions: object) -> tuple[Any, Bools]:
        """Feasible plans nearest to the residuals of actions (N, A), and which residuals were shortened (N,).

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        limited = self._clip(actions)
        plans, clipped = zip(*self._run(lambda part, mine: part.plan(limited[mine])), strict=True)
        return concatenate_records(plans), np.concatenate(clipped)

    def step(self, actions: object, waiting: Bools | None = None) -> Step:
        """Throw in every cell; see `Core.step`.

        Raises:
            ActionError: wrong shape, NaN or infinite values; no cell has thrown.
            PhysicsError: the engine warned, or stopped a simulation; other parts have thrown.
        """
        limited = self._clip(actions)

        def step(part: Core, mine: slice) -> Step:
            return part.step(limited[mine], waiting[mine] if waiting is not None and waiting[mine].any() else None)

        return _join_steps(self._run(step))

    def preview(self, actions: object, jitter: bool = False) -> Any:
        """Simulated outcome of the coming throws under actions, without advancing the cells; see `Core.preview`."""
        limited = self._clip(actions)
        return concatenate_records(self._run(lambda part, mine: part.preview(limited[mine], jitter)))

    def view(self) -> ThrowView:
        """Refuse pictures; an environment with a render mode has one part.

        Raises:
            ConfigError: always.
        """
        raise ConfigError("cells that step in parts have no pictures; give a render_mode, or threads=1")

    def _clip(self, actions: object) -> Floats:
        """Actions as `clip_actions` returns them: an action that is refused is refused before any part steps."""
        return clip_actions(actions, self.count, int(self.action_space.shape[0]), self.action_mode)

    def _run(self, work: Callable[[Core, slice], ResultT]) -> list[ResultT]:
        """Results of a function of each part and its rows, computed at the same time, the first part in this thread.

        Numpy's settings of floating-point errors are those of the caller in all threads.

        Raises:
            PhysicsError: of the first part that raises, with the part's rows.
        """
        tasks = [*zip(self.parts, self._rows, strict=True)]
        with ThreadPoolExecutor(len(tasks) - 1 or 1, thread_name_prefix="pnt_gym part") as pool:
            running = [pool.submit(copy_context().run, _name_rows, work, *task) for task in tasks[1:]]
            first = _name_rows(work, *tasks[0])
        return [first, *(part.result() for part in running)]


def _name_rows(work: Callable[[Core, slice], ResultT], part: Core, mine: slice) -> ResultT:
    """The result of a part; an error of its physics says which rows of all the part has."""
    try:
        return work(part, mine)
    except PhysicsError as error:
        raise PhysicsError(f"in the part of cells {mine.start} to {mine.stop - 1}: {error}") from error


def _join_steps(steps: Sequence[Step]) -> Step:
    """The results of all parts' steps, one after the other."""
    partial: Mapping[str, Bools] = concatenate_records([dict(step.partial) for step in steps])
    return Step(
        np.concatenate([step.observation for step in steps]),
        np.concatenate([step.reward for step in steps]),
        np.concatenate([step.ended for step in steps]),
        concatenate_records([step.info for step in steps]),
        partial,
    )
