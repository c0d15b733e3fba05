"""Release states for the tests of pallets, found without the package's planner; and the limits of an arm's motion."""

import numpy as np
from scipy.optimize import fsolve

from pnt_gym.planning.one_joint import Arm, Block
from pnt_gym.planning.one_joint.grasp import joint_torque, reactions, tipping_margin, torque_limit

GUESS = {
    "pallet_1": (0.36, 9.3, 0.279, 0.242),
    "pallet_2": (0.71, 9.4, 0.257, 0.259),
    "pallet_3": (1.10, 9.0, 0.232, 0.256),
    "aitch": (-0.24, 8.0, 0.269, 0.441),
    "tee": (-0.18, 8.0, 0.272, 0.436),
}
"""Near the one feasible release of each goal: the equations have others, with more whole turns."""


def arrival(u, half_height):
    """All six states x, y, phi, dx, dy, dphi (N, 6) at the end of flights from release states (N, 4) (Eq. 11)."""
    theta, omega, radius, flight = u.T
    angle = theta + np.arcsin(half_height / radius)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    velocity = -omega * y, omega * x - 9.81 * flight, omega
    pose = x - omega * y * flight, y + omega * x * flight - 0.5 * 9.81 * flight**2, theta + omega * flight
    return np.stack([*pose, *velocity], axis=-1)


def release(goal, half_height, guess):
    """The release state (4,) near a guess that leads to a goal x, y, phi, dy."""

    def miss(u):
        return arrival(u[None], half_height)[0, [0, 1, 2, 4]] - goal

    u, _, status, message = fsolve(miss, guess, full_output=True, xtol=1e-13)
    assert status == 1, message
    return u


def is_dynamic_grasp(u, part, arm):
    """Whether some acceleration at the release keeps the part on the arm and is within the motor's torque.

    Newton and Euler for part and arm as one body; the forces from the arm act at the two supporting vertices.
    """
    theta, omega, length, _ = u
    d, m, g = part.half_height, part.mass, 9.81
    r = np.sqrt(length**2 - d**2)
    a = np.linspace(0.0, 400.0, 40001)
    normal = m * (a * r - omega**2 * d + g * np.cos(theta))
    along = m * (-a * d - omega**2 * r + g * np.sin(theta))
    outer, inner = part.support
    # About the centre of mass: J a = n_A l_A - n_B l_B + along d, with n_A + n_B = normal.
    n_outer = (part.inertia * a - along * d + normal * inner) / (outer + inner)
    share = np.clip((omega / arm.speed - arm.knee) / (1.0 - arm.knee), 0.0, 1.0)
    limit = arm.torque + share * (arm.torque_at_speed - arm.torque)
    torque = arm.inertia * a + normal * r - along * d + part.inertia * a
    return bool(((n_outer > 0.0) & (normal - n_outer > 0.0) & (torque < limit)).any())


def assert_keeps_all_limits(motion, radius, static=True):
    """At 1 kHz and at the release, from the formulas of the forces alone."""
    arm, block = Arm(), Block()
    times = np.minimum(np.arange(0.0, motion.duration.max() + 1e-3, 1e-3), motion.duration[:, None])
    state = motion.sample(times)
    held = reactions(*state, radius[:, None], block)
    torque = joint_torque(*state, radius[:, None], arm, block)
    assert (held.normal > 0).all() and (held.moment_a < 0).all() and (held.moment_b > 0).all()
    assert (np.abs(torque) < torque_limit(state.speed, arm)).all()
    assert (np.abs(state.speed) < arm.speed).all()
    assert (state.angle > arm.angle[0]).all() and (state.angle < arm.angle[1]).all()
    assert (motion.time_step <= arm.time_step * (1 + 1e-9)).all()
    assert (tipping_margin(motion.start_angle, block) > 0).all() or not static
