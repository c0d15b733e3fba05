"""Paths and phase times of cycles, from the moves of each cycle."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Bools, Floats, concatenate_records, replace_rows, take
from pnt_gym.planning.motion.limits import EllipticWorkspace, MotionLimits
from pnt_gym.planning.motion.trajectory import JerkTrajectory, Segments

from ...common.fastest import fastest_motion
from .blend import RELEASE_SEGMENTS, Overlap, begin_times, blend


class Outline(NamedTuple):
    """Moves of N cycles before the moves are timed.

    Attributes:
        picks: starts of the cycles (N, 3) [m].
        next_picks: ends of the cycles (N, 3) [m].
        moves_to_release: the moves by name up to and including the place or the throw.
        moves_back: the moves by name after the place or the throw.
        is_throw: whether the last of ``moves_to_release`` is a throw; otherwise the last move ends in a place.
        position: release points (N, 3) [m].
        velocity: release velocities (N, 3) [m/s].
        lift: vertical part right after the place [m].
        drop: vertical part at the end [m].
        feasible: whether the row holds a plan (N,); the moves of infeasible rows take no time.
    """

    picks: Floats
    next_picks: Floats
    moves_to_release: dict[str, Segments]
    moves_back: dict[str, Segments]
    is_throw: bool
    position: Floats
    velocity: Floats
    lift: float
    drop: float
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


def fastest_return(outline: Outline, limits: MotionLimits, workspace: EllipticWorkspace | None) -> TimedCycles:
    """Cycles that stop after every move up to the release or the place, and return by the fastest motion."""
    parts = list(outline.moves_to_release.values())
    if outline.is_throw:
        throw = parts.pop()
        parts.append(take(throw, np.s_[:, :RELEASE_SEGMENTS]))
    ends = np.cumsum(np.stack([part.durations.sum(axis=1) for part in parts], axis=1), axis=1)
    rows = [_return_segments(outline, int(row), limits, workspace) for row in np.flatnonzero(outline.feasible)]
    path = JerkTrajectory.concatenate(outline.picks, [*parts, _stack_segments(rows, outline.feasible)])
    phase_ends = np.concatenate([ends, path.duration[:, None]], axis=1)
    return TimedCycles(path, (*outline.moves_to_release, "return"), phase_ends, ends[:, -1])


def _return_segments(outline: Outline, row: int, limits: MotionLimits, workspace: EllipticWorkspace | None) -> Segments:
    motion = fastest_motion(
        outline.position[row],
        outline.next_picks[row],
        take(limits, row),
        lift=outline.lift,
        drop=outline.drop,
        start_velocity=outline.velocity[row] if outline.is_throw else None,
        workspace=workspace,
    )
    return Segments(motion.durations, motion.jerks)


def _stack_segments(rows: list[Segments], feasible: Bools) -> Segments:
    """Segments of single rows as one batch, shorter rows padded with segments of no time; infeasible rows rest."""
    columns = max((row.durations.shape[1] for row in rows), default=1)
    empty = Segments(np.zeros((len(feasible), columns)), np.zeros((len(feasible), columns, 3)))
    return replace_rows(empty, feasible, concatenate_records([row.pad(columns) for row in rows])) if rows else empty
