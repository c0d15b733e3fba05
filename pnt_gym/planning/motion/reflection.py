"""Search for motions of a given duration, or a little longer, by reflections, for many rows at once.

With its duration T fixed, a motion of K pieces of constant jerk is linear in its jerks, and the limits on |j|, |a|
and |v| are balls: a feasible motion is a point common to an affine set and a product of balls. Reflections on the two
sets in turn (the iteration of Douglas and Rachford) find such a point in a few dozen steps, each of two small matrix
products. The matrices are the same for all rows because time is measured in units of T. T begins short of an estimate
and grows with the violation that is left. Velocity is bounded at the Bernstein coefficients of every piece and
acceleration at the ends of every piece, so the limits hold at all times. The iterates are in single precision; ends and
jerks of the feasible motions are computed in double precision.
"""

from __future__ import annotations

from functools import cache
from typing import Final, NamedTuple, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, take

Singles: TypeAlias = NDArray[np.float32]

PIECES: Final = 24
"""Most pieces of constant jerk per motion."""
FEW_PIECES: Final = 20
"""Pieces of a motion shorter than `SHORT`."""
SHORT: Final = 8.0
"""Duration in units of A / J below which `FEW_PIECES` suffice."""
SCALES: Final = 1.6 ** np.arange(-2.0, 12.0)
"""Durations in units of A / J that have matrices; rows take the nearest duration on a logarithmic scale."""


class Tuning(NamedTuple):
    """Parameters of the iteration.

    Each trade-off names the effect of another value on 160 throws and 160 returns with mixed limits: on their mean
    duration, on the work (matrix products) and on the share of returns with a motion, 99.4 % with these values.
    """

    block: int = 32
    """Rows solved together in the first stages. Only the stage sets the size, because matrix products of one shape
    give a row the same bits whatever the other rows are. Blocks are large enough for efficient products."""
    tail_block: int = 8
    """Rows solved together in the later stages, which few rows need."""
    tail: int = 5
    """First of the later stages."""
    stage: int = 16
    """Iterations per stage, after which the unsolved rows form new blocks; a multiple of `patience`."""
    stages: int = 20
    """Most stages per motion. With 12 only 92.5 % of the returns are found, with 30 all returns."""
    rounding: float = 4e-6
    """Violation that single precision may hide, in the units of the iteration: 30 times the spacing of floats at 1."""
    hopeless: float = 3.0
    """Multiple of the first duration at which the search for a motion is given up; 2 makes no difference."""
    patience: int = 8
    """Iterations between two changes of the duration, a multiple of `look`. 4: 0.8 % longer for 0.56 of the work; 16:
    0.4 % shorter for twice the work, and 91.9 % found."""
    look: int = 2
    """Iterations between two checks of the violation; 1 and 4 make no difference."""
    growth: float = 0.08
    """Relative growth of the duration per unit of relative violation. 0.16: 1 % longer for 0.68 of the work; 0.04:
    no shorter for 1.5 times the work."""
    least_growth: float = 0.003
    """Least growth. 0.0015: 0.4 % shorter for 1.18 of the work; 0.006: 0.6 % longer for 0.81."""
    greatest_growth: float = 0.08
    """Greatest growth, so that the duration does not overshoot from a first guess far too short. 0.04 and 0.16:
    within 0.15 %."""
    impatience: float = 1.076
    """Factor by which the least growth rises with every stage. 1: 0.25 % shorter for 1.1 of the work, 98.8 % found;
    1.15: 0.3 % longer for 0.93 of the work."""
    inside: float = 0.9985
    """Radius of the balls as a share of the limits: an iterate that converges to the smaller balls comes inside the
    limits after finitely many steps. 1 and 0.995: within 0.2 % of duration and 3 % of work."""
    height: float = 4.0
    """Weight of the heights against the velocities in the metric. 1: 0.1 % shorter for 1.13 of the work, 98.8 % found;
    8: 0.4 % longer for 0.94 of the work, and all returns found."""


TUNING: Final = Tuning()


class Band(NamedTuple):
    """Bounds of the position relative to the start, at the borders between the pieces; kept to 10 um.

    `fall`, `clear` and `by` keep a hand off an object that leaves the start with the start's velocity, which must then
    lie in the plane of x and z: the hand stays above the object until `by`, and behind the object from then on. Both
    bounds are linear in the jerks, so the search has no decision to make.

    Attributes:
        low: least height (N,) [m].
        high: greatest height (N,) [m].
        fall: downward acceleration of the object (N,) [m/s2].
        clear: distance behind the object along x (N,) [m]; 0 for no object.
        by: time from which the hand is behind the object (N,) [s].
    """

    low: Floats
    high: Floats
    fall: Floats
    clear: Floats
    by: Floats

    @classmethod
    def level(cls, low: Floats, high: Floats) -> Band:
        """Return a band of heights between two bounds (N,) [m], without an object."""
        zero = np.zeros_like(low)
        return cls(low, high, zero, zero, zero)


