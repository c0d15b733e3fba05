"""Kinematics, dynamics and references of the T3KR-class robot, pose by pose. Compiled; see `pnt_gym.compiled`.

**Pose.** In an arm's plane, with d from the pivot to the platform joint, L the arm's and l the rod's length,
|d - L n(q)|^2 = l^2 is k = d_x cos q + d_z sin q with k = (|d|^2 + L^2 - l^2) / 2L; the outward elbow is the root with
the larger q.

**Rates.** With t the elbow's direction of travel, v and a the motion of the TCP, |rod| = const has the derivatives
rod . (v - L q' t) = 0 and rod . (a - L q'' t + L q'^2 n) + |rod'|^2 = 0.

**Torques.** Rods are slender bars: with end accelerations a and b, the inertial forces at the ends are m (2 a + b) / 6
and m (a + 2 b) / 6. Four motors move three coordinates; the torques are those of the smallest norm.

A pose out of reach gives NaN.
"""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.robots.t3kr.geometry import ArmFrame, Mechanism
from pnt_gym.rows import Floats1, Floats2, Floats3, Rows1

ARMS = 4


@kernel_part
def _arm_pose(
    frame: ArmFrame, links: Mechanism, x: float, y: float, z: float
) -> tuple[float, float, float, float, float, float, float]:
    """An arm's cosine and sine, rod (outward, along the motor axis, up), root and reach at a TCP (x, y, z).

    The root is minus the rod's component along the elbow's direction of travel, zero where the arm is singular; the
    reach is k.
    """
    d_x = frame.cos * x + frame.sin * y + frame.offset_x
    d_y = frame.cos * y - frame.sin * x + frame.offset_y
    d_z = z + links.offset_z
    planar = d_x * d_x + d_z * d_z
    reach = (planar + d_y * d_y + links.squares) * links.half
    # The direction of d, turned by the angle whose cosine is k / |d| in the plane.
    root = np.sqrt(planar - reach * reach)
    scale = 1.0 / planar
    cos = (d_x * reach - d_z * root) * scale
    sin = (d_z * reach + d_x * root) * scale
    return cos, sin, d_x - links.length * cos, d_y, d_z - links.length * sin, root, reach


@kernel_part
def _arm_row(
    frame: ArmFrame, length: float, root: float, rod_x: float, rod_y: float, rod_z: float
) -> tuple[float, float, float]:
    """Derivative of an arm's angle by the TCP."""
    scale = -1.0 / (length * root)
    out, along, up = rod_x * scale, rod_y * scale, rod_z * scale
    return frame.cos * out - frame.sin * along, frame.sin * out + frame.cos * along, up


@kernel_part
def _solve_normal(rows: Floats, load_x: float, load_y: float, load_z: float) -> tuple[float, float, float]:
    """Solve (R^T R) x = load by cofactors, with R the rows (4, 3)."""
    # Entries of the symmetric matrix R^T R.
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for arm in range(ARMS):
        x, y, z = rows[arm, 0], rows[arm, 1], rows[arm, 2]
        xx, yy, zz = xx + x * x, yy + y * y, zz + z * z
        xy, xz, yz = xy + x * y, xz + x * z, yz + y * z
    # Cofactors of the first row, which give the determinant; then the other cofactors.
    c_xx, c_xy, c_xz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    scale = 1.0 / (xx * c_xx + xy * c_xy + xz * c_xz)
    a, b, c = load_x * scale, load_y * scale, load_z * scale
    c_yy, c_yz, c_zz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    return c_xx * a + c_xy * b + c_xz * c, c_xy * a + c_yy * b + c_yz * c, c_xz * a + c_yz * b + c_zz * c


@kernel
def arm_poses(tcp: Floats2, arms: Rows1[ArmFrame], mechanism: Rows1[Mechanism]) -> Floats3:
    """Cosine and sine of each arm, and the rod's components in its frame (5, 4, M), for TCPs (M, 3)."""
    links, out = mechanism[0], np.empty((5, ARMS, len(tcp)))
    for k in range(tcp.shape[0]):
        for arm in range(ARMS):
            pose = _arm_pose(arms[arm], links, tcp[k, 0], tcp[k, 1], tcp[k, 2])
            out[0, arm, k], out[1, arm, k] = pose[0], pose[1]
            out[2, arm, k], out[3, arm, k], out[4, arm, k] = pose[2], pose[3], pose[4]
    return out


