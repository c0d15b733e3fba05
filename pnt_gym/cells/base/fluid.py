"""MuJoCo's ellipsoid fluid model as arrays: the values that MuJoCo's compiler would write, for N different objects.

A model is compiled for one object; the cell gives every simulation a different object by writing these arrays into
the per-simulation fields `geom_fluid`, `geom_type`, `geom_size`, `geom_quat`, `geom_rbound`, `geom_aabb` and
`body_inertia`. Extents are (L, W, H) along the body's x, y and z. MuJoCo's cylinder has its axis along the
geom's z, so a lying cylinder's geom is turned and its coefficients are in the turned frame.

Every operation is elementwise: a row's result does not depend, to the last bit, on the other rows.
"""

# pyright: reportMissingTypeStubs=false
from __future__ import annotations

from typing import Any, Final, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, Ints, in_order, join_columns
from pnt_gym.cells.base import body_kernel
from pnt_gym.cells.base.items import CYLINDER, SHAPES
from pnt_gym.errors import ConfigError
from pnt_gym.rows import Floats1, Floats2, Floats3, Shorts1, Shorts2

# Share of the drag coefficient, by shape. MuJoCo's drag has no 1/2, and a box or cylinder is seen as the
# ellipsoid inside it, whose frontal area is pi/4 of a face: 0.5 / (pi/4) = 0.64.
_BLUNT: Final = np.array([0.50, 0.64, 0.64])
# Share of the blunt coefficient that the engine adds for the largest area less the area that the flow meets: friction
# along the faces. Blasius' laminar plate of 0.1 m at 2.5 m/s, Re 17 000, gives 0.019 of a plate's blunt coefficient.
_SLENDER = 0.02
_ANGULAR = 1.0
# Assumed: the engine's default of 1 over-lifts bluff bodies and would carry a can 5 cm sideways.
_KUTTA = 0.4
# Fitted to 62 flights of a table-tennis ball with measured spin (data of cogsys-tuebingen/spindoe): 0.72, of which 80 %
# lie in 0.37 to 0.83.
_MAGNUS = 0.7

# Inertia over m (b^2 + c^2) with semi-axes b, c: assumed, between a solid body and a closed thin shell. Solid
# and shell are 1/5 and 1/3 for an ellipsoid, 0.25-0.33 and 0.42-0.62 for the catalogue's cylinders and boxes.
GYRATION: Final = np.array([0.27, 0.38, 0.38])

_GEOM_TYPE: Final = np.array([4, 5, 6], dtype=np.int32)  # mjtGeom: ellipsoid, cylinder, box


@final
class GeomPlacement(NamedTuple):
    """N geoms in MuJoCo's convention, in the order of the fields' names.

    Attributes:
        type: (N,) int32 `mjtGeom` ids.
        size: (N, 3) semi-axes in m; a cylinder has (radius, half length, 0).
        quat: (N, 4) geom in the body, w first.
        rbound: (N,) radius in m of the bounding sphere.
        aabb: (N, 6) bounding box in the geom's frame, m: centre, half extents.
    """

    type: Shorts1
    size: Floats2
    quat: Floats2
    rbound: Floats1
    aabb: Floats2


@final
class ModelObjects(NamedTuple):
    """N objects as MuJoCo's fields: mass [kg], inertia (N, 3) [kg m2], geom and `geom_fluid` (N, 12)."""

    mass: Floats1
    inertia: Floats2
    placement: GeomPlacement
    fluid: Floats2


@final
class ModelFields(NamedTuple):
    """Fields of the bodies and geoms of S simulations, in the order of `MODEL_FIELDS`."""

    mass: Floats2
    inertia: Floats3
    type: Shorts2
    size: Floats3
    quat: Floats3
    rbound: Floats2
    aabb: Floats3
    fluid: Floats3


MODEL_FIELDS: Final = (
    "body_mass", "body_inertia", "geom_type", "geom_size", "geom_quat", "geom_rbound", "geom_aabb", "geom_fluid",
)  # fmt: skip


