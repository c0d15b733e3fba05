"""Where thrown parts come to rest: free parts launched into pallets, many at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.plant import TOUCH_DISTANCE, check_warnings
from pnt_gym.cells.one_joint.pallets import Pallet, add_pallets
from pnt_gym.cells.one_joint.parts import Part, add_part
from pnt_gym.constants import GRAVITY
from pnt_gym.engine import Batch, MjModel, mujoco
from pnt_gym.robots.one_joint.model import add_plane_joints
from pnt_gym.robots.specification import set_options

STEP: Final = 0.0005
"""Physics step [s]."""


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
    """N simulations of P parts that fly freely in the plane, without air, among Q pallets."""

    def __init__(self, pallets: Sequence[Pallet], parts: Sequence[Part], count: int) -> None:
        self.pallets, self.parts = tuple(pallets), tuple(parts)
        self.model: MjModel = _compile(self.pallets, self.parts)
        self.batch = Batch(self.model, nsim=count, nthread=1)

    def launch(self, state: Floats, duration: float) -> Rest:
        """Let go of all parts at x, y [m], phi [rad] with their rates (N, P, 6), and wait for a duration [s]."""
        batch, count = self.batch, len(state)
        batch.state[:], batch.warning[:] = 0.0, 0
        batch.bind("qpos")[:] = state[..., :3].reshape(count, -1)
        batch.bind("qvel")[:] = state[..., 3:].reshape(count, -1)
        found, distance = self._contacts(round(duration / STEP))
        check_warnings(batch)
        shape = (count, len(self.parts), 3)
        return Rest(
            pose=batch.bind("qpos").reshape(shape).copy(),
            velocity=batch.bind("qvel").reshape(shape).copy(),
            touched=np.asarray(((found > 0.0) & (distance < TOUCH_DISTANCE)).any(axis=1)),
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


def _compile(pallets: Sequence[Pallet], parts: Sequence[Part]) -> MjModel:
    spec = mujoco.MjSpec()
    set_options(spec, STEP, density=0.0, viscosity=0.0)
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
