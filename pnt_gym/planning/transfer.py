"""Fast motions between moving states under norm limits, N at a time: what the conveyor cell plans its throws with.

With its duration T fixed, a motion of K pieces of constant jerk is linear in its jerks, and the limits on |j|, |a|
and |v| are balls: a feasible motion is a point common to an affine set and a product of balls. Reflections on the two
sets in turn (Douglas and Rachford's iteration) find one in a few dozen steps, each of two small matrix products, and
the matrices are the same for all rows because time is measured in units of T. T begins short of an estimate and grows
with the violation that is left, so the first feasible motion is close to the fastest, on average about 2 % above it.
Velocity is bounded at the Bernstein coefficients of every piece and acceleration at its ends, so the limits hold at
all times.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.planning.arrays import Bools, Floats, length
from pnt_gym.planning.limits import MotionLimits
from pnt_gym.planning.scurve import stroke_time
from pnt_gym.planning.trajectory import Segments

PIECES: Final = 24
"""Pieces of constant jerk per motion."""
BLOCK: Final = 32
"""Rows solved together. Matrix products of one shape give a row the same bits whatever the other rows are."""
STAGE: Final = 16
STAGES: Final = 20
"""Iterations per stage, and most stages per motion; after each, the rows not solved yet are put together anew."""
HOPELESS: Final = 3.0
"""A motion not found within this multiple of its first duration is given up."""
PATIENCE: Final = 8
"""Iterations between two changes of the duration, a multiple of `LOOK`."""
LOOK: Final = 2
"""Iterations between two looks at the violation."""
FIRST: Final = 0.97
"""First duration as a share of the estimate."""
GROWTH: Final = 0.08
"""Relative growth of the duration per unit of relative violation."""
LEAST: Final = 0.003
MOST: Final = 0.08
"""Bounds of one growth; the lower one rises by `IMPATIENCE` with every stage."""
IMPATIENCE: Final = 1.076
INSIDE: Final = 0.9985
"""The balls are shrunk to this share of the limits: an iterate that converges to them gets inside after finite time."""
HEIGHT: Final = 4.0
"""Weight of the heights against the velocities in the iteration's metric."""
BACKWARD: Final = 0.5
"""Share of a move from rest to rest that a way against the motion is estimated to take."""
SCALES: Final = 1.6 ** np.arange(-2.0, 12.0)
"""Durations in units of A / J that matrices are made for; rows take the nearest on a logarithmic scale."""
STRETCH: Final = 1.5
"""The iteration converges fastest with matrices for a duration this much above the true one."""


@final
@dataclass(frozen=True, eq=False)
class Transfers:
    """N motions; rows without one have a duration of NaN.

    Attributes:
        duration: (N,) [s].
        jerks: (N, PIECES, 3) [m/s3], pieces of equal length.
        feasible: whether the row holds a motion (N,).
    """

    duration: Floats
    jerks: Floats
    feasible: Bools

    @property
    def segments(self) -> Segments:
        """The motions as segments; rows without one hold still."""
        step = np.where(self.feasible, self.duration, 0.0) / PIECES
        return Segments(np.repeat(step[:, None], PIECES, axis=1), self.jerks)


class Band(NamedTuple):
    """Bounds of the position relative to the start, at the borders between the pieces.

    The last three keep a hand off an object that leaves the start with the start's velocity, which must then lie in
    the plane of x and z: above the object until `by`, behind it from then on. Both are linear, so nothing has to be
    decided while the motion is sought.

    Attributes:
        low: least height (N,) [m].
        high: greatest height (N,) [m].
        fall: downward acceleration of the object (N,) [m/s2].
        clear: distance behind the object along x (N,) [m]; 0 for no object.
        by: time from which the hand is behind it (N,) [s].
    """

    low: Floats
    high: Floats
    fall: Floats
    clear: Floats
    by: Floats

    @classmethod
    def level(cls, low: Floats, high: Floats) -> Band:
        """Heights between two bounds (N,) [m], and no object."""
        zero = np.zeros_like(low)
        return cls(low, high, zero, zero, zero)


