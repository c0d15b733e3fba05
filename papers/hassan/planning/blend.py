"""Straight moves joined into one path, where each move may start while the previous move comes to rest.

A move is seven segments of constant jerk along a straight line (Hassan et al. 2022, Eq. 1): three segments to gain
speed, a cruise, and three segments to come to rest. Overlapping moves are added up. The sum has constant jerk between
the merged segment borders, so the sum is an exact ``JerkTrajectory`` without sampling.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import pairwise
from typing import Literal, TypeAlias, get_args

import numpy as np

from pnt_gym.arrays import Floats, concatenate_records
from pnt_gym.errors import PlanningError
from pnt_gym.names import unknown_name
from pnt_gym.planning.motion.limits import MotionLimits
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.scurve import accelerate, brake, speed_at
from pnt_gym.planning.motion.trajectory import JerkTrajectory

Overlap: TypeAlias = Literal["none", "jerk", "ramp"]
"""Overlap of a move with the previous move: none, one jerk phase, or one whole ramp."""

MOVE_SEGMENTS = 7
"""Segments of a move: three up to speed, one cruise, three back to rest."""

RELEASE_SEGMENTS = 4
"""Segments of a throw up to its release."""

# Number of segments of a move that may overlap the next move.
_OVERLAPPING = {"none": 0, "jerk": 1, "ramp": 3}
# Greatest difference of two coinciding borders by rounding [s]; no segment of a robot's motion is this short.
_SAME_TIME = 1e-12


def throw_move(direction: Floats, distance: Floats, limits: MotionLimits) -> Segments:
    """Return a throw that brakes at once after its release: seven segments, the release after the fourth.

    Args:
        direction: unit vectors (N, 3) of the throws.
        distance: ways from the pick to the release (N,) [m]; a row of 0 rests.
        limits: largest speed, acceleration and jerk.
    """
    up = accelerate(direction, distance, limits)
    down = brake(direction, speed_at(distance, limits), limits)
    return concatenate_records([up, down], axis=1)


def begin_times(moves: Sequence[Segments], overlap: Overlap, stops: Collection[int] = ()) -> Floats:
    """Return the begin time of each of M moves, (N, M) [s].

    Two moves overlap by the shorter of two times: the first move's deceleration and the second move's acceleration.
    These are whole ramps for "ramp" and the outermost jerk phases for "jerk".

    Args:
        moves: M moves of seven segments, N rows each.
        overlap: overlap of neighbouring moves.
        stops: indices of the moves that come to rest before the next move begins.

    Raises:
        ValueError: if there is no move, a move has not seven segments, or the rule is unknown.
    """
    _check_moves(moves, overlap)
    pieces = _OVERLAPPING[overlap]
    begins = [np.zeros(moves[0].durations.shape[0])]
    for index, (move, following) in enumerate(pairwise(moves)):
        begin = begins[-1] + move.durations.sum(axis=1)
        if pieces and index not in stops:
            way_down = move.durations[:, -pieces:].sum(axis=1)
            begin = begin - np.minimum(way_down, following.durations[:, :pieces].sum(axis=1))
        begins.append(begin)
    return np.stack(begins, axis=1)


def blend(start: Floats, moves: Sequence[Segments], begins: Floats) -> JerkTrajectory:
    """Return the sum of M moves as one path from ``start`` (N, 3) [m]; the moves begin at ``begins`` (N, M) [s]."""
    borders = [
        begins[:, m, None] + np.concatenate([np.zeros((len(start), 1)), np.cumsum(move.durations, axis=1)], axis=1)
        for m, move in enumerate(moves)
    ]
    times = _merge_close(np.sort(np.concatenate(borders, axis=1), axis=1))
    middle = 0.5 * (times[:, 1:] + times[:, :-1])
    jerks = np.zeros((*middle.shape, 3))
    for border, move in zip(borders, moves, strict=True):
        for k in range(move.durations.shape[1]):
            active = (middle >= border[:, k, None]) & (middle < border[:, k + 1, None])
            jerks += np.where(active[:, :, None], move.jerks[:, k, None, :], 0.0)
    return JerkTrajectory(start, np.diff(times, axis=1), jerks)


def _merge_close(times: Floats) -> Floats:
    """Sorted times (N, B) in which times that differ by rounding are replaced by the earliest of them."""
    distinct = np.diff(times, axis=1, prepend=-np.inf) > _SAME_TIME
    return np.maximum.accumulate(np.where(distinct, times, -np.inf), axis=1)


def _check_moves(moves: Sequence[Segments], overlap: Overlap) -> None:
    if overlap not in get_args(Overlap):
        raise PlanningError(unknown_name("overlap", overlap, get_args(Overlap)))
    if not moves:
        raise PlanningError("a path needs at least one move, got none")
    for move in moves:
        if move.durations.shape[1] != MOVE_SEGMENTS:
            raise PlanningError(f"a move has {MOVE_SEGMENTS} segments, got {move.durations.shape[1]}")
