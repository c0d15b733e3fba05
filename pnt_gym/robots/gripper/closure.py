"""The closure equations of the four forearms and their first derivatives (Leveziel et al., Eqs. 1-4 and 8).

A forearm runs from its elbow B_i to the platform's joint A_i and has the length l. Angles here count from the
outward horizontal of each arm, up positive. The paper's q_1 and q_2 are the angles here; its q_3 and q_4 are pi minus
the angles here, so entries (3, 3) and (4, 4) of J_q have the opposite sign. All arithmetic is element-wise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper.geometry import N_ARMS, Dimensions
from pnt_gym.robots.gripper.pose import map_pieces, pose_rows


@final
@dataclass(frozen=True, eq=False)
class Joints:
    """Coordinates of the platform's joints A_i from each arm's motor axis (4, M), and cosine and sine of theta (M,)."""

    out: Floats
    """Outward coordinate [m]."""
    along: Floats
    """Coordinate along the motor axis [m]: y for arms 1 and 3, x for arms 2 and 4."""
    up: Floats
    """Upward coordinate [m]."""
    cos_theta: Floats
    sin_theta: Floats


@final
@dataclass(frozen=True, eq=False)
class Closure:
    """The forearms B_i to A_i in the paper's letters [m], and entries (2, 4), (4, 4) of J_x [m2]; (M,) each.

    Rows of J_x: (a, y, b, 0), (x, e, f, fold_2), (c, y, d, 0), (x, g, h, fold_4).
    """

    x: Floats
    y: Floats
    a: Floats
    b: Floats
    c: Floats
    d: Floats
    e: Floats
    f: Floats
    g: Floats
    h: Floats
    fold_2: Floats
    fold_4: Floats

    def cofactors(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the cofactors of the fourth column of J_x (M,) each [m3]: triple products of forearms."""
        x, y = self.x, self.y
        # Cross products of forearms 1 and 3, and of 2 and 4.
        n_x, n_y, n_z = y * (self.d - self.b), self.b * self.c - self.a * self.d, y * (self.a - self.c)
        p_x, p_y, p_z = self.e * self.h - self.f * self.g, x * (self.f - self.h), x * (self.g - self.e)
        return (
            # Entry i is the triple product of the forearms other than i, with alternating sign.
            self.c * p_x + y * p_y + self.d * p_z,
            x * n_x + self.g * n_y + self.h * n_z,
            -(self.a * p_x + y * p_y + self.b * p_z),
            -(x * n_x + self.e * n_y + self.f * n_z),
        )

    def determinant(self) -> Floats:
        """Return det J_x (M,) [m5]; positive in the assembly mode of the robot."""
        cofactors = self.cofactors()
        return self.fold_2 * cofactors[1] + self.fold_4 * cofactors[3]

    def blend(self) -> tuple[Floats, Floats, Floats]:
        """Return forearm 2 times fold_4 minus forearm 4 times fold_2 (M,) each [m3]: rows 2 and 4 without theta."""
        m, n = self.fold_2, self.fold_4
        return self.x * (n - m), n * self.e - m * self.g, n * self.f - m * self.h

    def solve(self, load: Floats) -> Floats:
        """Return the (4, M) motion that solves J_x motion = load (4, M); infinite or NaN where J_x is singular."""
        first, second, third, fourth = load
        cofactors = self.cofactors()
        t_x, t_y, t_z = self.blend()
        blend_load = self.fold_4 * second - self.fold_2 * fourth
        y = self.y
        scale = 1.0 / (self.fold_2 * cofactors[1] + self.fold_4 * cofactors[3])
        # Cramer's rule on forearm 1, forearm 3 and the blend, whose determinant is -det J_x.
        weight_1, weight_3, blend = -first * scale, -third * scale, -blend_load * scale
        theta = (cofactors[0] * first + cofactors[1] * second + cofactors[2] * third + cofactors[3] * fourth) * scale
        return np.stack(
            [
                weight_1 * (y * t_z - self.d * t_y)
                + weight_3 * (t_y * self.b - t_z * y)
                + blend * (y * (self.d - self.b)),
                weight_1 * (self.d * t_x - self.c * t_z)
                + weight_3 * (t_z * self.a - t_x * self.b)
                + blend * (self.b * self.c - self.a * self.d),
                weight_1 * (self.c * t_y - y * t_x)
                + weight_3 * (t_x * y - t_y * self.a)
                + blend * (y * (self.a - self.c)),
                theta,
            ]
        )

    def matrix(self) -> Floats:
        """Return J_x (M, 4, 4) as printed below Eq. 8: columns 1 to 3 [m], column 4 [m2]."""
        zero = np.zeros_like(self.a)
        rows = [
            [self.a, self.y, self.b, zero],
            [self.x, self.e, self.f, self.fold_2],
            [self.c, self.y, self.d, zero],
            [self.x, self.g, self.h, self.fold_4],
        ]
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


