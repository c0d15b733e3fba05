"""Objects on the belt in three records with any leading shape S: true values, measured values, random draws.

The outline of an object is its true footprint on the belt, turned by its yaw.

Lengths are in m, masses in kg, forces in N, angles in rad.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.fluid import (
    GeomPlacement,
    fluid_coefficients,
    geom_placement,
    lying_extents,
    solid_shell_inertia,
)
from pnt_gym.cells.base.items import ELLIPSOID
from pnt_gym.cells.base.rotations import yaw_attitude
from pnt_gym.records import Record, computed

TARGET_DRAWS: Final = 8
"""Largest number of bins that are tried for one object before it stays on the belt."""


@final
@dataclass(frozen=True)
class Measured(Record):
    """Measurements of objects: the only values of objects that an observation may contain."""

    kind: Ints
    """Item that the classifier sees in each object: index into the cell's item list, S."""
    shape: Ints
    """The shape as in `Objects`; it is measured without error."""
    size: Floats
    mass: Floats
    seal: Floats
    yaw: Floats
    friction: Floats
    """Friction under the lip, of the item that the classifier sees."""
    grasp_noise: Floats
    """The camera's error of the grasp offset, S + (2,) [m]."""


@final
@dataclass(frozen=True)
class Draws(Record):
    """Random draws that place objects."""

    lane_y: Floats
    gap: Floats
    """Distance to the object before this one on the belt [m]."""
    place: Floats
    """Uniform draws for a pick without a belt: positions of this pick and of the next object, S + (4,)."""
    bin: Floats
    """Uniform draws that choose the object's bin, S + (TARGET_DRAWS, 3)."""
    fill: Floats
    """Uniform draws of the content of each bin, used where contents are not simulated, S + (B,)."""


@final
@dataclass(frozen=True)
class Objects(Record):
    """True, hidden values of objects, with their measurements and the draws that place them."""

    kind: Ints
    """True item: index into the cell's item list, S."""
    shape: Ints
    """0 ellipsoid, 1 cylinder lying along x, 2 box, S."""
    size: Floats
    """Full extents of the lying object before yaw, S + (3,)."""
    mass: Floats
    drag: Floats
    com_depth: Floats
    """Centre of mass below the cup [m]."""
    known_depth: Floats
    """The part of `com_depth` that the planner knows: the whole at mismatch 0, zero at mismatch 1 [m]."""
    seal: Floats
    """Force of the vacuum before release F0 [N]."""
    delay: Floats
    """Delay of the release after the command [s]."""
    jitter: Floats
    """The part of `delay` that differs from throw to throw [s]."""
    friction: Floats
    cup_friction: Floats
    """Friction under the lip of the cup."""
    cup_radius: Floats
    """Radius of the cup that holds the object [m]."""
    rolling_friction: Floats
    solref: Floats
    """MuJoCo `solref` of the object's contacts, S + (2,)."""
    yaw: Floats
    grasp: Floats
    """Centre of mass relative to the cup axis, along x, y, at zero belt-speed error, S + (2,) [m]."""
    belt_error: Floats
    """Relative error of the belt speed; adds to `grasp` along x with the distance from the camera."""
    spin: Floats
    """Angular velocity gained at release, about x, y, z [rad/s], S + (3,)."""
    pick_chance: Floats
    """Probability that a cup well inside the outline seals."""
    pick_draw: Floats
    """Uniform draw, or 1; the pick fails where the draw is below the probability of failure."""
    percent: Floats
    """Speed setting of the object's throw [%]."""
    measured: Measured
    draws: Draws

    @computed
    def turn(self) -> tuple[Floats, Floats]:
        """Cosines and sines of the yaws, each S."""
        return np.cos(self.yaw), np.sin(self.yaw)

    @computed
    def attitude(self) -> Floats:
        """Attitudes of N objects that lie or hang at rest (N, 4)."""
        return yaw_attitude(self.yaw)

    @computed
    def extents(self) -> Floats:
        """Extents of the modelled bodies of N objects (N, 3) [m], see `lying_extents`."""
        return lying_extents(self.shape, self.size)

    @computed
    def inertia(self) -> Floats:
        """Moments of inertia of N objects about their own axes, through the centre of the extents (N, 3) [kg m2]."""
        return solid_shell_inertia(self.mass, self.extents, self.shape)

    @computed
    def placement(self) -> GeomPlacement:
        """Geoms of the modelled bodies of N objects."""
        return geom_placement(self.shape, self.extents)

    @computed
    def fluid(self) -> Floats:
        """MuJoCo's `geom_fluid` of N objects (N, 12)."""
        return fluid_coefficients(self.shape, self.extents, self.drag)


_SHAPES: Final = {
    "size": (3,), "solref": (2,), "grasp": (2,), "spin": (3,), "grasp_noise": (2,), "place": (4,),
    "bin": (TARGET_DRAWS, 3),
}  # fmt: skip
"""Shapes of the columns of objects that are not one number."""


def columns_of_objects() -> dict[str, int]:
    """First columns of the values in the rows of a block of objects, the contents of bins last."""
    return Objects.first_columns({**_SHAPES, "fill": (1,)})


def objects_in_block(block: Floats, bins: int) -> Objects:
    """Objects whose values lie in a block S + (C,), with draws for the contents of a number of bins."""
    return Objects.from_block(block, {**_SHAPES, "fill": (bins,)})


def half_extent(objects: Objects, heading: float | Floats = 0.0) -> Floats:
    """Half extents of footprints along a horizontal direction, from their centres, S [m].

    In top view a box and a lying cylinder are rectangles, an ellipsoid is an ellipse.

    Args:
        objects: objects of any leading shape S.
        heading: angle of the direction, from the belt's travel towards the bins: one number, or S [rad].
    """
    # Support function: a |cos| + b |sin| of a rectangle, sqrt((a cos)^2 + (b sin)^2) of an ellipse.
    turned = heading - objects.yaw
    along = 0.5 * objects.size[..., 0] * np.abs(np.cos(turned))
    across = 0.5 * objects.size[..., 1] * np.abs(np.sin(turned))
    return np.where(objects.shape == ELLIPSOID, np.sqrt(along * along + across * across), along + across)
