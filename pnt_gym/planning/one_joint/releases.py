"""All releases that reach a landing state, as roots of an equation in the angle a that the block turns in flight.

With a = omega t_f the release angle is theta = phi - a, and Eq. 11 of Miyashita et al. becomes

    g (1 + a^2 / 2) t^2 + dy (1 + a^2) t - a (a y + x) = 0,      S = y - dy t - g t^2 / 2,      X = x + a S,
    h(a) = S cos(theta) - X sin(theta) - d = 0,                  r = X cos(theta) + S sin(theta) > 0,

where (X, S) is the centre of mass at the release. The quadratic gives at most two flight times t for an angle a,
so the roots lie on two branches. The branches meet where the quadratic's discriminant, of fourth degree in a,
vanishes, and a branch passes through t = 0 at a = 0 and a = -x / y. Between these borders h is smooth and is sampled;
each change of sign and each near touch of zero is refined to roots.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records, take
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.roots import bisect
from pnt_gym.planning.one_joint.flight import land, landing_jacobian

CELLS: Final = 40
"""Samples per half turn; neighbouring roots that are nearer than a sample are found as a near touch."""
BISECTIONS: Final = 20
"""Halvings of a root's interval before Newton's method."""
TOUCH_STEPS: Final = 24
POLISHES: Final = 5
EXACT: Final = 1e-13
"""Error of the landing state [m, rad, m/s] below which no further Newton step is needed."""
BETWEEN: Final = (0.1, 0.5, 0.9)
"""Additional samples of h, as shares of the way between neighbouring borders of smoothness."""
SMALL: Final = 1e-12
"""Smallest divisor: smaller divisors are replaced by this value, or their step is left out."""
TOUCH: Final = 5e-4
"""Samples of h this near zero [m] are always examined for a touch."""


class ReleaseRows(NamedTuple):
    """K releases: the row of their landing state (K,), u (K, 4) and the extra turns (K,)."""

    row: Ints
    u: Floats
    turns: Ints


class _Goals(NamedTuple):
    """Landing states and the half height d, broadcastable against the angles a."""

    x: Floats
    y: Floats
    phi: Floats
    dy: Floats
    d: float

    def with_turns(self, turns: Ints | int) -> _Goals:
        """The same goals with a number of extra whole turns."""
        return self._replace(phi=self.phi + 2.0 * np.pi * turns)


class _Intervals(NamedTuple):
    """Intervals of a that hold one root each, with their row, turns and branch."""

    row: Ints
    turns: Ints
    branch: Floats
    low: Floats
    high: Floats

    @classmethod
    def of(cls, row: Ints, turn: int, branch: Floats, *borders: Floats) -> _Intervals:
        """Intervals between neighbouring borders, all with the same number of turns."""
        turns = np.full(row.shape, turn, dtype=np.int64)
        return concatenate_records([cls(row, turns, branch, low, high) for low, high in pairwise(borders)])


def find_releases(z: Floats, half_height: float, angles: tuple[float, float], turns: Sequence[int]) -> ReleaseRows:
    """Return all releases with t_f > 0 and theta within ``angles`` that reach the landing states ``z`` (N, 4)."""
    x, y, phi, dy = (z[:, k, None, None] for k in range(4))
    goals = _Goals(x, y, phi, dy, half_height)
    borders = _borders(goals)
    cells = [_root_intervals(goals, borders, turn, angles) for turn in turns]
    intervals = concatenate_records(cells)
    goal = take(goals, (intervals.row, 0, 0)).with_turns(intervals.turns)
    below = _miss(goal, intervals.low, intervals.branch) < 0.0
    low, high = bisect(
        lambda a: (_miss(goal, a, intervals.branch) < 0.0) == below, intervals.low, intervals.high, BISECTIONS
    )
    u = _release(goal, 0.5 * (low + high), intervals.branch)
    u = _polish(u, z[intervals.row], intervals.turns, half_height)
    good = u[:, 3] > 0.0
    return ReleaseRows(intervals.row[good], u[good], intervals.turns[good])


def _flight_times(goal: _Goals, a: Floats, branch: Floats) -> tuple[Floats, Floats]:
    """Flight time t of the module's quadratic on a branch, and the discriminant.

    Where the discriminant is negative, both branches have the time of a zero discriminant.
    """
    square = a * a
    lead, linear = GRAVITY * (2.0 + square), goal.dy * (1.0 + square)
    last = a * (a * goal.y + goal.x)
    # `lead` is twice the quadratic's first coefficient, so that t = (branch sqrt(inside) - linear) / lead.
    inside = linear * linear + 2.0 * lead * last
    return (branch * np.sqrt(np.maximum(inside, 0.0)) - linear) / lead, inside


def _release_place(goal: _Goals, a: Floats, time: Floats) -> tuple[Floats, Floats]:
    """Return h and r [m]: the centre of mass at the release across the arm, less d, and along the arm."""
    up = goal.y - time * (goal.dy + 0.5 * GRAVITY * time)
    across = goal.x + a * up
    theta = goal.phi - a
    cosine, sine = np.cos(theta), np.sin(theta)
    return up * cosine - across * sine - goal.d, across * cosine + up * sine


def _miss(goal: _Goals, a: Floats, branch: Floats) -> Floats:
    return _release_place(goal, a, _flight_times(goal, a, branch)[0])[0]


def _root_intervals(goals: _Goals, borders: Floats, turn: int, angles: tuple[float, float]) -> _Intervals:
    """Intervals with a root; the arrays' axes are rows, the two branches and the angle (N, 2, M)."""
    goals = goals.with_turns(turn)
    low, high = goals.phi - angles[1], goals.phi - angles[0]
    count = max(8, int(np.ceil(CELLS * (angles[1] - angles[0]) / np.pi)))
    even = low + (high - low) * np.linspace(0.0, 1.0, count + 1)
    # Evenly spaced angles a and the borders of smoothness, sorted (N, 1, M).
    grid = np.sort(np.concatenate([even, np.clip(borders, low, high)], axis=2), axis=2)
    branch = np.array([[1.0], [-1.0]])
    value = _miss(goals, grid, branch)
    # Borders of smoothness are samples, so the middle of a cell decides whether the branch exists in the cell.
    time, inside = _flight_times(goals, 0.5 * (grid[..., 1:] + grid[..., :-1]), branch)
    valid = (inside >= 0.0) & (time > 0.0)
    change = valid & ((value[..., :-1] < 0.0) != (value[..., 1:] < 0.0))
    row, side, column = np.nonzero(change)
    plain = _Intervals.of(row, turn, branch[side, 0], grid[row, 0, column], grid[row, 0, column + 1])
    return concatenate_records([plain, *(find(goals, grid, value, valid, turn) for find in (_touches, _tips))])


