"""Learning from throw to throw: the virtual goal (Miyashita et al. 2010, section 5), and Newton's method beside it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.planning.one_joint._flight import landing_jacobian
from pnt_gym.planning.one_joint.landing import release_states_batch
from pnt_gym.planning.one_joint.parameters import Arm, Block

HALVINGS: Final = 20
"""Of the way back to the last goal that had a throw."""

Feasible = Callable[[Floats], Bools]
"""Which of some goals (N, 4) have a throw (N,)."""


def next_virtual_goal(virtual: Floats, goal: Floats, measured: Floats, gain: ArrayLike = 0.7) -> Floats:
    """Return the virtual goals (N, 4) of the next throws: virtual + K (goal - measured) (Eqs. 33, 34).

    Args:
        virtual: goals that were planned for (N, 4).
        goal: goals that are meant (N, 4).
        measured: where the throws arrived (N, 4).
        gain: diagonal of K, one number or (4,).

    Raises:
        ValueError: shapes disagree, or a gain is negative or not finite.
    """
    gains = np.asarray(gain, dtype=np.float64)
    if gains.shape not in ((), (4,)) or not np.isfinite(gains).all() or (gains < 0.0).any():
        raise ValueError(f"gain must be one or four finite numbers of at least 0, got {gain!r}")
    _one_shape(virtual=virtual, goal=goal, measured=measured)
    return virtual + gains * (goal - measured)


def reachable(arm: Arm | None = None, block: Block | None = None) -> Feasible:
    """Return the test whether a release exists that arm, motor and grasp can do."""
    return lambda goals: release_states_batch(goals, arm=arm, block=block).feasible


def pull_back(last: Floats, proposed: Floats, feasible: Feasible | None = None) -> tuple[Floats, Bools]:
    """Return the proposed goals, or the nearest ones to them on the lines to ``last`` that have a throw.

    Args:
        last: goals (N, 4) that have a throw.
        proposed: goals (N, 4) that may have none.
        feasible: the test; `reachable` for the paper's arm and block when not given.

    Returns:
        The goals (N, 4), each of which has a throw if its ``last`` one has, and which rows were pulled back (N,).
    """
    _one_shape(last=last, proposed=proposed)
    test = feasible or reachable()
    outside = ~np.asarray(test(proposed), dtype=np.bool_)
    result = proposed.copy()
    rows = np.nonzero(outside)[0]
    if not rows.size:
        return result, outside
    start, way = last[rows], proposed[rows] - last[rows]
    share, step = np.zeros(rows.size), 0.5
    for _ in range(HALVINGS):
        farther = share + step
        good = test(start + farther[:, None] * way)
        share = np.where(good, farther, share)
        step *= 0.5
    # A share of zero is the last goal itself, to the bit.
    result[rows] = np.where(share[:, None] > 0.0, start + share[:, None] * way, start)
    return result, outside


def newton_step(error: Floats, jacobian: Floats, damping: float = 1e-6) -> Floats:
    """Return the changes of the releases (N, 4) that take the errors away if the Jacobians are right.

    Args:
        error: goal less measured landing state (N, 4).
        jacobian: dz/du (N, 4, 4), as `release_jacobian` or what `broyden` made of it.
        damping: added to the squares of the singular values; keeps steps finite where a Jacobian is singular.
    """
    transposed = np.swapaxes(jacobian, 1, 2)
    square = (transposed[:, :, :, None] * jacobian[:, None]).sum(axis=2) + damping * np.eye(4)
    pull = (transposed * error[:, None]).sum(axis=2)
    return np.asarray(np.linalg.solve(square, pull[..., None]), dtype=np.float64)[..., 0]


def release_jacobian(u: Floats, block: Block | None = None) -> Floats:
    """Return dz/du (N, 4, 4) of the model at the releases ``u`` (N, 4) (Eq. 11)."""
    return landing_jacobian(u, (block or Block()).half_height)


def broyden(jacobian: Floats, step: Floats, change: Floats) -> Floats:
    """Return the Jacobians (N, 4, 4) nearest to the given ones that explain what the last steps changed.

    Args:
        jacobian: of the last throws (N, 4, 4).
        step: change of the releases (N, 4); rows of zeros leave their Jacobian as it is.
        change: of the measured landing states (N, 4).
    """
    size = (step * step).sum(axis=1)
    surprise = change - (jacobian * step[:, None]).sum(axis=2)
    update = surprise[:, :, None] * step[:, None] / np.where(size > 0.0, size, 1.0)[:, None, None]
    return jacobian + np.where((size > 0.0)[:, None, None], update, 0.0)


def _one_shape(**arrays: Floats) -> None:
    shapes = {name: array.shape for name, array in arrays.items()}
    first = next(iter(shapes.values()))
    if len(first) != 2 or first[1] != 4 or any(shape != first for shape in shapes.values()):
        raise ValueError(f"goals must have one shape (N, 4), got {shapes}")
