"""Paths and phase times of cycles, from the moves of each cycle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.trajectory import JerkTrajectory

from .blend import RELEASE_SEGMENTS, Overlap, begin_times, blend


class Outline(NamedTuple):
    """Moves of N cycles before the moves are timed.

    Attributes:
        picks: starts of the cycles (N, 3) [m].
        moves_to_release: the moves by name up to and including the place or the throw.
        moves_back: the moves by name after the place or the throw.
        is_throw: whether the last of ``moves_to_release`` is a throw; otherwise the last move ends in a place.
        position: release points (N, 3) [m].
        velocity: release velocities (N, 3) [m/s].
        feasible: whether the row holds a plan (N,); the moves of infeasible rows take no time.
    """

    picks: Floats
    moves_to_release: dict[str, Segments]
    moves_back: dict[str, Segments]
    is_throw: bool
    position: Floats
    velocity: Floats
    feasible: Bools


class TimedCycles(NamedTuple):
    """Path of N cycles, names and end times (N, P) [s] of their phases, and release times (N,) [s]."""

    path: JerkTrajectory
    phases: tuple[str, ...]
    phase_ends: Floats
    release_time: Floats


def straight_return(outline: Outline, overlap: Overlap) -> TimedCycles:
    """Cycles of straight moves alone: the hand rests at the place and at the next pick, elsewhere moves may overlap."""
    moves = [*outline.moves_to_release.values(), *outline.moves_back.values()]
    last = len(outline.moves_to_release) - 1
    begins = begin_times(moves, overlap, () if outline.is_throw else (last,))
    ends = begins + np.stack([move.durations.sum(axis=1) for move in moves], axis=1)
    names = list(outline.moves_to_release) + list(outline.moves_back)
    release_time = ends[:, last]
    if outline.is_throw:
        release_time = begins[:, last] + moves[last].durations[:, :RELEASE_SEGMENTS].sum(axis=1)
        ends = np.insert(ends, last, release_time, axis=1)
        names.insert(last + 1, "brake")
    return TimedCycles(blend(outline.picks, moves, begins), tuple(names), ends, release_time)
