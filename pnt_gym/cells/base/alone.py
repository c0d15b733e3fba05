"""Free objects on a batch: what differs between simulations, and how they fly and fall without the robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.fluid import fluid_coefficients, geom_placement, lying_size, solid_shell_inertia
from pnt_gym.cells.base.plant import check_warnings
from pnt_gym.constants import GRAVITY

DECIDE: Final = 0.032
"""Whether the objects are at rest for good is looked at this often [s]."""


def write_object(
    batch: Any, rows: Ints, body: int, geom: int, shape: Ints, size: Floats, mass: Floats, drag: Floats
) -> None:
    """Give the free objects of some simulations shape (N,), extents (N, 3) [m], mass (N,) [kg] and drag (N,)."""
    full = lying_size(shape, size)
    placed = geom_placement(shape, full)
    batch.expand("body_mass")[rows, body] = mass
    batch.expand("body_inertia")[rows, body] = solid_shell_inertia(mass, full, shape)
    batch.expand("geom_type")[rows, geom] = placed.type
    batch.expand("geom_size")[rows, geom] = placed.size
    batch.expand("geom_quat")[rows, geom] = placed.quat
    batch.expand("geom_rbound")[rows, geom] = placed.rbound
    aabb = batch.expand("geom_aabb")
    aabb[rows, geom] = placed.aabb.reshape(len(rows), *aabb.shape[2:])
    batch.expand("geom_fluid")[rows, geom] = fluid_coefficients(shape, full, drag)


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


def fall(batch: Any, rows: Ints, body: int, steps: Ints, rim: Floats) -> Fall:
    """Let objects fly and fall until it is certain for each whether it stays in its bin.

    An object whose energy does not lift it to the rim any more stays inside the walls, or outside. It is looked for
    at the same moments in every row, so a row's result does not depend on the others.

    Args:
        batch: simulations of nothing but a free object and what it may fall on, each in its first state.
        rows: N of them.
        body: the object.
        steps: of each simulation at most (N,).
        rim: height of the bins' rims (N,) [m].

    Raises:
        PhysicsError: the engine warned, or stopped a simulation.
    """
    count, chunk = len(steps), max(round(DECIDE / batch.model.opt.timestep), 1)
    spin = batch.expand("body_inertia")[rows, body] / batch.expand("body_mass")[rows, body, None]
    over = steps.copy()
    batch.warning[:] = 0
    parts: list[tuple[Ints, Any]] = []
    for start in range(0, int(steps.max()), chunk):
        left = np.flatnonzero(over > start)
        if left.size == 0:
            break
        part = batch.rollout(chunk, record=("sensordata", "qpos"), ids=rows[left])
        parts.append((left, part))
        turning = (spin[left] * batch.bind("qvel")[rows[left], 3:6] ** 2).sum(axis=1)
        still = left[_energy_height(part["sensordata"][:, -1], turning) < rim[left]]
        over[still] = np.minimum(steps[still], start + chunk)
    check_warnings(batch)
    sensors = np.zeros((count, chunk * len(parts), int(batch.model.nsensordata)))
    attitude = np.zeros((count, chunk * len(parts), 4))
    for k, (left, part) in enumerate(parts):
        sensors[left, k * chunk : (k + 1) * chunk] = part["sensordata"]
        attitude[left, k * chunk : (k + 1) * chunk] = part["qpos"][..., 3:7]
    return Fall(sensors, attitude, over)


def _energy_height(sensors: Floats, turning: Floats) -> Floats:
    """How high objects could rise (N,) [m].

    Args:
        sensors: of one moment: position and velocity in the first six columns (N, 6+).
        turning: twice the energy of rotation over the mass (N,) [m2/s2].
    """
    x, y, z = sensors[:, 3], sensors[:, 4], sensors[:, 5]
    return sensors[:, 2] + (x * x + y * y + z * z + turning) / (2.0 * GRAVITY)
