"""Objects and bins of the conveyor cell as fields of MuJoCo's models. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.compiled import kernel
from pnt_gym.rows import Floats1, Floats2, Floats3, Ints1

PANELS = 5
"""Number of a bin's panels: walls at +x, -x, +y and -y, and the bottom."""


@final
class Panels(NamedTuple):
    """The five panels of N bins, relative to the centres of the openings: walls at +x, -x, +y, -y, and the bottom."""

    half: Floats3
    """Half extents (N, 5, 3) [m]."""
    centre: Floats3
    """Centres (N, 5, 3) [m]."""


@final
class BinFields(NamedTuple):
    """The fields `BIN_FIELDS` of S simulations."""

    place: Floats3
    size: Floats3
    geom_place: Floats3
    rbound: Floats2
    aabb: Floats3


BIN_FIELDS: Final = ("body_pos", "geom_size", "geom_pos", "geom_rbound", "geom_aabb")


@final
class CupFields(NamedTuple):
    """The fields `CUP_FIELDS` of S simulations."""

    size: Floats3
    rbound: Floats2
    aabb: Floats3


CUP_FIELDS: Final = ("geom_size", "geom_rbound", "geom_aabb")


@final
class ContactFields(NamedTuple):
    """The fields `CONTACT_FIELDS` of S simulations."""

    place: Floats3
    friction: Floats3
    solref: Floats3


CONTACT_FIELDS: Final = ("geom_pos", "geom_friction", "geom_solref")


@final
class Contacts(NamedTuple):
    """What contacts of N objects need."""

    height: Floats1
    """Height of the body's middle above the centre of mass (N,) [m]."""
    friction: Floats1
    """Coefficient of sliding (N,)."""
    rolling: Floats1
    """Coefficient of rolling (N,) [m]."""
    solref: Floats2
    """MuJoCo's `solref` (N, 2)."""


@kernel
def bin_panels(size: Floats2, depth: float, wall: float, panels: Panels) -> None:
    """Fill panels (N, 5) as `scene.bin_panels`."""
    half, centre = panels
    w, d = wall / 2.0, depth / 2.0
    for row in range(len(size)):
        x, y = size[row, 0] / 2.0, size[row, 1] / 2.0
        half[row], centre[row] = w, 0.0
        # The walls at +x and -x end flush with the others' outer faces.
        half[row, 0, 1] = half[row, 1, 1] = y + 2.0 * w
        half[row, 2, 0] = half[row, 3, 0] = x
        half[row, 4, 0], half[row, 4, 1] = x + 2.0 * w, y + 2.0 * w
        centre[row, 0, 0], centre[row, 1, 0] = x + w, -(x + w)
        centre[row, 2, 1], centre[row, 3, 1] = y + w, -(y + w)
        for panel in range(4):
            half[row, panel, 2], centre[row, panel, 2] = d, -d
        centre[row, 4, 2] = -2.0 * d - w


@kernel
def draw_bins(draws: Floats3, size: Floats2, ranges: Floats2, clearance: float, rim: float) -> tuple[Floats3, Floats3]:
    """Square bins at random places: centres of the openings (N, T, 3) and inner sizes (N, T, 2) [m].

    Args:
        draws: uniform draws of places and sides of T bins for each of N objects (N, T, 3).
        size: measured extents of the objects (N, 3) [m].
        ranges: ranges of the bins' centres along x and y, and of the inner sides of the openings (3, 2) [m].
        clearance: least inner side beyond the largest extent of the object [m]; 0 for no least side.
        rim: height of the rims [m].
    """
    count, tries, _ = draws.shape
    target, opening = np.full((count, tries, 3), rim), np.empty((count, tries, 2))
    x, y, side = ranges[0], ranges[1], ranges[2]
    for n in range(len(draws)):
        least = max(size[n, 0], size[n, 1], size[n, 2]) + clearance if clearance > 0.0 else 0.0
        for k in range(draws.shape[1]):
            target[n, k, 0] = x[0] + (x[1] - x[0]) * draws[n, k, 0]
            target[n, k, 1] = y[0] + (y[1] - y[0]) * draws[n, k, 1]
            opening[n, k, 0] = opening[n, k, 1] = max(side[0] + (side[1] - side[0]) * draws[n, k, 2], least)
    return target, opening


@kernel
def place_bins(rows: Ints1, body: int, first: int, target: Floats2, panels: Panels, fields: BinFields) -> None:
    """Write the bins of N throws into the fields of some simulations.

    Args:
        rows: the simulations of the throws (N,).
        body: id of the bin's body.
        first: id of its first panel.
        target: centres of the openings (N, 3) [m].
        panels: the panels (N, 5).
        fields: the fields.
    """
    for n in range(len(rows)):
        row = rows[n]
        fields.place[row, body] = target[n]
        for panel in range(PANELS):
            geom, half = first + panel, panels.half[n, panel]
            x, y, z = half[0], half[1], half[2]
            fields.size[row, geom], fields.geom_place[row, geom] = half, panels.centre[n, panel]
            fields.rbound[row, geom] = math.sqrt(x * x + y * y + z * z)
            fields.aabb[row, geom, :3], fields.aabb[row, geom, 3:] = 0.0, half


@kernel
def write_contacts(rows: Ints1, geom: int, contacts: Contacts, fields: ContactFields) -> None:
    """Write what contacts of N objects need into the fields of some simulations (N,); `geom` is the object's geom."""
    for n in range(len(rows)):
        row = rows[n]
        fields.place[row, geom, 2], fields.solref[row, geom] = contacts.height[n], contacts.solref[n]
        # MuJoCo's order: sliding, torsional [m], rolling [m].
        friction, rolling = fields.friction[row, geom], contacts.rolling[n]
        friction[0], friction[1], friction[2] = contacts.friction[n], 0.1 * rolling, rolling


@kernel
def widen_cups(rows: Ints1, cups: Ints1, radius: Floats1, half: Floats1, bounds: Floats2, fields: CupFields) -> None:
    """Write the radii of cups into the fields of some simulations.

    Args:
        rows: the simulations (N,).
        cups: ids of the cylinders of a cup (C,).
        radius: radii (N,) [m].
        half: half lengths of the cylinders (C,) [m].
        bounds: radii of spheres around the cylinders (N, C) [m].
        fields: the fields.
    """
    for n in range(len(rows)):
        for k in range(len(cups)):
            row, geom = rows[n], cups[k]
            fields.size[row, geom, 0], fields.rbound[row, geom] = radius[n], bounds[n, k]
            fields.aabb[row, geom, :3] = 0.0
            fields.aabb[row, geom, 3] = fields.aabb[row, geom, 4] = radius[n]
            fields.aabb[row, geom, 5] = half[k]


@kernel
def hold_until(release: Ints1, motors: int, controls: int, held: Ints1, control: Floats3, counts: Ints1) -> None:
    """Hold N objects until their releases, with no other force and every other equality active at every step.

    Args:
        release: first steps without grip (N,).
        motors: number of controls of the motors, which stay.
        controls: number of all controls, before the equalities.
        held: columns that hold an object.
        control: controls and equality bits of every step (N, M, C), in place.
        counts: numbers of steps that are written (N,).
    """
    for row in range(control.shape[0]):
        for step in range(counts[row]):
            moment, hold = control[row, step], 1.0 if step < release[row] else 0.0
            moment[motors:controls] = 0.0
            moment[controls:] = 1.0
            for column in held:
                moment[column] = hold
