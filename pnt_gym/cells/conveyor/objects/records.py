"""Objects on the belt as rows of any leading shape S: true values, measured values, random draws.

`objects.mass` is the column of a field (see `rows.Columns`), `objects.rows` are the rows for compiled functions. The
outline of an object is its true footprint on the belt, turned by its yaw.
"""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, ClassVar, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.airborne import Body
from pnt_gym.cells.base.bodies import (
    ModelObjects,
    contact_solref,
    fluid_coefficients,
    geom_placement,
    lying_extents,
    solid_shell_inertia,
    yaw_attitude,
)
from pnt_gym.cells.base.items import CYLINDER, ELLIPSOID
from pnt_gym.cells.conveyor.config import LIP_GAP
from pnt_gym.rows import Columns, Pair, Quadruple, Rows1, Triple, field

TARGET_DRAWS: Final = 8
"""Largest number of bins that are tried for one object before it stays on the belt."""


@final
class Measured(Columns):
    """Measurements of objects: the only values of objects that an observation may contain."""

    kind: Ints = field("-", "item that the classifier sees in the object: index into the cell's item list")
    shape: Ints = field("-", "index in `items.SHAPES`; it is measured without error")
    size: Triple = field("m", "full extents of the lying object before yaw; the height is measured without noise")
    mass: Floats = field("kg", "mass")
    seal: Floats = field("N", "force of the vacuum before the release")
    yaw: Floats = field("rad", "yaw")
    friction: Floats = field("-", "friction under the lip, of the item that the classifier sees")
    grasp_noise: Pair = field("m", "the camera's error of the grasp offset")


@final
class Draws(Columns):
    """Random draws that place objects."""

    lane_y: Floats = field("m", "place across the belt")
    gap: Floats = field("m", "distance to the object before this one on the belt")
    place: Quadruple = field("-", "uniform draws for a pick without a belt: places of this pick and of the next object")
    bin: Annotated[Floats, (TARGET_DRAWS, 3)] = field("-", "uniform draws that choose the object's bin")


