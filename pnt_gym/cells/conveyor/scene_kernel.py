"""Objects and bins of the conveyor cell as fields of MuJoCo's models. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for

PANELS = 5
"""Number of a bin's panels: walls at +x, -x, +y and -y, and the bottom."""


@compile_for("void(f8[:, :], f8, f8, f8[:, :, ::1], f8[:, :, ::1])")
def fill_panels(size: Floats, depth: float, wall: float, half: Floats, centre: Floats) -> None:
    """Fill half extents and centres of panels (N, 5, 3) as `scene.bin_panels`."""
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


@compile_for(
    "void(f8[:, :, :], f8[:, :], UniTuple(f8, 2), UniTuple(f8, 2), UniTuple(f8, 2), f8, f8[:, :, ::1], f8[:, :, ::1])"
)
def draw_bins(
    draws: Floats,
    size: Floats,
    x: tuple[float, float],
    y: tuple[float, float],
    side: tuple[float, float],
    clearance: float,
    target: Floats,
    opening: Floats,
) -> None:
    """Write square bins at random places.

    Args:
        draws: uniform draws of places and sides of T bins for each of N objects (N, T, 3).
        size: measured extents of the objects (N, 3) [m].
        x: range of the bins' centres along x [m].
        y: range of the bins' centres along y [m].
        side: range of the inner sides of the openings [m].
        clearance: least inner side beyond the largest extent of the object [m]; 0 for no least side.
        target: written, centres of the openings along x and y (N, T, 3) [m].
        opening: written, inner sizes (N, T, 2) [m].
    """
    for n in range(len(draws)):
        least = max(size[n, 0], size[n, 1], size[n, 2]) + clearance if clearance > 0.0 else 0.0
        for k in range(draws.shape[1]):
            target[n, k, 0] = x[0] + (x[1] - x[0]) * draws[n, k, 0]
            target[n, k, 1] = y[0] + (y[1] - y[0]) * draws[n, k, 1]
            opening[n, k, 0] = opening[n, k, 1] = max(side[0] + (side[1] - side[0]) * draws[n, k, 2], least)


@compile_for(
    "void(i8[:], i8, i8, f8[:, :], f8[:, :, ::1], f8[:, :, ::1], f8[:, :, ::1], f8[:, :, ::1], f8[:, :, ::1],"
    "f8[:, ::1], f8[:, :, ::1])"
)
def place_bins(
    rows: Ints,
    body: int,
    first: int,
    target: Floats,
    half: Floats,
    centre: Floats,
    body_pos: Floats,
    geom_size: Floats,
    geom_pos: Floats,
    geom_rbound: Floats,
    geom_aabb: Floats,
) -> None:
    """Write the bins of N throws into the fields of some simulations.

    Args:
        rows: the simulations of the throws (N,).
        body: id of the bin's body.
        first: id of its first panel.
        target: centres of the openings (N, 3) [m].
        half: half extents of the panels (N, 5, 3) [m].
        centre: centres of the panels (N, 5, 3) [m].
        body_pos: field of the model, of all simulations (S, bodies, 3), and so on.
        geom_size: see `body_pos`.
        geom_pos: see `body_pos`.
        geom_rbound: see `body_pos`.
        geom_aabb: see `body_pos`.
    """
    for n in range(len(rows)):
        row = rows[n]
        body_pos[row, body] = target[n]
        for panel in range(PANELS):
            geom = first + panel
            x, y, z = half[n, panel, 0], half[n, panel, 1], half[n, panel, 2]
            geom_size[row, geom], geom_pos[row, geom] = half[n, panel], centre[n, panel]
            geom_rbound[row, geom] = math.sqrt(x * x + y * y + z * z)
            geom_aabb[row, geom, :3], geom_aabb[row, geom, 3:] = 0.0, half[n, panel]


@compile_for("void(i8[:], i8, f8[:], f8[:], f8[:], f8[:, :], f8[:, :, ::1], f8[:, :, ::1], f8[:, :, ::1])")
def write_contacts(
    rows: Ints,
    geom: int,
    place: Floats,
    friction: Floats,
    rolling: Floats,
    solref: Floats,
    geom_pos: Floats,
    geom_friction: Floats,
    geom_solref: Floats,
) -> None:
    """Write what contacts of N objects need into the fields of some simulations.

    Args:
        rows: the simulations of the objects (N,).
        geom: id of the object's geom.
        place: heights of the bodies' middles above the centres of mass (N,) [m].
        friction: coefficients of sliding (N,).
        rolling: coefficients of rolling (N,) [m].
        solref: MuJoCo's `solref` (N, 2).
        geom_pos: field of the model, of all simulations (S, geoms, 3), and so on.
        geom_friction: see `geom_pos`.
        geom_solref: see `geom_pos`.
    """
    for n in range(len(rows)):
        row = rows[n]
        geom_pos[row, geom, 2], geom_solref[row, geom] = place[n], solref[n]
        # MuJoCo's order: sliding, torsional [m], rolling [m].
        geom_friction[row, geom, 0], geom_friction[row, geom, 1] = friction[n], 0.1 * rolling[n]
        geom_friction[row, geom, 2] = rolling[n]


@compile_for("void(i8[:], i8[::1], f8[:], f8[:], f8[:, ::1], f8[:, :, ::1], f8[:, ::1], f8[:, :, ::1])")
def widen_cups(
    rows: Ints,
    cups: Ints,
    radius: Floats,
    half: Floats,
    bounds: Floats,
    geom_size: Floats,
    geom_rbound: Floats,
    geom_aabb: Floats,
) -> None:
    """Write the radii of cups into the fields of some simulations.

    Args:
        rows: the simulations (N,).
        cups: ids of the cylinders of a cup (C,).
        radius: radii (N,) [m].
        half: half lengths of the cylinders (C,) [m].
        bounds: radii of spheres around the cylinders (N, C) [m].
        geom_size: field of the model, of all simulations (S, geoms, 3), and so on.
        geom_rbound: see `geom_size`.
        geom_aabb: see `geom_size`.
    """
    for n in range(len(rows)):
        for k in range(len(cups)):
            row, geom = rows[n], cups[k]
            geom_size[row, geom, 0], geom_rbound[row, geom] = radius[n], bounds[n, k]
            geom_aabb[row, geom, :3] = 0.0
            geom_aabb[row, geom, 3] = geom_aabb[row, geom, 4] = radius[n]
            geom_aabb[row, geom, 5] = half[k]
