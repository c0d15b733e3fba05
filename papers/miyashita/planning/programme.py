"""The arm's motion to one release as a nonlinear programme (Miyashita et al., Eqs. 15-32, corrected).

Eq. 29 fixes the release beforehand, so the programme only chooses the motion. Its variables are the accelerations at
the borders of the spline's n intervals, and the six margins. Angle and speed at the release and rest at the start then
fix Delta t and the angles, and so every control point of Eq. 13.

The programme differs from the printed form in five points. t_n = n Delta t is the release time t_t (Eq. 23 prints t_f).
Each margin has the sign of its limit (Eqs. 16 and 28 leave the sign of M_A open). The torque limit falls with the
current speed (Eq. 10). The block may have to rest by itself on the standing arm. Limits are kept between the knots too,
at `per_interval` places of every interval.
"""

from __future__ import annotations

from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.one_joint.family import FORCED, Objective
from pnt_gym.planning.one_joint.grasp import braking_acceleration
from pnt_gym.planning.one_joint.margins import STATIC_ROOM
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.planning.one_joint.parameters import Arm, Block
from pnt_gym.planning.one_joint.shapes import INTERVALS, Shapes

ACCELERATION: Final = 100.0
"""Unit of the accelerations [rad/s2]."""
LEAST: Final = 1e-5
"""Smallest margin of a solution, as a share: the limits are strict."""
OTHERS: Final = 1e-3
"""Weight of the sum of all margins in the max-min objective, where the smallest margin has the weight 1."""


class Throw(NamedTuple):
    """A release: angle theta_t [rad], speed omega_t [rad/s], and radius r of the block [m]."""

    angle: float
    speed: float
    radius: float


class Weighing(NamedTuple):
    """Objective to maximise (weighted squares of margins, or the smallest margin of grasp and torque), and weights."""

    objective: Objective
    weights: Floats


class ForceCoefficients(NamedTuple):
    """Coefficients (4, 1) of forces as shares of their units: a acceleration + w speed^2 + c cos + s sin.

    The rows are N, -M_A, M_B and the torque (Eqs. 1-3 and 21).
    """

    a: Floats
    w: Floats
    c: Floats
    s: Floats

    @classmethod
    def of(cls, radius: float, arm: Arm, block: Block) -> ForceCoefficients:
        """Return the coefficients of Eqs. 1-3 and 21."""
        d, side, mass = block.half_height, block.half_length, block.mass
        # Inertia about the point of the surface below the centre of mass, per mass [m2].
        spin = block.inertia / mass + d * d
        inertia = arm.inertia + block.inertia + mass * (radius * radius + d * d)
        # Units: m g for N, m g l for moments, and the largest torque; m cancels in the first three rows.
        moment, torque = GRAVITY * side, arm.torque
        rows = (
            (radius / GRAVITY, -d / GRAVITY, 1.0, 0.0),
            ((side * radius - spin) / moment, -d * (side + radius) / moment, 1.0, d / side),
            ((side * radius + spin) / moment, d * (radius - side) / moment, 1.0, -d / side),
            (inertia / torque, 0.0, mass * GRAVITY * radius / torque, -mass * GRAVITY * d / torque),
        )
        return cls(*(np.array(column)[:, None] for column in zip(*rows, strict=True)))


def limit_rows(
    angle: Floats, speed: Floats, acceleration: Floats, bend: ForceCoefficients, arm: Arm
) -> tuple[Floats, tuple[Floats, Floats, Floats]]:
    """Distances to the eleven limits (11, M) in shares at M states, and their partial derivatives by the state."""
    cosine, sine = np.cos(angle), np.sin(angle)
    force = bend.a * acceleration + bend.w * speed * speed + bend.c * cosine + bend.s * sine
    by_angle, by_speed = bend.s * cosine - bend.c * sine, 2.0 * bend.w * speed
    by_rate = np.broadcast_to(bend.a, force.shape)
    half = 0.5 * (arm.angle[1] - arm.angle[0])
    unit, zero = np.ones_like(angle), np.zeros_like(angle)
    last = min(arm.torque_at_speed, arm.torque) / arm.torque
    # Eq. 10: above the knee the torque limit falls linearly with the speed.
    fall = (1.0 - last) / (1.0 - arm.knee)
    line = 1.0 + fall * (arm.knee - speed / arm.speed)
    torque = force[3] + arm.friction / arm.torque
    rows = [*force[:3], (angle - arm.angle[0]) / half, (arm.angle[1] - angle) / half]
    rows += [1.0 - speed / arm.speed, 1.0 + speed / arm.speed, 1.0 - torque, 1.0 + torque]
    rows += [line - torque, line + torque]
    turn, drop = unit / arm.speed, -fall / arm.speed
    t_angle, t_rate = by_angle[3], by_rate[3]
    partial = (
        np.stack([*by_angle[:3], unit / half, -unit / half, zero, zero, -t_angle, t_angle, -t_angle, t_angle]),
        np.stack([*by_speed[:3], zero, zero, -turn, turn, zero, zero, drop * unit, drop * unit]),
        np.stack([*by_rate[:3], zero, zero, zero, zero, -t_rate, t_rate, -t_rate, t_rate]),
    )
    return np.stack(rows), partial


