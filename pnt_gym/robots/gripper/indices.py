"""Indices of the platform's mobility, kappa and tau, and the singularities (Leveziel et al., section V).

Eqs. 9 and 10 are evaluated without inverting J_x, so both indices reach zero smoothly at a singularity instead of
ending in 0/0. An index is NaN where the pose is out of reach. kappa is exact to 1e-8 where its two largest singular
values are equal, and to rounding elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, number
from pnt_gym.planning.motion.roots import bisect
from pnt_gym.robots.gripper.closure import Arms, arms_at, solve_arms
from pnt_gym.robots.gripper.geometry import PROTOTYPE, Dimensions
from pnt_gym.robots.gripper.pose import map_pieces, pose_rows

PUBLISHED_TAU_SCALE: Final = 2.65
"""Factor from Eq. 10 to the published figures (tau over 0.1, 1/tau up to 10.3); likely w in cm left out of J_x."""

# The sign of det J_x is sampled at these steps of theta; bisection then finds the zero to rounding.
_SEARCH_STEP = np.deg2rad(1.0)
_HALVINGS = 50


@final
@dataclass(frozen=True, eq=False)
class Singularity:
    """Distance of poses from the singularities of J_x; both arrays have the shape of the poses."""

    value: Floats
    """det J_x / (l^4 w), 0.99 at the prototype's home; zero at a singularity, negative past it, NaN out of reach."""
    mask: Bools
    """Whether a pose is at or past a singularity."""


def conditioning(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE) -> tuple[Floats, Floats]:
    """Return kappa (Eq. 9) and tau (Eq. 10) in the working branch.

    kappa is the ratio of the singular values of the first three rows of J; 1 is best, 0 singular. tau is one over the
    norm of the last row, the motors' motion per angle of folding while the platform may drift. tau is Eq. 10 as
    printed; divided by `PUBLISHED_TAU_SCALE` it gives the published figures.

    Args:
        pose: (..., 4) x, y, z [m], theta [rad].
        dimensions: the robot.

    Returns:
        kappa and tau (...,), without unit; NaN where out of reach.

    Raises:
        PoseError: (a ValueError) the shape is not (..., 4), or a number is not finite.
    """
    values = arms_at(pose, dimensions, lambda arms: np.stack([arms_kappa(arms, dimensions), arms_tau(arms)], axis=1))
    return values[..., 0].copy(), values[..., 1].copy()


def kappa(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE) -> Floats:
    """Return kappa (...,) of Eq. 9, as `conditioning`."""
    return arms_at(pose, dimensions, lambda arms: arms_kappa(arms, dimensions))


def tau(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE) -> Floats:
    """Return tau (...,) of Eq. 10, as `conditioning`."""
    return arms_at(pose, dimensions, arms_tau)


def folding_speed(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE) -> Floats:
    """Return 1 / |J_q^-1 J_x e_4| (...,): folding per motor motion while the platform stays in place.

    tau lets the platform drift; a gripper that closes around an object must not. Arguments, NaN and errors as
    `conditioning`.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        return arms_at(
            pose,
            dimensions,
            lambda arms: 1.0 / np.hypot(arms.closure.fold_2 / arms.drive[1], arms.closure.fold_4 / arms.drive[3]),
        )


def singularity(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, tolerance: float = 1e-9) -> Singularity:
    """Return det J_x, without unit, and whether the determinant is at most ``tolerance``.

    A singularity needs both halves of the platform coplanar with their forearms; the determinant shows whether both
    are. Arguments and errors as `conditioning`.
    """
    size = dimensions.l**4 * dimensions.w
    value = arms_at(pose, dimensions, lambda arms: arms.closure.determinant() / size)
    return Singularity(value, value <= number(tolerance, "tolerance"))


def singular_angle(position: ArrayLike = (0.0, 0.0, -0.2), dimensions: Dimensions = PROTOTYPE) -> Floats:
    """Return the smallest angle of the halves above home at which J_x is singular.

    Args:
        position: (..., 3) of the platform's middle [m].
        dimensions: the robot.

    Returns:
        (...,) theta [rad] up to pi/2; NaN where there is none, or where the position is out of reach before.

    Raises:
        PoseError: (a ValueError) the shape is not (..., 3), or a number is not finite.
    """
    shape, rows = pose_rows(position, "position", 3)
    return map_pieces(lambda components: _first_root(components, dimensions), rows).reshape(shape)


def arms_kappa(arms: Arms, dims: Dimensions) -> Floats:
    """Eq. 9, kappa (M,): without theta, rows 2 and 4 of J_x leave one row, so J^-1 on translations is 3 x 3.

    The rows of J^-1 are forearm 1 / J_q1, forearm 3 / J_q3 and blend / sqrt(N), multiplied here by all three
    denominators.
    """
    closure, drive = arms.closure, arms.drive / (dims.r * dims.l)
    fold = 1.0 / (dims.w * dims.l)
    spread = np.hypot(fold * closure.fold_2 * drive[3], fold * closure.fold_4 * drive[1])
    weight_1, weight_3 = drive[2] * spread / dims.l, drive[0] * spread / dims.l
    blend_weight = drive[0] * drive[2] * (fold / dims.l)
    rows = (
        (closure.a * weight_1, closure.y * weight_1, closure.b * weight_1),
        (closure.c * weight_3, closure.y * weight_3, closure.d * weight_3),
        tuple(part * blend_weight for part in closure.blend()),
    )
    return _singular_ratio(np.array(rows))


def arms_tau(arms: Arms) -> Floats:
    """Eq. 10, tau (M,) as printed, by the cofactors of J_x's last column."""
    closure, drive = arms.closure, arms.drive
    c_1, c_2, c_3, c_4 = closure.cofactors()
    det = closure.fold_2 * c_2 + closure.fold_4 * c_4
    c_1, c_2, c_3, c_4 = c_1 * drive[0], c_2 * drive[1], c_3 * drive[2], c_4 * drive[3]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.abs(det) / np.sqrt(c_1 * c_1 + c_2 * c_2 + c_3 * c_3 + c_4 * c_4)


