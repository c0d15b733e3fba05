"""Tables of a line for compiled functions, from its level."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pnt_gym.arrays import Ints, concatenate_records
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.rows import Choice, LineNumbers, Setting, Site, Standstill, Station, Tables
from pnt_gym.planning.motion.kernel import fade
from pnt_gym.planning.motion.limits import Space
from pnt_gym.planning.motion.riding import arrival_time
from pnt_gym.rows import Rows1


def make_tables(config: LineConfig, planners: Sequence[PickPlanner], kind_of: Ints, chances: Chances) -> Tables:
    """Tables of a line, with a choice of zeros for rows without a choice.

    Args:
        config: level of the line.
        planners: planner of each kind of robots; the kinds differ in robot, bins and speed settings alone.
        kind_of: kind of each robot (R,).
        chances: table of the robots' throws.
    """
    kinds = [planner.config for planner in planners]
    robots, begins, ends = config.standstills()
    centres = np.array([[b.x, b.y, kind.bins.rim] for kind in kinds for b in kind.bins.fixed]).reshape(-1, 3)
    # The robots, with the ranges of the bins and settings of their kinds.
    sites = np.cumsum([0, *(len(kind.bins.fixed) for kind in kinds)])
    settings = np.cumsum([0, *(len(kind.limits.percent) for kind in kinds)])
    return Tables(
        line=_line_row(config, planners[0]),
        stations=Station.zeros(
            len(kind_of),
            base=config.robot_x(),
            first_site=sites[kind_of],
            end_site=sites[kind_of + 1],
            first_setting=settings[kind_of],
            end_setting=settings[kind_of + 1],
        ),
        can_take=config.can_take(),
        standstills=Standstill.zeros(len(robots), robot=robots, start=begins, end=ends),
        sites=Site.zeros(
            len(centres), centre=centres, bin=np.concatenate([np.arange(len(kind.bins.fixed)) for kind in kinds])
        ),
        accepts=np.ascontiguousarray(np.concatenate([kind.acceptance().T for kind in kinds])),
        settings=concatenate_records([_settings(planner) for planner in planners]),
        chances=chances.table,
        blank=Choice.zeros(1),
    )


def _line_row(config: LineConfig, planner: PickPlanner) -> Rows1[LineNumbers]:
    belt, motion = config.cell.belt, planner.config.motion
    share, (low, high), (upstream, downstream) = motion.follow_through.gravity_share, belt.pick_x, config.reach
    return LineNumbers.zeros(
        1,
        speed=belt.speed,
        height=belt.height,
        rides=belt.tracking,
        sight_low=upstream,
        sight_high=downstream,
        near_low=low - belt.speed * config.horizon,
        window_low=low,
        window_high=high,
        duration=config.duration,
        price=config.price_of_time,
        clearance=motion.clearance,
        horizon=config.horizon,
        dwell=motion.dwell,
        ceiling=motion.ceiling,
        coast=motion.follow_through.window,
        gravity_share=share or 0.0,
        reserve=motion.reserve,
    )


def _settings(planner: PickPlanner) -> Rows1[Setting]:
    """The speed settings of a kind of robots."""
    kind, space = planner.config, Space.of(planner.workspace)
    belt, motion = kind.belt, kind.motion
    limits = kind.robot.limits(np.array(kind.limits.percent, dtype=np.float64))
    way, least_time, early, behind = limits, -np.inf, 0.0, 0.0
    if belt.tracking:
        # The way of the hand ends upstream of the object, where the hand begins to ride.
        arrival = arrival_time(limits, belt.speed, motion.clearance)
        way = fade(limits, belt.speed, arrival).left
        least_time, early = arrival, belt.speed * arrival / 2.0
        behind = belt.speed * (arrival / 2.0 + motion.dwell)
    low, high = kind.lift_x
    return Setting.zeros(
        len(limits.velocity),
        percent=kind.limits.percent,
        velocity=limits.velocity,
        acceleration=limits.acceleration,
        jerk=limits.jerk,
        way_acceleration=way.acceleration,
        way_jerk=way.jerk,
        least_time=least_time,
        early=early,
        behind=behind,
        low=low - behind,
        high=high - behind,
        **space._asdict(),
    )
