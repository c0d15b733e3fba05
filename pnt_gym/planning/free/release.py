"""Release points and velocities of throws in a free direction.

For a given velocity the drag-free flight to the target fixes the release point, so elevation, speed and height remain
to be chosen. A coarse grid of choices, then a finer grid around the best choice at each of two heights, is compared by
the estimated time of throw and return, which is a formula. The optimum is flat: a few degrees cost less than one
percent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, finite_rows, length, take
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.free.approach import SPEEDING, Entry
from pnt_gym.planning.free.rules import HandRules
from pnt_gym.planning.motion.limits import LimitRows, Limits
from pnt_gym.planning.motion.scurve import brake_distance
from pnt_gym.planning.motion.transfer import estimate
from pnt_gym.planning.straight.frame import Frame
from pnt_gym.planning.straight.plan import MIN_REACH

TURN: Final = 1.6
"""Way of a hand that turns back, as a multiple of the shortest stop."""
RUN_UP: Final = 1.15
"""Vertical run-up as a multiple of the shortest, which would leave no acceleration for the horizontal run-up."""


def _grid(*axes: list[float]) -> Floats:
    """All combinations (3, C)."""
    return np.stack(np.meshgrid(*(np.array(axis) for axis in axes), indexing="ij")).reshape(3, -1)


COARSE: Final = tuple(
    _grid([float(np.deg2rad(e)) for e in range(10, 61, 10)], [SPEEDING, 0.9, 0.8, 0.6], [height])
    for height in (1.0, 0.7)
)
"""Elevation [rad], share of the speed limit, and release height as a share of the way from the pick to the ceiling."""
FINE: Final = _grid([-0.087, 0.0, 0.087], [-0.05, 0.0, 0.05], [-0.15, 0.0, 0.15])
"""Steps in elevation, speed and height around the best coarse choice."""
CHUNK: Final = 512
"""Rows whose choices are compared together, to bound memory."""
CAUTION: Final = 1.15
"""Multiple of the estimated rise after the release that has to fit below the cap: the next pick is not known yet."""


@final
@dataclass(frozen=True, eq=False)
class FreeReleases:
    """N releases; NaN in rows without a release.

    Attributes:
        position: release points (N, 3) [m].
        velocity: release velocities (N, 3) [m/s].
        flight_time: times from release to target (N,) [s].
        feasible: whether the row holds a release (N,).
    """

    position: Floats
    velocity: Floats
    flight_time: Floats
    feasible: Bools


def free_releases(
    picks: ArrayLike,
    targets: ArrayLike,
    limits: Limits,
    *,
    ceiling: ArrayLike,
    rules: HandRules,
) -> FreeReleases:
    """Choose releases in the vertical planes of picks and targets, on the assumption that hands return to their picks.

    Args:
        picks: positions of the resting hands (N, 3) [m].
        targets: points through which the objects have to come down (N, 3) [m].
        limits: largest speed, acceleration and jerk.
        ceiling: greatest height of the release [m], one number or (N,).
        rules: approach, window, cap and workspace.

    Raises:
        ValueError: an input is NaN or infinite, or shapes disagree.
    """
    frame = Frame.of(picks, targets)
    count = len(frame.picks)
    rows = limits.arrays(count)
    roof = finite_rows(ceiling, count, "ceiling")
    chosen, cost = np.zeros((3, count)), np.full(count, np.inf)
    for begin in range(0, count, CHUNK):
        part = np.arange(begin, min(begin + CHUNK, count))
        few = take(frame, part), take(rows, part), roof[part], rules
        around: list[Floats] = []
        for coarse in COARSE:
            first, _ = _choose(*few, np.repeat(coarse[:, None], len(part), axis=1))
            around.append(first[:, :, None] + FINE[:, None])
        fine = np.concatenate(around, axis=2)
        fine[1:] = np.minimum(fine[1:], np.array([SPEEDING, 1.0])[:, None, None])
        chosen[:, part], cost[part] = _choose(*few, fine)
    position, velocity, flight = _release(frame, rows.velocity, chosen, roof)
    feasible = np.isfinite(cost) & (frame.reach > MIN_REACH) & (frame.picks[:, 2] <= roof)
    gap = np.where(feasible, 0.0, np.nan)
    return FreeReleases(position + gap[:, None], velocity + gap[:, None], flight + gap, feasible)


def _choose(frame: Frame, limits: LimitRows, roof: Floats, rules: HandRules, choices: Floats) -> tuple[Floats, Floats]:
    """Quickest of each row's choices (3, N, C), and its estimated time (N,) [s]; all choices of all rows at once."""
    _, count, choice_count = choices.shape
    # Row i, choice c is row i C + c.
    index = np.arange(count, dtype=np.int64)
    rows = np.repeat(index, choice_count)
    row_limits = take(limits, rows)
    position, velocity, flight = _release(take(frame, rows), row_limits.velocity, choices.reshape(3, -1), roof[rows])
    room = greatest_height(roof, rules)[rows] - position[:, 2]
    good = (flight > 0.0) & (CAUTION * _rise(velocity, row_limits, rules) <= room)
    falling = Entry.of(limits, count, rules.approach).velocity[rows]
    picks = frame.picks[rows]
    above, start = picks + np.array([0.0, 0.0, rules.approach]), position + rules.window * velocity
    time = estimate(position - picks, np.zeros_like(picks), velocity, row_limits)
    time = time + estimate(above - start, velocity, falling, row_limits)
    # Height that the hand needs to gain its upward speed without going below the pick.
    run_up = RUN_UP * brake_distance(np.maximum(velocity[:, 2], 0.0), row_limits)
    good &= position[:, 2] - picks[:, 2] >= run_up
    if rules.workspace is not None:
        turn = turning_point(start, velocity, row_limits)
        good &= rules.workspace.contains(position) & rules.workspace.contains(turn)
    cost = np.where(good, time, np.inf).reshape(count, choice_count)
    best = cost.argmin(axis=1)
    return choices[:, index, best], cost[index, best]


