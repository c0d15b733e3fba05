"""What stays hidden in a logged throw, given what its gauges read: conditional means and draws.

Every hidden value of the suite has a prior (the catalogue and `spread`) and, if it is measured, a gauge (`noise`). Both
are normal, mostly of logarithms, so the value given its reading is normal too. A residue adds to the mass, and
is taken from a grid. A reading that the log lacks leaves the prior.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np
from scipy.stats import norm, qmc

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.base.items import CYLINDER, ItemTable, item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig

from .log import ThrowLog

Draws: TypeAlias = Mapping[str, Floats]
"""Standard normal numbers (M,) by the names of `NORMALS`."""
NORMALS: Final = (
    "common", "length", "width", "height", "length_noise", "width_noise", "residue", "mass", "seal", "depth", "lip",
    "drag", "yaw", "grasp_x", "grasp_y", "belt", "grasp_noise_x", "grasp_noise_y", "jitter", "spin_x", "spin_y",
    "spin_z",
)  # fmt: skip
"""Names of the standard normal numbers of a throw's hidden values."""
EXACT, BLIND = 1e-6, 1e3
"""Relative noise of the cup's gauge of height, and of a gauge that the log does not have."""
RESIDUES: Final = 16
"""Points of the grid of residues."""
MIDDLE_SHARE: Final = (0.05, 0.95)
"""Bounds of the depth of a centre of mass as a share of the height, as in the suite."""
FULL_SHARE: Final = 0.12
"""Deeper centre of mass of an item with a residue, as in the suite."""


@final
@dataclass(frozen=True)
class Hidden:
    """Hidden values of M throws."""

    row: Ints
    """Index of each throw in the log (M,)."""
    size: Floats
    mass: Floats
    seal: Floats
    drag: Floats
    """Drag coefficients before the common factor (M,)."""
    com_depth: Floats
    yaw: Floats
    grasp: Floats
    """Centre of mass from the cup's axis at zero belt-speed error (M, 2) [m]."""
    belt_error: Floats
    jitter: Floats
    spin: Floats
    """Random part of the spin, where the lip does not peel (M, 3) [rad/s]."""


