"""Objects from their random draws, and distances from their outlines, one row each. Compiled; see `pnt_gym.compiled`.

NumPy rounds exponentials, logarithms, sines and cosines in its own way, so these are arguments, and the caller computes
the delay of the release.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.bodies import level_extents, shell_inertia
from pnt_gym.cells.base.items import CUP_RADIUS, CYLINDER, ELLIPSOID
from pnt_gym.cells.conveyor.objects.records import TARGET_DRAWS, Objects
from pnt_gym.cells.conveyor.objects.rows import ItemMix, Lips, StandardDraws
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.rows import Floats1, Floats2, Floats3, Rows1

SMALLEST_EXTENT = 0.005
"""Smallest extent that the camera reports [m]."""
MIN_DEPTH, MAX_DEPTH = 0.05, 0.95
HALF_LIP = 4.0 / (3.0 * math.pi)
"""Distance of half a disc's centroid from the disc's middle, in radii."""


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
def _write_truth(made: Any, z: Any, u: Any, factors: Any, item: Any, cell: Any) -> None:
    """Write true extents, mass, drag, seal, contact and depth of an object, and how it lies."""
    for axis in range(3):
        # A cylinder keeps one diameter.
        factor = factors.size[2 if item.shape == CYLINDER and axis == 1 else axis]
        made.size[axis] = item.size[axis] * factor
    residue = item.residue * factors.residue
    made.mass = item.mass * factors.mass * (1.0 + residue)
    made.drag, made.seal = item.drag * factors.drag, item.seal_force * factors.seal
    made.restitution, made.friction = min(item.restitution * factors.restitution, 1.0), item.friction * factors.friction
    made.blow_off = cell.blow_off * factors.blow_off
    depth = item.com_depth + cell.com_depth * z.depth + 0.12 * residue / (1.0 + residue)
    share = min(max(depth, MIN_DEPTH), MAX_DEPTH)
    made.com_depth = share * made.size[2] + cell.mismatch * cell.height * z.height
    # At mismatch 0 the planner throws the centre of mass, from mismatch 1 on the tip of the cup.
    made.known_depth = max(1.0 - cell.mismatch, 0.0) * made.com_depth
    # How the object lies on the belt and under the cup, and its random spin.
    mismatch, draws = cell.mismatch, made.draws
    made.yaw = cell.yaw * (2.0 * u.yaw - 1.0)
    for axis in range(2):
        made.grasp[axis] = mismatch * cell.grasp * z.grasp[axis]
    made.belt_error = mismatch * cell.belt_speed * z.belt
    made.jitter = mismatch * cell.jitter * z.jitter
    for axis in range(3):
        made.spin[axis] = mismatch * cell.spin * z.spin[axis]
    made.spin[0] += cell.spin_per_offset * made.grasp[1]
    made.spin[1] -= cell.spin_per_offset * made.grasp[0]
    made.spin[2] /= 3.0
    draws.lane_y = cell.lane_y[0] + (cell.lane_y[1] - cell.lane_y[0]) * u.lane
    draws.gap = cell.spacing[0] + (cell.spacing[1] - cell.spacing[0]) * u.gap
    for k in range(4):
        draws.place[k] = u.place[k]
    for attempt in range(TARGET_DRAWS):
        for k in range(3):
            draws.bin[attempt, k] = u.bin[attempt, k]


@kernel
def draw_objects(draws: StandardDraws, mix: ItemMix, objects: Rows1[Objects]) -> None:
    """Write N objects, without the delays of their releases and the spins of lips and air."""
    cell, items, percent = mix.cell[0], mix.items, mix.percent
    for row in range(len(objects)):
        z, u, factors, made = draws.normals[row], draws.uniforms[row], draws.factors[row], objects[row]
        kind = draw_kind(u.kind, mix.shares, len(items))
        seen = draw_kind(draws.aside[row].seen, mix.confusion[kind], len(items)) if len(mix.confusion) > 0 else kind
        made.kind, made.measured.kind = kind, seen
        made.measured.friction = items[seen].cup_friction
        # The values that are the same for all objects of an item.
        item = items[kind]
        made.shape, made.rolling_friction = item.shape, item.rolling_friction
        made.cup_friction, made.pick_chance = item.cup_friction, item.pick_chance
        made.cup_radius = item.cup_radius if cell.fitted else CUP_RADIUS
        made.valve, made.tau, made.stiffness = cell.valve, cell.tau, cell.stiffness
        _write_truth(made, z, u, factors, item, cell)
        # The measurements: the height is measured without noise, by the cup.
        measured = made.measured
        measured.shape = made.shape
        for axis in range(2):
            noise = cell.size_noise * z.seen_size[axis]
            measured.size[axis] = max(made.size[axis] + noise, SMALLEST_EXTENT)
            measured.grasp_noise[axis] = cell.grasp_noise * z.seen_grasp[axis]
        measured.size[2] = made.size[2]
        measured.mass, measured.seal = made.mass * factors.seen_mass, made.seal * factors.seen_seal
        measured.yaw = made.yaw + cell.yaw_noise * z.seen_yaw
        made.pick_draw = draws.aside[row].pick
        made.percent = percent[min(int(u.percent * len(percent)), len(percent) - 1)]


@kernel
def peel_impulse(weight: float, x: float, y: float, radius: float, tau: float) -> tuple[float, float]:
    """Angular impulse of a lip that peels off at one side, about x and y [N m s].

    An object is free when the vacuum has decayed to the object's weight. The lip opens first where the object is
    heavier, on the side of its centre of mass. The remaining force of the vacuum, m g exp(-t / tau), is assumed to act
    on the other half of the lip, whose centroid is 4 r / (3 pi) from the middle. With the grasp offset e the arm about
    the centre of mass is e + 4 r / (3 pi), and the impulse is m g tau (e + 4 r / (3 pi)). The open side goes down. The
    impulse is an upper bound, because the half lip is assumed to hold until the vacuum is gone.
    The centre of mass is at x, y from the cup's axis [m]; tau is the time constant of the vacuum [s].
    """
    offset = math.sqrt(x * x + y * y)
    # The force m g exp(-t / tau) over all times gives m g tau; the rest is its arm.
    size, arm = weight * tau * (offset + HALF_LIP * radius), max(offset, 1e-12)
    return size * -(y / arm), size * (x / arm)


@kernel
def blow_impulse(mass: float, x: float, y: float, speed: float) -> tuple[float, float]:
    """Angular impulse about x and y of air that blows an object down along the cup's axis [N m s].

    The centre of mass at x, y from the cup's axis [m] gets a speed [m/s].
    """
    return mass * speed * y, mass * speed * -x


@kernel_part
def _spin(object_: Any, cos: float, sin: float, x: float, y: float) -> tuple[float, float, float]:
    """Spin of a free object about x, y, z [rad/s], from an angular impulse about the world's x and y [N m s]."""
    extents = level_extents(object_.shape == CYLINDER, object_.size)
    inertia_x, inertia_y, _ = shell_inertia(object_.shape, object_.mass, extents)
    # The inertia is diagonal only in the object's axes: there the impulse becomes a spin, which is turned back.
    about_x = (cos * x + sin * y) / inertia_x
    about_y = (cos * y - sin * x) / inertia_y
    return cos * about_x - sin * about_y, cos * about_y + sin * about_x, 0.0


