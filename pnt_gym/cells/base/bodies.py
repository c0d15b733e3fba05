"""Bodies of N different objects as MuJoCo's fields: the values that MuJoCo's compiler would write.

A model is compiled for one object; the cell gives every simulation a different object by writing these arrays into
the per-simulation fields `geom_fluid`, `geom_type`, `geom_size`, `geom_quat`, `geom_rbound`, `geom_aabb`, `geom_solref`
and `body_inertia`. Extents are (L, W, H) along the body's x, y and z. MuJoCo's cylinder has its axis along the
geom's z, so a lying cylinder's geom is turned and its coefficients are in the turned frame.

Rotations are about the vertical by a yaw, and in general by unit quaternions with w first.

Every operation is elementwise: a row's result does not depend, to the last bit, on the other rows.
"""

# pyright: reportMissingTypeStubs=false
from __future__ import annotations

import math
from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, Ints, in_order, join_columns
from pnt_gym.cells.base.items import CYLINDER, ELLIPSOID, SHAPES
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.errors import ConfigError
from pnt_gym.rows import Floats1, Floats2, Floats3, Ints1, Shorts1, Shorts2

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
GYRATION = (0.27, 0.38, 0.38)

GEOM_TYPE = (4, 5, 6)  # mjtGeom: ellipsoid, cylinder, box
HALF_TURN = math.sqrt(0.5)
"""Cosine and sine of half a quarter turn."""


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
    return lying_extents(*in_order(index.astype(np.int64), full))


@kernel_part
def level_extents(is_cylinder: bool, size: Floats) -> tuple[float, float, float]:
    """Extents of one body as `lying_size` has them."""
    mean = 0.5 * (size[1] + size[2])
    return (size[0], mean, mean) if is_cylinder else (size[0], size[1], size[2])


@kernel
def lying_extents(shape: Ints1, size: Floats2) -> Floats2:
    """Extents of bodies as `lying_size`, for extents and shapes that need no check."""
    extents = np.empty((len(shape), 3))
    for row in range(len(shape)):
        extents[row, 0], extents[row, 1], extents[row, 2] = level_extents(shape[row] == CYLINDER, size[row])
    return extents


@kernel_part
def _semi_axes(shape: int, full: Floats) -> tuple[float, float, float]:
    """Semi-axes in the geom's frame: a cylinder's length comes last."""
    if shape == CYLINDER:
        return 0.5 * full[1], 0.5 * full[2], 0.5 * full[0]
    return 0.5 * full[0], 0.5 * full[1], 0.5 * full[2]


@kernel
def geom_placement(shape: Ints1, full: Floats2) -> GeomPlacement:
    """Type, size, attitude and bounds of the geoms of N objects.

    Args:
        shape: (N,) index in `items.SHAPES`.
        full: (N, 3) extents in m as `lying_size` gives them.
    """
    count = len(shape)
    kind, size, quat = np.empty(count, np.int32), np.empty((count, 3)), np.empty((count, 4))
    rbound, aabb = np.empty(count), np.empty((count, 6))
    for row in range(len(size)):
        x, y, z = _semi_axes(shape[row], full[row])
        lies = shape[row] == CYLINDER
        kind[row] = GEOM_TYPE[shape[row]]
        size[row, 0], size[row, 1], size[row, 2] = x, z if lies else y, 0.0 if lies else z
        quat[row, 0], quat[row, 2] = HALF_TURN if lies else 1.0, HALF_TURN if lies else 0.0
        quat[row, 1] = quat[row, 3] = 0.0
        # A cylinder's corner has no y.
        corner = math.sqrt(x * x + (0.0 if lies else y * y) + z * z)
        rbound[row] = max(x, y, z) if shape[row] == ELLIPSOID else corner
        aabb[row, 0] = aabb[row, 1] = aabb[row, 2] = 0.0
        aabb[row, 3], aabb[row, 4], aabb[row, 5] = x, y, z
    return GeomPlacement(kind, size, quat, rbound, aabb)


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
    fill_added_mass(*in_order(shape, size), squares, integrals, coefficients)
    return coefficients


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


@kernel_part
def shell_inertia(shape: int, mass: float, extents: tuple[float, float, float]) -> tuple[float, float, float]:
    """Principal inertias of one body as `solid_shell_inertia`."""
    share, x, y, z = GYRATION[shape] * mass, 0.5 * extents[0], 0.5 * extents[1], 0.5 * extents[2]
    return share * (y * y + z * z), share * (x * x + z * z), share * (x * x + y * y)


@kernel
def solid_shell_inertia(mass: Floats1, size: Floats2, shape: Ints1) -> Floats2:
    """Principal inertias of N objects between a solid body and an empty shell.

    Args:
        mass: (N,) kg.
        size: (N, 3) extents in m as `lying_size` gives them.
        shape: (N,) index in `items.SHAPES`.

    Returns:
        (N, 3) moments in kg m2 about the body's L, W and H axes through the centre of the extents:
        k m (b^2 + c^2) with the two other semi-axes b and c, k = 0.38, for an ellipsoid 0.27.
    """
    inertia = np.empty((len(mass), 3))
    for row in range(len(mass)):
        extents = size[row, 0], size[row, 1], size[row, 2]
        inertia[row, 0], inertia[row, 1], inertia[row, 2] = shell_inertia(shape[row], mass[row], extents)
    return inertia


