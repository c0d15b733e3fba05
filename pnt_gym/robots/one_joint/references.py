"""Motor references of the thrower: angle, speed and feed-forward torque for every physics step.

Semi-implicit Euler moves a joint by the speed at the middle of the step. The joint therefore follows references made of
the planned speeds at the middles of steps without error, and a release in the middle of a step lets go with exactly the
planned speed, although the acceleration jumps at the release.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.planning.one_joint.parameters import Arm


@final
@dataclass(frozen=True)
class Load:
    """The object on the arm, as the controller knows it; every field is (N,)."""

    mass: Floats
    """[kg]"""
    inertia: Floats
    """Inertia about the object's centre of mass [kg m2]."""
    radius: Floats
    """r: distance from the pivot to the centre of mass, along the arm [m]."""
    height: Floats
    """d: height of the centre of mass above the arm [m]."""


@final
@dataclass(frozen=True)
class Clock:
    """Start time and release step of each simulation, on the clock of its planned motion."""

    start: Floats
    """Time of the beginning of step 0 (N,) [s]; at most one step before the motion begins."""
    release_step: Ints
    """The last step with grip (N,); the release is in the middle of this step."""

    @classmethod
    def releasing_at(cls, release: Floats, step: float) -> Clock:
        """The clock that puts releases (N,) [s] in the middle of a step."""
        # 1e-9: a release in the middle of a step stays in that step despite rounding.
        last = np.ceil(release / step - 0.5 - 1e-9).astype(np.int64)
        return cls(release - (last + 0.5) * step, last)


def motor_references(motion: ArmMotion, load: Load, clock: Clock, arm: Arm, step: float, steps: int) -> Floats:
    """Angle [rad], speed [rad/s] and feed-forward torque [N m] at each step: (N, steps, 3).

    Args:
        motion: N motions.
        load: the object that the arm carries until the planned release.
        clock: start time and release step.
        arm: the arm as the controller knows it.
        step: physics step [s].
        steps: number of physics steps.
    """
    begin = clock.start[:, None] + np.arange(-1, steps) * step
    middle = motion.sample(begin + 0.5 * step).speed
    before, during = middle[:, :-1], middle[:, 1:]
    first = motion.sample(clock.start[:, None]).angle
    angle = np.concatenate([first, first + step * np.cumsum(during[:, :-1], axis=1)], axis=1)
    acceleration = (during - before) / step
    # The load counts up to the release, which is in the middle of its step; 1e-9 s absorbs rounding.
    carried = begin[:, 1:] + 0.5 * step <= motion.duration[:, None] + 1e-9
    m, r, d = load.mass[:, None], load.radius[:, None], load.height[:, None]
    # Inverse dynamics of arm and load (Eq. 21); the arm itself is balanced. Parallel axes: the load about the pivot.
    inertia = load.inertia[:, None] + m * (r * r + d * d)
    weight = m * GRAVITY * (r * np.cos(angle) - d * np.sin(angle))
    arm_torque = arm.inertia * acceleration + arm.friction * np.sign(before)
    torque = arm_torque + np.where(carried, inertia * acceleration + weight, 0.0)
    return np.stack([angle, before, torque], axis=-1)
