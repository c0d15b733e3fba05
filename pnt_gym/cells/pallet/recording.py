"""A throw kept for pictures: enough to step through it again, bit for bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.engine import MjData, MjModel, mujoco
from pnt_gym.planning.arrays import Floats


@final
@dataclass(frozen=True)
class ThrowRecording:
    """One simulated throw.

    Attributes:
        model: the simulation's own model.
        body: id of the thrown part.
        state: integration state before the first step.
        control: controls and equality bits of every step (M, nu + neq).
        plan: the planned flight of the centre of mass (K, 3) [m].
        target: where the goal is, in the world (3,) [m].
    """

    model: MjModel
    body: int
    state: Floats
    control: Floats
    plan: Floats
    target: Floats

    def play(self, interval: float) -> Iterator[tuple[MjData, Floats]]:
        """Step through the throw, pausing about every `interval` [s]: the simulation and the part's trail (K, 3)."""
        data = mujoco.MjData(self.model)
        mujoco.mj_setState(self.model, data, self.state, int(mujoco.mjtState.mjSTATE_INTEGRATION.value))
        nu, trail, next_pause = int(self.model.nu), list[Floats](), 0.0
        for k, row in enumerate(self.control):
            if k * self.model.opt.timestep >= next_pause - 1e-12:
                mujoco.mj_forward(self.model, data)
                trail.append(data.xpos[self.body].copy())
                next_pause += interval
                yield data, np.array(trail)
            data.ctrl[:] = row[:nu]
            data.eq_active[:] = row[nu:] > 0.0
            mujoco.mj_step(self.model, data)
