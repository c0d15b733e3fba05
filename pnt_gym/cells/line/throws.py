"""Results of throws on a line: by a table of chances, or simulated by a conveyor cell."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, Self, TypeAlias, cast, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.base.plant import Recording
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.line import act_kernel
from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.choosing import Chooser
from pnt_gym.cells.line.config import distinct_cells
from pnt_gym.cells.line.state import Choices, LineState
from pnt_gym.cells.line.stream import STRETCH, Stream, redraw

Release: TypeAlias = Callable[[NDArray[np.float32], Ints], NDArray[np.floating]]
"""Corrects throws: maps observations (N, D) of `PnTRelease-v0` and classified items (N,) to actions (N, A)."""


@final
@dataclass(frozen=True)
class ThrowResults:
    """Results of N attempts to throw."""

    picked: Bools
    """Whether the cup sealed; otherwise the object stays on the belt (N,)."""
    is_success: Bools
    """Whether the object crossed the opening of its intended bin and lies in that bin (N,)."""
    sorted: Bools
    """Whether the attempt is a success and the bin takes the object's item (N,)."""
    ended_in: Ints
    """Index of the bin in which the object lies, -1 for none (N,)."""
    landing_error: Floats
    """Distance from the target (N,) [m]; NaN where nothing was simulated or picked."""
    energy: Floats
    """Positive work of the motors for the throw and the way back (N,) [J]; NaN where nothing was simulated."""
    lost: Bools
    """Whether the object left the cup before its release (N,); False where nothing was simulated."""
    miss: Floats
    """Where a thrown object came down at the height of the opening, from the middle of the opening along x and y (N, 2)
    [m]; NaN for lost objects, and where nothing was simulated or picked."""

    @classmethod
    def by_table(cls, picked: Bools, is_success: Bools, sorted_: Bools, ended_in: Ints) -> Self:
        """Results S of throws that are not simulated."""
        nan, lost, miss = _blank_columns(picked.shape)
        return cls(picked, is_success, sorted_, ended_in, nan, nan, lost, miss)

    @classmethod
    def nothing(cls, count: int) -> Self:
        """Results without any attempt."""
        never = np.zeros(count, dtype=np.bool_)
        return cls.by_table(never, never.copy(), never.copy(), np.full(count, -1))


@cache
def _blank_columns(shape: tuple[int, ...]) -> tuple[Floats, Bools, Floats]:
    """Landing errors or energies, losses and misses of throws that are not simulated; read only, as all share them."""
    columns = np.full(shape, np.nan), np.zeros(shape, dtype=np.bool_), np.full((*shape, 2), np.nan)
    for column in columns:
        column.flags.writeable = False
    return columns


@final
@dataclass(frozen=True)
class Attempt:
    """One choice in each of N lines, and its plan where the plan is asked for before the next reset of a line."""

    chooser: Chooser
    robot: Ints
    """Index of the deciding robot (N,)."""
    stream: Stream
    choice: Ints
    """Index of the choice (N,)."""
    chosen: Choices
    """The choices (N,)."""

    @property
    def valid(self) -> Bools:
        """Whether each choice exists (N,)."""
        return self.chosen.real

    @property
    def item(self) -> Ints:
        """Item as which the camera classifies each object; arbitrary where the choice does not exist (N,)."""
        return self._of_object(self.stream.objects.measured.kind, self.chooser.blank.kind)

    @property
    def true_kind(self) -> Ints:
        """True item of each object; arbitrary where the choice does not exist (N,)."""
        return self._of_object(self.stream.objects.kind, self.chooser.blank.objects.kind)

    @property
    def bin(self) -> Ints:
        """Index of the robot's bin; arbitrary where the choice does not exist (N,)."""
        return np.where(self.valid, self.chosen.bin, self.chooser.blank.bin)

    @property
    def percent(self) -> Floats:
        """Speed setting; arbitrary where the choice does not exist (N,) [%]."""
        return np.where(self.valid, self.chosen.percent, self.chooser.blank.objects.percent)

    def _of_object(self, values: Ints, blank: Ints) -> Ints:
        """Values (N, M) of the chosen objects (N,), or a value (1,) where the choice does not exist."""
        return np.where(self.valid, values[np.arange(len(self.choice)), self.chosen.index], blank)

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
    def execute(self, state: LineState, stream: Stream, attempt: Attempt) -> ThrowResults:
        """Results of one choice in each of N lines; no attempt where the choice does not exist.

        Args:
            state: states of the lines.
            stream: objects that come along.
            attempt: the choices.
        """

    def predict(
        self, robots: Ints, bins: Ints, objects: Objects, distance: Floats, luck: Floats
    ) -> ThrowResults | None:
        """Predicted results of throws, S; None where only a simulation can tell.

        Args:
            robots: index of the throwing robot.
            bins: index of the robot's bin.
            objects: the objects, each with its speed setting.
            distance: horizontal distance from the pick to the middle of the bin [m].
            luck: as for `execute`.
        """
        return None


