"""Free objects on a batch: the properties of each simulation's object, and flight and fall without the robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, in_order
from pnt_gym.cells.base import body_kernel, freefall
from pnt_gym.cells.base.fluid import MODEL_FIELDS, GeomPlacement, ModelFields, ModelObjects
from pnt_gym.cells.base.plant import check_warnings, simulation_ids
from pnt_gym.constants import GRAVITY

CHECK_INTERVAL: Final = 0.032
"""Interval between two checks whether an object can still leave its bin [s]."""
FASTEST_FALL: Final = 2.0 * GRAVITY
"""Downward acceleration that no object reaches above a rim [m/s2]: the air on a light spinning object adds a half."""


def write_object(
    batch: Any, rows: Ints, body: int, geom: int, mass: Floats, inertia: Floats, placement: GeomPlacement, fluid: Floats
) -> None:
    """Write mass (N,) [kg], inertia (N, 3) [kg m2], geom and `geom_fluid` (N, 12) of some simulations' free objects."""
    mass, inertia, fluid = in_order(mass, inertia, fluid)
    objects = ModelObjects(mass, inertia, GeomPlacement(*in_order(*placement)), fluid)
    body_kernel.write_bodies(rows, body, geom, objects, ModelFields(*map(batch.expand, MODEL_FIELDS)))


@final
@dataclass(frozen=True)
class Fall:
    """Flights of N objects without the robot, K steps each; sensors at the start of a step, attitudes at its end."""

    sensors: Floats
    """(N, K, columns)"""
    attitude: Floats
    """Quaternions, w first (N, K, 4)."""
    steps: Ints
    """Number of steps that count, for each object (N,)."""


def fall(batch: Any, rows: Ints, body: int, steps: Ints, rim: Floats, step: float) -> Fall:
    """Simulate flying objects until each has too little energy to cross the rim of its bin.

    An object with too little energy to reach the rim stays inside the walls, or outside. Every row is checked at the
    same moments, so the result of a row does not depend on the other rows. An object above the rim can still cross the
    rim, so the first checks are left out.

    Args:
        batch: simulations of a free object and its surroundings without the robot, each in its first state.
        rows: the N simulations.
        body: id of the object's body.
        steps: largest number of steps of each simulation (N,).
        rim: height of the bins' rims (N,) [m].
        step: length of a physics step [s].

    Raises:
        PhysicsError: the engine warned, or stopped a simulation.
    """
    count, chunk = len(steps), max(round(CHECK_INTERVAL / step), 1)
    spin = batch.expand("body_inertia")[rows, body] / batch.expand("body_mass")[rows, body, None]
    qpos, qvel, last_steps = batch.bind("qpos"), batch.bind("qvel"), steps.copy()
    rims = np.ascontiguousarray(rim)
    above = _shortest_time_above(qpos[rows, 2] - rim, qvel[rows, 2])
    batch.warning[:] = 0
    parts: list[tuple[Ints, slice, Any]] = []
    start, end = 0, chunk * (1 + min(int(above / step), int(steps.min()) - 1) // chunk)
    while (falling := (last_steps > start).nonzero()[0]).size > 0:
        part = batch.rollout(end - start, record=("sensordata", "qpos"), ids=simulation_ids(batch, rows[falling]))
        parts.append((falling, slice(start, end), part))
        rate = qvel[rows[falling], 3:6]
        freefall.end_settled(np.ascontiguousarray(part["sensordata"]), rate, falling, spin, rims, end, last_steps)
        start, end = end, end + chunk
    check_warnings(batch)
    sensors, attitude = np.zeros((count, start, int(batch.model.nsensordata))), np.zeros((count, start, 4))
    for falling, moments, part in parts:
        sensors[falling, moments], attitude[falling, moments] = part["sensordata"], part["qpos"][..., 3:7]
    return Fall(sensors, attitude, last_steps)


def _shortest_time_above(height: Floats, rising: Floats) -> float:
    """Time [s] in which none of N objects at heights [m] over a rim, with vertical velocities [m/s], falls below it."""
    speed = np.sqrt(rising**2 + 2.0 * FASTEST_FALL * np.maximum(height, 0.0))
    return float(np.where(height > 0.0, rising + speed, 0.0).min()) / FASTEST_FALL
