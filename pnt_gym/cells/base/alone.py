"""Free objects on a batch: what differs between simulations, and how they fly and fall without the robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.fluid import fluid_coefficients, geom_placement, lying_size, solid_shell_inertia
from pnt_gym.cells.base.plant import check_warnings
from pnt_gym.constants import GRAVITY

DECIDE: Final = 0.05
"""Whether the objects are at rest for good is looked at this often [s]."""


def write_object(batch: Any, body: int, geom: int, shape: Ints, size: Floats, mass: Floats, drag: Floats) -> None:
    """Give the free object of every simulation its shape (N,), extents (N, 3) [m], mass (N,) [kg] and drag (N,)."""
    full = lying_size(shape, size)
    placed = geom_placement(shape, full)
    batch.expand("body_mass")[:, body] = mass
    batch.expand("body_inertia")[:, body] = solid_shell_inertia(mass, full, shape)
    batch.expand("geom_type")[:, geom] = placed.type
    batch.expand("geom_size")[:, geom] = placed.size
    batch.expand("geom_quat")[:, geom] = placed.quat
    batch.expand("geom_rbound")[:, geom] = placed.rbound
    aabb = batch.expand("geom_aabb")
    aabb[:, geom] = placed.aabb.reshape(aabb[:, geom].shape)
    batch.expand("geom_fluid")[:, geom] = fluid_coefficients(shape, full, drag)


@final
@dataclass(frozen=True)
class Fall:
    """N objects on their own, K steps each; a step's values are those of its start, but the attitude's of its end."""

    sensors: Floats
    """(N, K, columns)"""
    attitude: Floats
    """Quaternions, w first (N, K, 4)."""
    steps: Ints
    """Of each object that count (N,)."""


def fall(batch: Any, body: int, steps: Ints, rim: Floats) -> Fall:
    """Let objects fly and fall until it is certain for each whether it stays in its bin.

    An object whose energy does not lift it to the rim any more stays inside the walls, or outside. It is looked for
    at the same moments in every row, so a row's result does not depend on the others.

    Args:
        batch: N simulations of nothing but a free object and what it may fall on, each in its first state.
        body: the object.
        steps: of each simulation at most (N,).
        rim: height of the bins' rims (N,) [m].

    Raises:
        PhysicsError: the engine warned, or stopped a simulation.
    """
    count, chunk = len(steps), max(round(DECIDE / batch.model.opt.timestep), 1)
    spin = (batch.expand("body_inertia")[:, body] / batch.expand("body_mass")[:, body, None]).copy()
    over = steps.copy()
    batch.warning[:] = 0
    parts: list[tuple[Ints, Any]] = []
    for start in range(0, int(steps.max()), chunk):
        rows = np.flatnonzero(over > start)
        if rows.size == 0:
            break
        part = batch.rollout(chunk, record=("sensordata", "qpos"), ids=rows)
        parts.append((rows, part))
        turning = (spin[rows] * batch.bind("qvel")[rows, 3:6] ** 2).sum(axis=1)
        still = _energy_height(part["sensordata"][:, -1], turning) < rim[rows]
        over[rows[still]] = np.minimum(steps[rows[still]], start + chunk)
    check_warnings(batch)
    sensors = np.zeros((count, chunk * len(parts), int(batch.model.nsensordata)))
    attitude = np.zeros((count, chunk * len(parts), 4))
    for k, (rows, part) in enumerate(parts):
        sensors[rows, k * chunk : (k + 1) * chunk] = part["sensordata"]
        attitude[rows, k * chunk : (k + 1) * chunk] = part["qpos"][..., 3:7]
    return Fall(sensors, attitude, over)


def _energy_height(sensors: Floats, turning: Floats) -> Floats:
    """How high objects could rise (N,) [m].

    Args:
        sensors: of one moment: position and velocity in the first six columns (N, 6+).
        turning: twice the energy of rotation over the mass (N,) [m2/s2].
    """
    x, y, z = sensors[:, 3], sensors[:, 4], sensors[:, 5]
    return sensors[:, 2] + (x * x + y * y + z * z + turning) / (2.0 * GRAVITY)
