"""How fast a hand may move so that no joint exceeds its limits, wherever in its reach and whichever way it moves.

With G the joints' velocities per velocity of the hand, joint k turns at most |G_k| V. Its torque is a sum of gravity,
of damping, of L_k a with the hand's acceleration, and of a quadratic form of its velocity. The sum of their largest
values is a bound of what any motion within V and A can take at one place; the places are a close mesh of the reach and
of its border.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.robots.joints import JointMotion, MotorLimits

SHARE: Final = 0.95
"""Largest share of a joint's speed, torque and range that a hand within its limits takes."""


@final
@dataclass(frozen=True)
class Bound:
    """The largest of a hand's limits that all joints allow, and the joint that allows no more."""

    value: float
    """Largest speed [m/s] or acceleration [m/s2] of the hand; negative where the joints hold the arm at no place."""
    joint: int
    place: Floats
    """Place at which the joint allows no more (3,) [m]."""


@final
@dataclass(frozen=True, eq=False)
class Loads:
    """What motions of the hand at M places ask of n joints."""

    places: Floats
    """Places (M, 3) [m]."""
    position: Floats
    """Positions (n, M)."""
    rates: Floats
    """Largest velocities of the joints at a velocity of 1 (n, M)."""
    weight: Floats
    """Torques at rest (n, M)."""
    drag: Floats
    """Largest torques by the damping of the joints at a velocity of 1 (n, M)."""
    pull: Floats
    """Largest torques by an acceleration of 1 (n, M)."""
    swing: Floats
    """Largest torques by a velocity of 1 (n, M)."""

    @classmethod
    def of(cls, motion: Callable[[Floats, Floats, Floats], JointMotion], places: Floats) -> Loads:
        """Loads by the motions of an arm's joints for places, velocities and accelerations (M, 3) of its hand."""
        axes, zero = np.eye(3), np.zeros(places.shape)
        rest = motion(places, zero, zero)

        def moved(velocity: Floats) -> JointMotion:
            return motion(places, zero + velocity, zero)

        single = [moved(axis) for axis in axes]
        pull = np.stack([motion(places, zero, zero + axis).torque - rest.torque for axis in axes], axis=-1)
        rates = np.stack([part.velocity for part in single], axis=-1)
        # The torque of a velocity is a quadratic form plus friction, which alone changes its sign with the velocity.
        friction = np.stack(
            [(part.torque - moved(-axis).torque) / 2.0 for part, axis in zip(single, axes, strict=True)]
        )
        form = np.zeros((*rest.torque.shape, 3, 3))
        for i, part in enumerate(single):
            form[..., i, i] = part.torque - rest.torque - friction[i]
        for i, j in combinations(range(3), 2):
            both = moved(axes[i] + axes[j]).torque - rest.torque - friction[i] - friction[j]
            form[..., i, j] = form[..., j, i] = (both - form[..., i, i] - form[..., j, j]) / 2.0
        swing = np.abs(np.linalg.eigvalsh(form)).max(axis=-1)
        turn, drag, draw = (np.linalg.norm(values, axis=-1) for values in (rates, np.moveaxis(friction, 0, -1), pull))
        return cls(places, rest.position, turn, np.abs(rest.torque), drag, draw, swing)

    def speed(self, limits: MotorLimits) -> Bound:
        """The hand's largest speed by the speeds of the joints."""
        return self._least(SHARE * limits.speed[:, None] / self.rates)

    def acceleration(self, limits: MotorLimits, speed: float) -> Bound:
        """The hand's largest acceleration by the torques of the motors, at speeds up to one [m/s]."""
        spare = SHARE * limits.torque[:, None] - self.weight - self.drag * speed - self.swing * speed**2
        return self._least(spare / self.pull)

    def range(self, limits: MotorLimits) -> Bound:
        """Where a joint comes nearest to an end of its range: the value is its distance from there [rad, m]."""
        return self._least(np.minimum(self.position - limits.lower[:, None], limits.upper[:, None] - self.position))

    def _least(self, values: Floats) -> Bound:
        joint, place = np.unravel_index(int(np.argmin(values)), values.shape)
        return Bound(float(values[joint, place]), int(joint), self.places[place])
