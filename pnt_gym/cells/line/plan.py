"""Plans of picks and throws along straight lines, for hands that meet objects on the belt. Compiled.

The robots move as by `StraightMover` and `TrackingMover`; lines need the ends of motions, not the motions.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pnt_gym.cells.conveyor.config import LIP_GAP
from pnt_gym.cells.line.choose import landing_chance
from pnt_gym.cells.line.rows import Candidate, Choice, LineNumbers, Meeting, Rider, Seen, Setting, Site, Tables
from pnt_gym.cells.line.sight import list_candidates
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.planning.motion.hunt import meet
from pnt_gym.planning.motion.intercept import HORIZON
from pnt_gym.planning.motion.kernel import space_margin
from pnt_gym.planning.motion.limits import Space
from pnt_gym.planning.motion.rows import Hunt
from pnt_gym.planning.motion.strokes import fading_time, least_fading, limits_beside, stop_phases
from pnt_gym.planning.straight.kernel import (
    braking_limit,
    choose_slopes,
    release_rows,
    reserve_shift,
    stays_inside,
    stop_distance,
)
from pnt_gym.planning.straight.rows import StopRules, Throw
from pnt_gym.rows import Floats1, Floats2, Ints1, Rows1, Rows2

HUNT, MEETING, CHOICE, THROW = Hunt.dtype, Meeting.dtype, Choice.dtype, Throw.dtype


@kernel_part
def pick_height(line: LineNumbers, rider: Rider) -> float:
    """Height of a hand that lifts an object [m]."""
    return line.height + rider.height + LIP_GAP - rider.known_depth


@kernel_part
def write_hunt(line: LineNumbers, setting: Setting, rider: Rider, x: float, hand: Floats1, hunt: Hunt) -> None:
    """Write the hunt of a hand for an object at a position along the belt, both from the robot's base."""
    hunt.place[0], hunt.place[1], hunt.place[2] = x - setting.early, rider.lane_y, pick_height(line, rider)
    hunt.belt[0], hunt.belt[1], hunt.belt[2], hunt.clearance = line.speed, 0.0, 0.0, line.clearance
    hunt.velocity, hunt.acceleration, hunt.jerk = setting.velocity, setting.way_acceleration, setting.way_jerk
    hunt.low, hunt.high, hunt.earliest = setting.low, setting.high, 0.0
    for axis in range(3):
        hunt.hand[axis] = hand[axis]


@kernel_part
def _meet_candidates(
    tables: Tables, candidates: Rows1[Candidate], lines: Ints1, seen: Rows2[Seen], hands: Floats2, riders: Rows2[Rider]
) -> Rows1[Meeting]:
    """Find the candidates that hands meet in time, in their order; the other arguments are those of `plan_options`."""
    most, line = len(candidates), tables.line[0]
    hunts, meetings, count = empty_rows(most, HUNT), empty_rows(most, MEETING), 0
    for c in range(most):
        candidate = candidates[c]
        rider = riders[lines[candidate.line], seen[candidate.line, candidate.place].index]
        setting = tables.settings[candidate.setting]
        write_hunt(line, setting, rider, candidate.x, hands[candidate.line], hunts[c])
    intercepts = meet(hunts, 0, HORIZON)
    for c in range(most):
        setting, intercept = tables.settings[candidates[c].setting], intercepts[c]
        if intercept.feasible and setting.least_time <= intercept.time <= line.horizon:
            meeting = meetings[count]
            meeting.candidate, meeting.time, meeting.wait = c, intercept.time, intercept.wait
            meeting.pick[0] = intercept.position[0] + setting.behind
            meeting.pick[1], meeting.pick[2] = intercept.position[1], intercept.position[2]
            count += 1
    return meetings[:count]


@kernel_part
def lay_out(line: LineNumbers, setting: Setting, site: Site, pick: Floats1, throw: Throw) -> tuple[float, bool]:
    """Write a throw to plan; returns the time of the fading and whether the limits allow it."""
    speed, velocity, peak, jerk = line.speed, setting.velocity, setting.acceleration, setting.jerk
    start, fading, is_possible = pick[0], 0.0, True
    if line.rides:
        fading = fading_time(speed, velocity, peak, jerk)
        start, is_possible = pick[0] + speed * fading / 2.0, fading >= least_fading(speed, peak)
        peak, jerk = limits_beside(fading, speed, peak, jerk)
    throw.pick[0], throw.pick[1], throw.pick[2] = start, pick[1], pick[2]
    for axis in range(3):
        throw.target[axis] = site.centre[axis]
    throw.velocity, throw.acceleration, throw.jerk = velocity, peak, jerk
    throw.tolerance, throw.ceiling = 0.0, pick[2] + line.ceiling
    throw.near, throw.far, throw.low, throw.high = 0.0, math.inf, -math.inf, math.inf
    return fading, is_possible