def _borders(goals: _Goals) -> Floats:
    """Angles a (N, 1, 21) where the branches meet or a branch passes through t = 0, and some angles between them.

    The zeros of the discriminant are the eigenvalues of its companion matrix. A complex zero gives its real part, a
    superfluous but harmless border.
    """
    square, lift = goals.dy * goals.dy, 2.0 * GRAVITY * goals.y
    side = 2.0 * GRAVITY * goals.x
    # Coefficients of dy^2 (1 + a^2)^2 + 2 g (2 + a^2) a (a y + x), by falling powers of a.
    falling = np.concatenate([square + lift, side, 2.0 * (square + lift), 2.0 * side, square], axis=2)[:, 0]
    scale = np.maximum(np.abs(falling).max(axis=1, keepdims=True), SMALL)
    lead = np.where(np.abs(falling[:, :1]) > SMALL * scale, falling[:, :1], SMALL * scale)
    companion = np.zeros((falling.shape[0], 4, 4))
    companion[:, 0] = -falling[:, 1:] / lead
    companion[:, [1, 2, 3], [0, 1, 2]] = 1.0
    joints = np.asarray(np.linalg.eigvals(companion).real, dtype=np.float64)[:, None]
    level = np.where(np.abs(goals.y) > SMALL, goals.y, SMALL)
    borders = np.sort(np.concatenate([np.zeros_like(goals.x), -goals.x / level, joints], axis=2), axis=2)
    # Where two borders are close, even samples would miss roots between the borders.
    gaps = np.diff(borders, axis=2)
    return np.concatenate([borders, *(borders[..., :-1] + share * gaps for share in BETWEEN)], axis=2)


def _touches(goals: _Goals, grid: Floats, value: Floats, valid: Bools, turn: int) -> _Intervals:
    """Pairs of roots between samples of the same sign, on both sides of the extremum between the samples."""
    size, sign = np.abs(value), value < 0.0
    before, middle, after = size[..., :-2], size[..., 1:-1], size[..., 2:]
    dip = (middle <= before) & (middle <= after) & valid[..., :-1] & valid[..., 1:]
    dip &= (sign[..., :-2] == sign[..., 1:-1]) & (sign[..., 1:-1] == sign[..., 2:])
    # A parabola through the three samples dips at most this far below the middle one.
    dip &= (middle <= np.maximum(before, after) - middle) | (middle < TOUCH)
    row, side, column = np.nonzero(dip)
    low, high, branch = grid[row, 0, column], grid[row, 0, column + 2], np.where(side == 0, 1.0, -1.0)
    if not row.size:
        return _Intervals.of(row, turn, branch, low, high)
    goal = take(goals, (row, 0, 0))
    side_sign = np.where(sign[row, side, column + 1], -1.0, 1.0)
    bottom, least = _lowest(lambda a: side_sign * _miss(goal, a, branch), low, high)
    crossed = least < 0.0
    return _Intervals.of(row[crossed], turn, branch[crossed], low[crossed], bottom[crossed], high[crossed])


