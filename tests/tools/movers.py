"""Choices of a line by other code than the line's: each option by the planner of its robot's conveyor cell."""

from typing import Any

import numpy as np

from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.line import choose, sight
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.choosing import Sight
from pnt_gym.cells.line.rows import Choice, LineState
from pnt_gym.planning.motion.kernel import fade
from pnt_gym.planning.motion.limits import LimitRows


def choices_anew(cell: LineCell, by_movers: bool = False) -> LineState:
    """The states of all lines with choices of the deciding robots that are looked for once more.

    Args:
        cell: the lines.
        by_movers: plan options by the robots' conveyor cells, and not by the stages of lines.
    """
    chooser, state, stream, lines = cell.chooser, cell.state.copy(), cell.stream, np.arange(cell.count)
    look, robot = chooser.sight(state, stream, lines), np.ascontiguousarray(state.robot)
    hand = state.arms["hand"][lines, robot]
    if by_movers:
        options = _plan_by_movers(chooser, look, robot, hand, stream)
    else:
        options = chooser.options(stream.riders, look, robot, hand)
    free = state.arms["free"].copy()
    choose.write_choices(chooser.tables, state, lines, look.seen, options)
    state.arms["free"] = free
    return state


def _plan_by_movers(chooser: Any, look: Sight, robot: Any, hand: Any, stream: Any) -> Any:
    """Options of all kinds of robots, merged in the order of the lines."""
    tables, objects, riders = chooser.tables, stream.objects, stream.riders
    candidates = sight.list_candidates(tables, look.seen, robot)
    kind = chooser._kind_of[robot[candidates["line"]]]
    parts = [
        _plan_kind(chooser, planner, candidates[kind == index], look, hand, objects)
        for index, planner in enumerate(chooser._planners)
    ]
    options = np.concatenate(parts)
    options = options[np.argsort(options["line"], kind="stable")]
    # Values and chances, looked up once more.
    rows, percent, edges = options["line"], tables.chances.percent, tables.chances.edges
    kind, index = look.seen["kind"][rows, options["place"]], look.seen["index"][rows, options["place"]]
    setting = np.abs(options["percent"][:, None] - percent).argmin(axis=1)
    part = np.searchsorted(edges, np.linalg.norm(options["away"], axis=1))
    options["chance"] = tables.chances.picked[kind] * tables.chances.landed[kind, setting, part]
    options["value"] = riders["worth"][look.line[rows], index]
    return options


def _plan_kind(chooser: Any, planner: Any, candidates: Any, look: Sight, hand: Any, objects: Any) -> Any:
    """The options of one kind of robots."""
    row, place, site, setting = (candidates[name] for name in ("line", "place", "site", "setting"))
    belt, mover, dwell = planner.config.belt, planner.mover, planner.config.motion.dwell
    index, bins = (look.line[row], look.seen["index"][row, place]), chooser.tables.sites["bin"][site]
    percent = chooser.tables.settings["percent"][setting]
    height = planner.height(objects.size[index], objects.known_depth[index])
    points = np.stack([candidates["x"], objects.draws.lane_y[index], height], axis=-1)
    meeting = mover.reach(ThrowMotion.resting(hand[row]), points, LimitRows.t3kr(percent))
    met = np.flatnonzero(meeting.feasible & (meeting.time <= chooser._config.horizon))
    throws = take(objects, (index[0][met], index[1][met])).replace(percent=percent[met])
    context, feasible = planner.plan_into(throws, meeting.position[met], bins[met])
    rows, pick, target = met[feasible], context.pick[feasible], context.target[feasible]
    motion = mover.throw(
        pick, take(context.plan, feasible), take(context.throw_limits, feasible), take(context.ceiling, feasible)
    )
    lift = meeting.time[rows] + dwell
    return Choice.zeros(
        len(rows),
        real=True,
        line=row[rows],
        place=place[rows],
        index=index[1][rows],
        bin=bins[rows],
        percent=percent[rows],
        pick=pick,
        away=target[:, :2] - pick[:, :2],
        lift=lift,
        wait=meeting.wait[rows],
        leave=lift + (belt.pick_x[1] - pick[:, 0]) / belt.speed,
        fading=fade(take(LimitRows.t3kr(percent), rows), belt.speed, 0.0).time if belt.tracking else 0.0,
        throwing=motion.stop_time,
        cycle=lift + motion.stop_time,
        stop=motion.stop,
    )
