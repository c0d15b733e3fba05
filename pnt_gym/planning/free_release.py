"""Where and how fast to let go when hand and object may part in any direction.

For a given velocity the drag-free flight to the target fixes the release point. Elevation, speed and height are left to
choose; a grid of them is compared by the estimated time of the two motions they join, which is a formula. The best
choice is flat: a few degrees cost less than one percent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.planning._frame import Frame
from pnt_gym.planning.approach import SPEEDING, approach_entry
from pnt_gym.planning.arrays import Bools, Floats, Ints, finite_points, finite_rows, length
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.planning.free_rules import HandRules
from pnt_gym.planning.limits import MotionLimits
from pnt_gym.planning.plan import MIN_REACH
from pnt_gym.planning.segments import brake_distance
from pnt_gym.planning.transfer import estimate

TURN: Final = 1.6
"""Way of a hand that turns back, as a multiple of the shortest stop."""
RUN_UP: Final = 1.15
"""Share of the shortest vertical run-up, which would leave no acceleration for the horizontal one."""
_ELEVATIONS: Final = np.deg2rad(np.arange(10.0, 66.0, 4.0))
_SHARES: Final = np.array([SPEEDING, 0.9, 0.8, 0.7, 0.6, 0.5])
_HEIGHTS: Final = np.array([1.0, 0.5])
"""Release heights as shares of the way from the pick to the ceiling."""
CHOICES: Final = np.stack(np.meshgrid(_ELEVATIONS, _SHARES, _HEIGHTS, indexing="ij")).reshape(3, -1)


@final
@dataclass(frozen=True, eq=False)
class FreeReleases:
    """N releases; NaN in rows without one.

    Attributes:
        position: release points (N, 3) [m].
        velocity: release velocities (N, 3) [m/s].
        flight_time: from release to target (N,) [s].
        feasible: whether the row holds a release (N,).
    """

    position: Floats
    velocity: Floats
    flight_time: Floats
    feasible: Bools


def free_releases(
    picks: ArrayLike,
    targets: ArrayLike,
    limits: MotionLimits,
    *,
    ceiling: ArrayLike,
    tolerance: ArrayLike = 0.0,
    next_picks: ArrayLike | None = None,
    rules: HandRules | None = None,
) -> FreeReleases:
    """Choose releases in the vertical planes of picks (N, 3) and targets (N, 3) [m].

    Args:
        picks: where the hands rest (N, 3) [m].
        targets: where the objects have to come down (N, 3) [m].
        limits: largest speed, acceleration and jerk.
        ceiling: greatest height of the release [m], one number or (N,).
        tolerance: the throw is aimed that much short of the target, as in `plan_release` [m].
        next_picks: where the hands go afterwards (N, 3) [m]; back to their pick when not given.
        rules: approach, window and workspace.

    Raises:
        ValueError: an input is NaN or infinite, a tolerance is negative, or shapes disagree.
    """
    rules = HandRules() if rules is None else rules
    frame = Frame.of(picks, targets, limits, tolerance)
    count = frame.size
    roof = finite_rows(ceiling, count, "ceiling")
    goal = frame.picks if next_picks is None else finite_points(next_picks, "next_picks")
    # All choices of all rows at once: row i, choice c is row i C + c.
    each = np.repeat(np.arange(count), CHOICES.shape[1])
    tried = _release(_rows(frame, each), np.tile(CHOICES, count), roof[each])
    cost = _cost(frame.picks[each], tried, goal[each], limits.take(each), rules).reshape(count, -1)
    best = cost.argmin(axis=1)
    chosen = best + CHOICES.shape[1] * np.arange(count)
    position, velocity, flight = (value[chosen] for value in tried)
    feasible = np.isfinite(cost[np.arange(count), best]) & (frame.plane.reach > MIN_REACH) & (frame.picks[:, 2] <= roof)
    gap = np.where(feasible, 0.0, np.nan)
    return FreeReleases(position + gap[:, None], velocity + gap[:, None], flight + gap, feasible)


def turning_point(start: Floats, velocity: Floats, limits: MotionLimits) -> Floats:
    """Return about how far (N, 3) [m] a hand gets that turns back from ``velocity`` at ``start``.

    It goes farther than a hand that just brakes, because it must not fall onto the object meanwhile.
    """
    level = velocity * np.array([1.0, 1.0, 0.0])
    speed = length(level)
    way = TURN * brake_distance(speed, limits) / np.maximum(speed, 1e-12)
    return start + level * way[:, None]


def _rows(frame: Frame, rows: Ints) -> Frame:
    return Frame(frame.picks[rows], frame.cosine[rows], frame.sine[rows], frame.plane.take(rows))


def _release(frame: Frame, choice: Floats, roof: Floats) -> tuple[Floats, Floats, Floats]:
    """Position (N, 3), velocity (N, 3) and flight time (N,) of one choice; flight 0 where the target is not reached."""
    elevation, share, height = choice
    speed = share * frame.plane.velocity
    low = frame.picks[:, 2]
    start = low + height * np.maximum(roof - low, 0.0)
    rise, level = speed * np.sin(elevation), speed * np.cos(elevation)
    drop = start - (low + frame.plane.rise)
    square = rise * rise + 2.0 * GRAVITY * drop
    flight = np.where(square > 0.0, (rise + np.sqrt(np.maximum(square, 0.0))) / GRAVITY, 0.0)
    along = frame.plane.reach - level * flight
    position = np.stack([low * 0.0 + along * frame.cosine, along * frame.sine, start], axis=1)
    position[:, :2] += frame.picks[:, :2]
    return position, np.stack([level * frame.cosine, level * frame.sine, rise], axis=1), flight


def _cost(
    picks: Floats, release: tuple[Floats, Floats, Floats], goal: Floats, limits: MotionLimits, rules: HandRules
) -> Floats:
    """Estimated time (N,) of throw and return [s]; infinite where no object or no hand can go."""
    position, velocity, flight = release
    falling = approach_entry(limits, len(picks), rules.approach).velocity
    above = goal + np.array([0.0, 0.0, rules.approach])
    start = position + rules.window * velocity
    cost = estimate(position - picks, np.zeros_like(picks), velocity, limits)
    cost = cost + estimate(above - start, velocity, falling, limits)
    good = (flight > 0.0) & (_rise(velocity, limits, rules) <= rules.hand_cap)
    # Without going below the pick, the hand needs this much height to gain its upward speed.
    good &= position[:, 2] - picks[:, 2] >= RUN_UP * brake_distance(np.maximum(velocity[:, 2], 0.0), limits)
    if rules.workspace is not None:
        turn = turning_point(start, velocity, limits)
        good &= rules.workspace.contains(position) & rules.workspace.contains(turn)
    return np.where(good, cost, np.inf)


def _rise(velocity: Floats, limits: MotionLimits, rules: HandRules) -> Floats:
    """How far about (N,) [m] the hand rises after the release.

    Until it is clear sideways it must not fall faster than the margin allows; then it brakes.
    """
    _, acceleration, jerk = limits.arrays(len(velocity))
    clear = np.sqrt(2.0 * rules.clear_distance / acceleration) + 0.5 * acceleration / jerk
    fall = (1.0 - rules.margin) * GRAVITY
    up = np.maximum(velocity[:, 2], 0.0)
    still = np.minimum(clear, up / fall)
    left = up - fall * still
    rest = left * (0.5 * left / acceleration + 0.25 * acceleration / jerk)
    return rules.window * up + still * (up - 0.5 * fall * still) + rest
