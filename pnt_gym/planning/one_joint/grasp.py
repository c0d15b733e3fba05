"""Reactions between block and moving arm, and the motor's torque (Miyashita et al., section 3.1).

All functions take arrays that broadcast: angle [rad], speed [rad/s], acceleration [rad/s2] of the arm, and the
distance r of the block's centre of mass from the pivot along the arm [m].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.one_joint.parameters import Arm, Block


class Reactions(NamedTuple):
    """Normal force and moments of the arm's surface on the block.

    Attributes:
        normal: N [N], positive while block and arm touch (Eq. 1).
        moment_a: M_A about the outer vertex [N m], negative while the inner vertex stays down (Eq. 2).
        moment_b: M_B about the inner vertex [N m], positive while the outer vertex stays down (Eq. 3).
    """

    normal: Floats
    moment_a: Floats
    moment_b: Floats


class AccelerationWindow(NamedTuple):
    """Accelerations of the arm between ``low`` and ``high`` [rad/s2] keep grasp and torque; none if low >= high."""

    low: Floats
    high: Floats

    @property
    def is_open(self) -> Bools:
        """Whether the window holds an acceleration."""
        return self.low < self.high


def reactions(angle: Floats, speed: Floats, acceleration: Floats, radius: Floats, block: Block) -> Reactions:
    """Return normal force and moments about both vertices (Eqs. 1-3)."""
    return _reactions((np.cos(angle), np.sin(angle)), speed, acceleration, radius, block)


def joint_torque(angle: Floats, speed: Floats, acceleration: Floats, radius: Floats, arm: Arm, block: Block) -> Floats:
    """Return the motor torque with the block on the arm [N m] (Eq. 21).

    The plate is balanced about the pivot. Coulomb friction acts against the motion, at rest against a motion upward.
    """
    inertia, bias = _load((np.cos(angle), np.sin(angle)), speed, radius, arm, block)
    return inertia * acceleration + bias


def loads(
    angle: Floats, speed: Floats, acceleration: Floats, radius: Floats, arm: Arm, block: Block
) -> tuple[Reactions, Floats]:
    """Return `reactions` and `joint_torque` together, with shared terms computed once."""
    direction = np.cos(angle), np.sin(angle)
    inertia, bias = _load(direction, speed, radius, arm, block)
    return _reactions(direction, speed, acceleration, radius, block), inertia * acceleration + bias


def torque_limit(speed: Floats, arm: Arm) -> Floats:
    """Return the motor's largest torque at ``speed`` [N m] (Eq. 10, Fig. 3), never below 0."""
    last = min(arm.torque_at_speed, arm.torque)
    beyond = np.maximum(np.abs(speed) / arm.speed - arm.knee, 0.0) / (1.0 - arm.knee)
    return np.maximum(arm.torque - (arm.torque - last) * beyond, 0.0)


def acceleration_window(angle: Floats, speed: Floats, radius: Floats, arm: Arm, block: Block) -> AccelerationWindow:
    """Return the accelerations at a state of the arm that keep the dynamic grasp and the torque limits.

    Eqs. 1-3 and 21 are linear in the acceleration, so each of Eqs. 4-6 and 9 bounds it on one side.
    """
    direction = np.cos(angle), np.sin(angle)
    normal, moment_a, moment_b = _per_mass(*direction, speed, radius, block)
    lever, spin = block.half_length * radius, _spin(block)
    inertia, bias = _load(direction, speed, radius, arm, block)
    limit = torque_limit(speed, arm)
    low = np.maximum(-normal / radius, -moment_b / (spin + lever))
    low = np.maximum(low, (-limit - bias) / inertia)
    high = (limit - bias) / inertia
    # Near the pivot the block's inertia reverses the sign of the moment about A. Where lever = spin, the moment does
    # not depend on the acceleration, and a tiny slope moves the bound far off to one side.
    slope = np.where(lever == spin, 1e-300, lever - spin)
    low = np.where(slope > 0.0, np.maximum(low, moment_a / slope), low)
    high = np.where(slope < 0.0, np.minimum(high, moment_a / slope), high)
    return AccelerationWindow(low, high)


def braking_acceleration(speed: Floats, arm: Arm) -> Floats:
    """Return the acceleration of the empty arm that brakes with the largest torque at ``speed`` [rad/s2].

    The torque limit only grows as the speed falls, so the motor can keep this acceleration until the arm stands.
    """
    return -np.where(speed < 0.0, -1.0, 1.0) * (torque_limit(speed, arm) + arm.friction) / arm.inertia


def tipping_margin(angle: Floats, block: Block) -> Floats:
    """Return the margin against tipping of the block on the resting arm; the block rests where the margin is positive.

    The unit is weight times half length: 1 on a horizontal arm, 0 where the centre of mass is above a vertex.
    """
    return np.cos(angle) - block.half_height / block.half_length * np.abs(np.sin(angle))


def _spin(block: Block) -> float:
    """J / m + d^2 [m2]: inertia per mass of the block about the arm's surface below its centre of mass."""
    return block.inertia / block.mass + block.half_height**2


def _reactions(
    direction: tuple[Floats, Floats], speed: Floats, acceleration: Floats, radius: Floats, block: Block
) -> Reactions:
    normal, moment_a, moment_b = _per_mass(*direction, speed, radius, block)
    lever, spin = block.half_length * radius, _spin(block)
    return Reactions(
        block.mass * (normal + radius * acceleration),
        block.mass * (moment_a + (spin - lever) * acceleration),
        block.mass * (moment_b + (spin + lever) * acceleration),
    )


def _per_mass(
    cosine: Floats, sine: Floats, speed: Floats, radius: Floats, block: Block
) -> tuple[Floats, Floats, Floats]:
    """N, M_A and M_B of Eqs. 1-3 per mass, without the terms of the acceleration."""
    d, side = block.half_height, block.half_length
    pull, weight = speed * speed, GRAVITY * cosine
    common = d * (radius * pull - GRAVITY * sine)
    across = side * (d * pull - weight)
    return weight - d * pull, common + across, common - across


def _load(
    direction: tuple[Floats, Floats], speed: Floats, radius: Floats, arm: Arm, block: Block
) -> tuple[Floats, Floats]:
    """Inertia of arm and block about the pivot [kg m2], and the torque without acceleration [N m]."""
    d, mass = block.half_height, block.mass
    inertia = arm.inertia + block.inertia + mass * (radius * radius + d * d)
    weight = mass * GRAVITY * (radius * direction[0] - d * direction[1])
    if arm.friction > 0.0:
        weight = weight + arm.friction * np.where(speed < 0.0, -1.0, 1.0)
    return inertia, weight
