"""Rows of objects in the air, and of what falling objects may meet, as `freefall` and `settle_kernel` take them."""

from __future__ import annotations

from typing import NamedTuple, final

from pnt_gym.rows import Floats1, Floats2, Floats3, Quadruple, Row, Rows1, Rows2, Triple, field

STATE = 13
"""Numbers in a state: position [m] (3), attitude (4, w first), world velocity [m/s] (3), body angular velocity [rad/s]
(3)."""


@final
class Body(Row):
    """An object in the air; its coefficients are those of MuJoCo's `geom_fluid`."""

    mass: float = field("kg", "mass")
    inertia: Triple = field("kg m2", "moments about the axes through the centre of mass")
    height: float = field("m", "height of the geom's middle above the centre of mass")
    attitude: Quadruple = field("-", "attitude of the geom in the body, w first")
    semi_axes: Triple = field("m", "semi-axes of the geom")
    interacts: float = field("-", "1 where the air acts on the object")
    blunt: float = field("-", "drag across the flow")
    slender: float = field("-", "drag along the flow")
    angular: float = field("-", "drag against rotation")
    kutta: float = field("-", "Kutta lift")
    magnus: float = field("-", "Magnus lift")
    virtual_mass: Triple = field("m3", "added mass along the geom's axes, per density of the fluid")
    virtual_inertia: Triple = field("m5", "added inertia about the geom's axes, per density of the fluid")


@final
class Pivot(Row):
    """A cup's lip as a spring about three axes, in which the object hangs at rest."""

    arm: Triple = field("m", "centre of mass from the lip, in the object's axes")
    stiffness: Triple = field("N m/rad", "stiffness about each axis")
    damping: Triple = field("N m s/rad", "damping about each axis")


@final
class Solid(Row):
    """A body that may touch bins, floor and belt."""

    shape: int = field("-", "index in `items.SHAPES`")
    half: Triple = field("m", "half extents")
    height: float = field("m", "height of the geom's middle above the centre of mass")
    spin: Triple = field("m2", "inertia over mass")
    rebound: float = field("-", "largest rebound speed over impact speed")
    farthest: float = field("m", "farthest point from the centre of mass")


@final
class BinShape(Row):
    """A bin."""

    x: float = field("m", "centre of the opening")
    y: float = field("m", "centre of the opening")
    half_x: float = field("m", "half the opening")
    half_y: float = field("m", "half the opening")
    depth: float = field("m", "depth below the rim")


@final
class Ground(Row):
    """Floor and belt."""

    floor: float = field("m", "height of the floor")
    belt: float = field("m", "height of the belt")
    min_x: float = field("m", "least x of the belt")
    max_x: float = field("m", "largest x of the belt")
    min_y: float = field("m", "least y of the belt")
    max_y: float = field("m", "largest y of the belt")


@final
class Airborne(NamedTuple):
    """N objects in the air."""

    body: Rows1[Body]
    wind: Floats2
    """Horizontal velocity of the air around each object (N, 2) [m/s]."""
    air: float
    """Share of the air's density and viscosity."""


@final
class Hanging(NamedTuple):
    """N objects that hang under compliant cups."""

    body: Rows1[Body]
    pivot: Rows1[Pivot]
    air: float
    """Share of the air's density and viscosity."""


@final
class Carrying(NamedTuple):
    """Motions of N hands at the beginnings of K steps, and the axes in which what they carry hangs at rest."""

    acceleration: Floats3
    """(N, K, 3) [m/s2]"""
    velocity: Floats3
    """(N, K, 3) [m/s]"""
    wind: Floats2
    """Horizontal velocity of the air around each hand (N, 2) [m/s]."""
    cosine: Floats1
    """Cosines of the axes' turns about the vertical (N,)."""
    sine: Floats1
    """Sines of these turns (N,)."""


@final
class Vicinity(NamedTuple):
    """Bodies of N falling objects and what they may meet."""

    solid: Rows1[Solid]
    bins: Rows2[BinShape]
    """Bins of each object's cell (N, B)."""
    rim: Floats1
    """Heights of the rims (N,) [m]."""
    ground: Rows1[Ground]
