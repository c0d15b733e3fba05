"""The quickest throw into the first of several targets that a robot can throw into, N objects together."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows
from pnt_gym.planning.straight.plan import ReleaseBatch
from pnt_gym.planning.straight.release import OPEN, release_lines, to_batch


class Rules(NamedTuple):
    """Rules of accepted throws.

    Attributes:
        window: time between the release and the braking, at constant velocity [s].
        gravity_share: share of gravity with which the hand may fall while braking; 0 for full braking.
        reserve: a target is accepted only with targets nearer and farther by this distance along the throw [m].
        workspace: positions that the hand can reach.
    """

    window: float
    gravity_share: float
    reserve: float
    workspace: EllipticWorkspace


class TargetChoice(NamedTuple):
    """Targets of N throws: index of each target, the releases, and which throws are accepted (N,)."""

    attempt: Ints
    plan: ReleaseBatch
    good: Bools


def choose_targets(
    picks: Floats,
    targets: Floats,
    limits: LimitRows,
    ceiling: Floats,
    rules: Rules,
    origins: Floats,
    may_throw: Bools,
) -> TargetChoice:
    """Return for each of N objects the quickest throw into the first of T targets whose throw is accepted.

    A row without an accepted throw has the last target. The arguments are finite, and are not checked.

    Args:
        picks: starts of the hand at rest (N, 3) [m].
        targets: targets in the order in which to try them (N, T, 3) [m].
        limits: limits of the hand (N,).
        ceiling: greatest heights of the release points (N,) [m].
        rules: rules of accepted throws.
        origins: points from which targets are moved along the throw (N, 3) [m].
        may_throw: which objects may be thrown at all (N,).
    """
    from pnt_gym.planning.straight.kernel import choose_targets as choose  # noqa: PLC0415 - numba takes a while

    count, space = len(picks), rules.workspace
    throws = np.empty((15, count))
    throws[:3], throws[6], throws[7], throws[8] = picks.T, *limits
    throws[9:] = np.array([0.0, 0.0, *OPEN])[:, None]
    throws[10] = ceiling
    attempt, slopes, moved = np.empty(count, dtype=np.int64), np.empty(count), np.empty(count, dtype=np.bool_)
    reason, good = np.empty(count, dtype=np.int64), may_throw.copy()
    borders = np.array([space.semi_x, space.semi_y, space.z_min, space.z_max])
    choose(throws, targets, origins, rules[:3], borders, attempt, slopes, moved, reason, good)
    return TargetChoice(attempt, to_batch(release_lines(throws, False, slopes, moved, reason)), good)
