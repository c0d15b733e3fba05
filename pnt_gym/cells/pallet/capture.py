"""Where thrown parts come to rest: free parts launched into pallets, many at once, and whether they lie right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.cells.outcome import TOUCH
from pnt_gym.cells.pallet.pallets import Pallet, add_pallets, stacked
from pnt_gym.cells.pallet.parts import Part, add_part
from pnt_gym.cells.rollout import check_warnings
from pnt_gym.engine import Batch, MjModel, mujoco
from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.robots.one_joint.model import add_plane_joints
from pnt_gym.robots.specification import set_options

STEP: Final = 0.0005
"""Physics step [s]."""


@final
@dataclass(frozen=True)
class Tolerance:
    """How a part may lie to be in its place, and how still."""

    position: float
    """Of the centre of mass, from the exact seat [m]."""
    angle: float
    """[rad]"""
    speed: float = 0.02
    """A part at rest creeps by less than 1 mm/s; one that hops or slides is faster [m/s]."""
    spin: float = 0.30
    """[rad/s]"""


IN_POCKET: Final = Tolerance(position=0.008, angle=float(np.deg2rad(5.0)))
"""A pocket leaves a part 6 mm to one side of the goal and 4 mm to the other; a part that lies on the lip is more than
8 mm off, and one that lies on the back board more than 10 deg."""
ON_STEM: Final = Tolerance(position=0.007, angle=float(np.deg2rad(5.0)))
"""A slot has 5 mm of play to either side; a part whose slot or stem is not engaged lies more than 10 mm higher."""


def lies_at(pose: Floats, velocity: Floats, seat: Floats, tolerance: Tolerance) -> Bools:
    """Whether parts rest in their seats (N,).

    Args:
        pose: x, y [m], phi [rad] (N, 3); whole turns do not matter.
        velocity: their rates (N, 3).
        seat: pose of a part that lies exactly right (3,) or (N, 3).
        tolerance: what still counts.
    """
    miss = pose - seat
    turn = np.abs((miss[:, 2] + np.pi) % (2.0 * np.pi) - np.pi)
    near = (np.hypot(miss[:, 0], miss[:, 1]) <= tolerance.position) & (turn <= tolerance.angle)
    still = np.hypot(velocity[:, 0], velocity[:, 1]) <= tolerance.speed
    return near & still & (np.abs(velocity[:, 2]) <= tolerance.spin)


def lies_in_pocket(pose: Floats, velocity: Floats, pallet: Pallet, tolerance: Tolerance = IN_POCKET) -> Bools:
    """Whether parts rest in a pallet (N,); see `lies_at`."""
    return lies_at(pose, velocity, pallet.pose, tolerance)


def are_joined(lower: Floats, upper: Floats, velocity: Floats, tolerance: Tolerance = ON_STEM) -> Bools:
    """Whether Ts rest with their stem in the upper slot of Hs (N,).

    Args:
        lower: poses of the Hs (N, 3).
        upper: poses of the Ts (N, 3).
        velocity: rates of the Ts (N, 3).
        tolerance: of the T from its seat on the H as it lies.
    """
    return lies_at(upper, velocity, stacked(lower), tolerance)


@final
@dataclass(frozen=True)
class Rest:
    """N launches of P parts among Q pallets at their end."""

    pose: Floats
    """x, y [m], phi [rad] (N, P, 3)."""
    velocity: Floats
    """Their rates (N, P, 3)."""
    touched: Bools
    """Whether a part ever touched a pallet (N, P, Q)."""


@final
class CaptureBench:
    """Parts that fly freely in the plane, without air, among pallets.

    Args:
        pallets: what stands there (Q).
        parts: what is launched or lies there (P), each once.
        count: simulations N.
        timestep: physics step [s].
        threads: worker threads; results do not depend on it.
    """

    def __init__(
        self, pallets: Sequence[Pallet], parts: Sequence[Part], count: int, timestep: float = STEP, threads: int = 1
    ) -> None:
        self.pallets, self.parts = tuple(pallets), tuple(parts)
        self.model: MjModel = _compile(self.pallets, self.parts, timestep)
        self.batch = Batch(self.model, nsim=count, nthread=threads)
        self._step = timestep

    def launch(self, state: Floats, duration: float) -> Rest:
        """Let go of all parts and wait.

        Args:
            state: x, y [m], phi [rad] and their rates (N, P, 6).
            duration: what is simulated [s].

        Raises:
            PhysicsError: the engine warned.
        """
        batch, count = self.batch, len(state)
        batch.state[:], batch.warning[:] = 0.0, 0
        batch.bind("qpos")[:] = state[..., :3].reshape(count, -1)
        batch.bind("qvel")[:] = state[..., 3:].reshape(count, -1)
        found, distance = self._contacts(round(duration / self._step))
        check_warnings(batch)
        shape = (count, len(self.parts), 3)
        return Rest(
            pose=batch.bind("qpos").reshape(shape).copy(),
            velocity=batch.bind("qvel").reshape(shape).copy(),
            touched=np.asarray(((found > 0.0) & (distance < TOUCH)).any(axis=1)),
        )

    def _contacts(self, steps: int) -> tuple[Floats, Floats]:
        """Number found and smallest distance [m], (N, steps, P, Q) each."""
        record = self.batch.rollout(steps, record=("sensordata",))["sensordata"]
        pairs = record.reshape(len(record), steps, len(self.parts), len(self.pallets), 2)
        return pairs[..., 0], pairs[..., 1]


def rewind(state: Floats, lead: float) -> Floats:
    """States (..., 6) of free flights a time `lead` [s] before; the inverse of ballistic flight."""
    pose, rate = state[..., :3], state[..., 3:]
    gravity = np.array([0.0, -GRAVITY, 0.0])
    return np.concatenate([pose - lead * rate + 0.5 * lead**2 * gravity, rate - lead * gravity], axis=-1)


def _compile(pallets: Sequence[Pallet], parts: Sequence[Part], timestep: float) -> MjModel:
    spec = mujoco.MjSpec()
    set_options(spec, timestep, density=0.0, viscosity=0.0)
    add_pallets(spec, pallets)
    for part in parts:
        body = spec.worldbody.add_body(name=part.name)
        add_plane_joints(body, part.name)
        add_part(body, part)
    found_and_distance, nearest, one = 0b1001, 1, 1
    for part in parts:
        for pallet in pallets:
            spec.add_sensor(
                type=mujoco.mjtSensor.mjSENS_CONTACT,
                objtype=mujoco.mjtObj.mjOBJ_BODY,
                objname=part.name,
                reftype=mujoco.mjtObj.mjOBJ_BODY,
                refname=pallet.name,
                intprm=[found_and_distance, nearest, one],
            )
    return spec.compile()
