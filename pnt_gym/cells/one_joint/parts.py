"""Parts that the one-joint arm throws: a block, a T and an H of wood (Miyashita et al., sections 1 and 6).

A part is planar: an outline in its own frame u (along the arm), v (away from the arm), with the origin at the centre
of mass, and the boxes that fill the outline for contact. The paper prints the block's size and mass; the shapes of T
and H are not published and are chosen here: both as long as the block, so that they lie on the arm like it, and of
the same wood. The T's stem ends in a nose of 45 degrees, which finds the slot of the H.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.engine import MjsBody, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.palette import AITCH as AITCH_COLOUR
from pnt_gym.palette import BLOCK as BLOCK_COLOUR
from pnt_gym.palette import CROSS, Colour
from pnt_gym.planning.one_joint.parameters import Block

PART_BIT: Final = 1
"""Collision bit of parts and pallets; other bits are free for the arm."""
WOOD_FRICTION: Final = 0.4
"""Wood on wood, sliding; between the usual 0.2 (kinetic) and 0.5 (static)."""
WOOD_SOLREF: Final = (0.004, 1.25)
"""Time constant [s] and damping ratio of a contact: overdamped, rebounds with a tenth of the speed."""
WOOD_SOLIMP: Final = (0.95, 0.99, 0.001, 0.5, 2.0)
"""Nearly rigid from the first micrometre on; a part at rest sinks in by less than 0.1 mm."""
WOOD_DENSITY: Final = 0.029 / (0.06 * 0.03 * 0.03)
"""Density of the paper's block, 29 g at 6 cm x 3 cm x 3 cm [kg/m3]."""
DEPTH: Final = 0.030
"""Depth across the plane of the throw [m] (section 6)."""

STEM: Final = 0.010
"""Width of the T's stem [m]."""
STEM_LENGTH: Final = 0.015
"""Length from the T's bar to the tip of the nose [m]."""
SLOT: Final = 0.020
"""Width of the H's slots [m]: 5 mm of play on either side of the stem."""
SLOT_DEPTH: Final = 0.016
"""Depth of the H's slots, 1 mm more than the stem is long, so that the bar and not the tip bears [m]."""
BAR: Final = 0.012
"""Thickness of the T's bar [m]."""
BRIDGE: Final = 0.010
"""Thickness of the H's cross bar [m]."""
WIDTH: Final = 0.060
"""Width of T and H, as long as the block [m]."""
H_HEIGHT: Final = 2.0 * SLOT_DEPTH + BRIDGE

_LARGEST_OFFSET = 1e-9  # m, what counts as a centre of mass at the origin

Outline = tuple[tuple[float, float], ...]
Boxes = tuple[tuple[float, float, float, float, float], ...]


