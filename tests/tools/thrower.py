"""What the tests of the one-joint thrower's cell share: plans that do not need the planner, and closed forms."""

from dataclasses import dataclass

import numpy as np

from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.context import Context
from pnt_gym.cells.one_joint.flight import Flight
from pnt_gym.cells.one_joint.hidden import Hidden, expected_hidden
from pnt_gym.cells.one_joint.plant import OneJointPlant
from pnt_gym.planning.one_joint.motion import ArmMotion
from tests.tools.one_joint import arrival

G = 9.81
BRAKING = -175.0
# Errors that switch every unmodelled effect off, to be switched on one by one.
NO_ERRORS = {
    "radius": 0.0, "inertia": 0.0, "friction": 0.0, "viscous": 0.0, "drag": 0.0, "delay": 0.0, "placement": 0.0,
    "timing": 0.0,
}  # fmt: skip
# Releases theta_t, omega_t, l_t, t_f; the first is that of the paper's goal (0, 0.4 m, 150 deg, 0 m/s).
RELEASES = np.array(
    [
        [np.deg2rad(20.835), 9.3190, 0.27858, 0.24191],
        [np.deg2rad(33.54), 8.616, 0.2764, 0.2967],
        [np.deg2rad(47.17), 9.257, 0.2568, 0.3070],
        [np.deg2rad(37.93), 12.18, 0.220, 0.204],
        [np.deg2rad(-3.10), 7.850, 0.2540, 0.4071],
        [np.deg2rad(-1.63), 8.857, 0.2272, 0.3579],
    ]
)
EXAMPLE = RELEASES[:1]
WEIGHTS = np.array([1.0, 1.0, 0.1, 0.1])


@dataclass(frozen=True)
class Throws:
    """Release states and arm motions: all that the plant needs of a plan."""

    u: np.ndarray
    motion: ArmMotion


def throws(u, duration=0.16):
    """Motions from rest to releases u (N, 4) whose acceleration rises to a plateau within a tenth of the time."""
    u = np.atleast_2d(np.asarray(u, dtype=np.float64))
    count, intervals = len(u), 10
    shape = np.ones((count, intervals + 1))
    shape[:, 0] = 0.5
    step = np.broadcast_to(duration, (count,)) / intervals
    mean = step * (shape.sum(axis=1) - 0.5 * (shape[:, 0] + shape[:, -1]))
    accelerations = shape * (u[:, 1] / mean)[:, None]
    braking = np.full(count, BRAKING)
    way = ArmMotion.of(np.zeros(count), step, accelerations, braking).release_angle
    return Throws(u, ArmMotion.of(u[:, 0] - way, step, accelerations, braking))


def closed_form(u, time, half_height=0.015):
    """x, y, phi (N, M, 3) of drag-free flights at times (N, M) since the release, written out from Newton's laws."""
    angle, spin, reach = u[:, 0], u[:, 1], u[:, 2]
    r = np.sqrt(reach**2 - half_height**2)
    x = r * np.cos(angle) - half_height * np.sin(angle)
    y = r * np.sin(angle) + half_height * np.cos(angle)
    columns = (
        x[:, None] - (spin * y)[:, None] * time,
        y[:, None] + (spin * x)[:, None] * time - 0.5 * G * time**2,
        angle[:, None] + spin[:, None] * time,
    )
    return np.stack(columns, axis=-1)


def state_at_goal(u, half_height=0.015):
    """x, y, phi, dy (N, 4) at the end of drag-free flights u (N, 4)."""
    return arrival(u, half_height)[:, [0, 1, 2, 4]]


def alone(**error) -> OneJointConfig:
    """The nominal cell with one error only and a perfect camera."""
    return OneJointConfig.load("nominal", errors={**NO_ERRORS, **error}, camera={"position": 0.0, "angle_deg": 0.0})


def coming(plan: Throws, hidden: Hidden) -> Context:
    """Throws of the first part into nothing, aimed at where they go without errors."""
    count, goal = len(plan.u), state_at_goal(plan.u)
    first = np.zeros(count, dtype=np.int64)
    return Context(first, first, goal, goal, plan, np.full((count, 1, 3), np.nan), hidden)


def fly(config: OneJointConfig, plan: Throws, hidden: Hidden | None = None, threads: int = 1) -> Flight:
    """Throw the block of a cell, without scatter unless hidden values are given."""
    count = len(plan.u)
    plant = OneJointPlant(config, count, threads)
    return plant.fly(coming(plan, expected_hidden(count, config) if hidden is None else hidden), plan)


def miss(config: OneJointConfig, u=EXAMPLE):
    """How far throws u pass from where they would without errors: x, y, phi, dy (N, 4)."""
    goal = state_at_goal(u)
    return fly(config, throws(u)).nearest(goal, WEIGHTS) - goal