def _singular_ratio(matrix: Floats) -> Floats:
    """Smallest over largest singular value of (3, 3, M) matrices; 0 for a matrix of zeros.

    The largest eigenvalue of the Gram matrix comes from the trigonometric solution of its characteristic cubic, the two
    smaller eigenvalues from their sum and product. Sum and product are computed from minors, so that no digits cancel
    when the matrix is nearly singular.
    """
    (p_x, p_y, p_z), (q_x, q_y, q_z), (s_x, s_y, s_z) = p, q, s = matrix
    normal = _cross(q, s)
    det = p_x * normal[0] + p_y * normal[1] + p_z * normal[2]
    # Sum of the squared 2 x 2 minors: sum of the products of two eigenvalues (Cauchy-Binet).
    minors = _square(normal) + _square(_cross(p, s)) + _square(_cross(p, q))
    pp, qq, ss = _square(p), _square(q), _square(s)
    pq, ps, qs = p_x * q_x + p_y * q_y + p_z * q_z, p_x * s_x + p_y * s_y + p_z * s_z, q_x * s_x + q_y * s_y + q_z * s_z
    mean = (pp + qq + ss) / 3.0
    # Deviator of the Gram matrix; the largest eigenvalue is mean + 2 spread cos(angle / 3).
    pp, qq, ss = pp - mean, qq - mean, ss - mean
    spread = np.sqrt((pp * pp + qq * qq + ss * ss + 2.0 * (pq * pq + ps * ps + qs * qs)) / 6.0)
    skew = pp * (qq * ss - qs * qs) - pq * (pq * ss - qs * ps) + ps * (pq * qs - qq * ps)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = np.where(spread > 0.0, skew / (2.0 * spread * spread * spread), 1.0)
        largest = mean + 2.0 * spread * np.cos(np.arccos(np.clip(cosine, -1.0, 1.0)) / 3.0)
        # Product and sum of the two smaller eigenvalues.
        product = det * det / largest
        total = (minors - product) / largest
        middle = 0.5 * (total + np.sqrt(np.maximum(total * total - 4.0 * product, 0.0)))
        ratio = np.abs(det) / (largest * np.sqrt(middle))
    return np.where((middle > 0.0) | np.isnan(mean), ratio, 0.0)


def _cross(a: Floats, b: Floats) -> tuple[Floats, Floats, Floats]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _square(vector: Floats | tuple[Floats, Floats, Floats]) -> Floats:
    return vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]


def _first_root(position: Floats, dims: Dimensions) -> Floats:
    """Smallest theta above home (M,) where det J_x of the (3, M) positions turns from positive to not positive."""

    def det(theta: Floats) -> Floats:
        return solve_arms(np.concatenate([position, theta[None]]), dims).closure.determinant()

    low = np.full(position.shape[1], dims.home_theta)
    high, searching = np.full_like(low, np.nan), det(low) > 0.0
    steps = int(np.ceil((np.pi / 2 - dims.home_theta) / _SEARCH_STEP))
    for theta in np.linspace(dims.home_theta, np.pi / 2, steps + 1)[1:]:
        value = det(np.full_like(low, theta))
        high[searching & (value <= 0.0)] = theta
        searching &= value > 0.0
        low[searching] = theta
    return bisect(lambda theta: det(theta) > 0.0, low, high, _HALVINGS)[1]
