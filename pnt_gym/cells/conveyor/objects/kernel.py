"""Objects from their random draws, and distances from their outlines, one row each. Compiled; see `pnt_gym.compiled`.

NumPy rounds exponentials, logarithms, sines and cosines in its own way, so these are arguments, and the caller computes
the delay of the release.
"""

from __future__ import annotations

import math

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.body_kernel import extents_of_lying, inertia_of_extents
from pnt_gym.cells.base.grip import CUP_RADIUS
from pnt_gym.cells.base.items import CYLINDER
from pnt_gym.cells.conveyor.objects.records import TARGET_DRAWS, columns_of_objects
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import GRAVITY

# Numbers of a cell: mismatch; spreads and noises of `config.spread` and `config.noise`; jitter of the release; whether
# cups are fitted; lanes and gaps on the belt.
(
    MISMATCH, RESIDUE_CHANCE, RESIDUE, COM_DEPTH, HEIGHT, GRASP, YAW, BELT_SPEED, SPIN, SPIN_PER_OFFSET, SIZE_NOISE,
    YAW_NOISE, GRASP_NOISE, JITTER, IS_FITTED, LANE_LOW, LANE_HIGH, GAP_LOW, GAP_HIGH,
) = range(19)  # fmt: skip
# Columns of an item.
(
    ITEM_SHAPE, ITEM_LENGTH, ITEM_WIDTH, ITEM_HEIGHT, ITEM_MASS, ITEM_DRAG, ITEM_DEPTH, ITEM_SEAL, ITEM_CONTAINER,
    ITEM_FRICTION, ITEM_ROLLING, ITEM_SOLREF, ITEM_DAMPING, ITEM_CUP_FRICTION, ITEM_CUP_RADIUS, ITEM_CHANCE,
) = range(16)  # fmt: skip
# Columns of an object's standard normal and uniform draws, and of its exponential factors.
(
    Z_MASS, Z_SIZE, Z_LENGTH, Z_WIDTH, Z_TALL, Z_DRAG, Z_SEAL, Z_DEPTH, Z_GRASP, Z_GRASP_Y, Z_HEIGHT, Z_BELT, Z_JITTER,
    Z_SPIN, Z_SPIN_Y, Z_SPIN_Z, Z_SEEN_SIZE, Z_SEEN_WIDTH, Z_SEEN_HEIGHT, Z_SEEN_MASS, Z_SEEN_SEAL, Z_SEEN_YAW,
    Z_GRASP_NOISE, Z_GRASP_NOISE_Y,
) = range(24)  # fmt: skip
U_KIND, U_LANE, U_GAP, U_YAW, U_CHANCE, U_RESIDUE, U_PERCENT, U_UNUSED, U_PLACE = range(9)
U_BIN = 12
F_MASS, F_SEAL, F_DRAG, F_SEEN_MASS, F_SEEN_SEAL, F_LENGTH, F_WIDTH, F_HEIGHT = range(8)
# Columns of the draws aside: whether the cup seals, what the classifier sees, contents of bins.
S_PICK, S_SEEN, S_FILL = range(3)
SMALLEST_EXTENT = 0.005
"""Smallest extent that the camera reports [m]."""
MIN_DEPTH, MAX_DEPTH = 0.05, 0.95
HALF_LIP = 4.0 / (3.0 * math.pi)
"""Distance of half a disc's centroid from the disc's middle, in radii."""
COLUMN = columns_of_objects()
"""First columns of the values in a block of objects."""
(
    KIND, SHAPE, SIZE, MASS, DRAG, DEPTH, KNOWN_DEPTH, SEAL, DELAY, JITTER_TIME, FRICTION, CUP_FRICTION, RADIUS,
    ROLLING, SOLREF, TURN, OFFSET, BELT_ERROR, SPIN_RATE, CHANCE, PICK_DRAW, PERCENT,
) = (
    COLUMN[name]
    for name in (
        "kind", "shape", "size", "mass", "drag", "com_depth", "known_depth", "seal", "delay", "jitter", "friction",
        "cup_friction", "cup_radius", "rolling_friction", "solref", "yaw", "grasp", "belt_error", "spin",
        "pick_chance", "pick_draw", "percent",
    )
)  # fmt: skip
SEEN_KIND, SEEN_SHAPE, SEEN_SIZE, SEEN_MASS, SEEN_SEAL, SEEN_YAW, SEEN_FRICTION, SEEN_GRASP = (
    COLUMN["measured." + name]
    for name in ("kind", "shape", "size", "mass", "seal", "yaw", "friction", "grasp_noise")
)  # fmt: skip
LANE, GAP, PLACE, BIN, FILL = (COLUMN["draws." + name] for name in ("lane_y", "gap", "place", "bin", "fill"))


