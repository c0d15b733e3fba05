"""Ends of N falls near bins: free flights in machine code, and contacts in the engine until an object stays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base import settle_kernel
from pnt_gym.cells.base.airborne import Airborne, Vicinity
from pnt_gym.cells.base.plant import check_warnings, simulation_ids

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
    energy, qpos, qvel = np.full(len(rows), -np.inf), batch.bind("qpos"), batch.bind("qvel")
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
