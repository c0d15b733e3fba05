"""Typed rows of a serial arm, for compiled functions.

Where all joints are at 0, every link's frame has the axes of the cell; its origin is on the axis of the link's joint.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pnt_gym.arrays import Floats
from pnt_gym.rows import Row, Triple, field

Nine: TypeAlias = Annotated[Floats, 9]
"""A matrix (3, 3), row after row."""


class Link(Row):
    """A joint and all bodies that move with it, up to the next joint."""

    offset: Triple = field("m", "origin of the frame in the frame of the link before, all joints at 0")
    axis: Triple = field("-", "axis of the joint")
    slides: float = field("-", "1 for a sliding joint, 0 for a turning one")
    mass: float = field("kg", "mass")
    centre: Triple = field("m", "centre of mass in the link's frame")
    inertia: Nine = field("kg m2", "inertia about the centre of mass")
    armature: float = field("kg m2", "inertia of the motor at the joint; of a sliding joint a mass [kg]")
    damping: float = field("N m s/rad", "viscous damping of the joint")


class Tool(Row):
    """The hand in the frame of the last link: its origin is the tip of the cup, its z axis points up at work."""

    offset: Triple = field("m", "tip of the cup")
    turn: Nine = field("-", "axes of the hand as columns, all joints at 0")


class SeedGrid(Row):
    """Box of points, evenly spaced along each axis, at which poses are known."""

    low: Triple = field("m", "point of the first index")
    step: Triple = field("m", "distances of neighbours along the axes")
    count_x: int = field("-", "points along x")
    count_y: int = field("-", "points along y")
    count_z: int = field("-", "points along z")