@kernel_part
def draw_kind(draw: float, bounds: Floats, count: int) -> int:
    """Item of a uniform draw: all items equally often, or by cumulated shares (K,), which may be empty."""
    if len(bounds) == 0:
        return min(int(draw * count), count - 1)
    kind = 0
    while kind < count - 1 and bounds[kind] <= draw:
        kind += 1
    return kind


@kernel_part
def _write_body(object_: Floats, z: Floats, u: Floats, factors: Floats, item: Floats, numbers: Floats) -> None:
    """Write true extents, mass, drag, seal and depth of an object."""
    is_cylinder = item[ITEM_SHAPE] == CYLINDER
    for axis in range(3):
        # A cylinder keeps one diameter.
        factor = factors[F_HEIGHT if is_cylinder and axis == 1 else F_LENGTH + axis]
        object_[SIZE + axis] = item[ITEM_LENGTH + axis] * factor
    leftover = item[ITEM_CONTAINER] > 0.0 and u[U_CHANCE] < numbers[RESIDUE_CHANCE]
    residue = numbers[RESIDUE] * u[U_RESIDUE] if leftover else 0.0
    object_[MASS] = item[ITEM_MASS] * factors[F_MASS] * (1.0 + residue)
    object_[DRAG], object_[SEAL] = item[ITEM_DRAG] * factors[F_DRAG], item[ITEM_SEAL] * factors[F_SEAL]
    depth = item[ITEM_DEPTH] + numbers[COM_DEPTH] * z[Z_DEPTH] + 0.12 * residue / (1.0 + residue)
    share, mismatch = min(max(depth, MIN_DEPTH), MAX_DEPTH), numbers[MISMATCH]
    object_[DEPTH] = share * object_[SIZE + 2] + mismatch * numbers[HEIGHT] * z[Z_HEIGHT]
    # At mismatch 0 the planner throws the centre of mass, from mismatch 1 on the tip of the cup.
    object_[KNOWN_DEPTH] = max(1.0 - mismatch, 0.0) * object_[DEPTH]


@kernel_part
def _write_place(object_: Floats, z: Floats, u: Floats, numbers: Floats) -> None:
    """Write how an object lies on the belt and under the cup, and its random spin."""
    mismatch = numbers[MISMATCH]
    object_[TURN] = numbers[YAW] * (2.0 * u[U_YAW] - 1.0)
    for axis in range(2):
        object_[OFFSET + axis] = mismatch * numbers[GRASP] * z[Z_GRASP + axis]
    object_[BELT_ERROR] = mismatch * numbers[BELT_SPEED] * z[Z_BELT]
    object_[JITTER_TIME] = mismatch * numbers[JITTER] * z[Z_JITTER]
    for axis in range(3):
        object_[SPIN_RATE + axis] = mismatch * numbers[SPIN] * z[Z_SPIN + axis]
    object_[SPIN_RATE] += numbers[SPIN_PER_OFFSET] * object_[OFFSET + 1]
    object_[SPIN_RATE + 1] -= numbers[SPIN_PER_OFFSET] * object_[OFFSET]
    object_[SPIN_RATE + 2] /= 3.0
    object_[LANE] = numbers[LANE_LOW] + (numbers[LANE_HIGH] - numbers[LANE_LOW]) * u[U_LANE]
    object_[GAP] = numbers[GAP_LOW] + (numbers[GAP_HIGH] - numbers[GAP_LOW]) * u[U_GAP]
    object_[PLACE : PLACE + 4] = u[U_PLACE : U_PLACE + 4]
    object_[BIN : BIN + 3 * TARGET_DRAWS] = u[U_BIN : U_BIN + 3 * TARGET_DRAWS]