@kernel
def write_spins(mismatch: float, peels: bool, objects: Rows1[Objects], lips: Lips, spin: Floats2) -> None:
    """Write the spins of N objects at release (N, 3) [rad/s]: as drawn, or from the peeling lip, and from blown air.

    `peels` says whether the lip gives a spin.
    """
    for row in range(len(spin)):
        object_, cos, sin = objects[row], lips.cosine[row], lips.sine[row]
        mass, place_x, place_y = object_.mass, lips.grasp[row, 0], lips.grasp[row, 1]
        if peels:
            x, y = peel_impulse(mass * GRAVITY, place_x, place_y, object_.cup_radius, lips.tau[row])
            spin[row, 0], spin[row, 1], spin[row, 2] = _spin(object_, cos, sin, mismatch * x, mismatch * y)
        if object_.blow_off > 0.0:
            x, y = blow_impulse(mass, place_x, place_y, mismatch * object_.blow_off)
            added = _spin(object_, cos, sin, x, y)
            for axis in range(3):
                spin[row, axis] += added[axis]


@kernel
def inside_outline(objects: Rows1[Objects], place: Floats2) -> Floats1:
    """Distance of points from the outlines of objects in top view (N,) [m]; positive inside, negative outside.

    The distance from an ellipse is scaled by the ellipse's smaller half axis: exact for a circle.

    Args:
        objects: N objects.
        place: one point per object, relative to the object's middle, along world x, y (N, 2) [m].
    """
    inside = np.empty(len(place))
    for row in range(len(inside)):
        object_ = objects[row]
        cos, sin, x, y = math.cos(object_.yaw), math.sin(object_.yaw), place[row, 0], place[row, 1]
        along, across = abs(cos * x + sin * y), abs(cos * y - sin * x)
        length, width = object_.size[0] / 2.0, object_.size[1] / 2.0
        if object_.shape == ELLIPSOID:
            inside[row] = (1.0 - math.hypot(along / length, across / width)) * min(length, width)
        else:
            beyond, aside = along - length, across - width
            outside = math.hypot(max(beyond, 0.0), max(aside, 0.0))
            inside[row] = max(min(-beyond, -aside), 0.0) - outside
    return inside


@kernel
def inertias_at_tip(mass: Floats1, arm: Floats2, inertia: Floats2) -> Floats3:
    """Inertias of objects about their cups' tips (N, 3, 3) [kg m2].

    `arm` are the centres of mass from the tips, in the objects' axes (N, 3) [m], and `inertia` the moments about the
    centres of mass (N, 3) [kg m2].
    """
    tensor = np.empty((len(mass), 3, 3))
    for row in range(len(tensor)):
        x, y, z = arm[row, 0], arm[row, 1], arm[row, 2]
        square = mass[row] * (x * x + y * y + z * z)
        for i in range(3):
            for j in range(3):
                tensor[row, i, j] = (-mass[row] * arm[row, i]) * arm[row, j]
            tensor[row, i, i] += inertia[row, i] + square
    return tensor
