"""The physics of N throws on one batch: the rollout, the free object in it, and a throw kept for pictures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.fluid import fluid_coefficients, geom_placement, solid_shell_inertia
from pnt_gym.engine import Batch, MjData, MjModel, mujoco

STAGES: Final = (0.25, 0.5, 0.75, 1.0)
"""Shares of the throws that are over after each stage of a rollout."""
ThrowsT = TypeVar("ThrowsT")
PlansT = TypeVar("PlansT")
FlightT = TypeVar("FlightT")
_INPUTS = int(mujoco.mjtState.mjSTATE_CTRL.value) | int(mujoco.mjtState.mjSTATE_EQ_ACTIVE.value)


class PhysicsError(RuntimeError):
    """The engine warned or stopped: the throw's numbers would be worthless."""


@final
@dataclass(frozen=True)
class Recording:
    """One simulated throw, kept for pictures: enough to step through it again, bit for bit.

    Attributes:
        model: the simulation's own model (its object and bin).
        body: id of what is thrown.
        state: integration state before the first step.
        control: controls and equality bits of every step (M, nu + neq).
        plan: the planned flight (K, 3) [m].
        target: where it should go (3,) [m].
    """

    model: MjModel
    body: int
    state: Floats
    control: Floats
    plan: Floats
    target: Floats

    def play(self, interval: float) -> Iterator[tuple[MjData, Floats]]:
        """Step through the throw, pausing about every `interval` [s]: the simulation and the trail so far (K, 3)."""
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


class Plant(ABC, Generic[ThrowsT, PlansT, FlightT]):
    """Abstract: N copies of a cell's physics on one `mujoco.batch.Batch`.

    What a throw gives is a pure function of what the subclass writes before it: the same alone, in a batch, and again
    later. So a plant has no state worth keeping; copies and pickles of it are made anew from what it was made of,
    and nobody watches them yet.

    Args:
        config: the cell, for a copy.
        model: compiled from it.
        count: simulations N.
        threads: worker threads; results do not depend on it.
    """

    def __init__(self, config: Any, model: MjModel, count: int, threads: int) -> None:
        self.batch = Batch(model, nsim=count, nthread=threads)
        self._made_of = (config, count, threads)
        self.record_row: int | None = None
        """The simulation whose throws are kept in `recording`, for pictures; None keeps nothing."""
        self.recording: Recording | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), self._made_of, {"recording": self.recording}

    @abstractmethod
    def fly(self, thrown: ThrowsT, plans: PlansT) -> FlightT:
        """Simulate one throw in every simulation.

        Args:
            thrown: the N coming throws.
            plans: what is done, one per simulation.

        Raises:
            PhysicsError: the engine warned, or stopped a simulation.
        """

    def stand(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation as it stands, for a picture."""
        model, data = self.batch.get_model(row), self.batch.get_data(row)
        mujoco.mj_forward(model, data)
        return model, data

    def write_object(self, body: int, geom: int, shape: Ints, size: Floats, mass: Floats, drag: Floats) -> None:
        """Give the free object of every simulation its shape (N,), extents (N, 3) [m], mass (N,) [kg] and drag (N,)."""
        batch, placed = self.batch, geom_placement(shape, size)
        batch.expand("body_mass")[:, body] = mass
        batch.expand("body_inertia")[:, body] = solid_shell_inertia(mass, size, shape)
        batch.expand("geom_type")[:, geom] = placed.type
        batch.expand("geom_size")[:, geom] = placed.size
        batch.expand("geom_quat")[:, geom] = placed.quat
        batch.expand("geom_rbound")[:, geom] = placed.rbound
        aabb = batch.expand("geom_aabb")
        aabb[:, geom] = placed.aabb.reshape(aabb[:, geom].shape)
        batch.expand("geom_fluid")[:, geom] = fluid_coefficients(shape, size, drag)

    def keep(self, body: int, control: Floats, plan: Floats, target: Floats) -> None:
        """Keep the throw of `record_row` that is about to be rolled out; the arguments are those of `Recording`."""
        row = self.record_row or 0
        self.recording = Recording(
            model=self.batch.get_model(row),
            body=body,
            state=self.batch.state[row].copy(),
            control=control.copy(),
            plan=plan,
            target=target.copy(),
        )


def staged_rollout(batch: Any, control: Floats, steps: Ints, names: Sequence[str]) -> dict[str, Floats]:
    """Roll out every simulation for its own number of steps; recorded rows are zero after their last step.

    The batch runs in stages, each with the throws that are not over yet, which saves steps and changes no result.

    Args:
        batch: N simulations.
        control: controls and equality bits of every step (N, M, nu + neq).
        steps: of each simulation (N,).
        names: what is recorded.

    Returns:
        The records by name, (N, M, columns) each.

    Raises:
        PhysicsError: the engine warned, or stopped a simulation.
    """
    record: dict[str, Floats] = {}
    batch.warning[:] = 0
    start = 0
    for end in np.unique(np.quantile(steps, STAGES, method="higher")):
        rows = np.flatnonzero(steps > start)
        part = batch.rollout(
            int(end) - start, control[rows, start:end], control_spec=_INPUTS, record=tuple(names), ids=rows
        )
        for name in names:
            whole = record.setdefault(name, np.zeros((*control.shape[:2], part[name].shape[-1])))
            whole[rows, start:end] = part[name]
        start = int(end)
    check_warnings(batch)
    return record


def check_warnings(batch: Any) -> None:
    """Make sure that the engine warned of nothing.

    Raises:
        PhysicsError: it did.
    """
    if batch.warning.any():
        row, kind = (int(i) for i in np.argwhere(batch.warning)[0][:2])
        raise PhysicsError(f"MuJoCo warned in simulation {row}: {mujoco.mjtWarning(kind).name}")
