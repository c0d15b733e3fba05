"""Kinematics and dynamics of a serial arm, pose by pose. Compiled; see `pnt_gym.compiled`.

**Pose.** The hand is level and unturned. Newton's method starts from the known pose of the nearest point of a grid, so
a pose depends on the hand's place alone and stays on the branch of the grid. Each step solves the normal equations
(J^T J + d) dq = J^T e, with e the errors of the place and of the attitude.

**Rates.** J q' = (v, 0), and J q'' = (a, 0) - J' q', where J' q' is the hand's acceleration at q'' = 0.

**Torques.** Newton and Euler: accelerations outward along the chain, forces and moments inward, all in the axes of the
cell. Gravity is an acceleration of the base.

A place out of reach gives NaN.
"""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.robots.arm.load_kernel import LinkMotion, accelerate, load
from pnt_gym.robots.arm.pose_kernel import find, place_links, solve, work_arrays
from pnt_gym.robots.arm.rows import Link, SeedGrid, Tool
from pnt_gym.rows import Floats1, Floats2, Floats3, Rows1

STEPS = 12
"""Steps of Newton's method from a neighbouring pose, of which four or five are used."""


@kernel_part
def _seed(grid: Rows1[SeedGrid], hand: Floats) -> int:
    """Index of the grid's point nearest to a place."""
    box = grid[0]
    index = 0
    for i in range(3):
        count = box.count_x if i == 0 else (box.count_y if i == 1 else box.count_z)
        place = (hand[i] - box.low[i]) / box.step[i]
        place = 0.0 if np.isnan(place) else min(max(place, 0.0), count - 1.0)
        index = index * count + int(np.floor(place + 0.5))
    return index


@kernel
def improve(links: Rows1[Link], tool: Rows1[Tool], hand: Floats2, steps: int, q: Floats2) -> Floats1:
    """Move poses (M, n) to ones with the hand at places (M, 3), in place; 1 for those that came there, else 0 (M,)."""
    found, work = np.zeros(len(hand)), work_arrays(len(links))
    for k in range(len(hand)):
        if find(links, tool, hand[k], steps, q[k], work):
            found[k] = 1.0
    return found


@kernel
def poses(links: Rows1[Link], tool: Rows1[Tool], grid: Rows1[SeedGrid], seeds: Floats2, hand: Floats2) -> Floats2:
    """Poses (M, n) with the hand at places (M, 3), by the poses of a grid's points (K, n); NaN out of reach."""
    out, work = np.empty((len(hand), len(links))), work_arrays(len(links))
    for k in range(len(hand)):
        out[k] = seeds[_seed(grid, hand[k])]
        if not find(links, tool, hand[k], STEPS, out[k], work):
            out[k] = np.nan
    return out


@kernel
def places(links: Rows1[Link], tool: Rows1[Tool], q: Floats2) -> Floats2:
    """Place of the hand and its axes, row after row (M, 12), at poses (M, n)."""
    out, work, last = np.empty((len(q), 12)), work_arrays(len(links)), len(links)
    for k in range(len(q)):
        place_links(links, tool, q[k], work)
        out[k, :3] = work.origin[last]
        for i in range(3):
            out[k, 3 + 3 * i : 6 + 3 * i] = work.frame[last, i]
    return out


@kernel
def motion(links: Rows1[Link], tool: Rows1[Tool], grid: Rows1[SeedGrid], seeds: Floats2, hand: Floats2) -> Floats3:
    """Positions, velocities, accelerations and torques of the joints (4, n, M) for motions of the hand (M, 9).

    A motion is place, velocity and acceleration [m, m/s, m/s2].
    """
    count = len(links)
    out, work = np.full((4, count, len(hand)), np.nan), work_arrays(count)
    q, rate, change, torque, goal = np.empty(count), np.empty(count), np.empty(count), np.empty(count), np.zeros(6)
    rest = np.zeros(count)
    body = LinkMotion(np.empty((count, 3)), np.empty((count, 3)), np.empty((count + 1, 3)))
    for k in range(len(hand)):
        q[:] = seeds[_seed(grid, hand[k])]
        if not find(links, tool, hand[k], STEPS, q, work):
            continue
        goal[:3], goal[3:] = hand[k, 3:6], 0.0
        solve(work.factor, work.rows, goal, rate)
        accelerate(links, work, rate, rest, body)
        for i in range(3):
            goal[i] = hand[k, 6 + i] - body.pull[count, i]
            goal[3 + i] = -body.spin_up[count - 1, i]
        solve(work.factor, work.rows, goal, change)
        accelerate(links, work, rate, change, body)
        load(links, work, body, torque)
        for j in range(count):
            out[0, j, k], out[1, j, k], out[2, j, k] = q[j], rate[j], change[j]
            out[3, j, k] = torque[j] + links[j].armature * change[j] + links[j].damping * rate[j]
    return out
