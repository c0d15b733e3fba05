"""What becomes of throws on a line: by a table of chances, or really thrown by a conveyor cell."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self, TypeAlias, cast, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replaced, take
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.base.plant import Recording
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.config import alike

Release: TypeAlias = Callable[[NDArray[np.float32], Ints], NDArray[np.floating]]
"""Corrects throws: observations (N, D) as of `PnTRelease-v0` and what the classifier says (N,), to actions (N, A)."""


@final
@dataclass(frozen=True)
class Made:
    """N attempts to throw."""

    picked: Bools
    """The cup sealed; else the object rides on (N,)."""
    is_success: Bools
    """It crossed the opening of the bin that it was meant for, and lies in it (N,)."""
    sorted: Bools
    """A success, and the bin takes what it is (N,)."""
    ended_in: Ints
    """Index of the bin in which it lies, -1 in none (N,)."""
    landing_error: Floats
    """Distance from its target (N,) [m]; NaN where nothing was simulated or picked."""
    energy: Floats
    """Positive work of the motors for the throw and the way back (N,) [J]; NaN where nothing was simulated."""

    @classmethod
    def nothing(cls, count: int) -> Self:
        """No attempt."""
        never, nan = np.zeros(count, dtype=np.bool_), np.full(count, np.nan)
        return cls(never, never.copy(), never.copy(), np.full(count, -1), nan, nan.copy())


class Thrower(ABC):
    """Abstract: carries throws out."""

    watched: bool = False
    """Whether the first line's simulated throws are kept, for pictures."""
    recording: Recording | None = None
    """Its last throw; None where it was not simulated, or nobody watches."""

    @abstractmethod
    def made(self, rows: Ints, robots: Ints, thrown: Context, luck: Floats) -> Made:
        """What becomes of throws in some lines, (K,) each.

        Args:
            rows: the lines.
            robots: who throws.
            thrown: the picks and their plans.
            luck: uniform draws that decide about the throws where nothing is simulated.
        """

    def foretold(self, robots: Ints, bins: Ints, objects: Objects, distance: Floats, luck: Floats) -> Made | None:
        """What would become of throws, S; None where only a simulation can tell.

        Args:
            robots: who throws.
            bins: into which of the robot's bins.
            objects: what is thrown, each at its speed setting.
            distance: horizontal, from the pick to the middle of the bin [m].
            luck: as for `made`.
        """
        return None


@final
class TableThrows(Thrower):
    """By chances.

    Args:
        configs: of each robot.
        chances: of their throws.
    """

    def __init__(self, configs: list[ConveyorConfig], chances: Chances) -> None:
        self._chances = chances
        accepts = [config.acceptance() for config in configs]
        self._accepts = np.zeros((len(configs), len(accepts[0]), max(one.shape[1] for one in accepts)), dtype=np.bool_)
        """Whether of each robot's (R) bins (B) one takes an item (K): (R, K, B)."""
        for index, one in enumerate(accepts):
            self._accepts[index, :, : one.shape[1]] = one

    def made(self, rows: Ints, robots: Ints, thrown: Context, luck: Floats) -> Made:
        """By the objects' own draws: a throw of the same object that is as likely ends alike."""
        return self.foretold(robots, thrown.bin, thrown.objects, thrown.distance, luck)

    def foretold(self, robots: Ints, bins: Ints, objects: Objects, distance: Floats, luck: Floats) -> Made:
        """What becomes of throws, S."""
        picked = objects.pick_draw >= 1.0 - self._chances.picked[objects.kind]
        success = picked & (luck < self._chances.land(objects.kind, objects.percent, distance))
        takes = self._accepts[robots, objects.kind, bins]
        nan = np.full(luck.shape, np.nan)
        return Made(picked, success, success & takes, np.where(success, bins, -1), nan, nan.copy())


@final
class ThrownThrows(Thrower):
    """Simulates each throw in a conveyor cell configured like the robot.

    Args:
        configs: of each robot.
        count: number of lines N.
        threads: of the physics.
    """

    release: Release | None = None
    """Corrects the throws; None for the planner's own."""

    def __init__(self, configs: list[ConveyorConfig], count: int, threads: int) -> None:
        different, self._same = alike(configs)
        self.cores = [Core(ConveyorCell(config, count, "independent", threads)) for config in different]

    def made(self, rows: Ints, robots: Ints, thrown: Context, luck: Floats) -> Made:
        """As the conveyor's physics has it, with the hand on its way back to where it came from."""
        result, self.recording = Made.nothing(len(rows)), None
        for index, core in enumerate(self.cores):
            own = np.flatnonzero(self._same[robots] == index)
            if own.size > 0:
                result = replaced(result, own, self._by(core, rows[own], take(thrown, own)))
        return result

    def _by(self, core: Core, rows: Ints, thrown: Context) -> Made:
        """Throws of some rows of a cell; what the other rows throw is nobody's."""
        cell = cast("ConveyorCell", core.cell)
        cell.plant.record_row = 0 if self.watched and rows[0] == 0 else None
        cell.context = replaced(cell.context, rows, _of_own_bins(thrown, len(cell.config.bins.fixed)))
        action: Any = np.zeros((core.count, *core.action_space.shape))
        if self.release is not None:
            action = self.release(core.observe(), cell.context.kind)
        outcome = core.preview(action, jitter=True)
        if cell.plant.record_row is not None:
            self.recording = cell.plant.recording
        return Made(
            picked=outcome.picked[rows],
            is_success=outcome.is_success[rows],
            sorted=outcome.sorted[rows],
            ended_in=outcome.ended_in[rows],
            landing_error=outcome.landing_error[rows],
            energy=outcome.energy[rows],
        )


def _of_own_bins(thrown: Context, count: int) -> Context:
    """Throws of a robot with so many bins, where others of the line may have more."""
    draws = replace(thrown.objects.draws, fill=thrown.objects.draws.fill[:, :count])
    return replace(thrown, objects=replace(thrown.objects, draws=draws), depth=thrown.depth[:, :count])