@kernel_part
def _write_measured(object_: Floats, z: Floats, factors: Floats, numbers: Floats) -> None:
    """Write the measurements of an object: the height is measured without noise, by the cup."""
    object_[SEEN_SHAPE] = object_[SHAPE]
    for axis in range(2):
        noise = numbers[SIZE_NOISE] * z[Z_SEEN_SIZE + axis]
        object_[SEEN_SIZE + axis] = max(object_[SIZE + axis] + noise, SMALLEST_EXTENT)
        object_[SEEN_GRASP + axis] = numbers[GRASP_NOISE] * z[Z_GRASP_NOISE + axis]
    object_[SEEN_SIZE + 2] = object_[SIZE + 2]
    object_[SEEN_MASS], object_[SEEN_SEAL] = object_[MASS] * factors[F_SEEN_MASS], object_[SEAL] * factors[F_SEEN_SEAL]
    object_[SEEN_YAW] = object_[TURN] + numbers[YAW_NOISE] * z[Z_SEEN_YAW]


@kernel_part
def _write_constants(object_: Floats, item: Floats, is_fitted: bool) -> None:
    """Write the values that are the same for all objects of an item."""
    object_[SHAPE], object_[FRICTION], object_[ROLLING] = item[ITEM_SHAPE], item[ITEM_FRICTION], item[ITEM_ROLLING]
    object_[SOLREF], object_[SOLREF + 1] = item[ITEM_SOLREF], item[ITEM_DAMPING]
    object_[CUP_FRICTION], object_[CHANCE] = item[ITEM_CUP_FRICTION], item[ITEM_CHANCE]
    object_[RADIUS] = item[ITEM_CUP_RADIUS] if is_fitted else CUP_RADIUS


@compile_for(
    "void(f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[::1], f8[:, ::1], f8[::1], f8[:, ::1], f8[::1],f8[:, ::1])"
)
def draw_objects(
    normals: Floats,
    uniforms: Floats,
    side_draws: Floats,
    factors: Floats,
    numbers: Floats,
    items: Floats,
    shares: Floats,
    confusion: Floats,
    percent: Floats,
    block: Floats,
) -> None:
    """Write N objects to the rows of a block, without the delays of their releases and the spins of lips and air.

    Args:
        normals: standard normal draws (N, 24).
        uniforms: uniform draws (N, 36).
        side_draws: draws aside (N, 2 + B).
        factors: exponential factors of masses, seals, drag and extents (N, 8).
        numbers: numbers of the cell by the names above.
        items: the items (K, 16) by the columns above.
        shares: cumulated shares of the items (K,); empty where all items are equally frequent.
        confusion: cumulated probabilities of the items that the classifier sees (K, K); (0, 0) for a sure classifier.
        percent: speed settings (P,) [%].
        block: written (N, columns of an object).
    """
    for row in range(len(block)):
        z, u, object_, side = normals[row], uniforms[row], block[row], side_draws[row]
        kind = draw_kind(u[U_KIND], shares, len(items))
        seen = draw_kind(side[S_SEEN], confusion[kind], len(items)) if len(confusion) > 0 else kind
        object_[KIND], object_[SEEN_KIND] = kind, seen
        object_[SEEN_FRICTION] = items[seen, ITEM_CUP_FRICTION]
        _write_constants(object_, items[kind], numbers[IS_FITTED] > 0.0)
        _write_body(object_, z, u, factors[row], items[kind], numbers)
        _write_place(object_, z, u, numbers)
        _write_measured(object_, z, factors[row], numbers)
        object_[PICK_DRAW], object_[PERCENT] = (
            side[S_PICK],
            percent[min(int(u[U_PERCENT] * len(percent)), len(percent) - 1)],
        )
        object_[FILL:] = side[S_FILL:]


