"""The physics of N throws of the gripper robot: objects, references, one `Batch.rollout`, and what came of it.

Each throw starts with open claws around an object that lies on the table, at rest or, on a belt, with all of it at the
belt's velocity; grip, lift, move, opening, flight and landing are all simulated. The outcome is a pure function of the
plan and the hidden values: the same alone, in a batch, and again later.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.cells.fluid import fluid_coefficients, geom_placement, lying_size, solid_shell_inertia
from pnt_gym.cells.recording import Recording
from pnt_gym.cells.rollout import staged_rollout
from pnt_gym.cells.tray.config import TrayConfig
from pnt_gym.cells.tray.hidden import Hidden
from pnt_gym.cells.tray.motion import TossPlans
from pnt_gym.cells.tray.scene import Scene, build_scene
from pnt_gym.cells.tray.simulated import Simulated
from pnt_gym.engine import Batch, MjData, MjModel, mujoco
from pnt_gym.planning.arrays import Floats, Ints
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.robots.gripper4.references import closed_pose, motor_references

LATEST_FLIGHT: Final = 1.15
"""A late release may lengthen the flight by this factor."""
_GAP = 1e-4
"""Between the object and the table at the start, which is no contact [m]."""
_INSTANT = 1e-6
"""Over which joint speeds are differences [s]."""


@final
class TrayPlant:
    """N copies of the cell's physics on one `mujoco.batch.Batch`.

    Args:
        config: the cell.
        count: simulations N.
        threads: worker threads; results do not depend on it.
    """

    def __init__(self, config: TrayConfig, count: int, threads: int = 1) -> None:
        self.config = config
        self._dimensions, self._build = config.robot.parts()
        self.scene: Scene = build_scene(config)
        self.batch = Batch(self.scene.model, nsim=count, nthread=threads)
        self._upright = np.array([t.upright for t in config.things])
        self._mass = np.array([t.mass for t in config.things])
        self.record_row: int | None = None
        """The simulation whose throws are kept in `recording`, for pictures; None keeps nothing."""
        self.recording: Recording | None = None

    def throw(self, plans: TossPlans, kind: Ints, place: Floats, hidden: Hidden) -> Simulated:
        """Simulate one throw in every simulation.

        Args:
            plans: the N throws.
            kind: which thing is thrown (N,).
            place: where it is seen on the table (N, 2) [m].
            hidden: the object as it is, and what else the planner does not know.

        Raises:
            PhysicsError: the engine warned, or stopped a simulation.
        """
        step = self.config.timestep
        landing = plans.release_time + np.maximum(plans.shift, 0.0) + LATEST_FLIGHT * plans.flight_time
        end = np.maximum(plans.stop_time, landing + hidden.delay + self.config.tray.settle)
        steps = np.ceil(end / step).astype(np.int64)
        self.write(plans, kind, place, hidden)
        control = self._controls(plans, kind, hidden, int(steps.max()))
        if self.record_row is not None:
            self.recording = self._record(self.record_row, control, plans, steps)
        sensordata = self._rollout(control, steps)
        return Simulated.from_sensors(sensordata, plans, steps - 1, step)

    def write(self, plans: TossPlans, kind: Ints, place: Floats, hidden: Hidden) -> None:
        """Set the simulations up: robot above its object, object on the table."""
        batch, scene = self.batch, self.scene
        upright = self._upright[kind]
        full = lying_size(hidden.shape, hidden.size)
        self._write_models(hidden, full)
        batch.state[:] = 0.0
        qpos = batch.bind("qpos")
        first = scene.object_qpos
        start = np.column_stack([plans.pick, plans.theta[:, 0]])
        qpos[:, :first] = closed_pose(start, self._dimensions)
        qpos[:, first : first + 2] = place + hidden.offset
        height = np.where(upright, full[:, 0], full[:, 2])
        qpos[:, first + 2] = self.config.table.height + height / 2.0 + _GAP
        qpos[:, first + 3 : first + 7] = _attitude(hidden.yaw, upright)
        batch.bind("eq_active")[:] = 1.0
        if hidden.belt_speed is not None:
            self._set_in_motion(start, plans.belt, hidden.belt_speed)

    def _set_in_motion(self, start: Floats, velocity: Floats, speed: Floats) -> None:
        """The belt and the object at the belt's true speed (N,), the robot at the planned velocity (N, 3)."""
        batch, scene, travel = self.batch, self.scene, self.config.table.travel
        batch.expand("geom_surfacevel")[:, scene.table, :3] = speed[:, None] * travel
        rate = np.column_stack([velocity, np.zeros(len(speed))])
        ahead, behind = (closed_pose(start + part * rate, self._dimensions) for part in (_INSTANT, -_INSTANT))
        qvel = batch.bind("qvel")
        first = ahead.shape[1]
        qvel[:, :first] = (ahead - behind) / (2.0 * _INSTANT)
        qvel[:, first : first + 3] = speed[:, None] * travel

    def pose(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation as it stands, for a picture."""
        model, data = self.batch.get_model(row), self.batch.get_data(row)
        mujoco.mj_forward(model, data)
        return model, data

    def _write_models(self, hidden: Hidden, full: Floats) -> None:
        """Per-simulation object: shape, size, mass, drag and grip."""
        batch, body, geom = self.batch, self.scene.object_body, self.scene.object_geom
        placed = geom_placement(hidden.shape, full)
        batch.expand("body_mass")[:, body] = hidden.mass
        batch.expand("body_inertia")[:, body] = solid_shell_inertia(hidden.mass, full, hidden.shape)
        batch.expand("geom_type")[:, geom] = placed.type
        batch.expand("geom_size")[:, geom] = placed.size
        batch.expand("geom_quat")[:, geom] = placed.quat
        batch.expand("geom_rbound")[:, geom] = placed.rbound
        aabb = batch.expand("geom_aabb")
        aabb[:, geom] = placed.aabb.reshape(aabb[:, geom].shape)
        batch.expand("geom_fluid")[:, geom] = fluid_coefficients(hidden.shape, full, hidden.drag)
        friction = batch.expand("geom_friction")
        for pad in self.scene.pads:
            friction[:, pad, 0] = hidden.friction
        batch.set_const()

    def _controls(self, plans: TossPlans, kind: Ints, hidden: Hidden, steps: int) -> Floats:
        """References and active equalities (N, steps, nu + neq)."""
        model, step = self.scene.model, self.config.timestep
        moving = min(int(np.ceil((plans.stop_time + hidden.delay).max() / step)) + 3, steps)
        time = np.asarray(np.arange(moving) * step, dtype=np.float64)
        poses = plans.pose(time, hidden.delay)
        share = 1.0 - self.config.mismatch * self.config.errors.feedforward
        payload = self._mass[kind][:, None]
        references = motor_references(poses, step, self._dimensions, self._build, payload=payload, share=share)
        control = np.ones((len(kind), steps, int(model.nu) + int(model.neq)))
        control[:, :moving, : int(model.nu)] = references.controls()
        control[:, moving:, : int(model.nu)] = control[:, moving - 1 : moving, : int(model.nu)]
        return control

    def _rollout(self, control: Floats, steps: Ints) -> Floats:
        """Sensordata (N, M, columns of `SENSORS`)."""
        widths = [("sensordata", int(self.scene.model.nsensordata))]
        return staged_rollout(self.batch, control, steps, widths)["sensordata"]

    def _record(self, row: int, control: Floats, plans: TossPlans, steps: Ints) -> Recording:
        time = np.linspace(0.0, float(plans.flight_time[row]), 40)[:, None]
        begin = plans.release[row] - np.array([0.0, 0.0, plans.hang[row]])
        return Recording(
            model=self.batch.get_model(row),
            state=self.batch.state[row].copy(),
            control=control[row, : steps[row]].copy(),
            plan=begin + plans.velocity[row] * time - np.array([0.0, 0.0, 0.5 * GRAVITY]) * time**2,
            target=plans.target[row].copy(),
        )


def _attitude(yaw: Floats, upright: Floats) -> Floats:
    """Quaternions (N, 4): turned about the vertical, and first, where upright, with the body's x axis up."""
    tilt = np.where(upright, -np.pi / 4.0, 0.0)
    cos, sin = np.cos(yaw / 2.0), np.sin(yaw / 2.0)
    c, s = np.cos(tilt), np.sin(tilt)
    return np.stack([cos * c, -sin * s, cos * s, sin * c], axis=-1)