def _tips(goals: _Goals, grid: Floats, value: Floats, valid: Bools, turn: int) -> _Intervals:
    """Pairs of roots on a branch next to a meeting of the branches.

    Near a meeting, h is smooth in the square root s of the distance to the meeting; the sign of s is the branch.
    """
    has_branch = valid[:, 0] | valid[:, 1]
    row, column = np.nonzero(has_branch[:, :-1] != has_branch[:, 1:])
    joint, neighbour = column + 1, column + 2 * has_branch[row, column + 1].astype(np.int64)
    joint_value, above, below = value[row, 0, joint], value[row, 0, neighbour], value[row, 1, neighbour]
    near, far = np.minimum(np.abs(above), np.abs(below)), np.maximum(np.abs(above), np.abs(below))
    same_sign = ((joint_value < 0.0) == (above < 0.0)) & ((joint_value < 0.0) == (below < 0.0))
    size = np.abs(joint_value)
    # Two roots lie beside a meeting where h has one sign there and is nearer to 0 at the meeting than beside it.
    dip = same_sign & (size <= near) & ((size <= far - size) | (size < TOUCH))
    row, sign = row[dip], np.where(joint_value[dip] < 0.0, -1.0, 1.0)
    tip, way = grid[row, 0, joint[dip]], grid[row, 0, neighbour[dip]] - grid[row, 0, joint[dip]]
    if not row.size:
        return _Intervals.of(row, turn, tip, tip, tip)
    goal = take(goals, (row, 0, 0))
    s, least = _lowest(
        lambda s: sign * _miss(goal, tip + way * s * s, np.where(s < 0.0, -1.0, 1.0)),
        np.full(row.shape, -1.0),
        np.ones(row.shape),
    )
    crossed = least < 0.0
    row, s, tip, way = row[crossed], s[crossed], tip[crossed], way[crossed]
    return _Intervals.of(row, turn, np.where(s < 0.0, -1.0, 1.0), tip, tip + way * s * s, tip + way)


def _lowest(measure: Callable[[Floats], Floats], low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Places of the least value between ``low`` and ``high`` (K,), by golden section, and the values there."""
    ratio = 0.5 * (np.sqrt(5.0) - 1.0)
    for _ in range(TOUCH_STEPS):
        left, right = high - ratio * (high - low), low + ratio * (high - low)
        lower = measure(left) < measure(right)
        low, high = np.where(lower, low, left), np.where(lower, right, high)
    place = 0.5 * (low + high)
    return place, measure(place)


def _release(goal: _Goals, a: Floats, branch: Floats) -> Floats:
    """Releases (K, 4) at the roots; NaN where the block would be on the other side of the pivot."""
    time, _ = _flight_times(goal, a, branch)
    radius = _release_place(goal, a, time)[1]
    moving = time > 0.0
    speed = a / np.where(moving, time, 1.0)
    # l_t is the distance of the centre of mass from the pivot: r along the arm and d across.
    length = np.sqrt(radius * radius + goal.d * goal.d)
    u = np.stack([goal.phi - a, speed, length, time], axis=1)
    u[~(moving & (radius > 0.0))] = np.nan
    return u


def _polish(u: Floats, z: Floats, turns: Ints, half_height: float) -> Floats:
    """Refine releases (K, 4) by Newton's method on Eq. 11; a step is taken only if it reduces the error."""
    goal = z.copy()
    goal[:, 2] += 2.0 * np.pi * turns
    for _ in range(POLISHES):
        error = goal - land(u, half_height)
        index = np.nonzero((np.abs(error).max(axis=1) > EXACT) & (u[:, 2] > half_height))[0]
        if not index.size:
            break
        jacobian = landing_jacobian(u[index], half_height)
        index = index[np.abs(np.linalg.det(jacobian)) > SMALL]
        jacobian = landing_jacobian(u[index], half_height)
        better = u[index] + np.linalg.solve(jacobian, error[index, :, None])[..., 0]
        # A step to l_t <= d is left out: r = sqrt(l_t^2 - d^2) would not be real.
        better = np.where(better[:, 2:3] > half_height, better, u[index])
        gain = np.abs(goal[index] - land(better, half_height)).max(axis=1) < np.abs(error[index]).max(axis=1)
        u[index[gain]] = better[gain]
    return u