class _Problem(NamedTuple):
    """Rows of one block: displacement at time 0 and its drift, end velocities, last acceleration, limits, band."""

    way: Floats
    drift: Floats
    before: Floats
    after: Floats
    braking: Floats
    bounds: Floats
    band: Band

    def take(self, rows: np.ndarray) -> _Problem:
        band = Band(*(value[rows] for value in self.band))
        return _Problem(
            self.way[rows],
            self.drift[rows],
            self.before[rows],
            self.after[rows],
            self.braking[rows],
            self.bounds[rows],
            band,
        )


def fast_transfer(
    way: Floats,
    before: Floats,
    after: Floats,
    limits: MotionLimits,
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
        limits: norms that hold at all times.
        braking: acceleration at the end (N, 3) [m/s2], below the limit; none when not given.
        drift: velocity of the end point (N, 3) [m/s]; at rest when not given.
        band: bounds of the position; none when not given.
        shortest: least duration (N,) [s].

    Returns:
        The motions. A row's result does not depend on the other rows.
    """
    count = len(way)
    never = np.full(count, np.inf)
    problem = _Problem(
        way,
        np.zeros_like(way) if drift is None else drift,
        before,
        after,
        np.zeros_like(way) if braking is None else braking,
        np.stack(limits.arrays(count), axis=1),
        Band.level(-never, never) if band is None else band,
    )
    guess = estimate(way, before, after, limits, drift)
    first = FIRST * guess if shortest is None else np.maximum(FIRST * guess, shortest)
    ratio = STRETCH * np.maximum(guess, first) * problem.bounds[:, 2] / problem.bounds[:, 1]
    scale = np.abs(np.log(ratio)[:, None] - np.log(SCALES)).argmin(axis=1)
    duration, jerks = np.full(count, np.nan), np.zeros((count, PIECES, 3))
    for kind in np.unique(scale):
        rows = np.flatnonzero(scale == kind)
        duration[rows], jerks[rows] = _search(_matrices(int(kind)), problem.take(rows), first[rows])
    return Transfers(duration, jerks, np.isfinite(duration))


def estimate(way: Floats, before: Floats, after: Floats, limits: MotionLimits, drift: Floats | None = None) -> Floats:
    """Return about how long a transfer takes (N,) [s], mostly a few percent too short.

    Counted are the change of velocity and the way that is left then: at full speed where it lies in the direction of
    the motion, as half a move from rest to rest where it lies against it.
    """
    velocity, acceleration, jerk = bounds = limits.arrays(len(way))
    turn = length(after - before) / acceleration + acceleration / jerk
    ahead = before + after
    rest = way - 0.5 * ahead * turn[:, None]
    if drift is not None:
        rest = rest + drift * turn[:, None]
    left = length(rest)
    along = rest[:, 0] * ahead[:, 0] + rest[:, 1] * ahead[:, 1] + rest[:, 2] * ahead[:, 2]
    against = 0.5 - 0.5 * along / np.maximum(left * length(ahead), 1e-9)
    quick = left / velocity
    return turn + quick + against * np.maximum(BACKWARD * stroke_time(left, *bounds) - quick, 0.0)


@final
class _Matrices:
    """Constant matrices for one ratio of duration to A / J.

    A row of the iteration holds, for each axis, jerks, accelerations, velocities and heights in units of T and
    weighted such that the balls' radii are of the order of one.
    """

    def __init__(self, scale: float) -> None:
        jerk = np.eye(PIECES)
        a, v, p = (np.zeros((PIECES + 1, PIECES)) for _ in range(3))
        step = 1.0 / PIECES
        for k in range(PIECES):
            p[k + 1] = p[k] + step * (v[k] + step * (a[k] / 2.0 + step * jerk[k] / 6.0))
            v[k + 1] = v[k] + step * (a[k] + step * jerk[k] / 2.0)
            a[k + 1] = a[k] + step * jerk[k]
        middle = v[:-1] + step * a[:-1] / 2.0
        rows = (jerk, a[1:-1], np.concatenate([middle, v[1:-1]]), p[1:-1])
        # In units of A / J: |j| <= J, |a| <= A, |v| <= V with V / A about 5 / 4 of A / J, as for the T3KR robot.
        weights = np.array([1.0 / scale**3, 1.0 / scale**2, 0.8 / scale, HEIGHT / scale])
        self.kind = np.repeat(np.arange(4), [len(part) for part in rows])
        self.weight = weights[self.kind]
        full = np.concatenate(rows) * self.weight[:, None]
        ends = np.stack([p[-1], v[-1], a[-1]])
        basis, _ = np.linalg.qr(ends.T, mode="complete")
        self.null: Floats = basis[:, 3:]
        self.ends: Floats = np.asarray(np.linalg.pinv(ends), dtype=np.float64)
        self.full: Floats = full
        self.reach: Floats = full @ self.null
        self.back: Floats = np.asarray(np.linalg.pinv(self.reach), dtype=np.float64)
        self.share = np.arange(1, PIECES) / PIECES
        # What the start's velocity, in units of T, adds to velocities and heights.
        carried = np.concatenate([np.zeros(PIECES + PIECES - 1), np.ones(2 * PIECES - 1), self.share])
        self.carried = carried * self.weight
        self.balls = int((self.kind < 3).sum())


@cache
def _matrices(kind: int) -> _Matrices:
    return _Matrices(float(SCALES[kind]))


class _Scaled(NamedTuple):
    """A block at its present durations: motion of least jerk, its row, inverse square radii, bounds of the place."""

    jerk: Floats
    row: Floats
    inverse: Floats
    low: Floats
    high: Floats
    far: Floats


class _State(NamedTuple):
    """Where the iteration stands: durations (B,) and iterates (B, 3, columns)."""

    time: Floats
    iterate: Floats


def _search(m: _Matrices, problem: _Problem, first: Floats) -> tuple[Floats, Floats]:
    """Durations (N,) and jerks (N, K, 3); NaN and zero where nothing was found."""
    count, columns = len(first), len(m.weight)
    duration, jerks = np.full(count, np.nan), np.zeros((count, PIECES, 3))
    state = _State(first.copy(), np.zeros((count, 3, columns)))
    for stage in range(STAGES):
        rows = np.flatnonzero(np.isnan(duration) & (state.time <= HOPELESS * first))
        for begin in range(0, rows.size, BLOCK):
            part = rows[begin : begin + BLOCK]
            padded = np.concatenate([part, np.repeat(part[-1:], BLOCK - part.size)])
            own = _State(*(value[padded] for value in state))
            time, jerk, after = _iterate(m, problem.take(padded), own, stage)
            duration[part], jerks[part] = time[: part.size], jerk[: part.size]
            for value, new in zip(state, after, strict=True):
                value[part] = new[: part.size]
    return duration, jerks


def _iterate(m: _Matrices, problem: _Problem, state: _State, stage: int) -> tuple[Floats, Floats, _State]:
    """One stage for a block: durations and jerks found, and where the iteration stands."""
    found, jerks = np.full(BLOCK, np.nan), np.zeros((BLOCK, PIECES, 3))
    time, iterate = state
    block = _scaled(m, problem, time)
    if stage == 0:
        # Begin with the motion of least jerk.
        iterate = block.row.copy()
    least = LEAST * IMPATIENCE**stage
    violation = np.ones(BLOCK)
    for step in range(1, STAGE + 1):
        inner = _product(iterate - block.row, m.back)
        point = block.row + _product(inner, m.reach)
        if step % LOOK == 0:
            violation = _violation(m, block, point)
            new = (violation <= 1.0) & np.isnan(found)
            if new.any():
                found[new] = time[new]
                total = (block.jerk + _product(inner, m.null))[new] / time[new, None, None] ** 3
                jerks[new] = total.transpose(0, 2, 1)
                if not np.isnan(found).any():
                    break
        reflected = 2.0 * point
        reflected -= iterate
        iterate -= point
        iterate += _projected(m, block, reflected)
        if step % PATIENCE == 0:
            growth = 1.0 + np.clip(GROWTH * (violation - 1.0), least, MOST)
            time = time * growth
            iterate *= (growth[:, None] ** (3.0 - np.minimum(m.kind, 3)))[:, None]
            block = _scaled(m, problem, time)
    return found, jerks, _State(time, iterate)


def _product(rows: Floats, matrix: Floats) -> Floats:
    """Matrix applied to the last axis of (B, 3, columns); one product of one shape for the whole block."""
    return (rows.reshape(3 * BLOCK, -1) @ matrix.T).reshape(BLOCK, 3, -1)


def _scaled(m: _Matrices, problem: _Problem, time: Floats) -> _Scaled:
    t = time[:, None]
    way = problem.way + t * problem.drift - t * problem.before
    ends = np.stack([way, t * (problem.after - problem.before), t**2 * problem.braking], axis=-1)
    jerk = _product(ends, m.ends)
    row = _product(jerk, m.full) + (t * problem.before)[..., None] * m.carried
    powers = np.stack([time, time**2, time**3], axis=1)
    radius = (problem.bounds * powers)[:, ::-1][:, np.minimum(m.kind[: m.balls], 2)] * m.weight[: m.balls]
    return _Scaled(jerk, row, 1.0 / radius**2, *_places(m, problem, time))


def _places(m: _Matrices, problem: _Problem, time: Floats) -> tuple[Floats, Floats, Floats]:
    """Weighted bounds (B, K - 1): least and greatest height, greatest x."""
    band, weight = problem.band, m.weight[m.balls :]
    since = time[:, None] * m.share
    tracked = (band.clear > 0.0)[:, None]
    falling = problem.before[:, 2:] * since - 0.5 * band.fall[:, None] * since**2
    near = tracked & (since < band.by[:, None])
    low = np.where(near, np.maximum(band.low[:, None], falling), band.low[:, None])
    behind = problem.before[:, :1] * since - band.clear[:, None]
    far = np.where(tracked & ~near, behind, np.inf)
    return low * weight, np.broadcast_to(band.high[:, None], since.shape) * weight, far * weight


def _squares(rows: Floats) -> Floats:
    x, y, z = rows[:, 0], rows[:, 1], rows[:, 2]
    return x * x + y * y + z * z


def _violation(m: _Matrices, block: _Scaled, point: Floats) -> Floats:
    """Largest ratio to the limits (B,); above 1 too where a place is out of bounds."""
    ratio = np.sqrt((_squares(point[..., : m.balls]) * block.inverse).max(axis=1))
    ahead, height = point[:, 0, m.balls :], point[:, 2, m.balls :]
    out = np.maximum(np.maximum(block.low - height, height - block.high), ahead - block.far).max(axis=1)
    return np.maximum(ratio, np.where(out > 1e-9, 1.0 + out, 0.0))


def _projected(m: _Matrices, block: _Scaled, rows: Floats) -> Floats:
    """Nearest point of the balls and bounds; changes `rows`."""
    over = np.maximum(_squares(rows[..., : m.balls]) * (block.inverse / INSIDE**2), 1.0)
    rows[..., : m.balls] /= np.sqrt(over)[:, None]
    np.clip(rows[:, 2, m.balls :], block.low, block.high, out=rows[:, 2, m.balls :])
    np.minimum(rows[:, 0, m.balls :], block.far, out=rows[:, 0, m.balls :])
    return rows
