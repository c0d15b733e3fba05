"""Plans of picks and throws along straight lines, for hands that meet objects on the belt. Compiled.

The formulas are those of `StraightMover` and `TrackingMover`, without segments of motions. NumPy rounds cube roots in
its own way, so the times of short throws are computed from NumPy's roots afterwards.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.cells.conveyor.config import LIP_GAP
from pnt_gym.cells.line.rows import Candidate, Choice, LineNumbers, Meeting, Rider, Seen, Setting, Short, Site, Tables
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.chase import Chase, earliest, search_end
from pnt_gym.planning.motion.intercept import HORIZON
from pnt_gym.planning.motion.riding import MOST_SHARE, USUAL_SPEED
from pnt_gym.planning.motion.strokes import brake_distance, is_short, long_peaks, ramp_times, stop_times, stroke_time
from pnt_gym.planning.straight.kernel import choose_slopes, is_inside, keep_stops_inside, release_rows
from pnt_gym.planning.straight.plan import ReleaseBatch
from pnt_gym.planning.straight.rows import Space, Stop, Throw, ThrowLine
from pnt_gym.rows import Bools1, Floats1, Floats2, Ints1, Rows1, Rows2, Triple

CHASE, MEETING, CHOICE, SHORT = Chase.dtype, Meeting.dtype, Choice.dtype, Short.dtype
THROW, STOP = Throw.dtype, Stop.dtype


@kernel_part
def _set_up(line: LineNumbers, setting: Setting, point: Floats1, hand: Floats1, chase: Chase) -> bool:
    """Write the chase of a hand after a point, as `plan_intercept`; returns whether the point comes in time."""
    speed, x = line.speed, point[0]
    for axis in range(3):
        chase.way[axis] = point[axis] - hand[axis]
    chase.way[2] += line.clearance
    velocity, acceleration, jerk = setting.velocity, setting.way_acceleration, setting.way_jerk
    chase.belt[0], chase.belt[1], chase.belt[2], chase.descent = speed, 0.0, 0.0, setting.descent
    chase.velocity, chase.acceleration, chase.jerk = velocity, acceleration, jerk
    low_time, high_time = (setting.low - x) / speed, (setting.high - x) / speed
    first, last = max(min(low_time, high_time), 0.0), min(max(low_time, high_time), HORIZON)
    chase.first, chase.last = (first, last) if first <= last else (0.0, 0.0)
    way = chase.way
    far = math.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    chase.end = search_end(far, line.pace, (velocity, acceleration, jerk), setting.descent)
    return first <= last and first <= HORIZON


@kernel_part
def _wait(line: LineNumbers, setting: Setting, chase: Chase, time: float) -> float:
    """Standstill of a hand above the belt before a meeting [s]."""
    if time > chase.first:
        return 0.0
    x, y, z = chase.way[0] + time * line.speed, chase.way[1], chase.way[2]
    stroke = math.sqrt(x * x + y * y + z * z)
    travel = stroke_time(stroke, setting.velocity, setting.way_acceleration, setting.way_jerk)
    return max(time - travel - setting.descent, 0.0)


@kernel
def meet_candidates(
    tables: Tables, candidates: Rows1[Candidate], lines: Ints1, seen: Rows2[Seen], hands: Floats2, riders: Rows2[Rider]
) -> Rows1[Meeting]:
    """Find the candidates that hands meet in time, as `Mover.reach` and `plan_intercept` do.

    Args:
        tables: what the level says.
        candidates: candidates of the deciding robots of K lines (C,).
        lines: indices of the lines (K,).
        seen: objects in sight (K, W).
        hands: positions of the deciding robots' hands, from their bases (K, 3) [m].
        riders: objects of all lines (N, M).

    Returns:
        The meetings (P,), in the order of the candidates.
    """
    most, line = len(candidates), tables.line[0]
    points, chases, is_open = np.empty((most, 3)), empty_rows(most, CHASE), np.empty(most, dtype=np.bool_)
    for c in range(most):
        candidate = candidates[c]
        setting = tables.settings[candidate.setting]
        rider = riders[lines[candidate.line], seen[candidate.line, candidate.place].index]
        points[c, 0], points[c, 1] = candidate.x - setting.early, rider.lane_y
        points[c, 2] = line.height + rider.height + LIP_GAP - rider.known_depth
        is_open[c] = _set_up(line, setting, points[c], hands[candidate.line], chases[c])
    times, meetings, count = earliest(chases), empty_rows(most, MEETING), 0
    for c in range(most):
        setting, time = tables.settings[candidates[c].setting], times[c]
        if not (is_open[c] and time >= setting.least_time and time <= line.horizon):
            continue
        meeting = meetings[count]
        meeting.candidate, meeting.time = c, time
        meeting.wait = _wait(line, setting, chases[c], time)
        meeting.pick[0] = points[c, 0] + time * line.speed + setting.behind
        meeting.pick[1], meeting.pick[2] = points[c, 1], points[c, 2]
        count += 1
    return meetings[:count]


@kernel
def write_descents(clearance: float, settings: Rows1[Setting]) -> None:
    """Write the times of the descents of speed settings, from their other fields."""
    for s in range(len(settings)):
        setting = settings[s]
        setting.descent = stroke_time(clearance, setting.velocity, setting.way_acceleration, setting.way_jerk)


@kernel_part
def fading_time(speed: float, velocity: float, peak: float, jerk: float) -> float:
    """Time in which the belt's speed fades from a hand [s], as `planning.motion.riding` bounds this time.

    T <= (V + s) / A + A / J, and a peak of at most a share of A.
    """
    longest = (velocity + speed) / peak + peak / jerk
    usual = (USUAL_SPEED + speed) / peak + peak / jerk
    return min(longest, max(usual, 2.0 * speed / (MOST_SHARE * peak)))


@kernel_part
def _lay_out(line: LineNumbers, setting: Setting, site: Site, pick: Floats1, throw: Throw) -> tuple[float, bool]:
    """Write a throw to plan; returns the time of the fading and whether the limits allow it."""
    speed, velocity, peak, jerk = line.speed, setting.velocity, setting.acceleration, setting.jerk
    start, fading, is_possible = pick[0], 0.0, True
    if line.rides:
        fading = fading_time(speed, velocity, peak, jerk)
        start, is_possible = pick[0] + speed * fading / 2.0, fading >= 2.0 * speed / (MOST_SHARE * peak)
        least, fade = 1.0 - MOST_SHARE, 2.0 * speed / fading
        peak, jerk = max(peak - fade, least * peak), max(jerk - 2.0 * fade / fading, least * jerk)
    throw.pick[0], throw.pick[1], throw.pick[2] = start, pick[1], pick[2]
    for axis in range(3):
        throw.target[axis] = site.centre[axis]
    throw.velocity, throw.acceleration, throw.jerk = velocity, peak, jerk
    throw.tolerance, throw.ceiling = 0.0, pick[2] + line.ceiling
    throw.near, throw.far, throw.low, throw.high = 0.0, math.inf, -math.inf, math.inf
    return fading, is_possible


@kernel_part
def _braking_acceleration(line: LineNumbers, acceleration: float, angle: float) -> float:
    """Limit of the acceleration while a hand brakes after a release at an elevation."""
    if math.isnan(line.gravity_share):
        return acceleration
    return min(acceleration, line.gravity_share * GRAVITY / max(math.sin(angle), 1e-3))


@kernel_part
def _throwing_time(line: LineNumbers, throw: Short) -> float:
    """Time from the lift until the hand stands still, as `StraightMover.throw` and a delay of the fading."""
    ramp, plateau = ramp_times(throw.top, throw.peak, throw.jerk)
    cruise = max(throw.stroke / throw.top - 2.0 * ramp - plateau, 0.0) if throw.top > 0.0 else 0.0
    release = ramp + plateau + ramp + 0.5 * cruise
    ramp, plateau = stop_times(throw.speed, throw.braking, throw.jerk)
    throwing = release + line.coast + (ramp + plateau + ramp)
    return throwing + max(throw.fading - release, 0.0) if line.rides else throwing


@kernel_part
def _keep_in_workspace(
    line: LineNumbers,
    throws: Rows1[Throw],
    meetings: Rows1[Meeting],
    lines: Rows1[ThrowLine],
    releases: Rows1[ReleaseBatch],
    is_good: Bools1,
) -> None:
    """Write which of the possible throws stop inside the workspace, also with their targets moved by the reserve."""
    count, borders = len(throws), line.workspace
    space, stops = Space(borders[0], borders[1], borders[2], borders[3]), empty_rows(count, STOP)
    for m in range(count):
        pick, throw, release, stop = meetings[m].pick, throws[m], releases[m], stops[m]
        is_good[m] &= release.feasible
        if line.rides:
            is_good[m] &= is_inside(pick[0], pick[1], pick[2], space)
        stop.slope, stop.braking = lines[m].slope, _braking_acceleration(line, throw.acceleration, release.angle)
        x, y = throw.target[0] - pick[0], throw.target[1] - pick[1]
        far = math.sqrt(x * x + y * y)
        stop.shift[0], stop.shift[1] = line.reserve * (x / far), line.reserve * (y / far)
    keep_stops_inside(throws, releases, stops, line.reserve > 0.0, line.coast, space, is_good)


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
    choice.value = choice.chance = choice.crowd = choice.heirs = choice.reaches = choice.queue = 0.0


@kernel_part
def _write_stop(line: LineNumbers, start: Triple, direction: Triple, throw: Short, stop: Triple) -> None:
    """Write the place at which a hand stands still after its throw."""
    way = 0.5 * throw.stroke + (line.coast * throw.speed + brake_distance(throw.speed, throw.braking, throw.jerk))
    for axis in range(3):
        stop[axis] = start[axis] + direction[axis] * way


@kernel
def plan_throws(
    tables: Tables, candidates: Rows1[Candidate], seen: Rows2[Seen], meetings: Rows1[Meeting]
) -> tuple[Rows1[Choice], Rows1[Short]]:
    """Plan the throws of met candidates; the robot can execute them for their targets and for moved targets.

    Args:
        tables: what the level says.
        candidates: candidates of the deciding robots (C,).
        seen: objects in sight (K, W).
        meetings: the candidates that are met (P,).

    Returns:
        The planned throws (G,), and the short ones among them, whose times `finish_short_throws` writes (S,).
    """
    count, line = len(meetings), tables.line[0]
    throws, fading, is_good = empty_rows(count, THROW), np.empty(count), np.empty(count, dtype=np.bool_)
    for m in range(count):
        candidate = candidates[meetings[m].candidate]
        setting, site = tables.settings[candidate.setting], tables.sites[candidate.site]
        fading[m], is_good[m] = _lay_out(line, setting, site, meetings[m].pick, throws[m])
    lines = choose_slopes(throws, False)
    releases = release_rows(throws, False, not math.isnan(line.gravity_share), lines)
    _keep_in_workspace(line, throws, meetings, lines, releases, is_good)
    # The row after the last short throw is room for the numbers of a long one.
    choices, short, good, shorts = empty_rows(count, CHOICE), empty_rows(count + 1, SHORT), 0, 0
    for m in range(count):
        if not is_good[m]:
            continue
        choice, candidate, throw = choices[good], candidates[meetings[m].candidate], short[shorts]
        plan, release = throws[m], releases[m]
        throw.choice, throw.stroke, throw.speed, throw.jerk = good, 2.0 * release.distance, release.speed, plan.jerk
        throw.braking, throw.fading = _braking_acceleration(line, plan.acceleration, release.angle), fading[m]
        _write_pick(tables, candidate, meetings[m], seen[candidate.line, candidate.place].index, choice)
        _write_stop(line, plan.pick, release.direction, throw, choice.stop)
        stroke, jerk = throw.stroke, throw.jerk
        if is_short(stroke, plan.velocity, plan.acceleration, jerk):
            throw.top, throw.peak = 0.25 * jerk * stroke * stroke, 0.5 * jerk * jerk * stroke
            shorts += 1
        else:
            throw.top, throw.peak = long_peaks(stroke, plan.velocity, plan.acceleration, jerk)
            choice.throwing = _throwing_time(line, throw)
            choice.cycle = choice.lift + choice.throwing
        good += 1
    return choices[:good], short[:shorts]


@kernel
def finish_short_throws(tables: Tables, short: Rows1[Short], choices: Rows1[Choice]) -> None:
    """Write the times of short throws, whose greatest speeds and accelerations are cube roots now."""
    for s in range(len(short)):
        choice = choices[short[s].choice]
        choice.throwing = _throwing_time(tables.line[0], short[s])
        choice.cycle = choice.lift + choice.throwing