@compile_for("UniTuple(f8, 2)(f8, f8, f8, f8, f8)")
def peel_impulse(weight: float, x: float, y: float, radius: float, tau: float) -> tuple[float, float]:
    """Angular impulse of a lip that peels off at one side, about x and y [N m s].

    An object is free when the vacuum has decayed to the object's weight. The lip opens first where the object is
    heavier, on the side of its centre of mass. The remaining force of the vacuum, m g exp(-t / tau), is assumed to act
    on the other half of the lip, whose centroid is 4 r / (3 pi) from the middle. With the grasp offset e the arm about
    the centre of mass is e + 4 r / (3 pi), and the impulse is m g tau (e + 4 r / (3 pi)). The open side goes down. The
    impulse is an upper bound, because the half lip is assumed to hold until the vacuum is gone.

    Args:
        weight: weight of the object [N].
        x: centre of mass relative to the cup's axis, along x [m].
        y: the same along y [m].
        radius: radius of the lip [m].
        tau: time constant of the vacuum [s].
    """
    offset = math.sqrt(x * x + y * y)
    # The force m g exp(-t / tau) over all times gives m g tau; the rest is its arm.
    size, arm = weight * tau * (offset + HALF_LIP * radius), max(offset, 1e-12)
    return size * -(y / arm), size * (x / arm)


@compile_for("UniTuple(f8, 2)(f8, f8, f8, f8)")
def blow_impulse(mass: float, x: float, y: float, speed: float) -> tuple[float, float]:
    """Angular impulse about x and y of air that blows an object down along the cup's axis [N m s].

    Args:
        mass: mass of the object [kg].
        x: centre of mass relative to the cup's axis, along x [m].
        y: the same along y [m].
        speed: speed that the air gives the centre of mass [m/s].
    """
    return mass * speed * y, mass * speed * -x


@compile_for("UniTuple(f8, 3)(f8, f8, f8, f8[:], f8, f8, f8, f8[:])")
def spin_from_impulse(
    x: float, y: float, mass: float, size: Floats, shape: float, cos: float, sin: float, gyration: Floats
) -> tuple[float, float, float]:
    """Spin of a free object about x, y, z [rad/s], from an angular impulse about x and y.

    Args:
        x: angular impulse about the world's x [N m s].
        y: the same about y [N m s].
        mass: mass of the object [kg].
        size: full extents (3,) [m].
        shape: index in `items.SHAPES`.
        cos: cosine of the object's yaw.
        sin: sine of the object's yaw.
        gyration: inertia of each shape, see `fluid.GYRATION`.
    """
    length, width, height = extents_of_lying(shape == CYLINDER, size)
    inertia_x, inertia_y, _ = inertia_of_extents(gyration[int(shape)] * mass, length, width, height)
    # The inertia is diagonal only in the object's axes: there the impulse becomes a spin, which is turned back.
    about_x = (cos * x + sin * y) / inertia_x
    about_y = (cos * y - sin * x) / inertia_y
    return cos * about_x - sin * about_y, cos * about_y + sin * about_x, 0.0


