"""Hidden values that differ from throw to throw, drawn before the throw from each row's generator."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.items import shape_index
from pnt_gym.cells.gripper.config import GripperConfig

_DRAWS: Final = 11


@final
@dataclass(frozen=True)
class Hidden:
    """N true objects, and the other values that no planner knows."""

    shape: Ints
    """Index in `items.SHAPES` (N,)."""
    size: Floats
    """Extents along the object's axes (N, 3) [m]."""
    mass: Floats
    """Mass (N,) [kg]."""
    friction: Floats
    """Friction against the pads (N,)."""
    drag: Floats
    """Drag coefficient (N,)."""
    offset: Floats
    """True minus observed place on the table (N, 2) [m]."""
    yaw: Floats
    """True minus planned direction about the vertical (N,) [rad]."""
    delay: Floats
    """Delay of the claws' opening (N,) [s]."""
    belt_speed: Floats | None = None
    """True speed of the belt (N,) [m/s]; None without a belt."""


def draw_hidden(
    generators: list[np.random.Generator], kind: Ints, place: Floats, config: GripperConfig
) -> tuple[Hidden, Floats]:
    """Hidden values and measured sizes of one throw per generator, each with the same number of draws.

    Args:
        generators: one per row.
        kind: index of the cell's item (N,).
        place: expected places of the objects (N, 2) [m].
        config: level of the cell.

    Returns:
        The hidden values, and the measured extents (N, 3) [m].
    """
    draws = np.stack([g.standard_normal(_DRAWS) for g in generators])
    m, errors = config.mismatch, config.errors
    expected = expected_hidden(kind, config)
    spread = np.exp(m * draws[:, :3] * np.array([errors.mass, errors.friction, errors.drag]))
    size = expected.size * np.maximum(1.0 + m * errors.width * draws[:, 3:4], 0.5)
    hidden = replace(
        expected,
        size=size,
        mass=expected.mass * spread[:, 0],
        friction=expected.friction * spread[:, 1],
        drag=expected.drag * spread[:, 2],
        offset=m * errors.placement * draws[:, 4:6],
        yaw=m * np.deg2rad(errors.yaw_deg) * draws[:, 6],
        delay=np.maximum(expected.delay + m * errors.timing * draws[:, 7], 0.0),
    )
    measured = size + m * errors.camera * draws[:, 8:11]
    if config.table.speed == 0.0:
        return hidden, measured
    return _on_belt(hidden, place, np.stack([g.standard_normal() for g in generators]), config), measured


def _on_belt(hidden: Hidden, place: Floats, draws: Floats, config: GripperConfig) -> Hidden:
    """Hidden values with the belt's true speed, and the offsets that this speed causes since the camera.

    Args:
        hidden: hidden values without the belt's effect.
        place: expected places of the objects (N, 2) [m].
        draws: standard normal (N,).
        config: level of the cell.
    """
    table, error = config.table, config.mismatch * config.errors.belt_speed * draws
    ride = place[:, 0] * table.travel[0] + place[:, 1] * table.travel[1] - table.camera
    offset = hidden.offset + (error * ride)[:, None] * table.travel[:2]
    return replace(hidden, offset=offset, belt_speed=table.speed * (1.0 + error))


def expected_hidden(kind: Ints, config: GripperConfig) -> Hidden:
    """The hidden values of each kind (N,) without their random part."""
    m, items = config.mismatch, config.item_list()
    zero = np.zeros(len(kind))
    oversize = np.array([i.oversize for i in items])[kind]
    return Hidden(
        shape=np.array([shape_index(i.shape) for i in items], dtype=np.int64)[kind],
        size=np.array([i.size for i in items])[kind] * (1.0 + m * oversize)[:, None],
        mass=np.array([i.mass for i in items])[kind],
        friction=np.array([i.friction if i.pad_friction is None else i.pad_friction for i in items])[kind],
        drag=np.array([i.drag for i in items])[kind],
        offset=np.zeros((len(kind), 2)),
        yaw=zero,
        delay=m * config.errors.delay * np.array([i.opening_delay for i in items])[kind],
        belt_speed=np.full(len(kind), config.table.speed) if config.table.speed > 0.0 else None,
    )
