"""Physics of N throws of the gripper robot: objects, references, one `Batch.rollout`, and the recorded throws.

Each throw starts with open claws around an object on the table, at rest or, on a belt, with robot and object at the
belt's velocity. Grip, lift, move, opening, flight and landing are all simulated. The outcome is a pure function of the
plan and the hidden values: the same for a single throw, in a batch, and on repetition.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.bodies import (
    MODEL_FIELDS,
    ModelFields,
    ModelObjects,
    fluid_coefficients,
    geom_placement,
    lying_size,
    solid_shell_inertia,
    write_object,
)
from pnt_gym.cells.base.plant import Plant, roll_out, step_counts
from pnt_gym.cells.base.recorded import MotorRecord
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.context import Context
from pnt_gym.cells.gripper.hidden import Hidden
from pnt_gym.cells.gripper.motion import TossPlans
from pnt_gym.cells.gripper.outcome import RecordedThrows
from pnt_gym.cells.gripper.scene import SENSORS, Scene, build_scene
from pnt_gym.palette import ITEMS
from pnt_gym.robots.gripper.geometry import N_ARMS
from pnt_gym.robots.gripper.references import closed_pose, motor_references

LATEST_FLIGHT: Final = 1.15
"""A late release may lengthen the flight by this factor."""
_GAP = 1e-4
"""Gap between the object and the table at the start, so that they do not touch [m]."""
_INSTANT = 1e-6
"""Half the time over which joint speeds are differenced [s]."""


@final
class GripperPlant(Plant[Context, TossPlans, RecordedThrows]):
    """N copies of the physics of the gripper robot's cell."""

    def __init__(self, config: GripperConfig, count: int, threads: int = 1) -> None:
        self.config = config
        self._dimensions, self._build = config.robot.parts()
        self.scene: Scene = build_scene(config)
        super().__init__(config, self.scene.model, count, threads)
        model = self.scene.model
        self.motors = np.array([int(model.joint(f"arm_{arm}").dofadr[0]) for arm in range(N_ARMS)])
        """Columns of qvel of the motors."""
        self.torques = np.arange(SENSORS["torque"].start, SENSORS["torque"].stop)
        """Columns of sensordata with the torques of the motors."""
        self._upright = np.array([item.upright for item in config.item_list()])
        self._mass = np.array([item.mass for item in config.item_list()])

    def fly(self, context: Context, plans: TossPlans) -> RecordedThrows:
        """Simulate one throw in every simulation: the N objects, and the N throws."""
        step, hidden = self.config.timestep, context.hidden
        # Only a delay lengthens the simulation; an early opening must not shorten it.
        landing = plans.release_time + np.maximum(plans.shift, 0.0) + LATEST_FLIGHT * plans.flight_time
        end = np.maximum(plans.stop_time, landing + hidden.delay + self.config.tray.settle)
        steps = step_counts(end, step)
        self.write(context, plans)
        control = self._controls(plans, context.kind, hidden, int(steps.max()))
        if (row := self.record_row) is not None:
            # The planned flight is that of the object's middle, which hangs below the platform.
            start = plans.release[row] - np.array([0.0, 0.0, plans.hang[row]])
            plan = start, plans.velocity[row], plans.flight_time[row]
            self.record_throw(self.scene.object_body, control[row, : steps[row]], plan, plans.target[row])
        record = roll_out(self.batch, control, steps, ("sensordata", "qvel"))
        throws = MotorRecord(record["sensordata"], self.torques, record["qvel"], self.motors)
        return RecordedThrows.of(throws, plans, steps - 1, step)

    def write(self, context: Context, plans: TossPlans) -> None:
        """Set up the simulations: robot above its object, object on the table."""
        batch, scene, hidden = self.batch, self.scene, context.hidden
        upright = self._upright[context.kind]
        full = lying_size(hidden.shape, hidden.size)
        # Each simulation's object: shape, size, mass, drag and grip.
        rows, shape = np.arange(len(full)), hidden.shape
        inertia, fluid = solid_shell_inertia(hidden.mass, full, shape), fluid_coefficients(shape, full, hidden.drag)
        objects = ModelObjects(hidden.mass, inertia, geom_placement(shape, full), fluid)
        fields = ModelFields(*map(batch.expand, MODEL_FIELDS))
        write_object(rows, scene.object_body, scene.object_geom, objects, fields)
        friction = batch.expand("geom_friction")
        for pad in scene.pads:
            friction[:, pad, 0] = hidden.friction
        batch.set_const()
        batch.expand("geom_rgba")[:, scene.object_geom] = ITEMS.take(context.kind, axis=0, mode="wrap")
        batch.state[:] = 0.0
        qpos = batch.bind("qpos")
        first = scene.object_qpos
        start = np.column_stack([plans.pick, plans.theta[:, 0]])
        qpos[:, :first] = closed_pose(start, self._dimensions)
        qpos[:, first : first + 2] = context.place + hidden.offset
        height = np.where(upright, full[:, 0], full[:, 2])
        qpos[:, first + 2] = self.config.table.height + height / 2.0 + _GAP
        # Quaternions (N, 4) of a turn about the vertical, for upright objects after turning the body's x axis up.
        # Half of a turn by -90 degrees about y, which lifts the body's x axis.
        tilt = np.where(upright, -np.pi / 4.0, 0.0)
        cos, sin = np.cos(hidden.yaw / 2.0), np.sin(hidden.yaw / 2.0)
        c, s = np.cos(tilt), np.sin(tilt)
        qpos[:, first + 3 : first + 7] = np.stack([cos * c, -sin * s, cos * s, sin * c], axis=-1)
        batch.bind("eq_active")[:] = 1.0
        if hidden.belt_speed is not None:
            # The true speed of belt and object, and the planned velocity of the robot.
            travel = self.config.table.travel
            batch.expand("geom_surfacevel")[:, scene.table, :3] = hidden.belt_speed[:, None] * travel
            rate = np.column_stack([plans.belt, np.zeros(len(hidden.belt_speed))])
            pose_after, pose_before = (
                closed_pose(start + sign * rate, self._dimensions) for sign in (_INSTANT, -_INSTANT)
            )
            qvel = batch.bind("qvel")
            joints = pose_after.shape[1]
            # Joint speeds that keep the loops closed: a central difference of closed poses.
            qvel[:, :joints] = (pose_after - pose_before) / (2.0 * _INSTANT)
            qvel[:, joints : joints + 3] = hidden.belt_speed[:, None] * travel

    def _controls(self, plans: TossPlans, kind: Ints, hidden: Hidden, steps: int) -> Floats:
        """References and active equalities (N, steps, nu + neq)."""
        model, step = self.scene.model, self.config.timestep
        moving = min(int(np.ceil((plans.stop_time + hidden.delay).max() / step)) + 3, steps)
        time = np.asarray(np.arange(moving) * step, dtype=np.float64)
        poses = plans.pose(time, hidden.delay)
        share = 1.0 - self.config.mismatch * self.config.errors.feedforward
        # The controller knows the catalogue's mass, not the mass of this object.
        payload = self._mass[kind][:, None]
        references = motor_references(poses, step, self._dimensions, self._build, payload=payload, share=share)
        control = np.ones((len(kind), steps, int(model.nu) + int(model.neq)))
        control[:, :moving, : int(model.nu)] = references.controls()
        control[:, moving:, : int(model.nu)] = control[:, moving - 1 : moving, : int(model.nu)]
        return control
