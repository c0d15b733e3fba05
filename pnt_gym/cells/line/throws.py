"""Results of throws on a line: by a table of chances, or simulated by a conveyor cell."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, TypeAlias, cast, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.base.plant import Recording
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.line import simulate
from pnt_gym.cells.line.choosing import Chooser
from pnt_gym.cells.line.config import distinct_cells
from pnt_gym.cells.line.rows import Choice, LineState, Result, Rider, Tables
from pnt_gym.cells.line.stream import Stream
from pnt_gym.rows import Rows1, Rows2

Release: TypeAlias = Callable[[NDArray[np.float32], Ints], NDArray[np.floating]]
"""Corrects throws: maps observations (N, D) of `PnTRelease-v0` and classified items (N,) to actions (N, A)."""
_SIMULATED: Final = ("picked", "is_success", "sorted", "ended_in", "landing_error", "energy")
"""Fields of a result that a throw's outcome has by the same names."""


@final
@dataclass(frozen=True)
class Attempt:
    """One choice in each of N lines, and its plan where the plan is asked for before the next reset of a line."""

    chooser: Chooser
    robot: Ints
    """Index of the deciding robot (N,)."""
    stream: Stream
    chosen: Rows1[Choice]
    """The choices (N,)."""

    @property
    def valid(self) -> Bools:
        """Whether each choice exists (N,)."""
        return self.chosen["real"]

    @property
    def item(self) -> Ints:
        """Item as which the camera classifies each object; arbitrary where the choice does not exist (N,)."""
        return np.where(self.valid, self._riders["seen"], self.chooser.blank.kind)

    @property
    def true_kind(self) -> Ints:
        """True item of each object; arbitrary where the choice does not exist (N,)."""
        return np.where(self.valid, self._riders["kind"], self.chooser.blank.objects.kind)

    @property
    def bin(self) -> Ints:
        """Index of the robot's bin; arbitrary where the choice does not exist (N,)."""
        return np.where(self.valid, self.chosen["bin"], self.chooser.blank.bin)

    @property
    def percent(self) -> Floats:
        """Speed setting; arbitrary where the choice does not exist (N,) [%]."""
        return np.where(self.valid, self.chosen["percent"], self.chooser.blank.objects.percent)

    @cached_property
    def _riders(self) -> Rows1[Rider]:
        """The chosen objects (N,)."""
        return take(self.stream.riders, (np.arange(len(self.robot)), self.chosen["index"]))

    @cached_property
    def context(self) -> Context:
        """Picks and throws; arbitrary where the choice does not exist (N,)."""
        return self.chooser.plan_choices(self.robot, self.stream, self.chosen)


class ThrowExecutor(ABC):
    """Abstract: computes the results of throws."""

    watched: bool = False
    """Whether the first line's simulated throws are recorded, for pictures."""
    recording: Recording | None = None
    """Recording of the first line's last throw; None where the throw was not simulated or not recorded."""

    @abstractmethod
    def execute(self, state: LineState, attempt: Attempt) -> Rows1[Result]:
        """Results of one choice in each of N lines; no attempt where the choice does not exist.

        Args:
            state: states of the lines.
            attempt: the choices.
        """


@final
class TableThrows(ThrowExecutor):
    """Results by a table of chances: the same object with the same chance gives the same result.

    Args:
        tables: tables of the line.
    """

    def __init__(self, tables: Tables) -> None:
        self._tables = tables

    def execute(self, state: LineState, attempt: Attempt) -> Rows1[Result]:
        """Results by the objects' own draws."""
        return self.predict(state, attempt.stream, attempt.chosen[:, None])[:, 0]

    def predict(self, state: LineState, stream: Stream, choices: Rows2[Choice]) -> Rows2[Result]:
        """Results of choices of the deciding robots (N, C)."""
        results = Result.none(*choices.shape)
        simulate.predict(self._tables, state, stream.riders, choices, results)
        return results


@final
class SimulatedThrows(ThrowExecutor):
    """Simulates each throw in a conveyor cell configured like the robot.

    Args:
        configs: each robot as a conveyor cell.
        can_throw: whether each kind of robot, as `distinct_cells` orders them, can throw.
        count: number of lines N.
        threads: threads of the physics.
    """

    release: Release | None = None
    """Policy that corrects the throws; None for the planner's throws."""

    def __init__(self, configs: list[ConveyorConfig], can_throw: Bools, count: int, threads: int) -> None:
        distinct, self._core_index = distinct_cells(configs)
        self.cores = {
            int(kind): Core(ConveyorCell(distinct[kind], count, "independent", threads))
            for kind in np.flatnonzero(can_throw)
        }
        """Cells in which each kind of robot throws, by the kind; robots that reach no bin have none."""

    def execute(self, state: LineState, attempt: Attempt) -> Rows1[Result]:
        """Results by the conveyor's physics, with the hand returning to the place of its pick."""
        results, rows = Result.none(len(attempt.robot)), np.flatnonzero(attempt.valid)
        if rows.size == 0:
            return results
        self.recording = None
        attempts = state.accounts["attempts"][rows, attempt.chosen["index"][rows]]
        throws = take(attempt.context, rows)
        objects = throws.objects.replace(pick_draw=simulate.redraw(throws.objects.pick_draw, attempts))
        throws, cores = throws.replace(objects=objects), self._core_index[state.robot[rows]]
        for index, core in self.cores.items():
            own = np.flatnonzero(cores == index)
            if own.size > 0:
                results[rows[own]] = self._simulate(core, rows[own], take(throws, own))
        return results

    def _simulate(self, core: Core, rows: Ints, throws: Context) -> Rows1[Result]:
        """Results of the throws in some rows of a cell; the cell's other rows are ignored."""
        cell = cast("ConveyorCell", core.cell)
        cell.plant.record_row = 0 if self.watched and rows[0] == 0 else None
        # Throws with arrays cut to the robot's number of bins; other robots of the line may have more.
        count = len(cell.config.bins.fixed)
        objects = throws.objects.replace(fill=throws.objects.fill[:, :count])
        cell.context = replace_rows(cell.context, rows, throws.replace(objects=objects, depth=throws.depth[:, :count]))
        action: Any = np.zeros((core.count, *core.action_space.shape))
        if self.release is not None:
            action = self.release(core.observe(), cell.context.kind)
        outcome = core.preview(action, jitter=True)
        if cell.plant.record_row is not None:
            self.recording = cell.plant.recording
        lost = outcome.picked & outcome.dropped
        flown = (outcome.picked & ~lost)[:, None]
        miss = np.where(flown, outcome.landing - cell.context.target[:, :2], np.nan)
        columns = {name: getattr(outcome, name)[rows] for name in _SIMULATED}
        return Result.zeros(len(rows), lost=lost[rows], miss=miss[rows], **columns)
