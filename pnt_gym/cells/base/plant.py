"""The physics of N throws on one batch: rollout, and recording of a throw; `flight` reads what was recorded."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.engine import Batch, MjData, MjModel, mujoco
from pnt_gym.errors import PhysicsError
from pnt_gym.names import unknown_name
from pnt_gym.planning.motion.ballistics import flight_state

LONGEST_THROW: Final = 60.0
"""Longest duration of a simulated throw [s]."""
TOUCH_DISTANCE: Final = 1e-5
"""Distance of two surfaces below which a contact counts [m]; predicted contacts of fast objects are farther apart."""
ThrowsT = TypeVar("ThrowsT")
PlansT = TypeVar("PlansT")
FlightT = TypeVar("FlightT")
_INPUTS = int(mujoco.mjtState.mjSTATE_CTRL.value) | int(mujoco.mjtState.mjSTATE_EQ_ACTIVE.value)


@final
@dataclass(frozen=True)
class Recording:
    """One simulated throw for pictures: the state and the controls with which the throw can be simulated again.

    Attributes:
        model: the model of the simulation, with its object and bin.
        body: id of the thrown body.
        state: integration state before the first step.
        control: controls and equality bits of every step (M, nu + neq).
        plan: the planned flight (K, 3) [m].
        target: centre of the throw's target (3,) [m].
    """

    model: MjModel
    body: int
    state: Floats
    control: Floats
    plan: Floats
    target: Floats

    def play(self, interval: float) -> Iterator[tuple[MjData, Floats]]:
        """Simulate the throw again; about every `interval` [s] yields the data and the object's trail so far (K, 3)."""
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

    The result of a throw is a pure function of the values that the subclass writes before the throw: the same alone, in
    a batch, and at any later time. So a plant has no state of its own: copies and pickles build a new plant from the
    constructor's arguments, and no simulation of the copy is recorded.

    Args:
        config: the cell's config, for copies of the plant.
        model: the model compiled from the config.
        count: simulations N.
        threads: worker threads; results do not depend on it.
    """

    def __init__(self, config: Any, model: MjModel, count: int, threads: int) -> None:
        self.batch = Batch(model, nsim=count, nthread=threads)
        self.qpos, self.qvel = self.batch.bind("qpos"), self.batch.bind("qvel")
        """Positions and velocities of all simulations, which may be written."""
        self._made_of = (config, count, threads)
        self.record_row: int | None = None
        """The simulation whose last throw is kept in `recording`, for pictures; None: no simulation."""
        self.recording: Recording | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), self._made_of, {"recording": self.recording}

    @abstractmethod
    def fly(self, context: ThrowsT, plans: PlansT) -> FlightT:
        """Simulate one throw in every simulation.

        Args:
            context: the N coming throws.
            plans: one plan per simulation.

        Raises:
            PhysicsError: the engine warned, or stopped a simulation.
        """

    def current_state(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation in its current state, for a picture."""
        model, data = self.batch.get_model(row), self.batch.get_data(row)
        mujoco.mj_forward(model, data)
        return model, data

    def record_throw(self, body: int, control: Floats, plan: tuple[Floats, Floats, float], target: Floats) -> None:
        """Keep a `Recording` of the throw of `record_row` that is rolled out next.

        Args:
            body: id of the thrown body.
            control: controls and equality bits of every step (M, nu + neq).
            plan: start (3,) [m], velocity (3,) [m/s] and time [s] of the planned flight.
            target: centre of the throw's target (3,) [m].
        """
        row, (start, velocity, time) = self.record_row or 0, plan
        self.recording = Recording(
            model=self.batch.get_model(row),
            body=body,
            state=self.batch.state[row].copy(),
            control=control.copy(),
            plan=flight_state(start, velocity, np.linspace(0.0, time, 40))[0],
            target=target.copy(),
        )


def step_counts(seconds: Floats, step: float) -> Ints:
    """Numbers of physics steps (N,) of a length `step` [s] that cover throws of durations (N,) [s].

    Raises:
        PhysicsError: a throw takes longer than `LONGEST`.
    """
    if not seconds.max() <= LONGEST_THROW:
        raise PhysicsError(f"a throw takes {seconds.max():.3g} s; a simulated throw takes at most {LONGEST_THROW:g} s")
    return np.ceil(seconds / step).astype(np.int64)


def roll_out(
    batch: Any, control: Floats, steps: Ints, names: Sequence[str], ids: Ints | None = None
) -> dict[str, Floats]:
    """Roll out every simulation for a separate number of steps; records have zeros after the last step.

    As many simulations as the batch has threads run at a time, the shortest throws first. They run in stages, each
    with the throws that are not over yet, to the end of the next throw: no throw is simulated longer than it takes, and
    the record of a simulation does not depend on the other simulations.

    Args:
        batch: N simulations.
        control: controls and equality bits of every step (N, M, nu + neq).
        steps: number of steps of each simulation (N,).
        names: names of the recorded fields.
        ids: the simulations; None for all.

    Returns:
        The recorded fields by name, (N, M, columns) each.

    Raises:
        PhysicsError: no such field is recorded; or the engine warned, or stopped a simulation.
    """
    simulations = np.arange(len(steps)) if ids is None else ids
    order, ends = np.argsort(steps, kind="stable").tolist(), steps.tolist()
    model, record = batch.model, dict[str, Floats]()
    widths = {"sensordata": model.nsensordata, "qpos": model.nq, "qvel": model.nv, "actuator_force": model.nactuator}
    for name in names:
        if name not in widths:
            raise PhysicsError(unknown_name("recorded field", name, widths))
        record[name] = np.empty((*control.shape[:2], int(widths[name])))
        for row, end in enumerate(ends):
            record[name][row, end:] = 0.0
    batch.warning[:] = 0
    for first in range(0, len(order), batch.nthread):
        group, start = order[first : first + batch.nthread], 0
        for place, row in enumerate(group):
            moments = slice(start, ends[row])
            start = ends[row]
            if moments.start == moments.stop:
                continue
            # The controls and records of one simulation are views, which the engine reads and writes without a copy.
            is_one = place == len(group) - 1
            index = slice(row, row + 1) if is_one else sorted(group[place:])
            out = {name: values[index, moments] for name, values in record.items()} if is_one else None
            part = batch.rollout(
                moments.stop - moments.start,
                control[index, moments],
                control_spec=_INPUTS,
                record=names,
                ids=simulation_ids(batch, simulations[index]),
                out=out,
            )
            if not is_one:
                for name in names:
                    record[name][index, moments] = part[name]
    check_warnings(batch)
    return record


def simulation_ids(batch: Any, rows: Ints) -> Ints | None:
    """Simulations for a call of the engine; None where these are all, which the engine need not check."""
    return None if rows.size == batch.nsim else rows


def check_warnings(batch: Any) -> None:
    """Make sure that the engine gave no warning in a batch.

    Raises:
        PhysicsError: the engine gave a warning; the sentence names the first one.
    """
    if np.count_nonzero(batch.warning) == 0:
        return
    warned = np.argwhere(batch.warning)[:, :2].tolist()
    row, kind = warned[0]
    name = mujoco.mjtWarning(kind).name
    error = PhysicsError(f"MuJoCo warned in simulation {row}: {name}; a number of the level is too extreme to simulate")
    error.simulations = [simulation for simulation, _ in warned]
    raise error


def touching(contact: Floats) -> Bools:
    """Which sensed contacts (..., 2), number and smallest distance [m], are real and not only predicted (...,)."""
    return np.asarray((contact[..., 0] > 0.0) & (contact[..., 1] < TOUCH_DISTANCE))
