"""Throws of objects that hands have met, throw by throw in machine code; see `pnt_gym.compiled`.

The formulas are those of `StraightMover` and `TrackingMover`, operation by operation, without segments of motions.
Numpy rounds cube roots in its own way, so the times of short throws are computed from numpy's roots afterwards.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.line.meeting_kernel import (
    CEILING,
    COAST,
    DWELL,
    GRAVITY_SHARE,
    JERK,
    MOST_SHARE,
    PERCENT,
    RESERVE,
    RIDES,
    SEMI_X,
    SPEED,
    USUAL_SPEED,
    VELOCITY,
    WINDOW_END,
    Z_MAX,
)
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.strokes import brake_distance, is_short, long_peaks, ramp_times, stop_times
from pnt_gym.planning.straight.kernel import choose_slopes, is_inside, keep_stops_inside, release_rows

THROW_ROWS, OPTION_COLUMNS = 15, 13
# Columns of an option, as `PicksAndThrows` has them.
OPTION_PICK, OPTION_AWAY, OPTION_LIFT, OPTION_WAIT, OPTION_LEAVE, OPTION_THROWING, OPTION_STOP = 1, 4, 6, 7, 8, 9, 10


@kernel_part
def fading_time(speed: float, usual_speed: float, velocity: float, peak: float, jerk: float, shortest: float) -> float:
    """Time in which the belt's speed fades from a hand [s], as `planning.motion.riding` bounds this time.

    T <= (V + s) / A + A / J, and a peak of at most a share of A.
    """
    longest = (velocity + speed) / peak + peak / jerk
    usual = (usual_speed + speed) / peak + peak / jerk
    return min(longest, max(usual, shortest))


@kernel_part
def _lay_out(
    numbers: Floats, setting: Floats, site: Floats, pick: Floats, peak: float, throws: Floats, m: int
) -> tuple[float, bool]:
    """Write a throw for the kernel of releases; returns the time of the fading and whether the limits allow it."""
    speed, velocity, jerk = numbers[SPEED], setting[VELOCITY], setting[JERK]
    start, fading, is_possible = pick[0], 0.0, True
    if numbers[RIDES] > 0.0:
        shortest = 2.0 * speed / (numbers[MOST_SHARE] * peak)
        fading = fading_time(speed, numbers[USUAL_SPEED], velocity, peak, jerk, shortest)
        start, is_possible = pick[0] + speed * fading / 2.0, fading >= shortest
        least, fade = 1.0 - numbers[MOST_SHARE], 2.0 * speed / fading
        peak, jerk = max(peak - fade, least * peak), max(jerk - 2.0 * fade / fading, least * jerk)
    throws[0, m], throws[1, m], throws[2, m] = start, pick[1], pick[2]
    throws[3, m], throws[4, m], throws[5, m] = site[0], site[1], site[2]
    throws[6, m], throws[7, m], throws[8, m] = velocity, peak, jerk
    throws[9, m], throws[10, m] = 0.0, pick[2] + numbers[CEILING]
    throws[11, m], throws[12, m], throws[13, m], throws[14, m] = 0.0, math.inf, -math.inf, math.inf
    return fading, is_possible


@kernel_part
def _braking_acceleration(numbers: Floats, acceleration: float, angle: float) -> float:
    """Limit of the acceleration while a hand brakes after a release at an elevation."""
    share = numbers[GRAVITY_SHARE]
    if math.isnan(share):
        return acceleration
    return min(acceleration, share * GRAVITY / max(math.sin(angle), 1e-3))


@kernel_part
def _throwing_time(
    numbers: Floats, stroke: float, speed: float, jerk: float, braking: float, fading: float, top: float, peak: float
) -> float:
    """Time from the lift until the hand stands still, as `StraightMover.throw` and a delay of the fading.

    Args:
        numbers: numbers of the cell.
        stroke: twice the way to the release [m].
        speed: speed at the release [m/s].
        jerk: limit of the jerk [m/s3].
        braking: limit of the acceleration after the release [m/s2].
        fading: time in which the belt's speed fades [s].
        top: greatest speed of the stroke [m/s].
        peak: greatest acceleration of the stroke [m/s2].
    """
    ramp, plateau = ramp_times(top, peak, jerk)
    cruise = max(stroke / top - 2.0 * ramp - plateau, 0.0) if top > 0.0 else 0.0
    release = ramp + plateau + ramp + 0.5 * cruise
    ramp, plateau = stop_times(speed, braking, jerk)
    throwing = release + numbers[COAST] + (ramp + plateau + ramp)
    return throwing + max(fading - release, 0.0) if numbers[RIDES] > 0.0 else throwing


@kernel_part
def _write_option(
    numbers: Floats, percent: float, site: Floats, pick: Floats, time: float, wait: float, option: Floats
) -> None:
    """Write the numbers of an option that do not depend on its throw."""
    lift = time + numbers[DWELL]
    option[0], option[OPTION_LIFT], option[OPTION_WAIT] = percent, lift, wait
    option[OPTION_PICK : OPTION_PICK + 3] = pick
    option[OPTION_AWAY], option[OPTION_AWAY + 1] = site[0] - pick[0], site[1] - pick[1]
    option[OPTION_LEAVE] = lift + (numbers[WINDOW_END] - pick[0]) / numbers[SPEED]


@kernel_part
def _keep_in_workspace(
    numbers: Floats,
    throws: Floats,
    picks: Floats,
    slopes: Floats,
    reasons: Ints,
    vectors: Floats,
    figures: Floats,
    is_good: Bools,
) -> None:
    """Write which of the possible throws stop inside the workspace, also with their targets moved by the reserve."""
    count = len(reasons)
    workspace = numbers[SEMI_X : Z_MAX + 1]
    plans, shifts = np.empty((7, count)), np.empty((2, count if numbers[RESERVE] > 0.0 else 0))
    for m in range(count):
        is_good[m] &= reasons[m] == 0
        if numbers[RIDES] > 0.0:
            is_good[m] &= is_inside(picks[m, 0], picks[m, 1], picks[m, 2], workspace)
        plans[0, m], plans[1, m], plans[2, m] = slopes[m], figures[4, m], figures[0, m]
        plans[3, m], plans[4, m], plans[5, m] = vectors[2, m, 0], vectors[2, m, 1], vectors[2, m, 2]
        plans[6, m] = _braking_acceleration(numbers, throws[7, m], figures[2, m])
        if numbers[RESERVE] > 0.0:
            x, y = throws[3, m] - picks[m, 0], throws[4, m] - picks[m, 1]
            far = math.sqrt(x * x + y * y)
            shifts[0, m], shifts[1, m] = numbers[RESERVE] * (x / far), numbers[RESERVE] * (y / far)
    keep_stops_inside(throws, plans, shifts, numbers[COAST], workspace, is_good)


@kernel_part
def _write_stop(
    numbers: Floats, throws: Floats, vectors: Floats, figures: Floats, braking: float, m: int, option: Floats
) -> None:
    """Write the place at which a hand stands still after its throw."""
    speed, jerk = figures[0, m], throws[8, m]
    way = figures[4, m] + (numbers[COAST] * speed + brake_distance(speed, braking, jerk))
    for axis in range(3):
        option[OPTION_STOP + axis] = throws[axis, m] + vectors[2, m, axis] * way


@compile_for(
    "Tuple((i8[::1], f8[:, ::1], i8[::1], f8[:, ::1]))(f8[::1], f8[:, ::1], f8[:, ::1], i8[:, :], i8[:], f8[:],"
    "f8[:, :], f8[:], f8[:])"
)
def plan_throws(
    numbers: Floats,
    settings: Floats,
    sites: Floats,
    candidates: Ints,
    met: Ints,
    times: Floats,
    picks: Floats,
    acceleration: Floats,
    waits: Floats,
) -> tuple[Ints, Floats, Ints, Floats]:
    """Plan the throws of met candidates; the robot can execute them for their targets and for moved targets.

    Args:
        numbers: numbers of the cell by the names of `meeting_kernel`.
        settings: speed settings by the columns of `meeting_kernel` (S, 12).
        sites: centres of the bins' openings (B, 3) [m].
        candidates: line among the K lines, object among the objects in sight, bin and setting, (4, C).
        met: the candidates that are met (P,).
        times: times of the meetings (P,) [s].
        picks: where the objects are lifted (P, 3) [m].
        acceleration: limit of each throw's acceleration (P,) [m/s2].
        waits: standstill of the hand above the belt (P,) [s].

    Returns:
        The candidates of the options (G,), the options' numbers as `PicksAndThrows` has them (G, 13), the options whose
        throws are short (S,), and numbers of these for `finish_short_throws` (7, S).
    """
    count = len(met)
    throws, fading, is_good = np.empty((THROW_ROWS, count)), np.empty(count), np.empty(count, dtype=np.bool_)
    for m in range(count):
        setting, site = settings[candidates[3, met[m]]], sites[candidates[2, met[m]]]
        fading[m], is_good[m] = _lay_out(numbers, setting, site, picks[m], acceleration[m], throws, m)
    slopes, is_moved, reasons = np.empty(count), np.empty(count, dtype=np.bool_), np.empty(count, dtype=np.int64)
    choose_slopes(throws, False, slopes, is_moved, reasons)
    vectors, figures = np.empty((3, count, 3)), np.empty((7, count))
    brakes = not math.isnan(numbers[GRAVITY_SHARE])
    release_rows(throws, False, brakes, slopes, is_moved, reasons, vectors, figures, np.empty((2, count), np.bool_))
    _keep_in_workspace(numbers, throws, picks, slopes, reasons, vectors, figures, is_good)
    chosen, options = np.empty(count, dtype=np.int64), np.empty((count, OPTION_COLUMNS))
    short, columns = np.empty(count, dtype=np.int64), np.empty((7, count))
    good, shorts = 0, 0
    for m in range(count):
        if not is_good[m]:
            continue
        c, option, jerk = met[m], options[good], throws[8, m]
        setting, stroke, speed = settings[candidates[3, c]], 2.0 * figures[4, m], figures[0, m]
        braking = _braking_acceleration(numbers, throws[7, m], figures[2, m])
        _write_option(numbers, setting[PERCENT], sites[candidates[2, c]], picks[m], times[m], waits[m], option)
        _write_stop(numbers, throws, vectors, figures, braking, m, option)
        if is_short(stroke, throws[6, m], throws[7, m], jerk):
            columns[0, shorts], columns[1, shorts] = 0.25 * jerk * stroke * stroke, 0.5 * jerk * jerk * stroke
            columns[2, shorts], columns[3, shorts], columns[4, shorts] = stroke, speed, jerk
            columns[5, shorts], columns[6, shorts] = braking, fading[m]
            short[shorts] = good
            shorts += 1
        else:
            top, peak = long_peaks(stroke, throws[6, m], throws[7, m], jerk)
            option[OPTION_THROWING] = _throwing_time(numbers, stroke, speed, jerk, braking, fading[m], top, peak)
        chosen[good] = c
        good += 1
    return chosen[:good], options[:good], short[:shorts], columns[:, :shorts].copy()


@compile_for("void(f8[::1], i8[:], f8[:, :], f8[:, :], f8[:, :])")
def finish_short_throws(numbers: Floats, short: Ints, columns: Floats, roots: Floats, options: Floats) -> None:
    """Write the times of short throws, whose greatest speeds and accelerations are cube roots.

    Args:
        numbers: see `plan_throws`.
        short: see `plan_throws`.
        columns: see `plan_throws`.
        roots: cube roots of the first two rows of the columns (2, S).
        options: written, see `plan_throws`.
    """
    for s in range(len(short)):
        stroke, speed, jerk, braking, fading = (
            columns[2, s], columns[3, s], columns[4, s], columns[5, s], columns[6, s]
        )  # fmt: skip
        options[short[s], OPTION_THROWING] = _throwing_time(
            numbers, stroke, speed, jerk, braking, fading, roots[0, s], roots[1, s]
        )
