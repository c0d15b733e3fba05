"""Rows from which objects are drawn: their standard draws, the items, the numbers of a cell; and objects let go."""

from __future__ import annotations

from typing import Annotated, NamedTuple, final

from pnt_gym.arrays import Floats
from pnt_gym.cells.conveyor.objects.records import TARGET_DRAWS
from pnt_gym.rows import Floats1, Floats2, Pair, Quadruple, Row, Rows1, Triple, field


@final
class Normals(Row):
    """Standard normal draws of an object."""

    mass: float = field("-", "spread of the mass")
    size: float = field("-", "spread of all extents together")
    axes: Triple = field("-", "spreads of each extent")
    drag: float = field("-", "spread of the drag")
    seal: float = field("-", "spread of the vacuum's force")
    depth: float = field("-", "spread of the centre of mass, as a share of the height")
    grasp: Pair = field("-", "grasp offset")
    height: float = field("-", "height of the centre of mass that the planner does not know")
    belt: float = field("-", "error of the belt's speed")
    jitter: float = field("-", "jitter of the release")
    spin: Triple = field("-", "random spin")
    seen_size: Triple = field("-", "the camera's errors of the extents")
    seen_mass: float = field("-", "error of the measured mass")
    seen_seal: float = field("-", "error of the measured force of the vacuum")
    seen_yaw: float = field("-", "the camera's error of the yaw")
    seen_grasp: Pair = field("-", "the camera's error of the grasp offset")


@final
class Uniforms(Row):
    """Uniform draws of an object, in [0, 1)."""

    kind: float = field("-", "item")
    lane: float = field("-", "place across the belt")
    gap: float = field("-", "distance to the object before this one")
    yaw: float = field("-", "yaw")
    unused: Pair = field("-", "drawn, and not used")
    percent: float = field("-", "speed setting")
    further: float = field("-", "drawn, and not used")
    place: Quadruple = field("-", "places of a pick without a belt")
    bin: Annotated[Floats, (TARGET_DRAWS, 3)] = field("-", "the object's bin")


@final
class Factors(Row):
    """Exponential factors of an object's normal draws, which NumPy computes: NumPy rounds them in its own way."""

    mass: float = field("-", "factor of the mass")
    seal: float = field("-", "factor of the vacuum's force")
    drag: float = field("-", "factor of the drag")
    seen_mass: float = field("-", "measured mass over mass")
    seen_seal: float = field("-", "measured force of the vacuum over the force")
    restitution: float = field("-", "factor of the restitution")
    friction: float = field("-", "factor of the friction of contacts")
    blow_off: float = field("-", "factor of the speed that blown air gives")
    residue: float = field("-", "residue over the item's mean")
    size: Triple = field("-", "factors of the extents")


@final
class Aside(Row):
    """Draws aside of an object, uniform in [0, 1)."""

    pick: float = field("-", "whether the cup seals; 1 where picks do not fail")
    seen: float = field("-", "item that the classifier sees")


@final
class ItemRow(Row):
    """An item, as `items.Item` explains."""

    shape: int = field("-", "index in `items.SHAPES`")
    size: Triple = field("m", "full extents")
    mass: float = field("kg", "mass")
    drag: float = field("-", "coefficient of the drag")
    com_depth: float = field("-", "centre of mass below the top, as a share of the height")
    seal_force: float = field("N", "force of the vacuum")
    residue: float = field("-", "mean content over the mass of the empty item")
    friction: float = field("-", "friction of contacts")
    rolling_friction: float = field("m", "rolling friction of contacts")
    restitution: float = field("-", "rebound speed over impact speed")
    cup_friction: float = field("-", "friction under the lip of the cup")
    cup_radius: float = field("m", "radius of the item's cup")
    pick_chance: float = field("-", "probability that a cup seals")


@final
class CellNumbers(Row):
    """Numbers of a cell: spreads and noises of its sections `spread` and `noise`, cup and belt."""

    mismatch: float = field("-", "factor of all hidden effects")
    com_depth: float = field("-", "spread of the centre of mass, as a share of the height")
    height: float = field("m", "spread of the centre of mass that the planner does not know")
    grasp: float = field("m", "spread of the grasp offset")
    yaw: float = field("rad", "largest yaw")
    belt_speed: float = field("-", "spread of the belt's speed")
    spin: float = field("rad/s", "spread of the random spin")
    spin_per_offset: float = field("rad/s/m", "spin of a grasp offset")
    size_noise: float = field("m", "the camera's noise of the extents")
    yaw_noise: float = field("rad", "the camera's noise of the yaw")
    grasp_noise: float = field("m", "the camera's noise of the grasp offset")
    jitter: float = field("s", "jitter of the release")
    fitted: bool = field("-", "whether each item has a cup of its own")
    valve: float = field("s", "delay of the valve")
    tau: float = field("s", "time constant of the vacuum under a tight seal")
    stiffness: float = field("N m/rad", "stiffness of the lip")
    blow_off: float = field("m/s", "speed that blown air gives")
    lane_y: Pair = field("m", "range of places across the belt")
    spacing: Pair = field("m", "range of distances between objects")


class Lips(NamedTuple):
    """Cups that N objects leave."""

    cosine: Floats1
    """Cosines of the objects' yaws (N,)."""
    sine: Floats1
    """Sines of these yaws (N,)."""
    grasp: Floats2
    """Centres of mass from the cups' axes, along x and y (N, 2) [m]."""
    tau: Floats1
    """Time constants of the vacuum (N,) [s]."""


class StandardDraws(NamedTuple):
    """Draws of N objects."""

    normals: Rows1[Normals]
    uniforms: Rows1[Uniforms]
    aside: Rows1[Aside]
    factors: Rows1[Factors]


class ItemMix(NamedTuple):
    """What a cell says of its objects."""

    cell: Rows1[CellNumbers]
    """The cell (1,)."""
    items: Rows1[ItemRow]
    """The items (K,)."""
    shares: Floats1
    """Cumulated shares of the items (K,); empty where all items are equally frequent."""
    confusion: Floats2
    """Cumulated probabilities of the items that the classifier sees (K, K); (0, 0) for a sure classifier."""
    percent: Floats1
    """Speed settings (P,) [%]."""
