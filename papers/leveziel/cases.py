"""What the parts of Leveziel et al. have in common: reachable poses, a search over them, the robot alone in MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.plant import staged_rollout
from pnt_gym.engine import Batch, mujoco
from pnt_gym.robots.gripper import PROTOTYPE, inverse_kinematics
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD, Build
from pnt_gym.robots.gripper.geometry import N_ARMS
from pnt_gym.robots.gripper.model import add_gripper, set_options
from pnt_gym.robots.gripper.references import MotorReferences, closed_pose, motor_references

from .motion import PoseMotion, Profile
from .scan import Workspace, scan_workspace

HOME_THETA: Final = PROTOTYPE.home_theta
CLOSED, OPEN = PROTOTYPE.theta
"""Ends of the prototype's range of theta [rad]."""
PAPER_COUNT: Final = 51_624
"""Positions of the paper's discretized reduced workspace; its step is not printed."""
PAPER_STEP: Final = 0.00467
"""Gives 51,491 positions at -45 deg, of all steps in hundredths of a millimetre the count next to the paper's [m]."""
CENTRE: Final = (0.0, 0.0, -0.2)
"""Of the paper's red curve in Fig. 6 [m]."""
AROUND: Final = 5.0
"""An angle that the paper gives as "around" or "near" another is within this of it [deg]."""
STILL: Final = 0.5
"""An angle of the halves counts as unchanged that changes by less than this, more than a video shows [deg]."""
ANGLES: Final = (CLOSED, HOME_THETA, OPEN)
"""At which moves are made [rad]."""
SMOOTH: Final = Profile("s-curve", 0.5)
"""Of the moves, in which the motors keep within their torque."""
SAMPLES: Final = 2001
"""Of each move."""
PIXEL: Final = 0.001
"""Spacing of sections [m]."""
SIDE: Final = 0.235
"""Beyond the workspace's extent to the side [m]."""
STEP: Final = 0.0005
"""Of the physics [s]."""
REST: Final = 0.04
"""Simulated after the end of a motion [s]."""

_POSE: Final = ("platform_x", "platform_y", "platform_z", "half_right")
_ARMS: Final = tuple(f"arm_{i}" for i in range(N_ARMS))
_ROUNDS: Final = 30
"""Grids of the search."""
_ROUNDING: Final = 1e-9
"""Keeps angles on the edge of the strokes from being rounded out of them [rad]."""


_FIRST, _NEXT = (
    np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, count)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for count in (41, 9)
)
"""Grids of angles over the whole stroke and around the best so far."""


@cache
def reduced(step: float = PAPER_STEP, theta: float = HOME_THETA) -> Workspace:
    """The reduced workspace on a grid."""
    return scan_workspace(step, theta)


def called(item: str) -> str:
    """The name that an item of the catalogue has in the figures."""
    return {"bottle_cap": "cap", "rubber_block": "block"}.get(item, item)


def millimetres(place: Floats) -> str:
    """A position for people."""
    return ", ".join(f"{1e3 * v + 0.0:.0f}" for v in place[:3])


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


def lowest(measure: Callable[[Floats], Floats], theta: float) -> tuple[Floats, float]:
    """The pose (4,) of the reduced workspace at one angle with the smallest measure of poses (M, 4), and that value.

    Ever finer grids over the angles of three motors, so that the edges of the strokes are met exactly; the robot
    mirrors itself, so these three stand for all four.
    """
    low, high = np.array(PROTOTYPE.stroke) + _ROUNDING * np.array([1.0, -1.0])
    best, value, pose = np.full(3, 0.5 * (low + high)), np.inf, np.full(4, np.nan)
    size = 0.5 * (high - low)
    for k in range(_ROUNDS):
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


@final
@dataclass(frozen=True, eq=False)
class Followed:
    """N motions as the model carried them out, at S times."""

    time: Floats
    """(S,) [s]"""
    pose: Floats
    """(N, S, 4) x, y, z [m], theta [rad] of the platform."""
    q: Floats
    """(N, S, 4) motor angles [rad]."""
    torque: Floats
    """(N, S, 4) of the motors [N m]."""


def follow(start: Floats, references: MotorReferences, build: Build = PROTOTYPE_BUILD) -> Followed:
    """Carry out motions with empty claws, from rest.

    Args:
        start: (N, 4) poses at the beginning.
        references: what the motors are told at each step (N, S, 4).
        build: masses, servos and claws.

    Raises:
        PhysicsError: the engine warned.
    """
    spec = mujoco.MjSpec()
    set_options(spec, STEP)
    robot = add_gripper(spec, build=build)
    model = spec.compile()
    count, steps = len(references.angle), int(references.angle.shape[1])
    batch = Batch(model, nsim=count, nthread=1)
    batch.state[:] = 0.0
    batch.bind("qpos")[:] = closed_pose(start)
    batch.bind("eq_active")[:] = 1.0
    control = np.ones((count, steps, int(model.nu) + int(model.neq)))
    control[..., : int(model.nu)] = references.controls()
    whole = np.full(count, steps, dtype=np.int64)
    record = staged_rollout(batch, control, whole, ("qpos", "actuator_force"))
    pose, arms = ([robot.joints.index(name) for name in names] for names in (_POSE, _ARMS))
    time = STEP * np.arange(1, steps + 1, dtype=np.float64)
    return Followed(time, record["qpos"][..., pose], record["qpos"][..., arms], record["actuator_force"])


def follow_motions(motions: Sequence[PoseMotion]) -> tuple[Floats, Followed]:
    """Carry motions out with torque fed forward until all are over and have rested at their ends.

    Returns:
        The poses that were told (N, S, 4), and what became of them.
    """
    steps = int(np.ceil((max(motion.duration for motion in motions) + REST) / STEP))
    time = STEP * np.arange(steps, dtype=np.float64)
    poses = np.stack([np.stack([np.interp(time, m.time, m.pose[:, k]) for k in range(4)], axis=-1) for m in motions])
    return poses, follow(poses[:, 0], motor_references(poses, STEP))