def turning_point(start: Floats, velocity: Floats, limits: Limits) -> Floats:
    """Return estimated turning points (N, 3) [m] of hands that turn back from ``velocity`` at ``start``.

    A hand that turns back goes farther than a hand that brakes, because it must not fall onto the object meanwhile.
    """
    level = velocity * np.array([1.0, 1.0, 0.0])
    speed = length(level)
    way = TURN * brake_distance(speed, limits) / np.maximum(speed, 1e-12)
    return start + level * way[:, None]


def _release(frame: Frame, fastest: Floats, choice: Floats, roof: Floats) -> tuple[Floats, Floats, Floats]:
    """Position (N, 3), velocity (N, 3) and flight time (N,) of releases with a choice (3, N) each.

    The flight time is 0 where the object never comes down to the target's height.
    """
    elevation, share, height = choice
    speed = share * fastest
    low = frame.picks[:, 2]
    start = low + height * np.maximum(roof - low, 0.0)
    rise, level = speed * np.sin(elevation), speed * np.cos(elevation)
    drop = start - (low + frame.rise)
    # The later time at which the object is at the target's height.
    square = rise * rise + 2.0 * GRAVITY * drop
    flight = np.where(square > 0.0, (rise + np.sqrt(np.maximum(square, 0.0))) / GRAVITY, 0.0)
    along = frame.reach - level * flight
    position = np.stack([low * 0.0 + along * frame.cosine, along * frame.sine, start], axis=1)
    position[:, :2] += frame.picks[:, :2]
    return position, np.stack([level * frame.cosine, level * frame.sine, rise], axis=1), flight


def greatest_height(ceiling: Floats, rules: HandRules) -> Floats:
    """Return the greatest height of the hand (N,) [m], the lower of cap and workspace."""
    workspace_top = np.inf if rules.workspace is None else rules.workspace.z_max
    return np.minimum(ceiling + rules.hand_cap, workspace_top)


def clearing_time(limits: Limits, count: int, distance: float) -> Floats:
    """Return the estimated least time (N,) [s] in which a braking hand falls ``distance`` [m] behind its object."""
    velocity, acceleration, jerk = limits.arrays(count)
    # Greatest speed between hand and object, a little below twice the limit: both move in opposite directions.
    separation_speed = 1.8 * velocity
    growing = np.minimum(np.sqrt(2.0 * distance / acceleration), separation_speed / acceleration)
    remaining_distance = distance - 0.5 * acceleration * growing**2
    return growing + np.maximum(remaining_distance, 0.0) / separation_speed + 0.5 * acceleration / jerk


def _rise(velocity: Floats, limits: LimitRows, rules: HandRules) -> Floats:
    """Estimated rise (N,) [m] of the hand after the release.

    Until the hand is clear sideways it must not fall faster than the margin allows; then the hand brakes.
    """
    _, acceleration, jerk = limits
    clear = clearing_time(limits, len(velocity), rules.clear_distance)
    fall = (1.0 - rules.margin) * GRAVITY
    up = np.maximum(velocity[:, 2], 0.0)
    rise_time = np.minimum(clear, up / fall)
    speed = up - fall * rise_time
    braking_rise = speed * (0.5 * speed / acceleration + 0.25 * acceleration / jerk)
    return rules.window * up + rise_time * (up - 0.5 * fall * rise_time) + braking_rise
