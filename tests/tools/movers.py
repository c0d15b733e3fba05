"""Choices of a line by other code than the line's: each option by the planner of its robot's conveyor cell."""

from dataclasses import replace
from typing import Any

import numpy as np

from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.line import choice_kernel, turn_kernel
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.options import Options, ThrowCandidates
from pnt_gym.cells.line.state import Choices
from pnt_gym.planning.motion.limits import LimitRows


def choices_anew(cell: LineCell, by_movers: bool = False) -> Choices:
    """The choices of the deciding robots of all lines, looked for once more.

    Args:
        cell: the lines.
        by_movers: plan options by the robots' conveyor cells, and not by the stages of lines.
    """
    chooser, state, stream = cell.chooser, cell.state, cell.stream
    found, lines = take(state.choices, np.arange(cell.count)), np.arange(cell.count)
    sight, robot = chooser.sight(state, stream, lines), state.robot[lines]
    candidates = _candidates(chooser, sight, robot)
    plan = _plan_by_movers if by_movers else _plan_by_stages
    options = plan(chooser, candidates, sight, state.hand[lines, robot], stream.objects)
    choice_kernel.choose_options(
        chooser.tables[1], chooser.can_take, chooser.bases, lines, robot, sight.object_index, sight.x, sight.kind,
        np.stack([options.row, options.place, options.bin]), options.numbers, stream.worth,
        np.empty(cell.count, dtype=np.bool_), (found.real, found.index, found.bin, found.numbers),
    )  # fmt: skip
    return found


def _candidates(chooser: Any, sight: Any, robot: Any) -> ThrowCandidates:
    sites = chooser._sites
    most = sight.x.size * sites.most
    index, x = np.empty((4, most), dtype=np.int64), np.empty(most)
    tables = chooser.can_take, chooser.bases, sites.ranges, sites.accepts
    count = turn_kernel.list_candidates(chooser.numbers, sight.x, sight.kind, robot, *tables, index, x)
    return ThrowCandidates(index[:, :count], x[:count])


def _plan_by_stages(chooser: Any, candidates: ThrowCandidates, sight: Any, hand: Any, objects: Any) -> Options:
    return chooser._option_planner.plan(candidates, sight, hand, objects)


def _plan_by_movers(chooser: Any, candidates: ThrowCandidates, sight: Any, hand: Any, objects: Any) -> Options:
    """Options of all kinds of robots, merged in the order of the lines."""
    kind, parts = chooser._sites.kind[candidates.indices[2]], []
    for index, planner in enumerate(chooser._planners):
        of_kind = take(candidates, np.s_[..., kind == index])
        parts.append(_plan_kind(chooser, planner, of_kind, sight, hand, objects))
    row, place, bins, numbers = (np.concatenate(values) for values in zip(*parts, strict=True))
    order = np.argsort(row, kind="stable")
    return Options(bin=bins[order], numbers=numbers[order], row=row[order], place=place[order])


def _plan_kind(chooser: Any, planner: Any, candidates: ThrowCandidates, sight: Any, hand: Any, objects: Any) -> Any:
    """Row, place, bin and numbers of the options of one kind of robots."""
    row, place, site, setting = candidates.indices
    belt, mover, dwell = planner.config.belt, planner.mover, planner.config.motion.dwell
    index, bins = (sight.line[row], sight.object_index[row, place]), chooser._sites.bin[site]
    percent = chooser._sites.percent[setting]
    height = planner.height(objects.size[index], objects.known_depth[index])
    points = np.stack([candidates.x, objects.draws.lane_y[index], height], axis=-1)
    meeting = mover.reach(ThrowMotion.resting(hand[row]), points, LimitRows.t3kr(percent))
    met = np.flatnonzero(meeting.feasible & (meeting.time <= chooser._config.horizon))
    throws = replace(take(objects, (index[0][met], index[1][met])), percent=percent[met])
    context, feasible = planner.plan_into(throws, meeting.position[met], bins[met])
    rows, pick, target = met[feasible], context.pick[feasible], context.target[feasible]
    motion = mover.throw(
        pick, take(context.plan, feasible), take(context.throw_limits, feasible), take(context.ceiling, feasible)
    )
    lift = meeting.time[rows] + dwell
    leave = lift + (belt.pick_x[1] - pick[:, 0]) / belt.speed
    away = target[:, :2] - pick[:, :2]
    columns = percent[rows], pick, away, lift, meeting.wait[rows], leave, motion.stop_time, motion.stop
    return row[rows], place[rows], bins[rows], np.column_stack(columns)