@kernel
def jacobian(tcp: Floats2, arms: Rows1[ArmFrame], mechanism: Rows1[Mechanism]) -> Floats3:
    """Derivatives of the arm angles by the TCP (M, 4, 3), for TCPs (M, 3)."""
    links, out = mechanism[0], np.empty((len(tcp), ARMS, 3))
    for k in range(tcp.shape[0]):
        for arm in range(ARMS):
            _, _, rod_x, rod_y, rod_z, root, _ = _arm_pose(arms[arm], links, tcp[k, 0], tcp[k, 1], tcp[k, 2])
            out[k, arm, 0], out[k, arm, 1], out[k, arm, 2] = _arm_row(
                arms[arm], links.length, root, rod_x, rod_y, rod_z
            )
    return out


@kernel
def closed_velocity(tcp: Floats2, velocity: Floats2, arms: Rows1[ArmFrame], mechanism: Rows1[Mechanism]) -> Floats3:
    """Rates of arms, of rods in the arm's plane and of rods out of it (3, 4, M), for moving TCPs (M, 3)."""
    links, out = mechanism[0], np.empty((3, ARMS, len(tcp)))
    length = links.length
    for k in range(tcp.shape[0]):
        x, y, z = velocity[k, 0], velocity[k, 1], velocity[k, 2]
        for arm in range(ARMS):
            frame = arms[arm]
            cos, sin, rod_x, rod_y, rod_z, root, _ = _arm_pose(frame, links, tcp[k, 0], tcp[k, 1], tcp[k, 2])
            row_x, row_y, row_z = _arm_row(frame, length, root, rod_x, rod_y, rod_z)
            turn = row_x * x + row_y * y + row_z * z
            # The rod's lower end moves with the platform, its upper end with the elbow: difference of the velocities.
            out_rate = frame.cos * x + frame.sin * y + length * sin * turn
            along = frame.cos * y - frame.sin * x
            up = z - length * cos * turn
            planar = rod_x * rod_x + rod_z * rod_z
            level = np.sqrt(planar)
            lean = along * level - rod_y * (rod_x * out_rate + rod_z * up) / level
            out[0, arm, k] = turn
            out[1, arm, k] = (rod_x * up - rod_z * out_rate) / planar - turn
            out[2, arm, k] = lean / (planar + rod_y * rod_y)
    return out


@kernel
def close_loops(arm: Floats2, swing: Floats2, tilt: Floats2, rods: int, hand: Floats2, platform: Floats1) -> Floats2:
    """Rows of joint values (N, n) as `kinematics.closed_pose` has them; rows with a NaN are NaN.

    Args:
        arm: values of the arms (4, N).
        swing: values of the rods in their arms' planes (4, N).
        tilt: values of the rods out of these planes (4, N).
        rods: number of rods of each arm, one or two.
        hand: values of the TCP (N, 3).
        platform: values of the platform; none with one rod.
    """
    each, size = 1 + 2 * rods, len(platform)
    values = np.empty((len(hand), ARMS * each + 3 + size))
    for k in range(len(values)):
        row = values[k]
        for i in range(ARMS):
            row[each * i] = arm[i, k]
            for rod in range(each * i + 1, each * (i + 1), 2):
                row[rod], row[rod + 1] = swing[i, k], tilt[i, k]
        row[ARMS * each : ARMS * each + 3] = hand[k]
        row[ARMS * each + 3 :] = platform
        if np.isnan(row).any():
            row[:] = np.nan
    return values


@kernel
def fit_points(centre: Floats3, radius: float, point: Floats2) -> None:
    """Move points (M, 3) by two Gauss-Newton steps towards a distance from four centres each (M, 4, 3), in place."""
    rods = np.empty((ARMS, 3))
    for k in range(point.shape[0]):
        for _ in range(2):
            load_x, load_y, load_z = 0.0, 0.0, 0.0
            for arm in range(ARMS):
                x, y, z = (
                    point[k, 0] - centre[k, arm, 0],
                    point[k, 1] - centre[k, arm, 1],
                    point[k, 2] - centre[k, arm, 2],
                )
                norm = np.sqrt(x * x + y * y + z * z)
                rods[arm, 0], rods[arm, 1], rods[arm, 2] = x / norm, y / norm, z / norm
                gap = radius - norm
                load_x, load_y, load_z = load_x + x / norm * gap, load_y + y / norm * gap, load_z + z / norm * gap
            # The step d of least squares, R^T R d = R^T gaps, with the unit rods as the rows of R.
            x, y, z = _solve_normal(rods, load_x, load_y, load_z)
            point[k, 0] += x
            point[k, 1] += y
            point[k, 2] += z


