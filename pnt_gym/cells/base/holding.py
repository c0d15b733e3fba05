"""Smallest margins of suction cups along the ways of their hands. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import GRAVITY

# Smallest load in a quotient [N]; the load is negative where the hand falls faster than the object.
LIGHTEST = 1e-9
# Rows of `holds` (6, N), as the fields of `grip.Hold`.
FORCE, MASS, FRICTION, DEPTH, OFFSET, RADIUS = range(6)


@kernel_part
def _load(holds: Floats, row: int, acceleration: Floats) -> float:
    """Holding force that the vacuum needs against slip and peel under an acceleration (3,) of the hand [N]."""
    mass, radius = holds[MASS, row], holds[RADIUS, row]
    x, y = acceleration[0], acceleration[1]
    sideways = mass * math.sqrt(x * x + y * y)
    down = mass * (GRAVITY + acceleration[2])
    slip = down + sideways / holds[FRICTION, row]
    peel = sideways * holds[DEPTH, row] / radius + down * (holds[OFFSET, row] / radius + 1.0)
    return max(slip, peel, LIGHTEST)


@compile_for("void(f8[:, ::1], f8[:, :, ::1], i8[::1], f8, f8[::1], i8[::1])")
def find_smallest_margins(
    holds: Floats, accelerations: Floats, counts: Ints, scale: float, margin: Floats, lost_at: Ints
) -> None:
    """Find the smallest margins of N holds, and where a margin is below 1 for the first time.

    Args:
        holds: the holds (6, N), by the rows above.
        accelerations: accelerations of the hands (N, K, 3) [m/s2].
        counts: numbers of accelerations that count, from the first (N,).
        scale: factor of the load.
        margin: overwritten by the smallest margins, inf where no acceleration counts (N,).
        lost_at: overwritten by the first acceleration whose margin is below 1, -1 for none (N,).
    """
    for row in range(len(accelerations)):
        margin[row], lost_at[row] = math.inf, -1
        for k in range(counts[row]):
            value = holds[FORCE, row] / _load(holds, row, accelerations[row, k]) / scale
            margin[row] = min(margin[row], value)
            if value < 1.0 and lost_at[row] < 0:
                lost_at[row] = k
