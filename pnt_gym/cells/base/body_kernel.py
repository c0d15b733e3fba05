"""Bodies of free objects as MuJoCo's fields, row by row; see `fluid`. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.fluid import ModelFields, ModelObjects
from pnt_gym.cells.base.items import CYLINDER, ELLIPSOID
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Floats1, Floats2, Ints1

HALF_TURN = math.sqrt(0.5)
"""Cosine and sine of half a quarter turn."""


@kernel_part
def _semi_axes(shape: int, full: Floats) -> tuple[float, float, float]:
    """Semi-axes in the geom's frame: a cylinder's length comes last."""
    if shape == CYLINDER:
        return 0.5 * full[1], 0.5 * full[2], 0.5 * full[0]
    return 0.5 * full[0], 0.5 * full[1], 0.5 * full[2]


@kernel_part
def lying_extents(is_cylinder: bool, size: Floats) -> tuple[float, float, float]:
    """Extents of a body as `fluid.lying_extents` has them."""
    mean = 0.5 * (size[1] + size[2])
    return (size[0], mean, mean) if is_cylinder else (size[0], size[1], size[2])


@kernel_part
def solid_shell_inertia(share: float, length: float, width: float, height: float) -> tuple[float, float, float]:
    """Inertia of a body as `fluid.solid_shell_inertia`; `share` is its gyration times its mass."""
    x, y, z = 0.5 * length, 0.5 * width, 0.5 * height
    return share * (y * y + z * z), share * (x * x + z * z), share * (x * x + y * y)


@kernel
def geom_placement(shape: Ints1, full: Floats2) -> tuple[Floats2, Floats2, Floats1, Floats2]:
    """Sizes, attitudes and bounds of geoms as `fluid.GeomPlacement` has them, after the types."""
    count = len(shape)
    size, quat, rbound, aabb = np.empty((count, 3)), np.empty((count, 4)), np.empty(count), np.empty((count, 6))
    for row in range(len(size)):
        x, y, z = _semi_axes(shape[row], full[row])
        lies = shape[row] == CYLINDER
        size[row, 0], size[row, 1], size[row, 2] = x, z if lies else y, 0.0 if lies else z
        quat[row, 0], quat[row, 2] = HALF_TURN if lies else 1.0, HALF_TURN if lies else 0.0
        quat[row, 1] = quat[row, 3] = 0.0
        # A cylinder's corner has no y.
        corner = math.sqrt(x * x + (0.0 if lies else y * y) + z * z)
        rbound[row] = max(x, y, z) if shape[row] == ELLIPSOID else corner
        aabb[row, 0] = aabb[row, 1] = aabb[row, 2] = 0.0
        aabb[row, 3], aabb[row, 4], aabb[row, 5] = x, y, z
    return size, quat, rbound, aabb


@kernel
def fill_added_mass(shape: Ints1, full: Floats2, squares: Floats2, integrals: Floats2, fluid: Floats2) -> None:
    """Fill virtual mass and virtual inertia per unit density (N, 12), in the last six columns.

    Lamb's factors k / (2 - k), with k = xyz int_0^inf ds / ((x^2 + s) sqrt((x^2 + s)(y^2 + s)(z^2 + s))) and so on, are
    Carlson's integrals R_D (3, N) times 2 xyz / 3.
    """
    for row in range(len(fluid)):
        x, y, z = _semi_axes(shape[row], full[row])
        product = x * y * z
        volume = (4.0 / 3.0 * math.pi) * product
        for axis in range(3):
            second, third = (axis + 1) % 3, (axis + 2) % 3
            k = (2.0 / 3.0) * product * integrals[axis, row]
            kb, kc = (2.0 / 3.0) * product * integrals[second, row], (2.0 / 3.0) * product * integrals[third, row]
            # The three factors add up to 2: the sum of the others is 2 - k without cancellation for thin plates.
            fluid[row, 6 + axis] = volume * k / (kb + kc)
            # Lamb: (b^2 - c^2)^2 (k_c - k_b) / (2 (b^2 - c^2) + (b^2 + c^2) (k_b - k_c)); a body that is round about
            # an axis moves no air about that axis.
            b, c = squares[second, row], squares[third, row]
            gap, share = b - c, 0.0
            if gap != 0.0:
                share = gap * gap * (kc - kb) / (2.0 * gap + (b + c) * (kb - kc))
            fluid[row, 9 + axis] = volume / 5.0 * share


@kernel
def write_object(rows: Ints1, body: int, geom: int, objects: ModelObjects, fields: ModelFields) -> None:
    """Write N objects into the fields of some simulations (N,), as `fluid.write_object` says."""
    placement = objects.placement
    for n in range(len(rows)):
        row = rows[n]
        fields.mass[row, body], fields.inertia[row, body] = objects.mass[n], objects.inertia[n]
        fields.type[row, geom], fields.size[row, geom] = placement.type[n], placement.size[n]
        fields.quat[row, geom], fields.rbound[row, geom] = placement.quat[n], placement.rbound[n]
        fields.aabb[row, geom], fields.fluid[row, geom] = placement.aabb[n], objects.fluid[n]
