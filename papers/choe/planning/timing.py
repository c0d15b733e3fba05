"""The quickest motion along a given path under limits on the lengths of velocity, acceleration and jerk.

The hand starts and ends at rest. Between the places where the hand must stop, the motion is optimised as a whole, with
the third derivative of the arc length piecewise constant; straight runs take the S-curve in closed form.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, Ints, concatenate_records
from pnt_gym.errors import PlanningError, PntGymError
from pnt_gym.planning.motion.limits import MotionLimits
from pnt_gym.planning.motion.scurve import min_time_scurve
from pnt_gym.planning.motion.trajectory import PeakRatios, Samples

from .curves import CurvePoints
from .plane import Joint, PlanePath, SpacePath
from .quickest import Progress, quickest_progress

JointRule: TypeAlias = Literal["strict", "relaxed"]
# Intervals of a curved run: more than twice as many make the motion less than 0.1 % quicker.
INTERVALS = 240
# Relative excess over a limit that counts as rounding.
TOLERANCE = 1e-6
# Time step at which the peaks of a motion are read [s], and the fewest and most steps in each interval.
CHECK_STEP = 5e-5
CHECK_STEPS = (8, 100)
_SIGNS = np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])


@final
@dataclass(frozen=True, eq=False)
class TimedPath:
    """One timed path of the hand: a ``HandPath`` of one row.

    Attributes:
        path: path of the hand in space.
        progress: arc length over time, K intervals of constant third derivative.
        knot_times: borders of the intervals (K + 1,) [s], from 0 to the duration.
    """

    path: SpacePath
    progress: Progress
    knot_times: Floats

    @classmethod
    def of(cls, path: SpacePath, progress: Progress) -> TimedPath:
        """Return the motion ``progress`` along ``path``."""
        return cls(path, progress, np.concatenate([[0.0], np.cumsum(progress.durations)]))

    @property
    def duration(self) -> Floats:
        """Total time (1,) [s]."""
        return self.knot_times[-1:]

    def sample(self, times: ArrayLike) -> Samples:
        """Return the motion at ``times`` [s], shape (M,) or (1, M), each result (1, M, 3); rest outside."""
        s, points, moving, _ = self._read(times)
        speed, rise = moving * s[1], moving * s[2]
        ahead, aside = self._directions(points)
        velocity = speed[:, None] * ahead
        acceleration = rise[:, None] * ahead + (points.curvature * speed**2)[:, None] * aside
        return Samples(self.path.positions(points.position)[None], velocity[None], acceleration[None])

    def jerk(self, times: ArrayLike) -> Floats:
        """Return the jerk at ``times`` [s], shape (M,) or (1, M), result (1, M, 3) [m/s3]; zero outside.

        Where the curvature jumps under the relaxed rule, the acceleration steps and no jerk exists; the value there is
        the jerk just after the step.
        """
        s, points, moving, third = self._read(times)
        along, across = _jerk(points, s[1], s[2], third)
        ahead, aside = self._directions(points)
        return (moving[:, None] * (along[:, None] * ahead + across[:, None] * aside))[None]

    def peak_ratios(self, limits: MotionLimits) -> PeakRatios:
        """Return the largest speed, acceleration and jerk as shares of ``limits``, each (1,).

        The peaks are read on both sides of every interval's border, and between them every 0.05 ms or 100 times.
        """
        steps = int(np.clip(np.ceil(self.progress.durations.max() / CHECK_STEP), *CHECK_STEPS))
        course = self.progress.course(np.linspace(0.0, 1.0, steps + 1))
        points = self.path.path.at(course.s, np.repeat(self.progress.pieces, steps + 1))
        third = np.repeat(self.progress.jerks, steps + 1)
        along, across = _jerk(points, course.speed, course.acceleration, third)
        cross = points.curvature * course.speed**2
        peaks = np.abs(course.speed), np.hypot(course.acceleration, cross), np.hypot(along, across)
        return PeakRatios(*(np.array([p.max() / limit]) for p, limit in zip(peaks, limits.numbers(), strict=True)))

    def slower(self, factor: float) -> TimedPath:
        """Return the same motion slowed down to ``factor`` times its time."""
        p = self.progress
        scaled = Progress(
            p.s, p.speed / factor, p.acceleration / factor**2, p.durations * factor, p.jerks / factor**3, p.pieces
        )
        return TimedPath.of(self.path, scaled)

    def _directions(self, points: CurvePoints) -> tuple[Floats, Floats]:
        """Unit vectors (M, 3) along the path and to its left."""
        left = np.stack([-points.tangent[:, 1], points.tangent[:, 0]], axis=1)
        return self.path.vectors(points.tangent), self.path.vectors(left)

    def _read(self, times: ArrayLike) -> tuple[tuple[Floats, Floats, Floats], CurvePoints, Floats, Floats]:
        """Arc length, speed and acceleration along the path; points; 1 while moving, else 0; s''', each (M, ...)."""
        time = np.asarray(times, dtype=np.float64)
        if time.ndim not in (1, 2) or (time.ndim == 2 and time.shape[0] != 1):
            raise PlanningError(f"times must have shape (M,) or (1, M), got {time.shape}")
        time = time.reshape(-1)
        p, end = self.progress, self.knot_times[-1]
        clipped = np.clip(time, 0.0, end)
        k = np.clip(np.searchsorted(self.knot_times, clipped, side="right") - 1, 0, p.jerks.size - 1)
        t, v0, a0, third = clipped - self.knot_times[k], p.speed[k], p.acceleration[k], p.jerks[k]
        way = p.s[k] + t * (v0 + t * (0.5 * a0 + t * third / 6.0))
        points = self.path.path.at(way, p.pieces[k])
        moving = ((time >= 0.0) & (time <= end)).astype(np.float64)
        return (way, v0 + t * (a0 + 0.5 * t * third), a0 + t * third), points, moving, third


def time_path(
    path: SpacePath, limits: MotionLimits, *, joints: JointRule = "strict", intervals: int = INTERVALS
) -> TimedPath:
    """Return the quickest motion along ``path`` from rest to rest.

    The hand stops at corners. Where only the curvature jumps, the hand stops too under the strict rule, which keeps
    the acceleration continuous. Under the relaxed rule the hand passes, and its normal acceleration steps.

    Args:
        path: path of the hand.
        limits: largest lengths of velocity, acceleration and jerk, one set.
        joints: "strict" or "relaxed".
        intervals: number of intervals of constant s''' in each curved run, at least 20.

    Raises:
        PntGymError: (a ValueError) if CasADi is missing, IPOPT finds no timing, or the timing cannot be slowed down
            to keep the limits.
        ValueError: if the rule is unknown, there are too few intervals, or limits hold more than one set.
    """
    if joints not in ("strict", "relaxed"):
        raise PlanningError(f"joints must be 'strict' or 'relaxed', got {joints!r}")
    if intervals < 20:
        raise PlanningError(f"intervals must be at least 20, got {intervals}")
    limits.numbers()
    runs = [_time_run(path, run, limits, intervals) for run in _runs(path.path, joints)]
    return TimedPath.of(path, _join_runs(runs))


def _runs(path: PlanePath, joints: JointRule) -> Iterator[tuple[int, int]]:
    """First piece of each part that the hand passes without a stop, and the piece after its last."""
    first = 0
    for k, joint in enumerate(path.joints, start=1):
        if joint is Joint.CORNER or (joint is Joint.TANGENT and joints == "strict"):
            yield first, k
            first = k
    yield first, len(path.pieces)


def _time_run(path: SpacePath, run: tuple[int, int], limits: MotionLimits, intervals: int) -> Progress:
    if run[1] - run[0] == 1 and path.path.pieces[run[0]].curve.straight:
        return _straight(path.path, run[0], limits)
    fastest = TimedPath.of(path, quickest_progress(path.path, run, limits, intervals))
    slowed = fastest.slower(max(1.0, _slowdown(fastest, limits)))
    if _slowdown(slowed, limits) > 1.0 + TOLERANCE / 3.0:
        raise PntGymError(f"the timing found exceeds its limits: {slowed.peak_ratios(limits)}")
    return slowed.progress


def _slowdown(motion: TimedPath, limits: MotionLimits) -> float:
    """Factor of time at which the motion just keeps its limits; below 1 the motion could be quicker."""
    ratios = motion.peak_ratios(limits)
    roots = float(ratios.velocity[0]), float(ratios.acceleration[0]) ** 0.5, float(ratios.jerk[0]) ** (1.0 / 3.0)
    return max(roots)


def _straight(path: PlanePath, piece: int, limits: MotionLimits) -> Progress:
    curve = min_time_scurve(float(path.borders[piece + 1] - path.borders[piece]), limits)
    edges = np.concatenate([[0.0], np.cumsum(curve.durations)])
    way, speed, acceleration = curve.sample(edges)
    pieces: Ints = np.full(7, piece, dtype=np.int64)
    return Progress(path.borders[piece] + way, speed, acceleration, curve.durations, _SIGNS * curve.jerk, pieces)


def _join_runs(runs: list[Progress]) -> Progress:
    """All runs as one motion; each run starts and ends at rest, so that the shared borders agree."""
    later = [run._replace(s=run.s[1:], speed=run.speed[1:], acceleration=run.acceleration[1:]) for run in runs[1:]]
    return concatenate_records([runs[0], *later])


def _jerk(points: CurvePoints, speed: Floats, rise: Floats, third: Floats) -> tuple[Floats, Floats]:
    """Jerk along the path and to its left, each (M,)."""
    bend = points.curvature
    return third - bend**2 * speed**3, 3.0 * bend * speed * rise + points.slope * speed**3