def lying_size(shape_index: ArrayLike, size: ArrayLike) -> Floats:
    """Extents of the N modelled bodies, the `size` of the other functions of this module.

    Args:
        shape_index: (N,) index in `items.SHAPES`.
        size: (N, 3) full extents (L, W, H) in m.

    Returns:
        (N, 3) full extents in m: the diameter of a cylinder is the mean of W and H, other shapes keep their extents.

    Raises:
        ConfigError: the arrays do not fit, an index is unknown or an extent is not positive and finite.
    """
    index, full = np.asarray(shape_index), np.asarray(size, dtype=np.float64)
    if index.ndim != 1 or index.dtype.kind not in "iu":
        raise ConfigError(f"shape_index has shape {index.shape} and type {index.dtype}, but must be (N,) of integers.")
    if full.shape != (index.shape[0], 3):
        raise ConfigError(f"size has shape {full.shape}, but must be ({index.shape[0]}, 3), one row per shape_index.")
    unknown = (index < 0) | (index >= len(SHAPES))
    if unknown.any():
        raise ConfigError(f"shape_index is {index[unknown][0]}, but must be from 0 to {len(SHAPES) - 1}.")
    bad = ~((full > 0.0) & (full < np.inf))
    if bad.any():
        raise ConfigError(f"size holds an extent of {full[bad][0]} m, but extents must be finite and more than 0.")
    return lying_extents(index, full)


def lying_extents(shape: Ints, size: Floats) -> Floats:
    """Extents of bodies as `lying_size`, for extents and shapes that need no check."""
    is_round, mean = shape == CYLINDER, 0.5 * (size[:, 1] + size[:, 2])
    return join_columns(size[:, 0], np.where(is_round, mean, size[:, 1]), np.where(is_round, mean, size[:, 2]))


def geom_placement(shape: Ints, size: Floats) -> GeomPlacement:
    """Type, size, attitude and bounds of the geoms of N objects.

    Args:
        shape: (N,) index in `items.SHAPES`.
        size: (N, 3) extents in m as `lying_size` gives them.

    Returns:
        Values for `geom_type`, `geom_size`, `geom_quat`, `geom_rbound` and `geom_aabb`.
    """
    return GeomPlacement(_GEOM_TYPE[shape], *body_kernel.geom_placement(*in_order(shape, size)))


def fluid_coefficients(shape: Ints, size: Floats, drag: Floats) -> Floats:
    """The 12 numbers of MuJoCo's `geom_fluid` for N objects.

    Added mass and inertia are Lamb's factors of the ellipsoid (Tuckerman 1925) by Carlson's integral. The
    compiler of MuJoCo takes the same integral by a 15-point quadrature: it differs by about 1e-6 at an aspect
    ratio of 10 and by 1e-5 at 50.

    Args:
        shape: (N,) index in `items.SHAPES`.
        size: (N, 3) extents in m as `lying_size` gives them.
        drag: (N,) drag coefficient Cd on the area facing the flow.

    Returns:
        (N, 12) interaction flag, blunt, slender and angular drag, Kutta and Magnus coefficients, virtual mass
        (3) in m3 and virtual inertia (3) in m5, per unit of fluid density and in the geom's frame.
    """
    from scipy.special import elliprd  # noqa: PLC0415  (heavy import)

    # Squares of the semi-axes in the geom's frame (3, N), where a cylinder's length comes last [m2].
    half = 0.5 * np.where((shape == CYLINDER)[:, None], size[:, [1, 2, 0]], size)
    coefficients, squares = np.empty((len(shape), 12)), np.ascontiguousarray((half * half).T)
    coefficients[:, :6] = 1.0, np.nan, np.nan, _ANGULAR, _KUTTA, _MAGNUS
    coefficients[:, 1] = _BLUNT[shape] * drag
    coefficients[:, 2] = _SLENDER * coefficients[:, 1]
    integrals = elliprd(squares[[1, 2, 0]], squares[[2, 0, 1]], squares)
    body_kernel.fill_added_mass(*in_order(shape, size), squares, integrals, coefficients)
    return coefficients


def solid_shell_inertia(mass: Floats, size: Floats, shape: Ints) -> Floats:
    """Principal inertias of N objects between a solid body and an empty shell.

    Args:
        mass: (N,) kg.
        size: (N, 3) extents in m as `lying_size` gives them.
        shape: (N,) index in `items.SHAPES`.

    Returns:
        (N, 3) moments in kg m2 about the body's L, W and H axes through the centre of the extents:
        k m (b^2 + c^2) with the two other semi-axes b and c, k = 0.38, for an ellipsoid 0.27.
    """
    share, (x, y, z) = GYRATION[shape] * mass, 0.5 * size.T
    return join_columns(share * (y * y + z * z), share * (x * x + z * z), share * (x * x + y * y))


def write_object(
    batch: Any, rows: Ints, body: int, geom: int, mass: Floats, inertia: Floats, placement: GeomPlacement, fluid: Floats
) -> None:
    """Write mass (N,) [kg], inertia (N, 3) [kg m2], geom and `geom_fluid` (N, 12) of some simulations' free objects."""
    objects = ModelObjects(*in_order(mass, inertia), GeomPlacement(*in_order(*placement)), *in_order(fluid))
    body_kernel.write_object(rows, body, geom, objects, ModelFields(*map(batch.expand, MODEL_FIELDS)))
