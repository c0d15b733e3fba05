"""Options of robots whose hands move on straight lines, planned in compiled stages.

The stages stand in `meeting_kernel` and `throwing_kernel`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from pnt_gym.arrays import Floats, length
from pnt_gym.cells.conveyor.config import LIP_GAP, ConveyorConfig
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line import meeting_kernel, throwing_kernel
from pnt_gym.cells.line.options import Options, Sight, Sites, ThrowCandidates
from pnt_gym.planning.motion.intercept import HORIZON
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.riding import MOST_SHARE, USUAL_SPEED, Fading, arrival_time


@final
class StraightPlanner:
    """Plans options of robots with the planner `straight`.

    Args:
        planners: the planner of each kind of robots; the kinds differ in bins and speed settings alone.
        sites: bins and speed settings of all kinds.
        horizon: time within which an object may be taken [s].
    """

    def __init__(self, planners: Sequence[PickPlanner], sites: Sites, horizon: float) -> None:
        self._bins = sites.bin
        self.tables = (
            _cell_numbers(planners[0], horizon),
            np.concatenate([_setting_columns(planner.config) for planner in planners]),
            sites.centre,
        )
        """Numbers of a cell, settings, and centres of the bins' openings, as `meeting_kernel` names them."""

    def plan(self, candidates: ThrowCandidates, sight: Sight, hand: Floats, objects: Objects) -> Options:
        """ThrowCandidates that can be met in time and thrown, with their plans.

        Args:
            candidates: candidates of the deciding robots of K lines.
            sight: sight of these lines.
            hand: positions at which the robots' hands stand still, from their bases (K, 3) [m].
            objects: objects of all N lines (N, M).
        """
        met, times, picks, acceleration, waits = meeting_kernel.meet_candidates(
            *self.tables[:2], *candidates, sight.line, sight.object_index, hand,
            objects.size, objects.known_depth, objects.draws.lane_y,
        )  # fmt: skip
        chosen, numbers, short, columns = throwing_kernel.plan_throws(
            *self.tables, candidates.indices, met, times, picks, acceleration, waits
        )
        throwing_kernel.finish_short_throws(self.tables[0], short, columns, np.cbrt(columns[:2]), numbers)
        row, place, site, _ = candidates.indices[:, chosen]
        return Options(bin=self._bins[site], numbers=numbers, row=row, place=place)


def _cell_numbers(planner: PickPlanner, horizon: float) -> Floats:
    """Numbers of a cell as `meeting_kernel` names them."""
    config, space = planner.config, planner.workspace
    belt, motion = config.belt, config.motion
    share = motion.follow_through.gravity_share
    pace = length(np.array([belt.speed, 0.0, 0.0]))
    return np.array(
        [
            belt.speed, float(pace), belt.height, LIP_GAP, motion.clearance, HORIZON, horizon, motion.dwell,
            motion.ceiling, motion.follow_through.window, np.nan if share is None else share, motion.reserve,
            space.semi_x, space.semi_y, space.z_min, space.z_max, belt.pick_x[1], float(belt.tracking),
            USUAL_SPEED, MOST_SHARE,
        ]
    )  # fmt: skip


def _setting_columns(config: ConveyorConfig) -> Floats:
    """Numbers of the speed settings of one kind of robots as `meeting_kernel` names them (S, 12)."""
    belt, motion = config.belt, config.motion
    percent = np.array(config.limits.percent, dtype=np.float64)
    limits, none = LimitRows.t3kr(percent), np.zeros(len(percent))
    low, high = config.lift_x
    way, least_time, early, behind = limits, none - np.inf, none, none
    if belt.tracking:
        # The way of the hand ends upstream of the object, where the hand begins to ride.
        arrival = arrival_time(limits, belt.speed, motion.clearance)
        way = Fading(belt.speed, none + arrival).planning_limits(limits)
        least_time, early = none + arrival, none + belt.speed * arrival / 2.0
        behind = none + belt.speed * (arrival / 2.0 + motion.dwell)
    window = low - behind, high - behind
    columns = [percent, *limits, way.acceleration, way.jerk, none, least_time, early, behind, *window]
    settings = np.ascontiguousarray(np.column_stack(columns))
    meeting_kernel.write_descents(motion.clearance, settings)
    return settings