def standard_draws(count: int, draws: int) -> Floats:
    """Standard normal numbers (N, K, NORMALS) in mirrored pairs, by a scrambled Sobol sequence for each throw."""
    pairs = np.empty((count, draws // 2, len(NORMALS)))
    for row in range(count):
        sobol = qmc.Sobol(len(NORMALS), scramble=True, rng=np.random.default_rng((0, row)))
        pairs[row] = norm.ppf(np.clip(sobol.random(draws // 2), 1e-6, 1.0 - 1e-6))
    return np.concatenate([pairs, -pairs], axis=1)


def draw_hidden(log: ThrowLog, config: ConveyorConfig, normals: Floats) -> Hidden:
    """Hidden values of throws at standard normal numbers (N, K, NORMALS), K for each throw in a row.

    Zeros give conditional means or medians.
    """
    count, draws, _ = normals.shape
    row = np.repeat(np.arange(count), draws)
    z: Draws = dict[str, Floats](zip(NORMALS, normals.reshape(count * draws, -1).T, strict=True))
    readings, spread, m = take(log, row), config.spread, config.mismatch
    table = item_arrays(config.item_list())
    size = _sizes(readings, config, table, z)
    mass, residue = _masses(readings, config, table, z)
    seal = np.exp(
        _read(np.log(table.seal_force[readings.kind]), spread.seal, np.log(readings.seal), config.noise.seal, z["seal"])
    )
    share = table.com_depth[readings.kind] + spread.com_depth * z["depth"] + FULL_SHARE * residue / (1.0 + residue)
    grasp, belt_error = _grasps(readings, config, z)
    anywhere = spread.yaw * (2.0 * norm.cdf(z["yaw"]) - 1.0)
    return Hidden(
        row=row,
        size=size,
        mass=mass,
        seal=seal,
        drag=table.drag[readings.kind] * np.exp(spread.drag * z["drag"]),
        com_depth=np.clip(share, *MIDDLE_SHARE) * size[:, 2] + m * spread.height * z["lip"],
        yaw=np.where(np.isfinite(readings.yaw), readings.yaw + config.noise.yaw * z["yaw"], anywhere),
        grasp=grasp,
        belt_error=belt_error,
        jitter=m * config.suction.jitter * z["jitter"],
        spin=m * spread.spin * np.stack([z["spin_x"], z["spin_y"], z["spin_z"]], axis=1),
    )


def _read(prior: Floats, sd: float, reading: Floats, noise: float, z: Floats) -> Floats:
    """Normal values (M,) with a prior, given their readings; NaN is no reading."""
    gain = sd**2 / max(sd**2 + noise**2, 1e-300) * np.isfinite(reading)
    return prior + gain * np.nan_to_num(reading - prior) + sd * np.sqrt(1.0 - gain) * z


def _sizes(log: ThrowLog, config: ConveyorConfig, table: ItemTable, z: Draws) -> Floats:
    """Extents (M, 3) [m], given those that camera (length, width) and cup (height) measured."""
    spread, middle = config.spread, table.size[log.kind]
    axes = np.eye(3) * spread.size_axis**2
    covariance = np.tile(axes + spread.size**2, (len(middle), 1, 1))
    axis_sizes = spread.size_axis * np.stack([z["length"], z["width"], z["height"]], axis=1)
    rods = table.shape[log.kind] == CYLINDER  # a cylinder keeps one diameter
    axis_sizes[rods, 1] = axis_sizes[rods, 2]
    covariance[rods, 1, 2] = covariance[rods, 2, 1] = covariance[rods, 2, 2]
    prior = np.log(middle) + spread.size * z["common"][:, None] + axis_sizes
    noise = np.stack(
        [config.noise.size / middle[:, 0], config.noise.size / middle[:, 1], EXACT * np.ones(len(middle))], axis=1
    )
    noise = np.where(np.isfinite(log.size), np.maximum(noise, EXACT), BLIND)
    read = np.log(log.size) - prior - noise * np.stack([z["length_noise"], z["width_noise"], 0.0 * z["mass"]], axis=1)
    total = covariance + np.eye(3) * (noise**2)[:, None, :]
    step = np.linalg.solve(total, np.where(np.isfinite(log.size), read, 0.0)[:, :, None])
    # Matheron's rule: a draw of the prior, corrected by the gain times what its reading lacks.
    size: Floats = np.exp(prior + (covariance @ step)[:, :, 0])
    size[rods, 1] = size[rods, 2]
    return size


def residues(config: ConveyorConfig, table: ItemTable, kind: Ints) -> Floats:
    """Equally likely residues of objects of kinds (N,) in masses of the item (N, RESIDUES); zeros of an empty kind."""
    spread = config.spread.residue
    levels = norm.ppf((np.arange(RESIDUES) + 0.5) / RESIDUES)
    return table.residue[kind][:, None] * np.exp(spread * levels - spread**2 / 2.0)


def _masses(log: ThrowLog, config: ConveyorConfig, table: ItemTable, z: Draws) -> tuple[Floats, Floats]:
    """Masses (M,) [kg] and residues in masses of the item (M,), given the measured masses."""
    spread, noise, kind = config.spread, config.noise.mass, log.kind
    grid = residues(config, table, kind)
    empty = np.log(table.mass[kind])
    reading = np.log(log.mass)
    miss = np.nan_to_num(reading[:, None] - empty[:, None] - np.log1p(grid))
    cost = 0.5 * miss**2 / max(spread.mass**2 + noise**2, 1e-12) * np.isfinite(reading)[:, None]
    chance = np.exp(cost.min(axis=1, keepdims=True) - cost)
    cumulated = np.cumsum(chance, axis=1)
    index = (cumulated < norm.cdf(z["residue"])[:, None] * cumulated[:, -1:]).sum(axis=1)
    residue = grid[np.arange(len(kind)), np.minimum(index, RESIDUES - 1)]
    return np.exp(_read(empty + np.log1p(residue), spread.mass, reading, noise, z["mass"])), residue


def _grasps(log: ThrowLog, config: ConveyorConfig, z: Draws) -> tuple[Floats, Floats]:
    """Grasp offsets at zero belt-speed error (M, 2) [m] and belt-speed errors (M,), given the measured offsets."""
    m, spread, noise = config.mismatch, config.spread, config.noise.grasp
    ride = log.pick[:, 0] - config.belt.camera_x
    grasp_variance, speed = (m * spread.grasp) ** 2, (m * spread.belt_speed) ** 2
    grasp = m * spread.grasp * np.stack([z["grasp_x"], z["grasp_y"]], axis=1)
    belt = m * spread.belt_speed * z["belt"]
    # Draws of the prior, moved by the gain times how far the log is from their own measurement (Matheron's rule).
    total = np.stack([grasp_variance + speed * ride**2, np.full(len(ride), grasp_variance)], axis=1) + noise**2
    shown = grasp + noise * np.stack([z["grasp_noise_x"], z["grasp_noise_y"]], axis=1)
    shown[:, 0] += belt * ride
    step = np.nan_to_num(log.grasp - shown) / np.maximum(total, 1e-300)
    return grasp + grasp_variance * step, belt + speed * ride * step[:, 0]
