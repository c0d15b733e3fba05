"""A slow motion along a run of a path that keeps all limits: where the search for the quickest one starts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.planning.motion.limits import MotionLimits

from .curves import CurvePoints
from .plane import PlanePath

PLACES = 2000
# Share of the limits at which the start moves.
SHARE = 0.6
# Window of the moving average, of the whole duration; three in a row make the jerk continuous.
WINDOW = 0.07


class Course(NamedTuple):
    """A motion along a run at many moments: time, arc length, speed and acceleration along the path, each (M,)."""

    time: Floats
    s: Floats
    speed: Floats
    acceleration: Floats

    def slower(self, factor: float) -> Course:
        """The same motion in ``factor`` times the time."""
        return Course(factor * self.time, self.s, self.speed / factor, self.acceleration / factor**2)


def run_points(path: PlanePath, run: tuple[int, int], s: Floats) -> CurvePoints:
    """Points at ``s`` (M,), read from the pieces ``run[0]`` up to, without, ``run[1]``."""
    return path.at(s, np.clip(path.piece_at(s), run[0], run[1] - 1))


def careful_course(path: PlanePath, run: tuple[int, int], limits: MotionLimits) -> Course:
    """Return a slow motion from rest to rest that slows down further where the path is bent."""
    s = np.linspace(float(path.borders[run[0]]), float(path.borders[run[1]]), PLACES)
    speed = _allowed_speed(run_points(path, run, s), s, limits)
    course = _smoothed(s, speed)
    return course.slower(_excess(run_points(path, run, course.s), course, limits) / SHARE)


def _allowed_speed(points: CurvePoints, s: Floats, limits: MotionLimits) -> Floats:
    """Speed at which each place can be passed, with rises and falls at a share of the acceleration."""
    velocity, acceleration, jerk = limits.numbers()
    bend, slope = np.maximum(np.abs(points.curvature), 1e-9), np.maximum(np.abs(points.slope), 1e-9)
    most = np.minimum(np.sqrt(acceleration / bend), np.minimum(jerk / bend**2, jerk / slope) ** (1.0 / 3.0))
    square = np.minimum(velocity, SHARE * most) ** 2
    square[[0, -1]] = 0.0
    # The least of w(s*) + 2 a |s - s*| over all s*: no rise or fall of w = v^2 is steeper than 2 a.
    gain = 2.0 * SHARE * acceleration * s
    square = np.minimum.accumulate(square - gain) + gain
    square = np.minimum.accumulate((square + gain)[::-1])[::-1] - gain
    return np.sqrt(np.maximum(square, 0.0))


def _smoothed(s: Floats, speed: Floats) -> Course:
    """The course with its speed averaged over a while, so that acceleration and jerk are finite."""
    moments = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (speed[1:] + speed[:-1]))])
    step = float(moments[-1]) / (PLACES - 1)
    width = int(WINDOW * PLACES)
    window = np.full(width, 1.0 / width)
    # Three moving averages, as one.
    window = np.convolve(np.convolve(window, window), window)
    rate = np.convolve(np.interp(step * np.arange(PLACES), moments, speed), window)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]))])
    scale = (s[-1] - s[0]) / (way[-1] * step)
    time = step * np.arange(rate.size, dtype=np.float64)
    return Course(time, s[0] + scale * step * way, scale * rate, scale * np.gradient(rate, step))


def _excess(points: CurvePoints, course: Course, limits: MotionLimits) -> float:
    """How many times slower the course must be to reach, but keep, its limits."""
    velocity, acceleration, jerk = limits.numbers()
    cross = points.curvature * course.speed**2
    along = np.gradient(course.acceleration, course.time) - points.curvature * cross * course.speed
    aside = 3.0 * points.curvature * course.speed * course.acceleration + points.slope * course.speed**3
    return max(
        float(course.speed.max()) / velocity,
        float(np.hypot(course.acceleration, cross).max() / acceleration) ** 0.5,
        float(np.hypot(along, aside).max() / jerk) ** (1.0 / 3.0),
    )
