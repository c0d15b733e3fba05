"""Outcomes of throws at the conveyor: landing, effort, grip, and whether the object was sorted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.recorded import Landed, Touchdown, lies_in
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.hold import Grips
from pnt_gym.cells.conveyor.robot import RobotSheet


@final
@dataclass(frozen=True)
class Effort:
    """Load of the motors in N motions: simulated, or planned where the robot is not simulated."""

    torque: Floats
    """Largest torque of any motor (N,) [N m]."""
    energy: Floats
    """Positive mechanical work of all motors (N,) [J], see `cells.base.recorded`."""


@final
@dataclass(frozen=True)
class SimulatedThrows:
    """Simulated results of N throws, before they are judged."""

    touchdown: Touchdown
    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release (N,) [m]."""
    effort: Effort
    """Load of the motors."""
    grips: Grips
    """Grips of the cups until the release."""


@dataclass(frozen=True)
class PlannedResults:
    """Results of N throws that follow from plans and belt, without simulation."""

    wait_time: Floats
    """Part of the cycle spent waiting for the next object (N,) [s]."""
    passed: Ints
    """Number of objects that left unpicked since the previous throw (N,)."""
    placed: Bools
    """The object is put down at its bin, not thrown (N,)."""
    disturbed: Bools
    """The object sweeps through another object on the belt (N,)."""


@final
@dataclass(frozen=True)
class Outcome(Landed, PlannedResults):
    """Outcome of N throws; the cycle lasts from lift to lift, dwell included."""

    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release (N,) [m]."""
    picked: Bools
    """The cup sealed; otherwise the object stays on the belt and has no landing (N,)."""
    dropped: Bools
    """The object left the cup before its release (N,)."""
    grip_margin: Floats
    """Smallest holding force over load of the cup until the release (N,)."""
    energy: Floats
    """Positive mechanical work of the motors in the cycle (N,) [J], see `cells.base.recorded`."""
    ended_in: Ints
    """Index of the bin in which the object lies at the end, 0 for a bin that is drawn per throw; -1: no bin (N,)."""
    belongs: Bools
    """The bin in which the object lies accepts the object's true item (N,)."""

    @property
    def sorted(self) -> Bools:
        """Whether a throw is a success into a bin that accepts the object's true item (N,)."""
        return self.is_success & self.belongs


def judge(
    simulated: SimulatedThrows,
    context: Context,
    config: ConveyorConfig,
    accepts: Bools,
    cycle_time: Floats,
    planned_results: PlannedResults,
) -> Outcome:
    """Outcome of N throws.

    Args:
        simulated: simulated results of the throws.
        context: the picks of the throws.
        config: the cell.
        accepts: whether fixed bins (columns) accept items (rows), as `config.acceptance()`.
        cycle_time: time from lift to lift, dwell included (N,) [s].
        planned_results: results that need no simulation.
    """
    landing = simulated.touchdown.landing_fields(context.target, context.opening, context.bin_depth, context.direction)
    effort = simulated.effort if config.robot.has_model else _stated_effort(config.robot, cycle_time)
    ended_in, objects = bins_of(simulated.touchdown, context, config, landing["in_bin"]), context.objects
    # A bin that is drawn for a throw accepts the item that the classifier saw.
    fits = accepts[objects.kind, ended_in] if config.bins.fixed else objects.kind == objects.measured.kind
    return Outcome(
        **landing,
        landing_error=np.sqrt(landing["landing_along"] ** 2 + landing["landing_across"] ** 2),
        cycle_time=cycle_time,
        peak_torque=effort.torque,
        tracking_error=simulated.tracking_error,
        picked=simulated.grips.picked,
        dropped=simulated.grips.dropped,
        grip_margin=simulated.grips.margin,
        energy=effort.energy,
        ended_in=ended_in,
        belongs=(ended_in >= 0) & fits,
        **vars(planned_results),
    )


def _stated_effort(sheet: RobotSheet, cycle_time: Floats) -> Effort:
    """Effort of a robot by its data sheet in cycles (N,) [s]; NaN where the sheet says nothing."""
    power = np.nan if sheet.energy is None else sheet.energy / sheet.cycle
    return Effort(np.full_like(cycle_time, np.nan), power * cycle_time)


def bins_of(touchdown: Touchdown, context: Context, config: ConveyorConfig, in_bin: Bools) -> Ints:
    """Indices of the bins in which objects lie at the end (N,), -1 for none; `in_bin` (N,): in the throw's own bin."""
    indices, bins = np.where(in_bin, context.bin, -1), config.bins
    for index, fixed in enumerate(bins.fixed):
        target, opening = np.array([[fixed.x, fixed.y, bins.rim]]), np.array([fixed.size])
        indices[lies_in(touchdown, target, opening, context.depth[:, index].copy())] = index
    return indices
