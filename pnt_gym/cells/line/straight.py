"""Options of robots whose hands move on straight lines, planned in compiled stages; see `option_kernel`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, length, take
from pnt_gym.cells.conveyor.config import LIP_GAP, ConveyorConfig
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line.options import OptionPlanner, Options, Sight, Sites, ThrowCandidates
from pnt_gym.planning.motion.intercept import HORIZON
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.riding import MOST_SHARE, USUAL_SPEED, Fading, arrival_time

CHASE_COLUMNS: Final = 13
THROW_ROWS: Final = 15


@final
class StraightPlanner(OptionPlanner):
    """Plans options of robots with the planner `straight`, to the bit as `MoverPlanner`.

    Args:
        planners: the planner of each kind of robots; the kinds differ in bins and speed settings alone.
        sites: bins and speed settings of all kinds.
        horizon: time within which an object may be taken [s].
    """

    def __init__(self, planners: Sequence[PickPlanner], sites: Sites, horizon: float) -> None:
        self._planners, self._sites = planners, sites
        config = planners[0].config
        self._is_careful = config.grip.safety is not None
        self._has_reserve = config.motion.reserve > 0.0
        self._numbers = _cell_numbers(planners[0], horizon)
        self._settings = np.concatenate([_setting_columns(planner.config) for planner in planners])

    def plan(self, candidates: ThrowCandidates, sight: Sight, hand: Floats, objects: Objects) -> Options:
        """Options of all kinds of robots."""
        chases, points = np.empty((len(candidates.x), CHASE_COLUMNS)), np.empty((len(candidates.x), 3))
        is_open = np.empty(len(candidates.x), dtype=np.bool_)
        common = self._numbers, self._settings
        from pnt_gym.cells.line import option_kernel as kernel  # noqa: PLC0415 - numba takes a while
        from pnt_gym.planning.motion.chase import earliest  # noqa: PLC0415

        kernel.chase_objects(
            *common, *candidates, sight.line, sight.object_index, hand,
            objects.size, objects.known_depth, objects.draws.lane_y, points, chases, is_open,
        )  # fmt: skip
        times, reached = np.empty(len(chases)), np.empty(len(chases), dtype=np.bool_)
        earliest(chases, times, reached)
        met, picks = np.empty(len(chases), dtype=np.int64), np.empty((len(chases), 3))
        acceleration, waits = np.empty(len(chases)), np.empty(len(chases))
        count = kernel.meet_objects(
            *common, candidates.indices, points, chases, is_open, times, reached,
            met, picks, acceleration, waits,
        )  # fmt: skip
        met, picks, acceleration = met[:count], picks[:count], acceleration[:count]
        if self._is_careful:
            met, picks, acceleration, kept = self._hold(candidates, sight, objects, met, picks)
            waits = waits[kept]
        return self._throw(candidates, times, met, picks, acceleration, waits)

    def _throw(
        self,
        candidates: ThrowCandidates,
        times: Floats,
        met: Ints,
        picks: Floats,
        acceleration: Floats,
        waits: Floats,
    ) -> Options:
        """Options among candidates that are met at picks, with limits of the throws' acceleration."""
        common, count = (self._numbers, self._settings), len(met)
        throws, moved = np.empty((THROW_ROWS, count)), np.empty((THROW_ROWS, 2 * count))
        fading, is_possible = np.empty(count), np.empty(count, dtype=np.bool_)
        from pnt_gym.cells.line import option_kernel as kernel  # noqa: PLC0415 - numba takes a while
        from pnt_gym.planning.straight.kernel import choose_slopes  # noqa: PLC0415

        kernel.lay_out_throws(
            *common,
            self._sites.centre,
            candidates.indices,
            met,
            picks,
            acceleration,
            throws,
            moved,
            fading,
            is_possible,
        )
        slopes, is_moved, reasons = np.empty(count), np.empty(count, dtype=np.bool_), np.empty(count, dtype=np.int64)
        choose_slopes(throws, False, slopes, is_moved, reasons)
        plans = self._release(throws, slopes, is_moved, reasons, needs_angles=True)
        # The slope of a moved throw is that of the nominal throw's angle.
        moved_slopes = np.tile(np.tan(np.where(reasons == 0, plans[1][2], 0.0)), 2)
        moved_reasons = np.zeros(2 * count, dtype=np.int64)
        moved_plans = plans
        if self._has_reserve:
            no_roof = np.zeros(2 * count, dtype=np.bool_)
            moved_plans = self._release(moved, moved_slopes, no_roof, moved_reasons, needs_angles=False)
        good, stops, radicands = np.empty(count, dtype=np.int64), np.empty((count, 3)), np.empty((2, count))
        count = kernel.accept_throws(
            self._numbers, met, picks, throws, reasons, *plans, moved, moved_reasons, *moved_plans, is_possible,
            good, stops, radicands,
        )  # fmt: skip
        good, numbers = good[:count], np.empty((count, 13))
        kernel.finish_options(
            *common, self._sites.centre, candidates.indices, times, met, picks, throws, plans[1], fading,
            good, stops, waits, np.cbrt(radicands[:, :count]), numbers,
        )  # fmt: skip
        row, place, site, _ = candidates.indices[:, met[good]]
        return Options(bin=self._sites.bin[site], numbers=numbers, row=row, place=place)

    def _release(
        self, throws: Floats, slopes: Floats, is_moved: Bools, reasons: Ints, needs_angles: bool
    ) -> tuple[Floats, Floats]:
        """Vectors and figures of releases along lines of given slopes, as `release_rows` writes them."""
        count = len(slopes)
        vectors, figures = np.empty((3, count, 3)), np.empty((7, count))
        active = np.empty((2, count), dtype=np.bool_)
        from pnt_gym.planning.straight.kernel import release_rows  # noqa: PLC0415 - numba takes a while

        release_rows(throws, False, needs_angles, slopes, is_moved, reasons, vectors, figures, active)
        return vectors, figures

    def _hold(
        self, candidates: ThrowCandidates, sight: Sight, objects: Objects, met: Ints, picks: Floats
    ) -> tuple[Ints, Floats, Floats, Ints]:
        """The throws that the cup can hold, with their limits of the acceleration, and their indices."""
        row, place, _, setting = candidates.indices[:, met]
        index, percent = (sight.line[row], sight.object_index[row, place]), self._sites.percent[setting]
        throws = replace(take(objects, index), percent=percent)
        limits, can_hold = self._planners[0].grip_limits(throws, picks)
        kept = np.flatnonzero(can_hold)
        return met[kept], picks[kept], limits.acceleration[kept], kept


def _cell_numbers(planner: PickPlanner, horizon: float) -> Floats:
    """Numbers of a cell as `option_kernel` names them."""
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
    """Numbers of the speed settings of one kind of robots as `option_kernel` names them (S, 12)."""
    from pnt_gym.cells.line.option_kernel import write_descents  # noqa: PLC0415 - numba takes a while

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
    write_descents(motion.clearance, settings)
    return settings
