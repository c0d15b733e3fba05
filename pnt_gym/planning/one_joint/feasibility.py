"""Feasibility of releases for arm, motor and grasp, with a sentence for each reason against a release."""

from __future__ import annotations

from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.errors import PntGymError
from pnt_gym.planning.one_joint.grasp import AccelerationWindow, acceleration_window, braking_acceleration, reactions
from pnt_gym.planning.one_joint.parameters import Arm, Block
from pnt_gym.planning.reasons import ReasonCode


@final
class ThrowReason(ReasonCode):
    """Why a goal has no throw; codes rise from farthest from a throw to nearest."""

    FEASIBLE = 0, "a throw exists"
    NO_RELEASE = 1, "no release within the arm's range of angles reaches the goal"
    SPEED = 2, "the speed of the release is outside the arm's limits"
    ANGLE = 3, "the angle of the release is outside the arm's range"
    RADIUS = 4, "the block would lie beyond the arm's end"
    WINDOW = 5, "no acceleration at the release keeps both grasp and torque limit"
    HELD = 6, "the motor cannot brake hard enough to let the block go"
    NO_MOTION = 7, "no motion from rest to the release keeps grasp and limits"


@final
class UnreachableGoal(PntGymError):
    """No throw reaches the goal; ``reasons`` says which limit each release to the goal breaks."""

    def __init__(self, goal: Floats, reasons: tuple[str, ...]) -> None:
        self.reasons = reasons
        x, y, phi, dy = (float(v) for v in goal)
        super().__init__(
            f"no throw reaches x = {x:.4g} m, y = {y:.4g} m, phi = {np.rad2deg(phi):.4g} deg, dy = {dy:.4g} m/s: "
            + "; ".join(reasons)
        )


def arm_radius(u: Floats, half_height: float) -> Floats:
    """Return r (...,) along the arm for l_t of the releases ``u`` (..., 4) (Eq. 26)."""
    return np.sqrt(np.maximum(u[..., 2] ** 2 - half_height**2, 0.0))


def first_reason(u: Floats, arm: Arm, block: Block) -> tuple[Ints, Floats]:
    """Return the first `ThrowReason` against each release (N, 4), and the width of its acceleration window [rad/s2]."""
    radius = arm_radius(u, block.half_height)
    window, lets_go = _at_release(u, radius, arm, block)
    checks = (
        (ThrowReason.SPEED, (u[:, 1] > 0.0) & (u[:, 1] < arm.speed)),
        (ThrowReason.ANGLE, (u[:, 0] > arm.angle[0]) & (u[:, 0] < arm.angle[1])),
        (ThrowReason.RADIUS, (radius > 0.0) & (radius <= arm.largest_radius(block))),
        (ThrowReason.WINDOW, window.is_open),
        (ThrowReason.HELD, lets_go),
    )
    reason = np.full(u.shape[0], int(ThrowReason.FEASIBLE), dtype=np.int64)
    for code, holds in reversed(checks):
        reason = np.where(holds, reason, int(code))
    return reason, window.high - window.low


def reasons_of(u: Floats, arm: Arm, block: Block) -> tuple[str, ...]:
    """Return all reasons against a release (4,), each with value and limit; empty for a feasible release."""
    angle, speed, _, _ = (float(v) for v in u)
    radius, longest = float(arm_radius(u, block.half_height)), arm.largest_radius(block)
    low, high = arm.angle
    reasons: list[str] = []
    if speed <= 0.0:
        reasons.append(f"speed {speed:.4g} rad/s is not positive; the arm throws anticlockwise")
    if abs(speed) >= arm.speed:
        reasons.append(f"speed {speed:.4g} rad/s is not below the limit of {arm.speed:.4g} rad/s")
    if not low < angle < high:
        degrees = np.rad2deg([angle, low, high])
        reasons.append(f"angle {degrees[0]:.4g} deg is out of the range {degrees[1]:.4g} to {degrees[2]:.4g} deg")
    if radius <= 0.0:
        reasons.append("radius r is 0 m, too short; the block must lie to the right of the pivot")
    if radius > longest:
        reasons.append(f"radius r = {radius:.4g} m is too long; the block is whole on the arm up to {longest:.4g} m")
    if reasons:
        return tuple(reasons)
    window, lets_go = _at_release(u, np.array(radius), arm, block)
    if not window.is_open:
        return (
            f"no acceleration window: the grasp needs more than {float(window.low):.4g} rad/s2 at the release, "
            f"the motor gives less than {float(window.high):.4g} rad/s2",
        )
    if not lets_go:
        brake = float(braking_acceleration(u[1], arm))
        return (f"the motor brakes with at most {-brake:.4g} rad/s2, too little to let the block go",)
    return ()


def _at_release(u: Floats, radius: Floats, arm: Arm, block: Block) -> tuple[AccelerationWindow, Bools]:
    """Window of accelerations up to releases, and whether the surface falls away from the block once the arm brakes.

    The surface falls away where the normal force N is negative.
    """
    angle, speed = u[..., 0], u[..., 1]
    # A radius of zero has its own reason, `RADIUS`.
    window = acceleration_window(angle, speed, np.where(radius > 0.0, radius, 1.0), arm, block)
    return window, reactions(angle, speed, braking_acceleration(speed, arm), radius, block).normal < 0.0