@final
@dataclass(frozen=True, eq=False)
class Arms:
    """The four arms in M poses; NaN where an arm cannot reach."""

    cos: Floats
    """(4, M) cosine of the arm's angle."""
    sin: Floats
    """(4, M) sine of the arm's angle."""
    drive: Floats
    """(4, M) diagonal of J_q [m2]; zero where an arm is stretched or folded."""
    closure: Closure


def joints(pose: Floats, dims: Dimensions) -> Joints:
    """Platform joints A_i of the (4, M) pose components x, y, z, theta."""
    x, y, z, theta = pose
    cos, sin = np.cos(theta), np.sin(theta)
    half, lift = dims.w * cos + (dims.v - dims.k), dims.w * sin + z
    middle = dims.u - dims.k
    out = np.empty((N_ARMS, x.size))
    along, up = np.empty_like(out), np.empty_like(out)
    np.add(x, middle, out=out[0])
    np.add(y, half, out=out[1])
    np.subtract(middle, x, out=out[2])
    np.subtract(half, y, out=out[3])
    along[0::2], along[1::2] = y, x
    up[0::2], up[1::2] = z, lift
    return Joints(out, along, up, cos, sin)


def solve_joints(points: Joints, dims: Dimensions, branch: Floats | float) -> tuple[Floats, Floats, Floats]:
    """Return cosine, sine and "root" of the arm angles (4, M) (Eqs. 5 and 6, divided by 2 r).

    The closure equation is out cos q + up sin q = reach; ``root`` is minus the branch times the forearm's share
    along the elbow's travel [m], so that J_q = -branch r root. NaN where an arm is out of reach (Eq. 7).
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        planar = points.out * points.out
        planar += points.up * points.up
        reach = points.along * points.along
        reach += planar
        # |A - B|^2 = l^2 with B = r (cos q, sin q): 2 r (out cos q + up sin q) = |A|^2 + r^2 - l^2.
        reach += dims.r**2 - dims.l**2
        reach *= 0.5 / dims.r
        root = np.sqrt(planar - reach * reach)
        signed = root * branch
        np.divide(1.0, planar, out=planar)
        cos = points.out * reach
        cos -= points.up * signed
        cos *= planar
        sin = points.up * reach
        sin += points.out * signed
        sin *= planar
    return cos, sin, root


def forearms(pose: Floats, points: Joints, cos: Floats, sin: Floats, dims: Dimensions) -> Closure:
    """The forearms from the elbows at the arms' angles to the platform joints; a forearm need not have the length l."""
    out, up = points.out - dims.r * cos, points.up - dims.r * sin
    # Forearms 2 and 4 times the derivative of A_2 and A_4 by theta, w (-sin theta, cos theta) outwards and upwards.
    fold = dims.w * (up[1::2] * points.cos_theta - out[1::2] * points.sin_theta)
    return Closure(
        *(pose[0], pose[1]),
        *(out[0], up[0], -out[2], up[2], out[1], up[1], -out[3], up[3]),
        *(fold[0], fold[1]),
    )


def solve_arms(pose: Floats, dims: Dimensions, branch: Floats | float = 1.0) -> Arms:
    """Arm angles, forearms and J_q of the (4, M) pose components, by default in the working branch."""
    points = joints(pose, dims)
    cos, sin, root = solve_joints(points, dims, branch)
    return Arms(cos, sin, root * (-dims.r * branch), forearms(pose, points, cos, sin, dims))


def arms_at(
    pose: ArrayLike, dims: Dimensions, function: Callable[[Arms], Floats], branch: Floats | float = 1.0
) -> Floats:
    """Return values (..., ...) of the arms of poses (..., 4); ``function`` computes the values (M, ...) from the arms.

    Raises:
        PoseError: (a ValueError) the shape is not (..., 4), or a number is not finite.
    """
    shape, rows = pose_rows(pose)
    values = map_pieces(lambda components: function(solve_arms(components, dims, branch)), rows)
    return values.reshape((*shape, *values.shape[1:]))


def excess(closure: Closure, points: Joints, dims: Dimensions) -> Floats:
    """Closure error (|A_i - B_i|^2 - l^2) / 2 of each forearm (4, M) [m2]; its derivative by the pose is J_x."""
    out = np.stack([closure.a, closure.e, closure.c, closure.g])
    up = np.stack([closure.b, closure.f, closure.d, closure.h])
    return 0.5 * (out * out + up * up + points.along * points.along - dims.l**2)
