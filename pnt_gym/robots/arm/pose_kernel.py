"""One pose of a serial arm: frames, Jacobian, Newton's method. Parts of compiled functions; see `kernel`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel_part
from pnt_gym.robots.arm.rows import Link, Tool
from pnt_gym.rows import Floats2, Floats3, Rows1

CLOSE = 1e-11
"""Largest error of a pose [m, rad]."""
DAMPING = 1e-4
"""Damping of the normal equations per metre or radian of error, which keeps steps short beside singular poses."""
REACH = 0.5
"""Largest change of a joint in one step [rad, m]."""


class Work(NamedTuple):
    """Arrays that hold one pose of an arm of n joints; index n of frames and origins is the hand."""

    frame: Floats3
    """Axes of the links as columns (n + 1, 3, 3)."""
    origin: Floats2
    """Origins of the links (n + 1, 3) [m]."""
    axis: Floats2
    """Axes of the joints (n, 3)."""
    rows: Floats2
    """Motion of the hand per joint velocity (n, 6)."""
    factor: Floats2
    """Lower factor of J^T J (n, n)."""


@kernel_part
def turn(axis: Floats, angle: float, before: Floats, after: Floats) -> None:
    """Write the frame (3, 3) `before`, turned about its own axis by an angle, to `after` (Rodrigues)."""
    x, y, z = axis[0], axis[1], axis[2]
    cos, sin = np.cos(angle), np.sin(angle)
    rest = 1.0 - cos
    for i in range(3):
        a, b, c = before[i, 0], before[i, 1], before[i, 2]
        along = (a * x + b * y + c * z) * rest
        after[i, 0] = a * cos + (b * z - c * y) * sin + x * along
        after[i, 1] = b * cos + (c * x - a * z) * sin + y * along
        after[i, 2] = c * cos + (a * y - b * x) * sin + z * along


@kernel_part
def rotate(frame: Floats, vector: Floats, out: Floats) -> None:
    """Write a vector of a frame (3, 3) in the cell's axes."""
    for i in range(3):
        out[i] = frame[i, 0] * vector[0] + frame[i, 1] * vector[1] + frame[i, 2] * vector[2]


@kernel_part
def add_cross(a: Floats, b: Floats, factor: float, out: Floats) -> None:
    """Add factor times a x b to a vector."""
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    z = a[0] * b[1] - a[1] * b[0]
    out[0] += factor * x
    out[1] += factor * y
    out[2] += factor * z


@kernel_part
def place_links(links: Rows1[Link], tool: Rows1[Tool], q: Floats, work: Work) -> None:
    """Write frames (n + 1, 3, 3), origins (n + 1, 3) and joint axes (n, 3) of links and hand at a pose.

    Index k is the link of joint k, index n the hand.
    """
    frame, origin, axis = work.frame, work.origin, work.axis
    before, shift = np.eye(3), np.empty(3)
    for k in range(len(links)):
        link = links[k]
        rotate(before, link.offset, shift)
        for i in range(3):
            origin[k, i] = shift[i] + (origin[k - 1, i] if k > 0 else 0.0)
        rotate(before, link.axis, axis[k])
        if link.slides > 0.5:
            frame[k] = before
            for i in range(3):
                origin[k, i] += axis[k, i] * q[k]
        else:
            turn(link.axis, q[k], before, frame[k])
        before = frame[k]
    last = len(links)
    rotate(before, tool[0].offset, shift)
    for i in range(3):
        origin[last, i] = origin[last - 1, i] + shift[i]
        for j in range(3):
            frame[last, i, j] = 0.0
            for m in range(3):
                frame[last, i, j] += before[i, m] * tool[0].turn[3 * m + j]


@kernel_part
def jacobian(links: Rows1[Link], origin: Floats, axis: Floats, out: Floats) -> None:
    """Write the hand's velocity and angular velocity per joint velocity (n, 6)."""
    last, arm = len(links), np.empty(3)
    for k in range(last):
        out[k] = 0.0
        if links[k].slides > 0.5:
            out[k, :3] = axis[k]
            continue
        for i in range(3):
            arm[i] = origin[last, i] - origin[k, i]
        add_cross(axis[k], arm, 1.0, out[k, :3])
        out[k, 3:] = axis[k]


@kernel_part
def factor_rows(rows: Floats, damping: float, out: Floats) -> None:
    """Write the lower factor of J J^T + damping, for rows J (n, 6) (Cholesky)."""
    count = len(rows)
    for i in range(count):
        for j in range(i + 1):
            total = damping if i == j else 0.0
            for m in range(6):
                total += rows[i, m] * rows[j, m]
            for m in range(j):
                total -= out[i, m] * out[j, m]
            out[i, j] = np.sqrt(total) if i == j else total / out[j, j]


@kernel_part
def solve(factor: Floats, rows: Floats, goal: Floats, out: Floats) -> None:
    """Write the joint values that give a motion (6,) of the hand, with the factor of `_factor`."""
    count = len(rows)
    for i in range(count):
        total = 0.0
        for m in range(6):
            total += rows[i, m] * goal[m]
        for m in range(i):
            total -= factor[i, m] * out[m]
        out[i] = total / factor[i, i]
    for i in range(count - 1, -1, -1):
        total = out[i]
        for m in range(i + 1, count):
            total -= factor[m, i] * out[m]
        out[i] = total / factor[i, i]


@kernel_part
def miss(frame: Floats, place: Floats, hand: Floats, out: Floats) -> float:
    """Write the errors of place and attitude (6,) of a hand, and return the largest; the attitude's is a half turn.

    The error of the attitude is the axis of the turn to the cell's axes, times the sine of its angle.
    """
    largest = 0.0
    for i in range(3):
        out[i] = hand[i] - place[i]
    out[3] = (frame[1, 2] - frame[2, 1]) / 2.0
    out[4] = (frame[2, 0] - frame[0, 2]) / 2.0
    out[5] = (frame[0, 1] - frame[1, 0]) / 2.0
    for i in range(6):
        largest = max(largest, abs(out[i]))
    if frame[0, 0] + frame[1, 1] + frame[2, 2] < 1.0:  # more than a right angle, where the sine falls again
        largest = max(largest, 1.0)
    return largest


@kernel_part
def work_arrays(count: int) -> Work:
    """Arrays for an arm of n joints."""
    return Work(
        np.empty((count + 1, 3, 3)),
        np.empty((count + 1, 3)),
        np.empty((count, 3)),
        np.empty((count, 6)),
        np.empty((count, count)),
    )


@kernel_part
def find(links: Rows1[Link], tool: Rows1[Tool], hand: Floats, steps: int, q: Floats, work: Work) -> bool:
    """Move a pose (n,) to one with the hand at a place by Newton's method, in place; whether it came there."""
    count, error, step = len(links), np.empty(6), np.empty(len(links))
    for attempt in range(steps + 1):
        place_links(links, tool, q, work)
        jacobian(links, work.origin, work.axis, work.rows)
        largest = miss(work.frame[count], work.origin[count], hand, error)
        if largest < CLOSE:
            factor_rows(work.rows, 0.0, work.factor)
            return True
        if attempt == steps or not largest < np.inf:
            break
        factor_rows(work.rows, DAMPING * largest, work.factor)
        solve(work.factor, work.rows, error, step)
        longest = 1.0
        for i in range(count):
            longest = max(longest, abs(step[i]) / REACH)
        for i in range(count):
            q[i] += step[i] / longest
    return False