class Problem(NamedTuple):
    """N transfers: displacement at time 0, drift of the end, end velocities, last acceleration, limits, band."""

    way: Floats
    drift: Floats
    before: Floats
    after: Floats
    braking: Floats
    bounds: Floats
    band: Band


@final
class Matrices:
    """Constant matrices of the iteration for one ratio of duration to A / J.

    A row of the iteration holds, for each axis, jerks, accelerations, velocities and heights in units of T, with
    weights that bring the balls' radii to the order of one.
    """

    def __init__(self, scale: float) -> None:
        self.pieces = pieces = FEW_PIECES if scale < SHORT else PIECES
        jerk = np.eye(pieces)
        a, v, p = (np.zeros((pieces + 1, pieces)) for _ in range(3))
        step = 1.0 / pieces
        for k in range(pieces):
            # Rows: effect of a unit jerk in each piece on the states at the borders, from rest, in units of T.
            p[k + 1] = p[k] + step * (v[k] + step * (a[k] / 2.0 + step * jerk[k] / 6.0))
            v[k + 1] = v[k] + step * (a[k] + step * jerk[k] / 2.0)
            a[k + 1] = a[k] + step * jerk[k]
        middle = v[:-1] + step * a[:-1] / 2.0
        # Velocities at the borders are means of the velocities in the middles, so only the middles need a bound.
        rows = (jerk, a[1:-1], middle, p[1:-1])
        # In units of A / J: |j| <= J, |a| <= A, |v| <= V with V / A about 5 / 4 of A / J, as for the T3KR robot.
        weights = np.array([1.0 / scale**3, 1.0 / scale**2, 0.8 / scale, TUNING.height / scale])
        self.kind = np.repeat(np.arange(4), [len(part) for part in rows])
        self.weight = weights[self.kind]
        full = np.concatenate(rows) * self.weight[:, None]
        ends = np.stack([p[-1], v[-1], a[-1]])
        basis, _ = np.linalg.qr(ends.T, mode="complete")
        self.null: Floats = basis[:, 3:]
        self.ends: Floats = np.asarray(np.linalg.pinv(ends), dtype=np.float64)
        self.least: Floats = full @ self.ends
        reach = full @ self.null
        self.reach: Floats = reach
        self.back: Floats = np.asarray(np.linalg.pinv(reach), dtype=np.float64)
        self.share = np.arange(1, pieces) / pieces
        # Contribution of the start's velocity, in units of T, to velocities and heights.
        carried = np.concatenate([np.zeros(2 * pieces - 1), np.ones(pieces), self.share])
        self.carried = carried * self.weight
        self.balls = int((self.kind < 3).sum())


@cache
def matrices(kind: int) -> Matrices:
    """Return the matrices for durations around `SCALES[kind]`."""
    return Matrices(float(SCALES[kind]))


class _Block(NamedTuple):
    """A block at its current durations: ends, row of the motion of least jerk, inverse square radii, bounds."""

    ends: Floats
    row: Singles
    inverse: Singles
    low: Singles
    high: Singles
    far: Singles


class _State(NamedTuple):
    """State of the iteration: durations (B,) and iterates (B, 3, columns)."""

    time: Floats
    iterate: Singles


def search(m: Matrices, problem: Problem, first: Floats) -> tuple[Floats, Floats]:
    """Return durations (N,) [s] and jerks (N, K, 3) [m/s3] of feasible motions; NaN and zero where the search fails.

    Args:
        m: matrices of about the right duration.
        problem: N transfers.
        first: durations to begin with (N,) [s].
    """
    count, columns = len(first), len(m.weight)
    duration, jerks = np.full(count, np.nan), np.zeros((count, m.pieces, 3))
    times, iterates = first.copy(), np.zeros((count, 3, columns), dtype=np.float32)
    for stage in range(TUNING.stages):
        size = TUNING.tail_block if stage >= TUNING.tail else TUNING.block
        rows = np.flatnonzero(np.isnan(duration) & (times <= TUNING.hopeless * first))
        for begin in range(0, rows.size, size):
            part = rows[begin : begin + size]
            block_rows = np.concatenate([part, np.repeat(part[-1:], size - part.size)])
            state = _State(times[block_rows], iterates[block_rows])
            time, jerk, after = _iterate(m, take(problem, block_rows), state, stage)
            duration[part], jerks[part] = time[: part.size], jerk[: part.size]
            times[part], iterates[part] = after.time[: part.size], after.iterate[: part.size]
    return duration, jerks


