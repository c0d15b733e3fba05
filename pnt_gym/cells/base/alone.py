"""Free objects on a batch: the properties of each simulation's object, and flight and fall without the robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.fluid import GeomPlacement
from pnt_gym.cells.base.plant import check_warnings

CHECK_INTERVAL: Final = 0.032
"""Interval between two checks whether an object can still leave its bin [s]."""
DECISION_INTERVAL: Final = 0.008
"""Interval between two checks of a fall of which only the end counts [s]; longer than a contact's spring is bent."""


def write_object(
    batch: Any, rows: Ints, body: int, geom: int, mass: Floats, inertia: Floats, placement: GeomPlacement, fluid: Floats
) -> None:
    """Write mass (N,) [kg], inertia (N, 3) [kg m2], geom and `geom_fluid` (N, 12) of some simulations' free objects."""
    batch.expand("body_mass")[rows, body] = mass
    batch.expand("body_inertia")[rows, body] = inertia
    batch.expand("geom_type")[rows, geom] = placement.type
    batch.expand("geom_size")[rows, geom] = placement.size
    batch.expand("geom_quat")[rows, geom] = placement.quat
    batch.expand("geom_rbound")[rows, geom] = placement.rbound
    aabb = batch.expand("geom_aabb")
    aabb[rows, geom] = placement.aabb.reshape(len(rows), *aabb.shape[2:])
    batch.expand("geom_fluid")[rows, geom] = fluid


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
    same moments, so the result of a row does not depend on the other rows.

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
    from pnt_gym.cells.base.freefall import end_settled  # noqa: PLC0415 - compiles, where nothing is kept

    count, chunk = len(steps), max(round(CHECK_INTERVAL / step), 1)
    spin = batch.expand("body_inertia")[rows, body] / batch.expand("body_mass")[rows, body, None]
    qvel, last_steps = batch.bind("qvel"), steps.copy()
    batch.warning[:] = 0
    parts: list[tuple[Ints, Any]] = []
    for start in range(0, int(steps.max()), chunk):
        falling = np.flatnonzero(last_steps > start)
        if falling.size == 0:
            break
        part = batch.rollout(chunk, record=("sensordata", "qpos"), ids=rows[falling])
        parts.append((falling, part))
        end_settled(part["sensordata"], qvel, rows, falling, spin, rim, start + chunk, last_steps)
    check_warnings(batch)
    sensors = np.zeros((count, chunk * len(parts), int(batch.model.nsensordata)))
    attitude = np.zeros((count, chunk * len(parts), 4))
    for k, (falling, part) in enumerate(parts):
        sensors[falling, k * chunk : (k + 1) * chunk] = part["sensordata"]
        attitude[falling, k * chunk : (k + 1) * chunk] = part["qpos"][..., 3:7]
    return Fall(sensors, attitude, last_steps)


@final
class Vicinity(NamedTuple):
    """Bodies of N falling objects and what they may meet, in the numbers of `settle_kernel`."""

    solid: Floats
    """Bodies (N, SOLID)."""
    bins: Floats
    """Bins of each object's cell (N, B, BIN)."""
    rim: Floats
    """Heights of the rims (N,) [m]."""
    ground: Floats
    """Floor and belt (N, GROUND)."""


def settle(batch: Any, rows: Ints, vicinity: Vicinity, steps: Ints, step: float) -> tuple[Floats, Floats]:
    """Simulate falling objects until each stays in or out of a bin, or its time is over.

    Every row is checked at the same moments, so the result of a row does not depend on the other rows.

    Args:
        batch: simulations of a free object and its surroundings without the robot, each in its first state.
        rows: the N simulations.
        vicinity: the objects and what they may meet.
        steps: number of steps of each throw (N,).
        step: length of a physics step [s].

    Returns:
        Last positions [m] and velocities [m/s] (N, 3); the velocity of an object that stays counts as zero.

    Raises:
        PhysicsError: the engine warned, or stopped a simulation.
    """
    from pnt_gym.cells.base.settle_kernel import end_decided  # noqa: PLC0415 - compiles, where nothing is kept

    chunk, remaining = max(round(DECISION_INTERVAL / step), 1), steps.copy()
    position, velocity, energy = np.empty((len(rows), 3)), np.empty((len(rows), 3)), np.full(len(rows), -np.inf)
    qpos, qvel, falling, end = batch.bind("qpos"), batch.bind("qvel"), np.arange(len(rows)), 0
    batch.warning[:] = 0
    while falling.size > 0:
        part, end = batch.rollout(chunk, record=("sensordata",), ids=rows[falling]), end + chunk
        end_decided(
            part["sensordata"], qpos, qvel, rows, falling, *vicinity, energy, end, remaining, step, position, velocity
        )
        falling = np.flatnonzero(remaining)
    check_warnings(batch)
    return position, velocity