@kernel
def write_object(rows: Ints1, body: int, geom: int, objects: ModelObjects, fields: ModelFields) -> None:
    """Write free objects into the fields of some simulations (N,); `body` and `geom` are their ids there."""
    placement = objects.placement
    for n in range(len(rows)):
        row = rows[n]
        fields.mass[row, body], fields.inertia[row, body] = objects.mass[n], objects.inertia[n]
        fields.type[row, geom], fields.size[row, geom] = placement.type[n], placement.size[n]
        fields.quat[row, geom], fields.rbound[row, geom] = placement.quat[n], placement.rbound[n]
        fields.aabb[row, geom], fields.fluid[row, geom] = placement.aabb[n], objects.fluid[n]


_DEAD_TIME_CONSTANT = 0.003  # s, MuJoCo solref of a contact meant not to bounce
_LEAST_BOUNCE = float(np.exp(-2.0))  # rebound of a critically damped contact that cannot pull
_LEAST_DAMPING = 0.005  # keeps the time constant finite at restitution 1
# Damping ratio cos(phi) against rebound exp(-2 phi / tan(phi)), phi from 0 (critical) to pi/2 (none).
_PHI = np.linspace(0.0, np.pi / 2.0, 4097)
_BOUNCE = np.concatenate([[_LEAST_BOUNCE], np.exp(-2.0 * _PHI[1:] / np.tan(_PHI[1:]))])


def contact_solref(restitution: ArrayLike) -> Floats:
    """MuJoCo `solref` (time constant, damping ratio) of a contact that rebounds with the given restitution.

    A contact is a spring and damper with damping ratio zeta = cos(phi) that pushes but never pulls, so the
    body leaves when the force, not the depth, is back at zero. That makes e = exp(-2 phi / tan(phi))
    (Schwager and Poeschel 2007, "Coefficient of restitution and linear-dashpot model revisited"); the more
    familiar exp(-pi zeta / sqrt(1 - zeta^2)) would rebound up to 0.15 too high. The stiffness rises with
    sqrt(e) so that every impact goes as deep as the critically damped one, 1.1 mm per m/s: even a 12 mm plate
    does not pass a 10 mm wall at 9 m/s. Half a period lasts 3.4 ms or more. Damping cannot bring the rebound
    below exp(-2) = 0.135: for lower restitutions the result is (0.003, 1). At restitution 1 the damping ratio
    is 0.005.

    MuJoCo averages the solref of two geoms of equal priority: give the item's geom the higher priority.

    Args:
        restitution: (...) rebound speed over impact speed, 0 to 1.

    Returns:
        (..., 2) time constant in s and damping ratio.

    Raises:
        ConfigError: a restitution is outside 0 to 1 or not a number.
    """
    e = np.asarray(restitution, dtype=np.float64)
    if not np.all((e >= 0.0) & (e <= 1.0)):
        bad = e[~((e >= 0.0) & (e <= 1.0))].flat[0]
        raise ConfigError(f"restitution is {bad}, but must be from 0 to 1.")
    damping = np.maximum(np.cos(np.interp(e, _BOUNCE, _PHI)), _LEAST_DAMPING)
    stiffening = np.sqrt(np.maximum(e, _LEAST_BOUNCE) / _LEAST_BOUNCE)
    return join_columns(_DEAD_TIME_CONSTANT / (damping * stiffening), damping)


@kernel_part
def turned_back(x: float, y: float, cosine: float, sine: float) -> tuple[float, float]:
    """Components along the axes of a body turned about z of a vector with components x, y along the world's axes."""
    return cosine * x + sine * y, cosine * y - sine * x


@kernel
def turn_back(vector: Floats2, cosine: Floats1, sine: Floats1) -> Floats2:
    """World vectors (N, 3) in the axes of bodies turned about z, by cosines and sines (N,) of their yaws."""
    turned = np.empty(vector.shape)
    for row in range(len(turned)):
        turned[row, 0], turned[row, 1] = turned_back(vector[row, 0], vector[row, 1], cosine[row], sine[row])
        turned[row, 2] = vector[row, 2]
    return turned


def yaw_attitude(yaw: Floats) -> Floats:
    """Attitudes (N, 4) of bodies that are only turned by yaw (N,) about z."""
    return join_columns(np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0))


def level_axes(attitude: Floats) -> tuple[Floats, Floats]:
    """World x and y in the axes of bodies with attitude (..., 4): (..., 3) each."""
    w, x, y, z = attitude[..., 0], attitude[..., 1], attitude[..., 2], attitude[..., 3]
    # The first two rows of the rotation matrix from body axes to the world's.
    along = join_columns(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y))
    across = join_columns(2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x))
    return along, across


@kernel_part
def up_axis(attitude: Floats) -> tuple[float, float, float]:
    """The vertical in the axes of a body with an attitude (4,): the third row of that matrix."""
    w, x, y, z = attitude[0], attitude[1], attitude[2], attitude[3]
    return 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


@kernel
def vertical(attitude: Floats3) -> Floats3:
    """The vertical in the axes of N bodies with attitudes at K moments (N, K, 4): (N, K, 3)."""
    rows, moments, _ = attitude.shape
    axes = np.empty((rows, moments, 3))
    for row in range(rows):
        for k in range(moments):
            axes[row, k, 0], axes[row, k, 1], axes[row, k, 2] = up_axis(attitude[row, k])
    return axes