@final
class HandMotion(NamedTuple):
    """Position [m], velocity [m/s] and acceleration [m/s2] of the TCP at M moments, (M, 3) each."""

    position: Floats2
    velocity: Floats2
    acceleration: Floats2


@kernel_part
def _repeats(hand: HandMotion, payload: Floats, k: int) -> bool:
    """Whether a moment is as the moment before, as after the end of a motion."""
    for axis in range(3):
        if hand.position[k, axis] != hand.position[k - 1, axis]:
            return False
        if hand.velocity[k, axis] != hand.velocity[k - 1, axis]:
            return False
        if hand.acceleration[k, axis] != hand.acceleration[k - 1, axis]:
            return False
    return payload[k] == payload[k - 1]


@kernel
def joint_motion(hand: HandMotion, payload: Floats1, arms: Rows1[ArmFrame], mechanism: Rows1[Mechanism]) -> Floats3:
    """Cosine, sine, velocity, acceleration and motor torque of each arm (5, 4, M).

    Args:
        hand: motion of the TCP.
        payload: masses that the platform holds (M,) [kg].
        arms: frames of the arms.
        mechanism: one row.
    """
    out = np.empty((5, ARMS, len(payload)))
    links, rows = mechanism[0], np.empty((ARMS, 3))
    length, coupling = links.length, links.coupling
    for k in range(payload.size):
        if k > 0 and _repeats(hand, payload, k):
            out[:, :, k] = out[:, :, k - 1]
            continue
        place, velocity, acceleration = hand.position[k], hand.velocity[k], hand.acceleration[k]
        v_x, v_y, v_z = velocity[0], velocity[1], velocity[2]
        a_x, a_y, a_z = acceleration[0], acceleration[1], acceleration[2]
        speed2 = v_x * v_x + v_y * v_y + v_z * v_z
        pull_x, pull_y, pull_z = 0.0, 0.0, 0.0
        for arm in range(ARMS):
            frame, row = arms[arm], rows[arm]
            cos, sin, rod_x, rod_y, rod_z, root, reach = _arm_pose(frame, links, place[0], place[1], place[2])
            row[0], row[1], row[2] = _arm_row(frame, length, root, rod_x, rod_y, rod_z)
            turn = row[0] * v_x + row[1] * v_y + row[2] * v_z
            # Components of the TCP's velocity and acceleration along the elbow's direction of travel.
            speed_along = v_z * cos - (frame.cos * v_x + frame.sin * v_y) * sin
            pull_along = a_z * cos - (frame.cos * a_x + frame.sin * a_y) * sin
            elbow = length * turn
            rod_rate2 = speed2 + elbow * (elbow - 2.0 * speed_along)
            centripetal = elbow * turn * (reach - length)
            linear = row[0] * a_x + row[1] * a_y + row[2] * a_z
            rate = linear - (rod_rate2 + centripetal) / (length * root)
            out[0, arm, k], out[1, arm, k], out[2, arm, k], out[3, arm, k] = cos, sin, turn, rate
            # Torque that moves the motor, the arm and the rods' upper ends.
            out[4, arm, k] = links.inertia * rate + links.weight * cos + coupling * pull_along
            # Acceleration of the elbow over the arm's length, outward and up: tangential and centripetal.
            outward, up = -(rate * sin + turn * turn * cos), rate * cos - turn * turn * sin
            pull_x, pull_y, pull_z = pull_x + frame.cos * outward, pull_y + frame.sin * outward, pull_z + up
        # A slender rod puts a third of its inertia and half of its weight on its lower end, and couples a sixth of its
        # mass to the elbow.
        moved, weight = payload[k] + links.moved, (payload[k] + links.carried) * GRAVITY
        x, y, z = _solve_normal(
            rows,
            moved * a_x + coupling * pull_x,
            moved * a_y + coupling * pull_y,
            moved * a_z + coupling * pull_z + weight,
        )
        # Minimum-norm motor torques with J^T torque = load: J (J^T J)^-1 load.
        for arm in range(ARMS):
            out[4, arm, k] += rows[arm, 0] * x + rows[arm, 1] * y + rows[arm, 2] * z
    return out