@kernel_part
def _write_pick(tables: Tables, candidate: Candidate, meeting: Meeting, index: int, choice: Choice) -> None:
    """Write the fields of a choice that do not depend on its throw."""
    line, site = tables.line[0], tables.sites[candidate.site]
    choice.real, choice.line, choice.place, choice.index = True, candidate.line, candidate.place, index
    choice.bin, choice.percent = site.bin, tables.settings[candidate.setting].percent
    choice.lift, choice.wait = meeting.time + line.dwell, meeting.wait
    for axis in range(3):
        choice.pick[axis] = meeting.pick[axis]
    choice.away[0], choice.away[1] = site.centre[0] - meeting.pick[0], site.centre[1] - meeting.pick[1]
    choice.leave = choice.lift + (line.window_high - meeting.pick[0]) / line.speed
    choice.crowd = choice.heirs = choice.reaches = choice.queue = 0.0


@kernel_part
def write_throw(rules: StopRules, throw: Throw, release: Any, fading: float, choice: Choice) -> None:
    """Write the times of a throw, and the place at which the hand stands still after it."""
    braking = braking_limit(throw.acceleration, rules.gravity_share, release.direction[2])
    ramp, plateau = stop_phases(release.speed, braking, throw.jerk)
    # A throw that is shorter than the fading of the belt's speed begins later.
    choice.fading, choice.throwing = fading, max(release.time, fading) + rules.window + (2.0 * ramp + plateau)
    choice.cycle = choice.lift + choice.throwing
    way = stop_distance(release.distance, release.speed, rules.window, braking, throw.jerk)
    for axis in range(3):
        choice.stop[axis] = throw.pick[axis] + release.direction[axis] * way


@kernel_part
def space_of(setting: Setting) -> Space:
    """Workspace of the robot that has a speed setting."""
    s = setting
    return Space(s.semi_x, s.semi_y, s.z_min, s.z_max, s.x, s.y, s.hole)


@kernel_part
def stop_rules(line: LineNumbers) -> StopRules:
    """Rules by which the hands of a line stop after a throw."""
    return StopRules(line.coast, line.gravity_share, line.reserve)


@kernel_part
def _plan_throws(
    tables: Tables, candidates: Rows1[Candidate], seen: Rows2[Seen], meetings: Rows1[Meeting]
) -> Rows1[Choice]:
    """Plan the throws of met candidates that robots can execute for their targets and for moved targets."""
    count, line = len(meetings), tables.line[0]
    throws, fading, is_good = empty_rows(count, THROW), np.empty(count), np.empty(count, dtype=np.bool_)
    rules, shifts = stop_rules(line), np.empty((count, 2))
    for m in range(count):
        candidate, pick = candidates[meetings[m].candidate], meetings[m].pick
        setting, site = tables.settings[candidate.setting], tables.sites[candidate.site]
        fading[m], is_good[m] = lay_out(line, setting, site, pick, throws[m])
        is_good[m] &= space_margin(pick[0], pick[1], pick[2], space_of(setting)) >= 0.0
        shifts[m, 0], shifts[m, 1] = reserve_shift(throws[m], pick, line.reserve)
    releases = release_rows(throws, False, False, choose_slopes(throws, False))
    choices, good = empty_rows(count, CHOICE), 0
    for m in range(count):
        candidate, shift = candidates[meetings[m].candidate], (shifts[m, 0], shifts[m, 1])
        space = space_of(tables.settings[candidate.setting])
        if is_good[m] and stays_inside(throws[m], releases[m], shift, rules, space):
            choice = choices[good]
            _write_pick(tables, candidate, meetings[m], seen[candidate.line, candidate.place].index, choice)
            write_throw(rules, throws[m], releases[m], fading[m], choice)
            good += 1
    return choices[:good]


@kernel
def plan_options(
    tables: Tables, riders: Rows2[Rider], lines: Ints1, seen: Rows2[Seen], robots: Ints1, hands: Floats2
) -> Rows1[Choice]:
    """Plan the throws that robots can choose, with values and chances, in the order of the lines.

    Args:
        tables: what the level says.
        riders: objects of all lines (N, M).
        lines: indices of the lines (K,).
        seen: objects in sight (K, W).
        robots: the robots (K,).
        hands: places at which their hands stand still, from their bases (K, 3) [m].
    """
    candidates = list_candidates(tables, seen, robots)
    meetings = _meet_candidates(tables, candidates, lines, seen, hands, riders)
    planned = _plan_throws(tables, candidates, seen, meetings)
    for k in range(len(planned)):
        choice = planned[k]
        kind = seen[choice.line, choice.place].kind
        choice.value = riders[lines[choice.line], choice.index].worth
        choice.chance = tables.chances.picked[kind] * landing_chance(tables.chances, kind, choice)
    return planned
