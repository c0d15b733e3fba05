"""What no object of a throw may go through: belts, bins, tables, trays and pallets."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np

from pnt_gym.cells.base.stage import BELT_THICKNESS
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.scene import FLOOR_DROP, SENSORS, bin_panels
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.scene import TABLE_THICKNESS, tray_panels

FAR: Final = 20.0
"""No object ends farther away [m]."""
SOFT: Final = 0.02
"""The floor has MuJoCo's own softness: at rest an object lies g (0.02 s)^2, 4 mm, deep in it, arriving deeper [m]."""


class Solids(NamedTuple):
    """What no centre of an object may be in: upright boxes of N cells, and everything below a height."""

    half: np.ndarray
    """(N, K, 3) [m]"""
    centre: np.ndarray
    """(N, K, 3) [m]"""
    floor: float
    """[m]"""


def conveyor_solids(config: ConveyorConfig, thrown: Any) -> Solids:
    """Belt and bins; of random bins the bin at which the throw was aimed."""
    bins, belt, count = config.bins, config.belt, len(thrown.target)
    if bins.random is None:
        places = np.tile([(b.x, b.y) for b in bins.fixed], (count, 1, 1))
        openings = np.tile([b.size for b in bins.fixed], (count, 1, 1))
    else:
        places, openings = thrown.target[:, None, :2], thrown.opening[:, None]
    half, middle = bin_panels(openings.reshape(-1, 2), bins)
    rims = np.concatenate([places, np.full((*places.shape[:2], 1), bins.rim)], axis=-1)
    middle = middle.reshape(count, -1, 5, 3) + rims[:, :, None]
    size = np.array([belt.x[1] - belt.x[0], belt.y[1] - belt.y[0], BELT_THICKNESS]) / 2
    place = np.array([sum(belt.x) / 2, sum(belt.y) / 2, belt.height - BELT_THICKNESS / 2])
    floor = min(bins.rim - bins.depth - bins.wall - FLOOR_DROP, belt.height - 0.3)
    return Solids(
        np.concatenate([half.reshape(count, -1, 3), np.tile(size, (count, 1, 1))], axis=1),
        np.concatenate([middle.reshape(count, -1, 3), np.tile(place, (count, 1, 1))], axis=1),
        floor,
    )


def gripper_solids(config: GripperConfig, thrown: Any) -> Solids:
    """Table or belt, and tray."""
    table, count = config.table, len(thrown.kind)
    half, centre = tray_panels(config.tray, len(config.items))
    thick = BELT_THICKNESS if table.speed > 0.0 else TABLE_THICKNESS
    size = np.array([table.x[1] - table.x[0], table.y[1] - table.y[0], thick]) / 2
    place = np.array([sum(table.x) / 2, sum(table.y) / 2, table.height - thick / 2])
    floor = config.tray.rim - config.tray.depth - config.tray.wall - 0.2
    return Solids(
        np.tile(np.vstack([half, size]), (count, 1, 1)), np.tile(np.vstack([centre, place]), (count, 1, 1)), floor
    )


def crossings(offset: np.ndarray, half: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Steps (N, M - 1) in which a centre passes the middle of a wall, however fast: flat objects dip into its surface.

    A centre that is nearer to an edge of the wall than to its sides passes over the edge, into which it dips as well.

    Args:
        offset: from the wall's middle along its own axes (N, M, 2 or 3) [m].
        half: its half extents (N, 2 or 3) [m].
        free: steps that count (N, M).
    """
    rows, thin = np.arange(len(half)), half.argmin(axis=-1)
    side = offset[rows, :, thin]
    beside = np.abs(offset) < (half - half[rows, thin, None])[:, None]
    beside[rows, :, thin] = True
    in_range = beside.all(axis=-1) & free
    return (side[:, 1:] * side[:, :-1] <= 0.0) & in_range[:, 1:] & in_range[:, :-1]


def through(core: Any, thrown: Any, flown: Any) -> str:
    """What an object of the last throws went through; empty if nothing."""
    config = core.config
    if not isinstance(config, ConveyorConfig | GripperConfig):
        return through_pallets(core, flown[1])
    if isinstance(config, ConveyorConfig):
        (_, thrown, *_), fallen = flown
        solids, position = conveyor_solids(config, thrown), fallen.sensors[..., SENSORS["object_position"]]
        free = np.arange(position.shape[1]) < fallen.steps[:, None]
        final = position[np.arange(len(position)), fallen.steps - 1]
    else:
        solids, flight = gripper_solids(config, thrown), flown[1].flight
        position, steps = flight.position, np.arange(flight.position.shape[1])
        free = (steps > flight.release_step[:, None]) & (steps <= flight.last_step[:, None])
        final = position[np.arange(len(position)), flight.last_step]
    for k in range(solids.half.shape[1]):
        crossed = crossings(position - solids.centre[:, None, k], solids.half[:, k], free)
        if crossed.any():
            row, step = np.argwhere(crossed)[0]
            return f"cell {row} went through solid {k} at {position[row, step].round(4).tolist()}"
    if not (np.abs(final) < FAR).all() or (final[:, 2] < solids.floor - SOFT).any():
        return f"an object ended at {final[np.argmin(final[:, 2])].tolist()}"
    return ""


def through_pallets(core: Any, flown: Any) -> str:
    """The same in the plane of the one-joint thrower."""
    x, y = flown.pose[..., 0], flown.pose[..., 1]
    for pallet in core.cell.job.pallets:
        for u, v, half_u, half_v, angle in pallet.walls:
            cos, sin = np.cos(angle), np.sin(angle)
            along, up = cos * (x - u) + sin * (y - v), cos * (y - v) - sin * (x - u)
            half = np.tile([half_u, half_v], (len(x), 1))
            crossed = crossings(np.stack([along, up], axis=-1), half, flown.after_release)
            if crossed.any():
                row, step = np.argwhere(crossed)[0]
                return f"cell {row} went through {pallet.name} at {flown.pose[row, step].round(4).tolist()}"
    return "" if (np.abs(flown.final_pose[..., 1]) < FAR).all() else "a part ended far away"
