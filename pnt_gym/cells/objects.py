"""Objects on the belt: what is true of each (hidden) and what the cell's sensors say of it.

One object is one row of standard draws (normal and uniform) from its own cell's generator. Everything here is a
pure function of those rows, so a cell gives the same objects alone and in a batch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.cells.items import ItemTable, item_arrays
from pnt_gym.cells.suction import release_delay
from pnt_gym.config import CellConfig
from pnt_gym.planning.arrays import Floats, Ints

NORMALS = 24
"""Standard normal draws per object."""
TARGET_DRAWS = 8
"""Bins that may be tried for one object before it is let go."""
UNIFORMS = 12 + 3 * TARGET_DRAWS
"""Uniform draws per object."""
_CYLINDER = 1
_SMALLEST = 0.005
"""The camera reports no extent below this [m]."""
_MIN_DEPTH, _MAX_DEPTH = 0.05, 0.95


@final
@dataclass(frozen=True)
class Objects:
    """Objects with any leading shape S; lengths in m, masses in kg, forces in N, angles in rad.

    The first block is hidden truth, `measured_*` is what sensors report, the rest are the draws that place it.
    """

    kind: Ints
    """Index into the cell's item list, S."""
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
    rolling_friction: Floats
    restitution: Floats
    yaw: Floats
    grasp: Floats
    """Centre of mass from the cup axis along x, y at zero belt-speed error, S + (2,) [m]."""
    belt_error: Floats
    """Relative error of the belt speed; adds to `grasp` along x with the distance from the camera."""
    spin: Floats
    """Angular velocity gained at release, about x, y, z [rad/s], S + (3,)."""

    measured_size: Floats
    measured_mass: Floats
    measured_seal: Floats
    measured_yaw: Floats
    grasp_noise: Floats
    """What the camera adds to the true grasp offset, S + (2,) [m]."""

    lane_y: Floats
    gap: Floats
    """Distance to the object before it on the belt [m]."""
    percent: Floats
    """Speed setting of its throw [%]."""
    place: Floats
    """Uniform draws for a pick without a belt: where it is picked and where the next object waits, S + (4,)."""
    bin_draw: Floats
    """Uniform draws that choose its bin, S + (TARGET_DRAWS, 3)."""


def draw_objects(generators: list[np.random.Generator], count: int, config: CellConfig) -> Objects:
    """`count` new objects for each generator, shape (len(generators), count)."""
    normals = np.stack([g.standard_normal((count, NORMALS)) for g in generators])
    uniforms = np.stack([g.random((count, UNIFORMS)) for g in generators])
    return objects_from_draws(normals, uniforms, config, item_arrays(config.item_list()))


def objects_from_draws(normals: Floats, uniforms: Floats, config: CellConfig, table: ItemTable) -> Objects:
    """Objects from standard draws.

    Args:
        normals: S + (NORMALS,) standard normal.
        uniforms: S + (UNIFORMS,) in [0, 1).
        config: the cell; its mismatch scales every hidden effect, not the catalogue and not the sensor noise.
        table: the items, stacked.
    """
    m, spread, noise = config.mismatch, config.spread, config.noise
    z = np.moveaxis(normals, -1, 0)
    u = np.moveaxis(uniforms, -1, 0)
    kind = np.minimum((u[0] * len(config.items)).astype(np.int64), len(config.items) - 1)
    size = _sizes(table, kind, normals, config)
    residue = np.where(table.container[kind] & (u[4] < spread.residue_chance), spread.residue * u[5], 0.0)
    mass = table.mass[kind] * np.exp(spread.mass * z[0]) * (1.0 + residue)
    seal = table.seal_force[kind] * np.exp(spread.seal * z[6])
    depth = table.com_depth[kind] + spread.com_depth * z[7] + 0.12 * residue / (1.0 + residue)
    com_depth = np.clip(depth, _MIN_DEPTH, _MAX_DEPTH) * size[..., 2] + m * spread.height * z[10]
    grasp = m * spread.grasp * normals[..., 8:10]
    jitter = m * config.suction.jitter * z[12]
    yaw = spread.yaw * (2.0 * u[3] - 1.0)
    percents = np.asarray(config.limits.percent)
    lane, gap = config.belt.lane_y, config.belt.spacing
    return Objects(
        kind=kind,
        shape=table.shape[kind],
        size=size,
        mass=mass,
        drag=table.drag[kind] * np.exp(spread.drag * z[5]),
        com_depth=com_depth,
        known_depth=max(1.0 - m, 0.0) * com_depth,
        seal=seal,
        delay=np.maximum(m * release_delay(seal, mass, config.suction) + jitter, 0.0),
        jitter=jitter,
        friction=table.friction[kind],
        rolling_friction=table.rolling_friction[kind],
        restitution=table.restitution[kind],
        yaw=yaw,
        grasp=grasp,
        belt_error=m * spread.belt_speed * z[11],
        spin=_spin(m * spread.spin * normals[..., 13:16], spread.spin_per_offset * grasp),
        measured_size=_measured_size(size, noise.size * normals[..., 16:19]),
        measured_mass=mass * np.exp(noise.mass * z[19]),
        measured_seal=seal * np.exp(noise.seal * z[20]),
        measured_yaw=yaw + noise.yaw * z[21],
        grasp_noise=noise.grasp * normals[..., 22:24],
        lane_y=lane[0] + (lane[1] - lane[0]) * u[1],
        gap=gap[0] + (gap[1] - gap[0]) * u[2],
        percent=percents[np.minimum((u[6] * len(percents)).astype(np.int64), len(percents) - 1)],
        place=uniforms[..., 8:12],
        bin_draw=uniforms[..., 12:].reshape(*uniforms.shape[:-1], TARGET_DRAWS, 3),
    )


def _sizes(table: ItemTable, kind: Ints, normals: Floats, config: CellConfig) -> Floats:
    """True extents; a cylinder keeps one diameter."""
    axes = config.spread.size_axis * normals[..., 2:5]
    round_ = table.shape[kind] == _CYLINDER
    axes[..., 1] = np.where(round_, axes[..., 2], axes[..., 1])
    return table.size[kind] * np.exp(config.spread.size * normals[..., 1:2] + axes)


def _spin(random: Floats, offset: Floats) -> Floats:
    """Spin at release: a random part (a third of it about z), and one from the off-centre grip."""
    spin = random.copy()
    spin[..., 2] /= 3.0
    spin[..., 0] += offset[..., 1]
    spin[..., 1] -= offset[..., 0]
    return spin


def _measured_size(size: Floats, noise: Floats) -> Floats:
    """What the camera says of length and width; the height is felt by the cup when it touches down."""
    seen = np.maximum(size + noise, _SMALLEST)
    seen[..., 2] = size[..., 2]
    return seen