@final
class Objects(Columns):
    """True, hidden values of objects, with their measurements and the draws that place them.

    Args:
        rows: the objects, of any leading shape S.
        fill: uniform draws of the content of each bin, used where contents are not simulated, S + (B,).
    """

    kind: Ints = field("-", "true item: index into the cell's item list")
    shape: Ints = field("-", "0 ellipsoid, 1 cylinder lying along x, 2 box")
    size: Triple = field("m", "full extents of the lying object before yaw")
    mass: Floats = field("kg", "mass")
    drag: Floats = field("-", "coefficient of the drag")
    com_depth: Floats = field("m", "centre of mass below the cup")
    known_depth: Floats = field("m", "part of `com_depth` that the planner knows: all of it at mismatch 0, none at 1")
    seal: Floats = field("N", "force of the vacuum before the release, F0")
    valve: Floats = field("s", "delay of the valve")
    tau: Floats = field("s", "time constant of the vacuum under a tight seal")
    delay: Floats = field("s", "delay of the release after the command")
    jitter: Floats = field("s", "part of `delay` that differs from throw to throw")
    friction: Floats = field("-", "friction of contacts")
    cup_friction: Floats = field("-", "friction under the lip of the cup")
    cup_radius: Floats = field("m", "radius of the cup that holds the object")
    stiffness: Floats = field("N m/rad", "stiffness of the cup's lip against bending; infinite for a rigid cup")
    blow_off: Floats = field("m/s", "speed downwards that blown air gives the object at the release, at mismatch 1")
    rolling_friction: Floats = field("m", "rolling friction of contacts")
    restitution: Floats = field("-", "rebound speed over impact speed of contacts")
    yaw: Floats = field("rad", "yaw")
    grasp: Pair = field("m", "centre of mass from the cup's axis, along x and y, at zero error of the belt's speed")
    belt_error: Floats = field("-", "relative error of the belt's speed; adds to `grasp` with the way from the camera")
    spin: Triple = field("rad/s", "angular velocity gained at the release")
    pick_chance: Floats = field("-", "probability that a cup well inside the outline seals")
    pick_draw: Floats = field("-", "uniform draw, or 1; the pick fails where the draw is below the chance of failure")
    percent: Floats = field("%", "speed setting of the object's throw")
    hand_error: Triple = field("m", "distance of the hand from its planned place in the object's throw")
    measured: Measured = field("-", "measurements")
    draws: Draws = field("-", "random draws")

    _fields: ClassVar = ("rows", "fill")

    def __init__(self, rows: NDArray[Any], fill: Floats) -> None:
        super().__init__(rows)
        self.fill = fill

    @cached_property
    def turn(self) -> tuple[Floats, Floats]:
        """Cosines and sines of the yaws, each S."""
        return np.cos(self.yaw), np.sin(self.yaw)

    @cached_property
    def attitude(self) -> Floats:
        """Attitudes of N objects that lie or hang at rest (N, 4)."""
        return yaw_attitude(self.yaw)

    @cached_property
    def extents(self) -> Floats:
        """Extents of the modelled bodies of N objects (N, 3) [m], see `lying_extents`."""
        return lying_extents(self.shape, self.size)

    @cached_property
    def middle(self) -> Floats:
        """Heights of the bodies' middles above the centres of mass, of N objects that lie or hang at rest (N,) [m]."""
        return self.com_depth - LIP_GAP - self.size[:, 2] / 2.0

    @cached_property
    def inertia(self) -> Floats:
        """Moments of inertia of N objects about their own axes, through the centre of the extents (N, 3) [kg m2]."""
        return solid_shell_inertia(self.mass, self.extents, self.shape)

    @cached_property
    def model(self) -> ModelObjects:
        """Masses, inertias, geoms and air of the modelled bodies of N objects, as MuJoCo's fields."""
        shape, extents = self.shape, self.extents
        geoms, fluid = geom_placement(shape, extents), fluid_coefficients(shape, extents, self.drag)
        return ModelObjects(self.mass, self.inertia, geoms, fluid)

    @cached_property
    def body(self) -> Rows1[Body]:
        """N objects as bodies in the air."""
        geoms, fluid, body = self.model.placement, self.model.fluid, Body.empty(len(self.mass))
        body["mass"], body["inertia"], body["height"] = self.mass, self.inertia, self.middle
        # The semi-axes of a cylinder along its geom's axes: its radius twice, and half its length.
        size, lies = geoms.size, (self.shape == CYLINDER)[:, None]
        body["attitude"], body["semi_axes"] = geoms.quat, np.where(lies, size[:, [0, 0, 1]], size)
        for name, column in zip(("interacts", "blunt", "slender", "angular", "kutta", "magnus"), fluid.T, strict=False):
            body[name] = column
        body["virtual_mass"], body["virtual_inertia"] = fluid[:, 6:9], fluid[:, 9:]
        return body

    @cached_property
    def solref(self) -> Floats:
        """MuJoCo's `solref` of the contacts of N objects (N, 2) [s, -], see `contact_solref`."""
        return contact_solref(self.restitution)


def half_extent(objects: Objects, heading: float | Floats = 0.0) -> Floats:
    """Half extents of footprints along a horizontal direction, from their centres, S [m].

    In top view a box and a lying cylinder are rectangles, an ellipsoid is an ellipse.

    Args:
        objects: objects of any leading shape S.
        heading: angle of the direction, from the belt's travel towards the bins: one number, or S [rad].
    """
    turned = heading - objects.yaw
    is_ellipse = objects.shape == ELLIPSOID
    return outline_reach(is_ellipse, objects.size[..., 0], objects.size[..., 1], np.cos(turned), np.sin(turned))


def outline_reach(is_ellipse: Any, length: Any, width: Any, cosine: Any, sine: Any) -> Any:
    """Half extents of outlines along directions that are turned from their lengths, S: of arrays, or of numbers.

    Args:
        is_ellipse: whether each outline is an ellipse, not a rectangle, S.
        length: extents S [m].
        width: extents across the length S [m].
        cosine: cosines of the turns S.
        sine: sines of the turns S.
    """
    # Support function: a |cos| + b |sin| of a rectangle, sqrt((a cos)^2 + (b sin)^2) of an ellipse.
    along, across = 0.5 * length * abs(cosine), 0.5 * width * abs(sine)
    return is_ellipse * np.sqrt(along * along + across * across) + (1.0 - is_ellipse) * (along + across)
