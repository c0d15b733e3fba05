"""The gripper robot alone in MuJoCo: motions side by side, and what the platform makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.cells.rollout import staged_rollout
from pnt_gym.engine import Batch, mujoco
from pnt_gym.planning.arrays import Floats
from pnt_gym.robots.gripper4 import Motion
from pnt_gym.robots.gripper4.build import PROTOTYPE_BUILD, Build
from pnt_gym.robots.gripper4.geometry import N_ARMS
from pnt_gym.robots.gripper4.model import add_gripper4, set_options
from pnt_gym.robots.gripper4.references import MotorReferences, closed_pose, motor_references

STEP: Final = 0.0005
"""Of the physics [s]."""
REST: Final = 0.04
"""Simulated after the end of a motion [s]."""
_POSE: Final = ("platform_x", "platform_y", "platform_z", "half_right")


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
    robot = add_gripper4(spec, build=build)
    model = spec.compile()
    count, steps = len(references.angle), int(references.angle.shape[1])
    batch = Batch(model, nsim=count, nthread=1)
    batch.state[:] = 0.0
    batch.bind("qpos")[:] = closed_pose(start)
    batch.bind("eq_active")[:] = 1.0
    control = np.ones((count, steps, int(model.nu) + int(model.neq)))
    control[..., : int(model.nu)] = references.controls()
    widths = [("qpos", int(model.nq)), ("actuator_force", N_ARMS)]
    record = staged_rollout(batch, control, np.full(count, steps, dtype=np.int64), widths)
    pose, arms = ([robot.joints.index(name) for name in names] for names in (_POSE, _arms()))
    time = STEP * np.arange(1, steps + 1, dtype=np.float64)
    return Followed(time, record["qpos"][..., pose], record["qpos"][..., arms], record["actuator_force"])


def _arms() -> tuple[str, ...]:
    return tuple(f"arm_{i}" for i in range(N_ARMS))


def told(motions: Sequence[Motion]) -> Floats:
    """Poses (N, S, 4) of motions at every step, and on at their ends until all are over and have rested."""
    steps = int(np.ceil((max(motion.duration for motion in motions) + REST) / STEP))
    time = STEP * np.arange(steps, dtype=np.float64)
    return np.stack([np.stack([np.interp(time, m.time, m.pose[:, k]) for k in range(4)], axis=-1) for m in motions])


def follow_motions(motions: Sequence[Motion]) -> tuple[Floats, Followed]:
    """Carry motions out with torque fed forward; the poses that were told (N, S, 4), and what became of them."""
    poses = told(motions)
    return poses, follow(poses[:, 0], motor_references(poses, STEP))