@final
class TableThrows(ThrowExecutor):
    """Results by a table of chances.

    Args:
        configs: each robot as a conveyor cell.
        chances: table of the robots' throws.
    """

    def __init__(self, configs: list[ConveyorConfig], chances: Chances) -> None:
        self._chances = chances
        accepts = [config.acceptance() for config in configs]
        self._accepts = np.zeros(
            (len(configs), len(accepts[0]), max(acceptance.shape[1] for acceptance in accepts)), dtype=np.bool_
        )
        """Whether bin B of robot R takes item K: (R, K, B)."""
        for index, acceptance in enumerate(accepts):
            self._accepts[index, :, : acceptance.shape[1]] = acceptance

    def execute(self, state: LineState, stream: Stream, attempt: Attempt) -> ThrowResults:
        """Results by the objects' own draws: the same object with the same chance gives the same result."""
        choices, objects, chances = state.choices, stream.objects, self._chances
        results, ended_in = np.empty((3, len(attempt.choice)), dtype=np.bool_), np.empty_like(attempt.choice)
        act_kernel.throw_by_table(
            state.robot, attempt.choice, choices.real, choices.index, choices.bin, choices.numbers,
            objects.kind, objects.pick_draw, stream.luck, state.books.read().attempts, STRETCH,
            self._accepts, chances.percent, chances.edges, chances.picked, chances.landed, results, ended_in,
        )  # fmt: skip
        return ThrowResults.by_table(results[0], results[1], results[2], ended_in)

    def predict(self, robots: Ints, bins: Ints, objects: Objects, distance: Floats, luck: Floats) -> ThrowResults:
        """Results of throws by the table, S."""
        picked = objects.pick_draw >= 1.0 - self._chances.picked[objects.kind]
        success = picked & (luck < self._chances.landing_chance(objects.kind, objects.percent, distance))
        accepted = self._accepts[robots, objects.kind, bins]
        return ThrowResults.by_table(picked, success, success & accepted, np.where(success, bins, -1))


@final
class SimulatedThrows(ThrowExecutor):
    """Simulates each throw in a conveyor cell configured like the robot.

    Args:
        configs: each robot as a conveyor cell.
        count: number of lines N.
        threads: threads of the physics.
    """

    release: Release | None = None
    """Policy that corrects the throws; None for the planner's throws."""

    def __init__(self, configs: list[ConveyorConfig], count: int, threads: int) -> None:
        distinct, self._core_index = distinct_cells(configs)
        self.cores = [Core(ConveyorCell(config, count, "independent", threads)) for config in distinct]

    def execute(self, state: LineState, stream: Stream, attempt: Attempt) -> ThrowResults:
        """Results by the conveyor's physics, with the hand returning to the place of its pick."""
        results, rows = ThrowResults.nothing(len(attempt.choice)), np.flatnonzero(attempt.valid)
        if rows.size == 0:
            return results
        self.recording = None
        attempts = state.books.at((rows, attempt.chosen.index[rows])).attempts
        throws = take(attempt.context, rows)
        throws = replace(throws, objects=redraw_picks(throws.objects, attempts))
        return replace_rows(results, rows, self._simulate_all(rows, state.robot[rows], throws))

    def _simulate_all(self, rows: Ints, robots: Ints, throws: Context) -> ThrowResults:
        """Results of throws in some lines, each by the cell of its robot."""
        result = ThrowResults.nothing(len(rows))
        for index, core in enumerate(self.cores):
            core_rows = np.flatnonzero(self._core_index[robots] == index)
            if core_rows.size > 0:
                result = replace_rows(result, core_rows, self._simulate(core, rows[core_rows], take(throws, core_rows)))
        return result

    def _simulate(self, core: Core, rows: Ints, throws: Context) -> ThrowResults:
        """Results of the throws in some rows of a cell; the cell's other rows are ignored."""
        cell = cast("ConveyorCell", core.cell)
        cell.plant.record_row = 0 if self.watched and rows[0] == 0 else None
        cell.context = replace_rows(cell.context, rows, _cut_bins(throws, len(cell.config.bins.fixed)))
        action: Any = np.zeros((core.count, *core.action_space.shape))
        if self.release is not None:
            action = self.release(core.observe(), cell.context.kind)
        outcome = core.preview(action, jitter=True)
        if cell.plant.record_row is not None:
            self.recording = cell.plant.recording
        lost = outcome.picked & outcome.dropped
        flown = (outcome.picked & ~lost)[:, None]
        return ThrowResults(
            picked=outcome.picked[rows],
            is_success=outcome.is_success[rows],
            sorted=outcome.sorted[rows],
            ended_in=outcome.ended_in[rows],
            landing_error=outcome.landing_error[rows],
            energy=outcome.energy[rows],
            lost=lost[rows],
            miss=np.where(flown, outcome.landing - cell.context.target[:, :2], np.nan)[rows],
        )


def redraw_picks(objects: Objects, attempt: Ints) -> Objects:
    """Objects with new draws of whether the cup seals, by the number of earlier attempts, S."""
    return replace(objects, pick_draw=redraw(objects.pick_draw, attempt))


def _cut_bins(throws: Context, count: int) -> Context:
    """Throws with arrays cut to the robot's number of bins; other robots of the line may have more."""
    draws = replace(throws.objects.draws, fill=throws.objects.draws.fill[:, :count])
    return replace(throws, objects=replace(throws.objects, draws=draws), depth=throws.depth[:, :count])
