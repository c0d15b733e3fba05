"""Outcome of throws: the state at the goal, and whether the part rests in its pallet or on another part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.one_joint.config import OneJointConfig, Tolerance
from pnt_gym.cells.one_joint.context import Context
from pnt_gym.cells.one_joint.flight import Flight
from pnt_gym.cells.one_joint.measure import estimated_state
from pnt_gym.cells.one_joint.pallets import Pallet, stack_pose
from pnt_gym.cells.one_joint.tasks import Job
from pnt_gym.planning.one_joint import ThrowPlans


@final
@dataclass(frozen=True)
class SeatTolerance:
    """Largest deviation and motion of a part that rests in its place."""

    position: float
    """Distance of the centre of mass from the exact seat [m]."""
    angle: float
    """Deviation of the angle [rad]."""
    speed: float = 0.02
    """A part at rest creeps by less than 1 mm/s; one that hops or slides is faster [m/s]."""
    spin: float = 0.30
    """Angular speed [rad/s]."""


IN_POCKET: Final = SeatTolerance(position=0.008, angle=float(np.deg2rad(5.0)))
"""A pocket leaves a part 6 mm to one side of the goal and 4 mm to the other; a part that lies on the lip is more than
8 mm off, and one that lies on the back board more than 10 deg."""
ON_STEM: Final = SeatTolerance(position=0.007, angle=float(np.deg2rad(5.0)))
"""A slot has 5 mm of play to either side; a part whose slot or stem is not engaged lies more than 10 mm higher."""


@final
@dataclass(frozen=True)
class Outcome:
    """N throws; every field has shape (N,) unless noted.

    States are x, y [m], phi [rad] and dy [m/s] where the flight passes nearest to the goal (Appendix).
    """

    goal: Floats
    """Goals (N, 4)."""
    measured: Floats
    """State estimated from the camera (N, 4)."""
    true: Floats
    """State of the simulated flight (N, 4)."""
    is_success: Bools
    """Whether the state is within the tolerance; with pallets, whether the part rests in the right pallet and touched
    no other."""
    in_pallet: Bools
    """Whether the part rests in its pallet, or on the previous part; always False without pallets."""
    touched_other: Bools
    """Whether the part touched a pallet other than its target."""
    cycle_time: Floats
    """Time from the start of the arm until the part has arrived and the arm is back [s]."""
    peak_torque: Floats
    """Largest motor torque [N m]."""
    final: Floats
    """Poses x, y, phi of every part at the end (N, P, 3)."""

    @property
    def error(self) -> Floats:
        """Measured state minus goal (N, 4)."""
        return self.measured - self.goal

    @property
    def true_error(self) -> Floats:
        """True state minus goal (N, 4)."""
        return self.true - self.goal

    @property
    def error_x(self) -> Floats:
        """Error along x, measured minus goal (N,) [m]."""
        return self.error[:, 0]

    @property
    def error_y(self) -> Floats:
        """Error upwards, measured minus goal (N,) [m]."""
        return self.error[:, 1]

    @property
    def error_phi(self) -> Floats:
        """Error of the angle, measured minus goal (N,) [rad]."""
        return self.error[:, 2]

    @property
    def error_dy(self) -> Floats:
        """Error of the vertical speed, measured minus goal (N,) [m/s]."""
        return self.error[:, 3]

    @property
    def landing_error(self) -> Floats:
        """True distance of the centre of mass from the goal [m]."""
        return np.hypot(self.true_error[:, 0], self.true_error[:, 1])


def is_within(true_error: Floats, tolerance: Tolerance) -> Bools:
    """Whether states pass their goals within a tolerance (N,).

    Args:
        true_error: state minus goal (N, 4).
        tolerance: largest errors of a success.
    """
    near = np.hypot(true_error[:, 0], true_error[:, 1]) <= tolerance.position
    angle_ok = np.abs(true_error[:, 2]) <= np.deg2rad(tolerance.angle_deg)
    return near & angle_ok & (np.abs(true_error[:, 3]) <= tolerance.speed)


def judge(
    flight: Flight, context: Context, plans: ThrowPlans, job: Job, config: OneJointConfig, return_time: Floats
) -> Outcome:
    """Outcome of N throws.

    Args:
        flight: recorded throws.
        context: the coming throws as they were planned for.
        plans: plans of the throws.
        job: parts and pallets.
        config: level of the cell.
        return_time: time from the arm's standstill back to its start (N,) [s].
    """
    goal, flight_time = context.goal, plans.u[:, 3]
    true = flight.nearest(goal, config.scale.weights())
    in_pallet, touched_other = _judge_rest(job, context.kind, flight)
    good = in_pallet & ~touched_other if job.pallets else is_within(true - goal, config.tolerance)
    return Outcome(
        goal=goal.copy(),
        measured=estimated_state(flight, flight_time, goal, context.hidden.noise, config),
        true=true,
        is_success=good,
        in_pallet=in_pallet,
        touched_other=touched_other,
        cycle_time=np.maximum(flight.release_time + flight_time, plans.motion.stop_time + return_time),
        peak_torque=flight.peak_torque,
        final=flight.final_pose,
    )


def lies_at(pose: Floats, velocity: Floats, seat: Floats, tolerance: SeatTolerance) -> Bools:
    """Whether parts rest in their seats (N,).

    Args:
        pose: x, y [m], phi [rad] (N, 3); whole turns do not matter.
        velocity: velocities (N, 3) [m/s, rad/s].
        seat: pose of a part exactly in its seat (3,) or (N, 3).
        tolerance: largest deviation and motion.
    """
    miss = pose - seat
    turn = np.abs((miss[:, 2] + np.pi) % (2.0 * np.pi) - np.pi)
    near = (np.hypot(miss[:, 0], miss[:, 1]) <= tolerance.position) & (turn <= tolerance.angle)
    still = np.hypot(velocity[:, 0], velocity[:, 1]) <= tolerance.speed
    return near & still & (np.abs(velocity[:, 2]) <= tolerance.spin)


def lies_in(pose: Floats, velocity: Floats, pallet: Pallet) -> Bools:
    """Whether parts rest in a pallet (N,); see `lies_at`."""
    return lies_at(pose, velocity, pallet.pose, IN_POCKET)


def _judge_rest(job: Job, kind: Ints, flight: Flight) -> tuple[Bools, Bools]:
    """Whether throws of kinds (N,) rest in their place, and whether they touched a wrong pallet."""
    if not job.pallets:
        nowhere = np.zeros(len(kind), dtype=np.bool_)
        return nowhere, nowhere
    pose, velocity, touches = flight.final_pose, flight.final_velocity, flight.touches()
    inside = np.stack([lies_in(pose[:, 0], velocity[:, 0], pallet) for pallet in job.pallets], axis=1)
    if job.in_order:
        # The second part of an assembly rests on the first part, which stands on the only pallet; the second part must
        # not touch that pallet.
        second = inside[:, 0] & lies_at(pose[:, 1], velocity[:, 1], stack_pose(pose[:, 0]), ON_STEM)
        return np.where(kind == 0, inside[:, 0], second), (kind == 1) & touches[:, 0]
    is_target = np.arange(len(job.pallets)) == kind[:, None]
    return (inside & is_target).any(axis=1), (touches & ~is_target).any(axis=1)