@compile_for("void(f8, b1, f8, f8[:], f8[:, :], f8[:], f8[:, :], f8[:, :], f8[:], f8[:], f8[:], f8[:, :])")
def write_spins(
    mismatch: float,
    peels: bool,
    blown: float,
    mass: Floats,
    size: Floats,
    shape: Floats,
    turn: Floats,
    grasp: Floats,
    radius: Floats,
    tau: Floats,
    gyration: Floats,
    spin: Floats,
) -> None:
    """Write the spins of N objects at release: as drawn, or from the peeling lip, and from blown air.

    Args:
        mismatch: factor of all hidden effects.
        peels: whether the lip gives a spin.
        blown: speed that blown air gives objects, 0 without air [m/s].
        mass: masses of the objects (N,) [kg].
        size: full extents (N, 3) [m].
        shape: indices in `items.SHAPES` (N,).
        turn: cosine and sine of the objects' yaws (2, N).
        grasp: centres of mass relative to the cup's axis (N, 2) [m].
        radius: radii of the lips (N,) [m].
        tau: time constants of the vacuum (N,) [s].
        gyration: inertia of each shape, see `fluid.GYRATION`.
        spin: spins as drawn, overwritten (N, 3) [rad/s].
    """
    for row in range(len(spin)):
        place_x, place_y, cos, sin = grasp[row, 0], grasp[row, 1], turn[0, row], turn[1, row]
        if peels:
            x, y = peel_impulse(mass[row] * GRAVITY, place_x, place_y, radius[row], tau[row])
            x, y = mismatch * x, mismatch * y
            spin[row, 0], spin[row, 1], spin[row, 2] = spin_from_impulse(
                x, y, mass[row], size[row], shape[row], cos, sin, gyration
            )
        if blown > 0.0:
            x, y = blow_impulse(mass[row], place_x, place_y, mismatch * blown)
            added = spin_from_impulse(x, y, mass[row], size[row], shape[row], cos, sin, gyration)
            for axis in range(3):
                spin[row, axis] += added[axis]


@compile_for("void(b1[::1], f8[:, :], f8[:], f8[:, :], f8[::1])")
def find_inside(is_ellipse: Bools, size: Floats, yaw: Floats, place: Floats, inside: Floats) -> None:
    """Write the distances of points from outlines, as `outline.inside_outline` (N,).

    Args:
        is_ellipse: whether an outline is an ellipse, else a rectangle (N,).
        size: extents of the objects (N, 3) [m].
        yaw: yaws of the objects (N,) [rad].
        place: points relative to the objects' middles (N, 2) [m].
        inside: written (N,) [m].
    """
    for row in range(len(inside)):
        cos, sin, x, y = math.cos(yaw[row]), math.sin(yaw[row]), place[row, 0], place[row, 1]
        along, across = abs(cos * x + sin * y), abs(cos * y - sin * x)
        length, width = size[row, 0] / 2.0, size[row, 1] / 2.0
        if is_ellipse[row]:
            inside[row] = (1.0 - math.hypot(along / length, across / width)) * min(length, width)
        else:
            beyond, aside = along - length, across - width
            outside = math.hypot(max(beyond, 0.0), max(aside, 0.0))
            inside[row] = max(min(-beyond, -aside), 0.0) - outside


@compile_for("void(f8[:], f8[:, :], f8[:, :], f8[:, :, ::1])")
def fill_inertias(mass: Floats, arm: Floats, inertia: Floats, tensor: Floats) -> None:
    """Fill the inertias of objects about their cups' tips.

    Args:
        mass: masses (N,) [kg].
        arm: centres of mass relative to the tips, in the objects' axes (N, 3) [m].
        inertia: moments about the centres of mass (N, 3) [kg m2].
        tensor: filled (N, 3, 3) [kg m2].
    """
    for row in range(len(tensor)):
        x, y, z = arm[row, 0], arm[row, 1], arm[row, 2]
        square = mass[row] * (x * x + y * y + z * z)
        for i in range(3):
            for j in range(3):
                tensor[row, i, j] = (-mass[row] * arm[row, i]) * arm[row, j]
            tensor[row, i, i] += inertia[row, i] + square
