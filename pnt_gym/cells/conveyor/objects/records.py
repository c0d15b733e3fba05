"""Objects on the belt, in three records with any leading shape S: what is true, what is measured, what was drawn.

Lengths are in m, masses in kg, forces in N, angles in rad.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from pnt_gym.arrays import Floats, Ints


@final
@dataclass(frozen=True)
class Measured:
    """What the cell's sensors report of objects: all that an observation may contain of them."""

    kind: Ints
    """What the cell's classifier takes each for: index into the cell's item list, S."""
    shape: Ints
    """As in `Objects`; no sensor errs about it."""
    size: Floats
    mass: Floats
    seal: Floats
    yaw: Floats
    friction: Floats
    """Under the lip, of what it is seen as."""
    grasp_noise: Floats
    """What the camera adds to the true grasp offset, S + (2,) [m]."""


@final
@dataclass(frozen=True)
class Draws:
    """What was drawn to place objects."""

    lane_y: Floats
    gap: Floats
    """Distance to the object before it on the belt [m]."""
    place: Floats
    """Uniform draws for a pick without a belt: where it is picked and where the next object waits, S + (4,)."""
    bin: Floats
    """Uniform draws that choose its bin, S + (TARGET_DRAWS, 3)."""
    fill: Floats
    """Uniform draws of how much lies in each bin, where nothing else says it, S + (B,)."""


@final
@dataclass(frozen=True)
class Objects:
    """What is true of objects, and hidden; with what sensors report of them, and the draws that place them."""

    kind: Ints
    """What each is: index into the cell's item list, S."""
    shape: Ints
    """0 ellipsoid, 1 cylinder lying along x, 2 box, S."""
    size: Floats
    """Full extents as it lies before yaw, S + (3,)."""
    mass: Floats
    drag: Floats
    com_depth: Floats
    """Centre of mass below the cup [m]."""
    known_depth: Floats
    """The part of `com_depth` that the planner knows: all of it without mismatch, nothing at mismatch 1 [m]."""
    seal: Floats
    """Force of the vacuum before release F0 [N]."""
    delay: Floats
    """Release later than commanded by this [s]."""
    jitter: Floats
    """The part of `delay` that differs from throw to throw [s]."""
    friction: Floats
    cup_friction: Floats
    """Under the lip of the cup."""
    cup_radius: Floats
    """Of the cup that holds it [m]."""
    rolling_friction: Floats
    solref: Floats
    """Of its contacts, S + (2,)."""
    yaw: Floats
    grasp: Floats
    """Centre of mass from the cup axis along x, y at zero belt-speed error, S + (2,) [m]."""
    belt_error: Floats
    """Relative error of the belt speed; adds to `grasp` along x with the distance from the camera."""
    spin: Floats
    """Angular velocity gained at release, about x, y, z [rad/s], S + (3,)."""
    pick_chance: Floats
    """That a cup well inside its outline seals."""
    pick_draw: Floats
    """Uniform draw, or 1, below which the pick fails: where the chance to fail is greater."""
    percent: Floats
    """Speed setting of its throw [%]."""
    measured: Measured
    draws: Draws