@final
class Programme:
    """The programme for one throw in x (K,): accelerations, margins, and for max-min the smallest margin.

    Args:
        throw: the release.
        arm: the arm, whose limits the motion keeps.
        block: the block on the arm.
        weighing: the objective.
        static_start: whether the block must rest by itself before the throw.
        per_interval: places in each interval at which the limits are kept.
        least: smallest margin at these places, as a share.
    """

    def __init__(
        self,
        throw: Throw,
        arm: Arm,
        block: Block,
        weighing: Weighing,
        *,
        static_start: bool,
        per_interval: int = 2,
        least: float = LEAST,
    ) -> None:
        self.throw, self.arm, self.block, self.weighing = throw, arm, block, weighing
        self.static_start, self.per_interval, self.least = static_start, per_interval, least
        unit = Shapes(np.eye(INTERVALS + 1), per_interval)
        # Columns: effect of a unit acceleration at one border on the samples, for a time step of 1.
        self._rate = ACCELERATION * unit.accelerations.T
        self._speed = ACCELERATION * INTERVALS * unit.speeds.T
        self._way = ACCELERATION * INTERVALS**2 * (unit.angles[:, -1:] - unit.angles).T
        self._bend = ForceCoefficients.of(throw.radius, arm, block)
        self.size = INTERVALS + 7 + (weighing.objective == "max_min")

    def start(self, accelerations: Floats) -> Floats:
        """Return x (K,) for accelerations at the borders (n + 1,) [rad/s2], with the margins of that motion."""
        x = np.zeros(self.size)
        x[: INTERVALS + 1] = accelerations / ACCELERATION
        rows = self._limit_distances(x)[0]
        least = [rows[k].min() for k in (0, 1, 2)]
        least += [rows[3:5].min(), rows[5:7].min(), rows[7:].min()]
        x[INTERVALS + 1 : INTERVALS + 7] = np.maximum(least, self.least)
        if self.weighing.objective == "max_min":
            x[-1] = min(x[INTERVALS + 1 + k] for k in FORCED)
        return x

    def bounds(self) -> list[tuple[float, float]]:
        """Lower and upper bounds of x; the margins of speed and angle are at most the margins at the release."""
        arm, throw = self.arm, self.throw
        half = 0.5 * (arm.angle[1] - arm.angle[0])
        side = min(throw.angle - arm.angle[0], arm.angle[1] - throw.angle) / half
        largest = (np.inf, np.inf, np.inf, side, 1.0 - throw.speed / arm.speed, 1.0)
        free = [(-np.inf, np.inf)]
        margins = [(min(self.least, high), high) for high in largest]
        return [*free * (INTERVALS + 1), *margins, *(free if self.weighing.objective == "max_min" else [])]

    def cost(self, x: Floats) -> tuple[float, Floats]:
        """Return the cost and its gradient (K,): minus the objective of Eq. 28, or minus the smallest margin."""
        gradient = np.zeros(self.size)
        margins = x[INTERVALS + 1 : INTERVALS + 7]
        if self.weighing.objective == "max_min":
            gradient[INTERVALS + 1 : INTERVALS + 7] = -OTHERS
            gradient[-1] = -1.0
            return float(-x[-1] - OTHERS * margins.sum()), gradient
        gradient[INTERVALS + 1 : INTERVALS + 7] = -self.weighing.weights * margins
        return float(-0.5 * (self.weighing.weights * margins * margins).sum()), gradient

    def constraints(self, x: Floats) -> tuple[Floats, Floats]:
        """Return values that must not be negative (C,), and their Jacobian (C, K)."""
        rows, partial, chain = self._limit_distances(x)
        margin = x[INTERVALS + 1 : INTERVALS + 7]
        # The margin that each limit counts for: N, M_A, M_B, two ends of angle and of speed, four limits of the torque.
        owner = np.array([0, 1, 2, 3, 3, 4, 4, 5, 5, 5, 5])
        values = [(rows - margin[owner, None]).ravel()]
        slopes = np.zeros((*rows.shape, self.size))
        slopes[..., : INTERVALS + 1] = (
            partial[0][..., None] * chain[0] + partial[1][..., None] * chain[1] + partial[2][..., None] * chain[2]
        )
        slopes[np.arange(owner.size), :, INTERVALS + 1 + owner] = -1.0
        jacobian = [slopes.reshape(-1, self.size)]
        for value, slope in self._single_constraints(x, chain[0][0]):
            values.append(np.array([value]))
            jacobian.append(slope[None])
        return np.concatenate(values), np.concatenate(jacobian)

    def motion(self, x: Floats) -> ArmMotion:
        """Return the spline of x."""
        accelerations = ACCELERATION * x[: INTERVALS + 1]
        step = self._time_step(x)
        # The speed at the release; it differs from the throw's speed only where x violates its bounds.
        speed = step * float(self._speed[-1] @ x[: INTERVALS + 1])
        start = self.throw.angle - step**2 * float(self._way[0] @ x[: INTERVALS + 1])
        return ArmMotion.of(
            np.array([start]),
            np.array([step]),
            accelerations[None],
            braking_acceleration(np.array([speed]), self.arm),
        )

    def _time_step(self, x: Floats) -> float:
        """Delta t that reaches the release's speed; where none exists, a long Delta t that violates the bounds."""
        gain = float(self._speed[-1] @ x[: INTERVALS + 1])
        return self.throw.speed / max(gain, 0.05 * self.throw.speed / self.arm.time_step)

    def _states(self, x: Floats) -> tuple[tuple[Floats, Floats, Floats], tuple[Floats, Floats, Floats]]:
        """Angle, speed and acceleration at the samples (M,), and their derivatives (M, n + 1)."""
        a, step = x[: INTERVALS + 1], self._time_step(x)
        # Delta t = speed / gain, so its derivative is -Delta t^2 / speed times that of the gain.
        slope = -(step**2) / self.throw.speed * self._speed[-1]
        way, speed = self._way @ a, self._speed @ a
        states = self.throw.angle - step**2 * way, step * speed, self._rate @ a
        chain = (
            -(step**2) * self._way - 2.0 * step * way[:, None] * slope,
            step * self._speed + speed[:, None] * slope,
            self._rate,
        )
        return states, chain

    def _limit_distances(
        self, x: Floats
    ) -> tuple[Floats, tuple[Floats, Floats, Floats], tuple[Floats, Floats, Floats]]:
        """Distances to the eleven limits (11, M) in shares, their partial derivatives by state, and the chain."""
        state, chain = self._states(x)
        rows, partial = limit_rows(*state, self._bend, self.arm)
        return rows, partial, chain

    def _single_constraints(self, x: Floats, start_slope: Floats) -> list[tuple[float, Floats]]:
        """Constraints without samples: bound of Delta t, resting block, and smallest margin; each with its gradient."""
        unit = self.throw.speed / self.arm.time_step
        rows = [(float(self._speed[-1] @ x[: INTERVALS + 1]) / unit - 1.0, self._pad_gradient(self._speed[-1] / unit))]
        if self.static_start:
            start = float(self._states(x)[0][0][0])
            height = self.block.half_height / self.block.half_length
            # A block at rest does not tip: tan |theta| stays below its half length over its half height.
            for sign in (1.0, -1.0):
                value = np.cos(start) - sign * height * np.sin(start) - STATIC_ROOM
                slope = -np.sin(start) - sign * height * np.cos(start)
                rows.append((float(value), self._pad_gradient(slope * start_slope)))
        if self.weighing.objective == "max_min":
            for k in FORCED:
                slope = np.zeros(self.size)
                slope[INTERVALS + 1 + k], slope[-1] = 1.0, -1.0
                rows.append((float(x[INTERVALS + 1 + k] - x[-1]), slope))
        return rows

    def _pad_gradient(self, slope: Floats) -> Floats:
        """Gradient (K,) by x from a gradient (n + 1,) by the accelerations."""
        gradient = np.zeros(self.size)
        gradient[: INTERVALS + 1] = slope
        return gradient
