"""N falls near bins without the robot: recorded by the engine, or free flights in machine code and then contacts.

`fall` records every step until an object can no longer leave or enter its bin; `settle` gives the ends of the falls.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base import freefall, settle_kernel
from pnt_gym.cells.base.airborne import Airborne, Vicinity
from pnt_gym.cells.base.bodies import contact_solref
from pnt_gym.cells.base.plant import check_warnings, simulation_ids
from pnt_gym.constants import GRAVITY

CHECK_INTERVAL: Final = 0.032
"""Interval between two checks of a recorded fall whether an object can still leave its bin [s]."""
FASTEST_FALL: Final = 2.0 * GRAVITY
"""Downward acceleration that no object reaches above a rim [m/s2]: the air on a light spinning object adds a half."""
DECISION_INTERVAL: Final = 0.008
"""Time that the engine simulates between two checks [s]: longer than the spring of a contact is bent."""


@final
@dataclass(frozen=True)
class FallEnd:
    """Ends of N falls."""

    state: Floats
    """Last states (N, STATE)."""
    stays: Bools
    """Whether the object stays where it is, in a bin or outside, although it still moves (N,)."""
    steps: Ints
    """Steps that were left to the throw (N,)."""
    simulated: Ints
    """Steps that the engine simulated (N,); 0 where the object is judged without a contact."""

    @property
    def position(self) -> Floats:
        """Last positions (N, 3) [m]."""
        return self.state[:, :3]

    @property
    def velocity(self) -> Floats:
        """Last velocities (N, 3) [m/s]; zero for an object that stays."""
        return np.where(self.stays[:, None], 0.0, self.state[:, 7:10])


def settle(
    batch: Any,
    motion: tuple[Floats, Floats],
    rows: Ints,
    objects: tuple[Airborne, Vicinity],
    state: Floats,
    steps: Ints,
    step: float,
    write: Callable[[Ints, Floats], None],
) -> FallEnd:
    """Follow N falling objects until each stays in or out of a bin, or its throw is over.

    Every row is checked at moments that depend on that row alone, and so does its result.

    Args:
        batch: simulations of a free object and its surroundings without the robot.
        motion: positions and velocities of all simulations, as the batch binds them.
        rows: the simulations of the N objects.
        objects: the objects in the air, and what they may meet.
        state: their states (N, STATE).
        steps: number of steps of each throw (N,).
        step: length of a physics step [s].
        write: sets up the simulations of some of the N objects, by their indices (K,) and states (K, STATE).

    Raises:
        PhysicsError: the engine warned, or stopped a simulation.
    """
    chunk = max(round(DECISION_INTERVAL / step), 1)
    state, steps, simulated = state.copy(), steps.copy(), np.zeros_like(rows)
    verdict = np.full(len(rows), settle_kernel.FALLING)
    energy, (qpos, qvel) = np.full(len(rows), -np.inf), motion
    settle_kernel.follow(state, *objects, step, energy, steps, verdict)
    falling = (verdict == settle_kernel.FALLING).nonzero()[0]
    if falling.size > 0:
        write(falling, state[falling])
        batch.warning[:] = 0
    while falling.size > 0:
        simulations, late = rows[falling], (steps[falling] <= chunk).nonzero()[0]
        names = ("qpos", "qvel") if late.size > 0 else ()
        record = batch.rollout(chunk, record=names, ids=simulation_ids(batch, simulations))
        state[falling, :7], state[falling, 7:] = qpos[simulations], qvel[simulations]
        if late.size > 0:
            # The state at the beginning of the throw's last step is recorded at the end of the step before.
            over = falling[late]
            moment = late, steps[over] - 2
            state[over, :7], state[over, 7:] = record["qpos"][moment], record["qvel"][moment]
            verdict[over] = settle_kernel.OVER
        steps[falling] -= chunk
        simulated[falling] += chunk
        settle_kernel.follow(state, *objects, step, energy, steps, verdict)
        falling = (verdict == settle_kernel.FALLING).nonzero()[0]
        simulations = rows[falling]
        qpos[simulations], qvel[simulations] = state[falling, :7], state[falling, 7:]
    check_warnings(batch)
    return FallEnd(state, verdict == settle_kernel.STAYS, steps, simulated)


@final
@dataclass(frozen=True)
class Fall:
    """Flights of N objects without the robot, K steps at most; sensors at the start of a step, attitudes at its end.

    Values of steps that no simulation reached are zero.
    """

    sensors: Floats
    """(N, K, columns)"""
    attitude: Floats
    """Quaternions, w first (N, K, 4)."""
    steps: Ints
    """Number of steps that count, for each object (N,)."""


def fall(
    batch: Any, motion: tuple[Floats, Floats], rows: Ints, spin: Floats, steps: Ints, rim: Floats, step: float
) -> Fall:
    """Simulate flying objects until each has too little energy to cross the rim of its bin.

    An object with too little energy to reach the rim stays inside the walls, or outside. Every row is checked at the
    same moments, so the result of a row does not depend on the other rows. An object above the rim can still cross the
    rim, so the first checks are left out.

    Args:
        batch: simulations of a free object and its surroundings without the robot, each in its first state.
        motion: positions and velocities of all simulations, as the batch binds them.
        rows: the N simulations.
        spin: moments of inertia over mass of the N objects (N, 3) [m2].
        steps: largest number of steps of each simulation (N,).
        rim: height of the bins' rims (N,) [m].
        step: length of a physics step [s].

    Raises:
        PhysicsError: the engine warned, or stopped a simulation.
    """
    count, chunk, last_steps = len(steps), max(round(CHECK_INTERVAL / step), 1), steps.copy()
    (qpos, qvel), rims = motion, np.ascontiguousarray(rim)
    turning = qvel[:, 3:6]
    # The shortest time in which no object that is above its rim falls below it.
    height, rising = qpos[rows, 2] - rim, qvel[rows, 2]
    speed = np.sqrt(rising**2 + 2.0 * FASTEST_FALL * np.maximum(height, 0.0))
    above = float(np.where(height > 0.0, rising + speed, 0.0).min()) / FASTEST_FALL
    batch.warning[:] = 0
    start, end = 0, chunk * (1 + min(int(above / step), int(steps.min()) - 1) // chunk)
    parts = list[tuple[Ints, slice, dict[str, Floats]]]()
    while (falling := (last_steps > start).nonzero()[0]).size > 0:
        simulations = rows[falling]
        part = batch.rollout(end - start, record=("sensordata", "qpos"), ids=simulation_ids(batch, simulations))
        freefall.end_settled(part["sensordata"], turning[simulations], falling, spin, rims, end, last_steps)
        parts.append((falling, slice(start, end), part))
        start, end = end, end + chunk
    check_warnings(batch)
    sensors, attitude = np.zeros((count, start, batch.model.nsensordata)), np.zeros((count, start, 4))
    for falling, moments, part in parts:
        sensors[falling, moments], attitude[falling, moments] = part["sensordata"], part["qpos"][..., 3:7]
    return Fall(sensors, attitude, last_steps)


@cache
def passive_restitution(step: float) -> float:
    """Largest restitution [-] whose contacts give no object speed in steps of the engine [s]."""
    restitution, rebounds = np.linspace(0.0, 1.0, 101), np.empty(101)
    settle_kernel.fill_rebounds(contact_solref(restitution), step, rebounds)
    gains = rebounds > 1.0
    return float(restitution[np.argmax(gains) - 1 if gains.any() else -1])