@final
@dataclass(frozen=True)
class Part:
    """A prism of one material whose cross-section lies in the plane of the throw.

    Raises:
        ConfigError: a depth or density is not positive, or an outline is clockwise or has its centroid off the
            origin.
    """

    name: str
    outline: Outline
    """Corners u, v [m], anticlockwise, the origin at the centre of mass."""
    boxes: Boxes
    """Boxes for contact, which together fill the outline: centre u, v, half sizes along the box's own axes [m], and the
    angle of the box [rad]."""
    depth: float = DEPTH
    """Depth across the plane [m]."""
    density: float = WOOD_DENSITY
    """Density [kg/m3]."""
    rgba: Colour = BLOCK_COLOUR

    def __post_init__(self) -> None:
        for name in ("depth", "density"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ConfigError(f"{name} of part {self.name!r} is {value}, but must be positive.")
        if not self.area > 0.0:
            raise ConfigError(f"outline of part {self.name!r} has area {self.area} m2, but must run anticlockwise.")
        centroid = _moments(np.array(self.outline))[0]
        if float(np.abs(centroid).max()) > _LARGEST_OFFSET:
            raise ConfigError(f"centroid of part {self.name!r} is at {centroid} m, but must be at the origin.")

    @cached_property
    def mass(self) -> float:
        """Mass of the part [kg]."""
        return self.density * self.depth * self.area

    @cached_property
    def area(self) -> float:
        """Area of the cross-section [m2]."""
        return float(_cross_products(np.array(self.outline)).sum() / 2.0)

    @cached_property
    def inertia(self) -> float:
        """Moment of inertia J about the centre of mass, across the plane [kg m2]."""
        second = _moments(np.array(self.outline))[1]
        return self.density * self.depth * float(second.sum())

    @cached_property
    def inertias(self) -> tuple[float, float, float]:
        """Moments of inertia about the part's u axis, the axis across the plane, and the v axis [kg m2]."""
        along_u, along_v = self.density * self.depth * _moments(np.array(self.outline))[1]
        # A prism adds m depth^2 / 12 about axes in its plane; about u counts the extent along v, and vice versa.
        flat = self.mass * self.depth**2 / 12.0
        return float(along_v + flat), self.inertia, float(along_u + flat)

    @property
    def half_height(self) -> float:
        """d: height of the centre of mass above the arm's surface [m]."""
        return -min(v for _, v in self.outline)

    @property
    def support(self) -> tuple[float, float]:
        """l_A, l_B: from the centre of mass to the outer and the inner supporting vertex, along the arm [m]."""
        low = [u for u, v in self.outline if v < _LARGEST_OFFSET - self.half_height]
        return max(low), -min(low)

    @property
    def half_length(self) -> float:
        """The shorter of l_A and l_B, which bounds the dynamic grasp [m]; they are equal for every part here."""
        return min(self.support)

    @property
    def reach(self) -> float:
        """Distance of the farthest corner from the centre of mass [m]."""
        return max(float(np.hypot(u, v)) for u, v in self.outline)


def block(part: Part) -> Block:
    """The part as the planner models it: mass, support and height of the centre of mass.

    The planner's block is a full box, so its inertia differs from the part's: 11 % more for the T, 15 % less for the H.
    This inertia is small beside m l_A r in Eqs. 2 and 3; the bounds of the dynamic grasp move by 1 %.
    """
    return Block(mass=part.mass, half_length=part.half_length, half_height=part.half_height, depth=part.depth)


def add_part(body: MjsBody, part: Part, affinity: int = PART_BIT) -> None:
    """Give a body the part's mass and its geoms; the body's x axis is u, its z axis v.

    Args:
        body: body of a mujoco.MjSpec; the caller adds the joints.
        part: the part.
        affinity: collision bits of what the part touches besides other parts and pallets.
    """
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = part.mass, np.array(part.inertias), np.zeros(3)
    add_boxes(body, part.boxes, part.depth, part.rgba, affinity=affinity)


def add_boxes(body: MjsBody, boxes: Boxes, depth: float, rgba: Colour, affinity: int = PART_BIT) -> None:
    """Add wooden boxes (centre u, v, half sizes, angle) to a body whose x axis is u and whose z axis is v."""
    for k, (u, v, half_u, half_v, angle) in enumerate(boxes):
        body.add_geom(
            name=f"{body.name}_{k}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[half_u, depth / 2, half_v],
            pos=[u, 0, v],
            quat=turn_quaternion(angle),
            rgba=rgba,
            mass=0,
            contype=PART_BIT,
            conaffinity=affinity,
            condim=3,
            friction=[WOOD_FRICTION, 0.0, 0.0],
            solref=WOOD_SOLREF,
            solimp=WOOD_SOLIMP,
        )


def turn_quaternion(angle: float) -> Floats:
    """Quaternion (4,) of an anticlockwise turn, seen with x to the right and z up [rad]."""
    return np.array([np.cos(angle / 2), 0.0, -np.sin(angle / 2), 0.0])


def _cross_products(outline: Floats) -> Floats:
    """Twice the areas of the triangles between the origin and each side of a polygon (V, 2), (V,) [m2]."""
    a, b = outline, np.roll(outline, -1, axis=0)
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _moments(outline: Floats) -> tuple[Floats, Floats]:
    """Centroid (2,) and second moments of area (2,), of u^2 and of v^2, of a polygon (V, 2) by Green's theorem."""
    a, b, cross = outline, np.roll(outline, -1, axis=0), _cross_products(outline)[:, None]
    area = cross.sum() / 2.0
    # Sums over the triangles between the origin and the sides, a side's ends being a and b.
    centroid = ((a + b) * cross).sum(axis=0) / (6.0 * area)
    second = ((a * a + a * b + b * b) * cross).sum(axis=0) / 12.0
    # Parallel axes: from the origin to the centroid.
    return centroid, second - area * centroid**2


def _box(u: tuple[float, float], v: tuple[float, float]) -> tuple[float, float, float, float, float]:
    """An upright box between two values of u and two values of v."""
    return (u[0] + u[1]) / 2, (v[0] + v[1]) / 2, (u[1] - u[0]) / 2, (v[1] - v[0]) / 2, 0.0


def _tee() -> Part:
    """The T about its centre of mass; its bar lies on the arm, its stem points up."""
    h, s, shoulder = WIDTH / 2, STEM / 2, BAR + STEM_LENGTH - STEM / 2
    right: Sequence[tuple[float, float]] = ((h, 0.0), (h, BAR), (s, BAR), (s, shoulder))
    left = tuple((-u, v) for u, v in reversed(right))
    corners = (*right, (0.0, BAR + STEM_LENGTH), *left)
    # The nose is a square on its corner. Its diagonal is the stem's width: its lower half is hidden in the stem.
    half = float(STEM / np.sqrt(8.0))
    boxes = (_box((-h, h), (0.0, BAR)), _box((-s, s), (BAR, shoulder)), (0.0, shoulder, half, half, np.pi / 4))
    u, v = (float(value) for value in _moments(np.array(corners))[0])
    return Part(
        name="tee",
        outline=tuple((a - u, b - v) for a, b in corners),
        boxes=tuple((a - u, b - v, half_u, half_v, angle) for a, b, half_u, half_v, angle in boxes),
        rgba=CROSS,
    )


def _aitch() -> Part:
    """The H; both legs stand on the arm, one slot opens below the cross bar and one above."""
    h, s, top, bridge = WIDTH / 2, SLOT / 2, H_HEIGHT / 2, BRIDGE / 2
    right: Sequence[tuple[float, float]] = ((s, -bridge), (s, -top), (h, -top), (h, top), (s, top), (s, bridge))
    left = tuple((-u, -v) for u, v in right)
    boxes = (_box((-h, -s), (-top, top)), _box((s, h), (-top, top)), _box((-s, s), (-bridge, bridge)))
    return Part(name="aitch", outline=(*right, *left), boxes=boxes, rgba=AITCH_COLOUR)


_H, _D = WIDTH / 2, 0.015
BLOCK: Final = Part(
    name="block", outline=((-_H, -_D), (_H, -_D), (_H, _D), (-_H, _D)), boxes=(_box((-_H, _H), (-_D, _D)),)
)
TEE: Final = _tee()
AITCH: Final = _aitch()
