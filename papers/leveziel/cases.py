"""Shared code of the parts of Leveziel et al.: reachable poses, a search over poses, and the robot alone in MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.plant import roll_out
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
"""Grid step [m] with 51,491 positions at -45 deg: of all hundredths of a millimetre nearest to the paper's count."""
CENTRE: Final = (0.0, 0.0, -0.2)
"""Position of the paper's red curve in Fig. 6 [m]."""
AROUND: Final = 5.0
"""Greatest difference of an angle from a value that the paper gives as "around" or "near" [deg]."""
STILL: Final = 0.5
"""Change of the halves' angle below which the angle counts as unchanged [deg]; a video shows less than this."""
ANGLES: Final = (CLOSED, HOME_THETA, OPEN)
"""Angles of the halves at which moves are computed and simulated [rad]."""
SMOOTH: Final = Profile("s-curve", 0.5)
"""Profile of the moves, with which the motors keep within their torque."""
SAMPLES: Final = 2001
"""Samples of each move."""
PIXEL: Final = 0.001
"""Spacing of points in sections [m]."""
SIDE: Final = 0.235
"""Half width of sections [m], beyond the workspace's extent."""
STEP: Final = 0.0005
"""Time step of the physics [s]."""
REST: Final = 0.04
"""Simulated time after the end of a motion [s]."""

_POSE: Final = ("platform_x", "platform_y", "platform_z", "half_right")
_ARMS: Final = tuple(f"arm_{i}" for i in range(N_ARMS))
_ROUNDS: Final = 30
"""Number of ever finer grids in the search."""
_ROUNDING: Final = 1e-9
"""Margin inside the strokes, so that rounding puts no angle outside [rad]."""


_FIRST, _NEXT = (
    np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, count)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    for count in (41, 9)
)
"""Grids of motor angles over the whole stroke, and around the best angles so far."""


@cache
def reduced(step: float = PAPER_STEP, theta: float = HOME_THETA) -> Workspace:
    """The reduced workspace (within the motors' strokes) on a grid."""
    return scan_workspace(step, theta)


def item_label(item: str) -> str:
    """Name of a catalogue item in figures and rows."""
    return {"bottle_cap": "cap", "rubber_block": "block"}.get(item, item)


def millimetres(place: Floats) -> str:
    """A position (3,) [m] as text in millimetres."""
    return ", ".join(f"{1e3 * v + 0.0:.0f}" for v in place[:3])


def poses_at(positions: Floats, theta: float) -> Floats:
    """Poses (..., 4) of positions (..., 3) [m], all at the angle ``theta`` [rad]."""
    return np.concatenate([positions, np.full((*positions.shape[:-1], 1), theta)], axis=-1)


def is_reachable(poses: Floats) -> Bools:
    """Whether the robot reaches each of the poses (..., 4) within the motors' strokes (...,)."""
    return np.isfinite(inverse_kinematics(poses, strokes=True)[..., 0])


def random_poses(count: int, seed: int = 0, theta: tuple[float, float] = PROTOTYPE.theta) -> Floats:
    """Random poses (count, 4), uniform over the reduced workspace and over a range of angles [rad]."""
    rng = np.random.default_rng(seed)
    # A box that contains the reduced workspace; poses outside the workspace are left out.
    low, high = (np.array([-0.16, -0.155, -0.285, theta[0]]), np.array([0.16, 0.155, -0.12, theta[1]]))
    poses = rng.uniform(low, high, (8 * count, 4))
    return poses[is_reachable(poses)][:count]


