"""Landing states of releases, and releases that reach a landing state (Miyashita et al., section 3.2).

A release u is (theta_t, omega_t, l_t, t_f) in [rad, rad/s, m, s], a landing state z is (x, y, phi, dy) in
[m, m, rad, m/s]; the pivot is the origin and phi is never wrapped.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints, not_finite_error, number, tuples
from pnt_gym.errors import PlanningError
from pnt_gym.planning.one_joint.feasibility import ThrowReason, first_reason, reasons_of
from pnt_gym.planning.one_joint.flight import land
from pnt_gym.planning.one_joint.parameters import Arm, Block, arm_and_block
from pnt_gym.planning.one_joint.releases import find_releases

TURNS: Final = (-2, -1, 0, 1, 2)
"""Extra whole turns of the block that `release_states` considers."""


@final
@dataclass(frozen=True, eq=False)
class ReleaseStates:
    """The K releases that reach a landing state, ordered by turns and then flight time.

    Attributes:
        u: releases (K, 4) = theta_t [rad], omega_t [rad/s], l_t [m], t_f [s], with theta_t within half a turn.
        turns: extra whole turns of the block in flight (K,): the block arrives at phi + 2 pi turns.
        feasible: whether the release is feasible for arm, motor and grasp (K,).
        reasons: a tuple of sentences per release, the reasons against it; empty for a feasible release.
    """

    u: Floats
    turns: Ints
    feasible: Bools
    reasons: tuple[tuple[str, ...], ...]


@final
@dataclass(frozen=True, eq=False)
class BestReleases:
    """The best feasible release for each of N landing states.

    Attributes:
        goal: landing states (N, 4).
        u: the feasible release with the widest acceleration window (N, 4); NaN where no release is feasible.
        feasible: whether there is a feasible release (N,).
        reason: `ThrowReason` (N,) of the release that comes nearest to being feasible.
    """

    goal: Floats
    u: Floats
    feasible: Bools
    reason: Ints


def landing_state(u: ArrayLike, half_height: float = 0.015) -> Floats:
    """Return the landing states z (..., 4) of the releases ``u`` (..., 4) (Eq. 11).

    Args:
        u: theta_t [rad], omega_t [rad/s], l_t [m], t_f [s].
        half_height: d, from the arm's surface to the centre of mass [m].

    Raises:
        ValueError: the shape is not (..., 4), a number is not finite, or l_t is less than half_height.
    """
    release = four_columns(u, "u")
    half_height = _check_height(half_height)
    radius = release[..., 2]
    if (radius < half_height).any() or (radius <= 0.0).any():
        raise PlanningError(
            f"l_t is {radius.min():.6g} m; it is the distance of the centre of mass from the pivot and must be "
            f"positive and at least half_height = {half_height:.6g} m"
        )
    return land(release, half_height)


def release_states(
    z: ArrayLike, half_height: float = 0.015, *, arm: Arm | None = None, block: Block | None = None
) -> ReleaseStates:
    """Return every release that reaches the landing state ``z`` (4,), with -2 to 2 extra whole turns.

    Args:
        z: x, y [m], phi [rad], dy [m/s].
        half_height: d, from the arm's surface to the centre of mass [m]; replaces the block's half height.
        arm: the arm, whose limits decide feasibility; the paper's when not given.
        block: the thrown block; the paper's when not given.

    Raises:
        ValueError: z is not four finite numbers, or half_height is negative.
    """
    goal = four_columns(z, "z")
    if goal.shape != (4,):
        raise PlanningError(f"z must have shape (4,), got {goal.shape}; release_states_batch takes many")
    arm, block = arm_and_block(arm, block)
    block = replace(block, half_height=_check_height(half_height))
    releases = find_releases(goal[None], block.half_height, (-np.pi, np.pi), TURNS)
    order = np.lexsort((releases.u[:, 3], releases.turns))
    u, turns = releases.u[order], releases.turns[order]
    reasons = tuple(reasons_of(row, arm, block) for row in u)
    return ReleaseStates(u, turns, np.array([not r for r in reasons], dtype=np.bool_), reasons)


def release_states_batch(z: ArrayLike, *, arm: Arm | None = None, block: Block | None = None) -> BestReleases:
    """Return the best feasible release for each landing state ``z`` (N, 4), all at once.

    Only releases without extra turns and within the arm's range of angles are considered. A landing state whose
    releases all lie outside the range gets the reason `NO_RELEASE`.

    Args:
        z: x, y [m], phi [rad], dy [m/s].
        arm: the arm, whose limits decide feasibility; the paper's when not given.
        block: the thrown block; the paper's when not given.

    Raises:
        ValueError: the shape is not (N, 4) or a number is not finite.
    """
    goal = rows_of_four(z, "z")
    arm, block = arm_and_block(arm, block)
    releases = find_releases(goal, block.half_height, arm.angle, turns=(0,))
    reason, room = first_reason(releases.u, arm, block)
    count = goal.shape[0]
    u = np.full((count, 4), np.nan)
    code = np.full(count, int(ThrowReason.NO_RELEASE), dtype=np.int64)
    # Feasible releases come last, by rising width of the window: a later release of a row overwrites the earlier.
    order = np.lexsort((room, np.where(reason == ThrowReason.FEASIBLE, np.inf, reason)))
    row = releases.row[order]
    u[row], code[row] = releases.u[order], reason[order]
    feasible = code == ThrowReason.FEASIBLE
    u[~feasible] = np.nan
    return BestReleases(goal, u, feasible, code)


def four_columns(values: ArrayLike, name: str) -> Floats:
    """Return ``values`` as a float64 array of shape (..., 4).

    Raises:
        ValueError: the shape is not (..., 4), or a number is not finite.
    """
    array = tuples(values, name, 4)
    if not np.isfinite(array).all():
        raise not_finite_error(array, name)
    return array


def rows_of_four(values: ArrayLike, name: str) -> Floats:
    """Return ``values`` as a float64 array of shape (N, 4).

    Raises:
        ValueError: the shape is not (N, 4), or a number is not finite.
    """
    rows = four_columns(values, name)
    if rows.ndim != 2:
        raise PlanningError(f"{name} must have shape (N, 4), got {rows.shape}")
    return rows


def _check_height(half_height: float) -> float:
    height = number(half_height, "half_height")
    if not 0.0 <= height < np.inf:
        raise PlanningError(f"half_height is {half_height}; it must be finite and at least 0 m")
    return height