def _iterate(m: Matrices, problem: Problem, state: _State, stage: int) -> tuple[Floats, Floats, _State]:
    """Run one stage for a block: durations (NaN where unsolved) and jerks of its motions, and the iteration's state."""
    time, iterate = state
    durations, jerks = np.full(len(time), np.nan), np.zeros((len(time), m.pieces, 3))
    block = _scale_block(m, problem, time)
    if stage == 0:
        # Begin with the motion of least jerk.
        iterate = block.row.copy()
    least = TUNING.least_growth * TUNING.impatience**stage
    violation = np.ones(len(time))
    for step in range(1, TUNING.stage + 1):
        inner = _product(iterate - block.row, m.back)
        point = block.row + _product(inner, m.reach).astype(np.float32)
        if step % TUNING.look == 0:
            violation = _violation(m, block, point)
            new = (violation <= 1.0 - TUNING.rounding) & np.isnan(durations)
            if new.any():
                durations[new] = time[new]
                total = _product(block.ends, m.ends) + _product(inner, m.null)
                jerks[new] = (total / time[:, None, None] ** 3)[new].transpose(0, 2, 1)
                if not np.isnan(durations).any():
                    break
        reflected = 2.0 * point
        reflected -= iterate
        iterate -= point
        iterate += _project(m, block, reflected)
        if step % TUNING.patience == 0:
            growth = 1.0 + np.clip(TUNING.growth * (violation - 1.0), least, TUNING.greatest_growth)
            time = time * growth
            iterate *= (growth[:, None] ** (3.0 - np.minimum(m.kind, 3)))[:, None].astype(np.float32)
            if step < TUNING.stage:
                block = _scale_block(m, problem, time)
    return durations, jerks, _State(time, iterate)


def _product(rows: Floats | Singles, matrix: Floats) -> Floats:
    """Matrix applied to the last axis of (B, 3, columns), as one product for the whole block.

    The product is in double precision: in single precision a row's bits would depend on the row's place in the block.
    """
    flat = rows.reshape(3 * len(rows), -1).astype(np.float64, copy=False)
    return (flat @ matrix.T).reshape(len(rows), 3, -1)


def _scale_block(m: Matrices, problem: Problem, time: Floats) -> _Block:
    """The block at its current durations (B,), in the weighted units of the iteration."""
    t = time[:, None]
    # Relative to a motion with the velocity of the start, which adds its way in `carried`.
    way = problem.way + t * problem.drift - t * problem.before
    ends = np.stack([way, t * (problem.after - problem.before), t**2 * problem.braking], axis=-1)
    row = _product(ends, m.least) + (t * problem.before)[..., None] * m.carried
    powers = np.stack([time, time**2, time**3], axis=1)
    radius = (problem.bounds * powers)[:, ::-1][:, np.minimum(m.kind[: m.balls], 2)] * m.weight[: m.balls]
    # Bounds at the borders (B, K - 1): least and greatest height, greatest x.
    band, weight, since = problem.band, m.weight[m.balls :], t * m.share
    tracked = (band.clear > 0.0)[:, None]
    falling = problem.before[:, 2:] * since - 0.5 * band.fall[:, None] * since**2
    near = tracked & (since < band.by[:, None])
    low = np.where(near, np.maximum(band.low[:, None], falling), band.low[:, None])
    behind_object = problem.before[:, :1] * since - band.clear[:, None]
    far = np.where(tracked & ~near, behind_object, np.inf)
    high = np.broadcast_to(band.high[:, None], since.shape)
    parts = (row, 1.0 / radius**2, low * weight, high * weight, far * weight)
    singles: list[Singles] = [part.astype(np.float32) for part in parts]
    return _Block(ends, *singles)


def _squares(rows: Singles) -> Singles:
    x, y, z = rows[:, 0], rows[:, 1], rows[:, 2]
    return np.asarray(x * x + y * y + z * z, dtype=np.float32)


def _violation(m: Matrices, block: _Block, point: Singles) -> Floats:
    """Largest ratio of jerk, acceleration and velocity to the limits (B,); above 1 also where a bound is broken."""
    ratio = np.sqrt((_squares(point[..., : m.balls]) * block.inverse).max(axis=1))
    ahead, height = point[:, 0, m.balls :], point[:, 2, m.balls :]
    out = np.maximum(np.maximum(block.low - height, height - block.high), ahead - block.far).max(axis=1)
    return np.maximum(ratio, np.where(out > TUNING.rounding, 1.0 + out, 0.0)).astype(np.float64)


def _project(m: Matrices, block: _Block, rows: Singles) -> Singles:
    """Project `rows` in place onto the balls and bounds."""
    over = np.maximum(_squares(rows[..., : m.balls]) * block.inverse * TUNING.inside**-2, 1.0)
    rows[..., : m.balls] /= np.sqrt(over)[:, None]
    np.clip(rows[:, 2, m.balls :], block.low, block.high, out=rows[:, 2, m.balls :])
    np.minimum(rows[:, 0, m.balls :], block.far, out=rows[:, 0, m.balls :])
    return rows