def arm_positions(angles: Floats, theta: float) -> Floats:
    """Positions (M, 3) at which arms 1, 2 and 3 have the angles (M, 3) [rad]; NaN where the forearms do not meet.

    The platform's middle is the intersection of three spheres whose radius is a forearm's length. Their centres are the
    elbows, moved by the offsets of the forearms' ends from the platform's middle.
    """
    dims = PROTOTYPE
    reach, up = dims.k + dims.r * np.cos(angles.T), dims.r * np.sin(angles.T)
    zero = np.zeros(len(angles))
    # Elbows less the ends of the forearms: +-u along x for arms 1 and 3, v and the half's end for arm 2 along y.
    first = np.stack([reach[0] - dims.u, zero, up[0]], axis=-1)
    second = np.stack([zero, reach[1] - dims.v - dims.w * np.cos(theta), up[1] - dims.w * np.sin(theta)], axis=-1)
    third = np.stack([dims.u - reach[2], zero, up[2]], axis=-1)
    span, side = third - first, second - first
    distance = np.linalg.norm(span, axis=-1, keepdims=True)
    along = span / distance
    ahead = (side * along).sum(axis=-1, keepdims=True)
    perpendicular = side - ahead * along
    width = np.linalg.norm(perpendicular, axis=-1, keepdims=True)
    # Trilateration: equal radii put the point half-way between the first and the third centre.
    x, across = 0.5 * distance, perpendicular / width
    y = ((side * side).sum(axis=-1, keepdims=True) - 2.0 * ahead * x) / (2.0 * width)
    with np.errstate(invalid="ignore"):
        depth = np.sqrt(dims.l**2 - x * x - y * y)
    normal = np.cross(along, across)
    # Of the two intersections the robot takes the lower one.
    return first + x * along + y * across - np.sign(normal[:, 2:]) * depth * normal


def lowest_pose(measure: Callable[[Floats], Floats], theta: float) -> tuple[Floats, float]:
    """The pose (4,) of the reduced workspace at one angle with the smallest ``measure``, and that smallest value.

    The search uses ever finer grids over the angles of three motors, so that grids contain the edges of the strokes.
    Three motors suffice because the robot is mirror symmetric. ``measure`` takes poses (M, 4).
    """
    low, high = np.array(PROTOTYPE.stroke) + _ROUNDING * np.array([1.0, -1.0])
    best, value, pose = np.full(3, 0.5 * (low + high)), np.inf, np.full(4, np.nan)
    size = 0.5 * (high - low)
    for k in range(_ROUNDS):
        poses = poses_at(arm_positions(np.clip(best + size * (_FIRST if k == 0 else _NEXT), low, high), theta), theta)
        poses = poses[np.isfinite(poses[:, 0])]
        poses = poses[is_reachable(poses)]
        values = measure(poses)
        i = int(values.argmin())
        if values[i] < value:
            value, pose = float(values[i]), poses[i]
            best = inverse_kinematics(pose)[:3]
        # The first grid's spacing is a twentieth of its half width: the second covers two spacings to every side.
        size *= 0.7 if k else 0.1
    return pose, value


@final
@dataclass(frozen=True, eq=False)
class SimulatedMotions:
    """Simulation of N motions at S times."""

    time: Floats
    """Times (S,) [s]."""
    pose: Floats
    """Poses of the platform (N, S, 4): x, y, z [m], theta [rad]."""
    q: Floats
    """Motor angles (N, S, 4) [rad]."""
    torque: Floats
    """Motor torques (N, S, 4) [N m]."""


def follow(start: Floats, references: MotorReferences, build: Build = PROTOTYPE_BUILD) -> SimulatedMotions:
    """Simulate motions of the robot with empty claws, from rest.

    Args:
        start: poses at the beginning (N, 4).
        references: commands to the motors at each step (N, S, 4).
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
    record = roll_out(batch, control, whole, ("qpos", "actuator_force"))
    pose, arms = ([robot.joints.index(name) for name in names] for names in (_POSE, _ARMS))
    time = STEP * np.arange(1, steps + 1, dtype=np.float64)
    return SimulatedMotions(time, record["qpos"][..., pose], record["qpos"][..., arms], record["actuator_force"])


def follow_motions(motions: Sequence[PoseMotion]) -> tuple[Floats, SimulatedMotions]:
    """Simulate motions with torque feed-forward until every motion is over and the robot has rested at its end.

    Returns:
        The commanded poses (N, S, 4), and the simulation.
    """
    steps = int(np.ceil((max(motion.duration for motion in motions) + REST) / STEP))
    time = STEP * np.arange(steps, dtype=np.float64)
    poses = np.stack([np.stack([np.interp(time, m.time, m.pose[:, k]) for k in range(4)], axis=-1) for m in motions])
    return poses, follow(poses[:, 0], motor_references(poses, STEP))
