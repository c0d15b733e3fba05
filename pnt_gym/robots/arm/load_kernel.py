"""Motion and torques of a serial arm in one pose. Parts of compiled functions; see `kernel`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.robots.arm.pose_kernel import Work, add_cross, rotate
from pnt_gym.robots.arm.rows import Link
from pnt_gym.rows import Floats2, Rows1


class LinkMotion(NamedTuple):
    """Motion of the links of an arm of n joints."""

    spin: Floats2
    """Angular velocities (n, 3) [rad/s]."""
    spin_up: Floats2
    """Angular accelerations (n, 3) [rad/s2]."""
    pull: Floats2
    """Accelerations of the links' origins and of the hand (n + 1, 3) [m/s2]."""


@kernel_part
def accelerate(links: Rows1[Link], work: Work, rate: Floats, change: Floats, body: LinkMotion) -> None:
    """Write the motion of the links for joint velocities and accelerations (n,)."""
    spin, spin_up, pull, last = np.zeros(3), np.zeros(3), np.zeros(3), len(links)
    arm = np.zeros(3)
    for k in range(last + 1):
        if k > 0:
            for i in range(3):
                arm[i] = work.origin[k, i] - work.origin[k - 1, i]
            add_swing(spin, spin_up, arm, pull)
        if k < last:
            axis = work.axis[k]
            if links[k].slides > 0.5:
                # The origin moves along the axis, which turns with the link before.
                add_cross(spin, axis, 2.0 * rate[k], pull)
                for i in range(3):
                    pull[i] += axis[i] * change[k]
            else:
                add_cross(spin, axis, rate[k], spin_up)
                for i in range(3):
                    spin[i] += axis[i] * rate[k]
                    spin_up[i] += axis[i] * change[k]
            body.spin[k], body.spin_up[k] = spin, spin_up
        body.pull[k] = pull


@kernel_part
def add_swing(spin: Floats, spin_up: Floats, arm: Floats, pull: Floats) -> None:
    """Add the acceleration of the end of an arm (3,) that turns to that of its begin."""
    swing = np.zeros(3)
    add_cross(spin, arm, 1.0, swing)
    add_cross(spin_up, arm, 1.0, pull)
    add_cross(spin, swing, 1.0, pull)


@kernel_part
def load(links: Rows1[Link], work: Work, body: LinkMotion, torque: Floats) -> None:
    """Write the torques or forces (n,) of the joints that move the links and hold their weight."""
    force, moment, pull, arm, own = np.zeros(3), np.zeros(3), np.empty(3), np.empty(3), np.empty(3)
    last = len(links)
    for k in range(last - 1, -1, -1):
        link = links[k]
        if k < last - 1:
            for i in range(3):
                arm[i] = work.origin[k + 1, i] - work.origin[k, i]
            add_cross(arm, force, 1.0, moment)
        rotate(work.frame[k], link.centre, arm)
        pull[:] = body.pull[k]
        add_swing(body.spin[k], body.spin_up[k], arm, pull)
        pull[2] += GRAVITY
        for i in range(3):
            own[i] = link.mass * pull[i]
            force[i] += own[i]
        add_cross(arm, own, 1.0, moment)
        add_spin_load(link, work.frame[k], body.spin[k], body.spin_up[k], moment)
        total = 0.0
        for i in range(3):
            total += work.axis[k, i] * (force[i] if link.slides > 0.5 else moment[i])
        torque[k] = total


@kernel_part
def add_spin_load(link: Link, frame: Floats, spin: Floats, spin_up: Floats, moment: Floats) -> None:
    """Add the moment that turns a link about its centre of mass (Euler)."""
    turned, inertia = np.zeros(3), np.zeros(3)
    for i in range(3):  # in the link's axes
        for j in range(3):
            held, raised = 0.0, 0.0
            for m in range(3):
                held += frame[m, j] * spin[m]
                raised += frame[m, j] * spin_up[m]
            inertia[i] += link.inertia[3 * i + j] * held
            turned[i] += link.inertia[3 * i + j] * raised
    out = np.empty(3)
    rotate(frame, turned, out)
    for i in range(3):
        moment[i] += out[i]
    rotate(frame, inertia, out)
    add_cross(spin, out, 1.0, moment)
