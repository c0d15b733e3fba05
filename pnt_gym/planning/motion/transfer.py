"""Fast motions between moving states under norm limits, N at a time, for the throws of the conveyor cell.

`reflection` searches for a feasible motion: the duration begins below an estimate and grows with the violation that is
left. The first feasible motion takes on average about 2 % longer than the fastest motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, length, take
from pnt_gym.planning.motion import kernel
from pnt_gym.planning.motion.limits import LimitRows, Limits
from pnt_gym.planning.motion.reflection import PIECES, SCALES, Band, Problem, matrices, search
from pnt_gym.planning.motion.rows import Segments

__all__ = ["PIECES", "Band", "Transfers", "estimate", "fast_transfer"]

FIRST: Final = 0.97
"""First duration as a share of the estimate."""
BACKWARD: Final = 0.5
"""Estimated time of a way against the motion, as a share of a move from rest to rest."""
STRETCH: Final = 1.5
"""Duration of the matrices over the true duration; the iteration converges fastest with this ratio."""


@final
@dataclass(frozen=True, eq=False)
class Transfers:
    """N motions; rows without a motion have a duration of NaN.

    Attributes:
        duration: (N,) [s].
        steps: durations of the pieces (N, PIECES) [s]; short motions end with pieces of no duration.
        jerks: (N, PIECES, 3) [m/s3].
        feasible: whether the row holds a motion (N,).
    """

    duration: Floats
    steps: Floats
    jerks: Floats
    feasible: Bools

    @property
    def segments(self) -> Segments:
        """The motions as segments; rows without a motion rest."""
        return Segments(np.where(self.feasible[:, None], self.steps, 0.0), self.jerks)


def fast_transfer(
    way: Floats,
    before: Floats,
    after: Floats,
    limits: Limits,
    *,
    braking: Floats | None = None,
    drift: Floats | None = None,
    band: Band | None = None,
    shortest: Floats | None = None,
) -> Transfers:
    """Return quick motions from velocity ``before``, without acceleration, to velocity ``after``.

    Args:
        way: end less start (N, 3) [m], at time 0 if the end moves.
        before: velocity at the start (N, 3) [m/s], below the limit.
        after: velocity at the end (N, 3) [m/s], below the limit.
        limits: limits of the norms at all times.
        braking: acceleration at the end (N, 3) [m/s2], below the limit; none when not given.
        drift: velocity of the end point (N, 3) [m/s]; at rest when not given.
        band: bounds of the position; none when not given.
        shortest: least duration (N,) [s].

    Returns:
        The motions. A row's result does not depend on the other rows.
    """
    count = len(way)
    rows = limits.arrays(count)
    never = np.full(count, np.inf)
    problem = Problem(
        way,
        np.zeros_like(way) if drift is None else drift,
        before,
        after,
        np.zeros_like(way) if braking is None else braking,
        np.stack(rows, axis=1),
        Band.level(-never, never) if band is None else band,
    )
    guess = estimate(way, before, after, rows, drift)
    first = FIRST * guess if shortest is None else np.maximum(FIRST * guess, shortest)
    # In units of A / J, by which `SCALES` orders the matrices.
    ratio = STRETCH * np.maximum(guess, first) * problem.bounds[:, 2] / problem.bounds[:, 1]
    scale = np.abs(np.log(ratio)[:, None] - np.log(SCALES)).argmin(axis=1)
    duration, steps, jerks = np.full(count, np.nan), np.zeros((count, PIECES)), np.zeros((count, PIECES, 3))
    for kind in np.unique(scale):
        part = np.flatnonzero(scale == kind)
        matrix_set = matrices(int(kind))
        used = np.arange(PIECES) < matrix_set.pieces
        duration[part], part_jerks = search(matrix_set, take(problem, part), first[part])
        steps[part] = used * (duration[part] / matrix_set.pieces)[:, None]
        jerks[np.ix_(part, used)] = part_jerks
    return Transfers(duration, steps, jerks, np.isfinite(duration))


def estimate(way: Floats, before: Floats, after: Floats, limits: LimitRows, drift: Floats | None = None) -> Floats:
    """Return an estimate of the duration of transfers (N,) [s], mostly a few percent too short.

    The estimate is the time of the change of velocity plus the time of the remaining way: at full speed where the
    remaining way lies in the direction of the motion, half a move from rest to rest where it lies against the motion.
    """
    velocity, acceleration, jerk = limits
    # Change of velocity at full acceleration, plus the rise and fall of the acceleration.
    turn = length(after - before) / acceleration + acceleration / jerk
    ahead = before + after
    remainder = way - 0.5 * ahead * turn[:, None]
    if drift is not None:
        remainder = remainder + drift * turn[:, None]
    distance = length(remainder)
    along = remainder[:, 0] * ahead[:, 0] + remainder[:, 1] * ahead[:, 1] + remainder[:, 2] * ahead[:, 2]
    # 0 for a way along the motion, 1 for a way against it: half of one less the cosine.
    against = 0.5 - 0.5 * along / np.maximum(distance * length(ahead), 1e-9)
    quick, still = distance / velocity, kernel.strokes(distance, limits)["time"]
    return turn + quick + against * np.maximum(BACKWARD * still - quick, 0.0)
