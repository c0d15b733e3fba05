"""Joint velocities, accelerations and motor torques of the T3KR-class robot in closed form.

Rods are slender bars: with end accelerations a and b, the inertial forces at the ends are m (2 a + b) / 6 and
m (a + 2 b) / 6. Four motors move three coordinates; the torques returned are those of the smallest norm.
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3KR, T3krGeometry
from pnt_gym.robots.t3kr.kinematics import ArmPose, components, jacobian_rows, solve_arms, solve_normal


@final
@dataclass(frozen=True)
class HandMotion:
    """Motion of the TCP: (3, M) position (m), velocity (m/s), acceleration (m/s^2); (M,) payload (kg)."""

    position: Floats
    velocity: Floats
    acceleration: Floats
    payload: Floats

    @classmethod
    def stack(
        cls, position: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike, payload: ArrayLike = 0.0
    ) -> tuple[tuple[int, ...], "HandMotion"]:
        """Return the leading shape and the motion of broadcastable (..., 3) arrays and a (...,) payload."""
        x, v, a = np.broadcast_arrays(position, velocity, acceleration)
        shape, points = components(x)
        mass = np.broadcast_to(np.asarray(payload, dtype=np.float64), shape).reshape(-1)
        return shape, cls(points, components(v)[1], components(a)[1], mass)


@final
@dataclass(frozen=True)
class JointMotion:
    """Joint angle (rad), velocity (rad/s), acceleration (rad/s^2), motor torque (N m); (4, M) or (4, N, K) arrays."""

    position: Floats
    velocity: Floats
    acceleration: Floats
    torque: Floats


def joint_motion(hand: HandMotion, geometry: T3krGeometry = T3KR) -> JointMotion:
    """Joint motion and motor torques for a motion of the TCP; not finite where out of reach or singular."""
    with np.errstate(invalid="ignore", divide="ignore"):
        arms = solve_arms(hand.position, geometry)
        rows = jacobian_rows(arms, geometry)
        q_dot = rows[0] * hand.velocity[0] + rows[1] * hand.velocity[1] + rows[2] * hand.velocity[2]
        q_ddot = _joint_acceleration(arms, rows, q_dot, hand, geometry)
        share = solve_normal(rows, _platform_load(arms, q_dot, q_ddot, hand, geometry))
        # Minimum-norm motor torques with J^T torque = load: J (J^T J)^-1 load.
        load = rows[0] * share[0] + rows[1] * share[1] + rows[2] * share[2]
        torque = _arm_torque(arms, q_ddot, hand, geometry) + load
        return JointMotion(np.arctan2(arms.sin, arms.cos), q_dot, q_ddot, torque)


def _elbow_component(arms: ArmPose, vector: Floats, geometry: T3krGeometry) -> Floats:
    """Components (4, M) of (3, M) world vectors along each elbow's direction of travel."""
    frames = geometry.arms
    return vector[2] * arms.cos - (frames.cos * vector[0] + frames.sin * vector[1]) * arms.sin


def _joint_acceleration(arms: ArmPose, rows: Floats, q_dot: Floats, hand: HandMotion, geometry: T3krGeometry) -> Floats:
    """Joint accelerations q'' (4, M) from the second derivative of |rod| = const.

    rod . (a - L q'' t + L q'^2 n) + |rod'|^2 = 0, with the elbow along n and its direction of travel t.
    """
    length, (v_x, v_y, v_z), (a_x, a_y, a_z) = geometry.arm_length, hand.velocity, hand.acceleration
    elbow = length * q_dot
    speed2 = v_x * v_x + v_y * v_y + v_z * v_z
    rod_rate2 = speed2 + elbow * (elbow - 2.0 * _elbow_component(arms, hand.velocity, geometry))
    centripetal = elbow * q_dot * (arms.reach - length)
    linear = rows[0] * a_x + rows[1] * a_y + rows[2] * a_z
    return linear - (rod_rate2 + centripetal) / (length * arms.root)


def _arm_torque(arms: ArmPose, q_ddot: Floats, hand: HandMotion, geometry: T3krGeometry) -> Floats:
    """Torque (4, M) [N m] that moves the motor, the arm and the rods' upper ends."""
    length, rods = geometry.arm_length, 2.0 * geometry.rod_mass
    arm = geometry.arm_inertia + geometry.arm_mass * geometry.arm_com**2
    inertia = geometry.armature + arm + rods * length**2 / 3.0
    weight = GRAVITY * (geometry.arm_mass * geometry.arm_com + rods * length / 2.0)
    elbow_pull = (rods * length / 6.0) * _elbow_component(arms, hand.acceleration, geometry)
    return inertia * q_ddot + weight * arms.cos + elbow_pull


def _platform_load(arms: ArmPose, q_dot: Floats, q_ddot: Floats, hand: HandMotion, geometry: T3krGeometry) -> Floats:
    """Force (3, M) [N] that moves the platform, its payload and the rods' lower ends."""
    frames, length, rods = geometry.arms, geometry.arm_length, 2.0 * geometry.rod_mass
    spin2 = q_dot * q_dot
    # Acceleration of the elbows over the arm's length, outward and up: tangential and centripetal.
    out, up = -(q_ddot * arms.sin + spin2 * arms.cos), q_ddot * arms.cos - spin2 * arms.sin
    # A slender rod puts a third of its inertia and half of its weight on its lower end, and couples a sixth of its
    # mass to the elbow.
    inertial = hand.payload + (geometry.platform_mass + N_ARMS * rods / 3.0)
    weight = (hand.payload + (geometry.platform_mass + N_ARMS * rods / 2.0)) * GRAVITY
    coupling = rods * length / 6.0
    return np.stack(
        [
            inertial * hand.acceleration[0] + coupling * (frames.cos * out).sum(axis=0),
            inertial * hand.acceleration[1] + coupling * (frames.sin * out).sum(axis=0),
            inertial * hand.acceleration[2] + coupling * up.sum(axis=0) + weight,
        ]
    )
