"""What the parts of Leveziel et al. have in common: angles, the grid, reachable poses and a search over them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Final

import numpy as np

from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.robots.gripper4 import PROTOTYPE, Workspace, inverse_kinematics, scan_workspace

HOME_THETA: Final = PROTOTYPE.home_theta
CLOSED, OPEN = PROTOTYPE.theta
"""Ends of the prototype's range of theta [rad]."""
PAPER_COUNT: Final = 51_624
"""Positions of the paper's discretized reduced workspace; its step is not printed."""
PAPER_STEP: Final = 0.00467
"""Gives 51,491 positions at -45 deg, of all steps in hundredths of a millimetre the count next to the paper's [m]."""
CENTRE: Final = (0.0, 0.0, -0.2)
"""Of the paper's red curve in Fig. 6 [m]."""

_ROUNDING: Final = 1e-9
"""Keeps angles on the edge of the strokes from being rounded out of them [rad]."""


def _cube(count: int) -> Floats:
    return np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, count)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


_FIRST, _NEXT = _cube(41), _cube(9)


@cache
def reduced(step: float = PAPER_STEP, theta: float = HOME_THETA) -> Workspace:
    """The reduced workspace on a grid."""
    return scan_workspace(step, theta)


def posed(positions: Floats, theta: float) -> Floats:
    """Poses (..., 4) of positions (..., 3) at one angle."""
    return np.concatenate([positions, np.full((*positions.shape[:-1], 1), theta)], axis=-1)


def held(poses: Floats) -> Bools:
    """Which poses (..., 4) the strokes allow (...,)."""
    return np.isfinite(inverse_kinematics(poses, strokes=True)[..., 0])


def random_poses(count: int, seed: int = 0, theta: tuple[float, float] = PROTOTYPE.theta) -> Floats:
    """Poses (count, 4) drawn evenly from the reduced workspace at angles within a range [rad]."""
    rng = np.random.default_rng(seed)
    low, high = (np.array([-0.16, -0.155, -0.285, theta[0]]), np.array([0.16, 0.155, -0.12, theta[1]]))
    poses = rng.uniform(low, high, (8 * count, 4))
    return poses[held(poses)][:count]


def positions_of(angles: Floats, theta: float) -> Floats:
    """Positions (M, 3) at which arms 1, 2 and 3 have the angles (M, 3) [rad]; NaN where the forearms do not meet.

    The platform's middle is a forearm's length from three points: where the elbows would be if all forearms met there.
    """
    dims = PROTOTYPE
    reach, up = dims.k + dims.r * np.cos(angles.T), dims.r * np.sin(angles.T)
    zero = np.zeros(len(angles))
    one = np.stack([reach[0] - dims.u, zero, up[0]], axis=-1)
    two = np.stack([zero, reach[1] - dims.v - dims.w * np.cos(theta), up[1] - dims.w * np.sin(theta)], axis=-1)
    three = np.stack([dims.u - reach[2], zero, up[2]], axis=-1)
    span, side = three - one, two - one
    distance = np.linalg.norm(span, axis=-1, keepdims=True)
    along = span / distance
    ahead = (side * along).sum(axis=-1, keepdims=True)
    beside = side - ahead * along
    width = np.linalg.norm(beside, axis=-1, keepdims=True)
    x, across = 0.5 * distance, beside / width
    y = ((side * side).sum(axis=-1, keepdims=True) - 2.0 * ahead * x) / (2.0 * width)
    with np.errstate(invalid="ignore"):
        depth = np.sqrt(dims.l**2 - x * x - y * y)
    normal = np.cross(along, across)
    return one + x * along + y * across - np.sign(normal[:, 2:]) * depth * normal


def lowest(measure: Callable[[Floats], Floats], theta: float, rounds: int = 30) -> tuple[Floats, float]:
    """The pose (4,) of the reduced workspace at one angle with the smallest value, and that value.

    Ever finer grids over the angles of three motors, so that the edges of the strokes are met exactly; the robot
    mirrors itself, so these three stand for all four.

    Args:
        measure: of poses (M, 4).
        theta: of all poses [rad].
        rounds: grids.
    """
    low, high = np.array(PROTOTYPE.stroke) + _ROUNDING * np.array([1.0, -1.0])
    best, value, pose = np.full(3, 0.5 * (low + high)), np.inf, np.full(4, np.nan)
    size = 0.5 * (high - low)
    for k in range(rounds):
        poses = posed(positions_of(np.clip(best + size * (_FIRST if k == 0 else _NEXT), low, high), theta), theta)
        poses = poses[np.isfinite(poses[:, 0])]
        poses = poses[held(poses)]
        values = measure(poses)
        i = int(values.argmin())
        if values[i] < value:
            value, pose = float(values[i]), poses[i]
            best = inverse_kinematics(pose)[:3]
        size *= 0.7 if k else 0.1
    return pose, value
