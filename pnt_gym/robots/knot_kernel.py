"""Controls of motors between the knots of their references. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

from pnt_gym.compiled import kernel
from pnt_gym.rows import Floats3


@kernel
def upsample(position: Floats3, velocity: Floats3, torque: Floats3, spacing: float, stride: int, out: Floats3) -> None:
    """Fill position, velocity and torque of each motor at samples from those at knots.

    The position is the cubic Hermite p0 + h01 (p1 - p0) + h10 v0 + h11 v1, the velocity its derivative; the torque is
    linear.

    Args:
        position: at the knots (M, N, K), as velocity and torque.
        velocity: see position.
        torque: see position.
        spacing: time between knots [s].
        stride: samples per knot interval.
        out: (N, steps, 3 M and more), of which 3 M columns are filled.
    """
    motors, steps = len(position), out.shape[1]
    for row in range(out.shape[0]):
        for first in range(0, steps, stride):
            knot = first // stride
            for arm in range(motors):
                p, v, t = position[arm, row, knot], velocity[arm, row, knot], torque[arm, row, knot]
                sample = out[row, first, 3 * arm : 3 * arm + 3]
                sample[0], sample[1], sample[2] = p, v, t
            for step in range(1, min(stride, steps - first)):
                u = step / stride
                left, right = u * ((1.0 - u) * (1.0 - u)) * spacing, u * u * (u - 1.0) * spacing
                blend, slope = u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / spacing
                early, late = (1.0 - u) * (1.0 - 3.0 * u), u * (3.0 * u - 2.0)
                for arm in range(motors):
                    p, v, t = position[arm, row, knot], velocity[arm, row, knot], torque[arm, row, knot]
                    dp, w = position[arm, row, knot + 1] - p, velocity[arm, row, knot + 1]
                    sample = out[row, first + step, 3 * arm : 3 * arm + 3]
                    sample[0] = p + blend * dp + left * v + right * w
                    sample[1] = slope * dp + early * v + late * w
                    sample[2] = t + u * (torque[arm, row, knot + 1] - t)
