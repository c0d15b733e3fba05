"""Physics of N throws of the one-joint arm: references, one `Batch.rollout`, and the recorded flight.

Each throw starts at rest with the part on the arm, so its outcome is a pure function of the plan and the hidden values:
the same for a single throw, in a batch, and on repetition.

With an ideal release the part is held rigidly until it comes free, at the planned release plus a delay. Until then the
arm already brakes: the delay is that of an object that clings to the braking arm. A delay of the motor's command would
let the object go at constant speed and miss less.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.plant import TOUCH_DISTANCE, Plant, roll_out, step_counts
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.context import Context
from pnt_gym.cells.one_joint.flight import Flight
from pnt_gym.cells.one_joint.measure import MIN_CONTACT_FLIGHT, MIN_FRAMES
from pnt_gym.cells.one_joint.scene import TORQUE, Scene, build_scene, contact_columns
from pnt_gym.cells.one_joint.tasks import Job
from pnt_gym.planning.one_joint import ThrowPlans
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.robots.one_joint.model import STOPPER_GAP, STOPPER_WIDTH
from pnt_gym.robots.one_joint.references import Clock, Load, motor_references

LATEST_FLIGHT: Final = 1.15
"""Factor on the planned flight time within which a missed throw passes its goal."""
MARGIN: Final = 0.010
"""Time added to the longest flight [s]."""
SETTLE: Final = 0.45
"""Time simulated after the planned arrival at pallets, so that the part comes to rest [s]."""
PARKING_DISTANCE: Final = 4.0
"""Distance at which waiting parts float [m]."""


@final
class OneJointPlant(Plant[Context, ThrowPlans, Flight]):
    """N copies of the one-joint cell's physics; the level's task gives parts and pallets."""

    def __init__(self, config: OneJointConfig, count: int, threads: int = 1) -> None:
        self.config = config
        self.arm = config.arm.arm()
        job = Job.of(config)
        self.scene: Scene = build_scene(config, job.parts, job.pallets)
        super().__init__(config, self.scene.model, count, threads)
        # Mass, inertia and height of every part (P,); the radius comes from the plan.
        self._loads = Load(*np.array([(p.mass, p.inertia, 0.0, p.half_height) for p in job.parts]).T)

    def fly(self, context: Context, plans: ThrowPlans) -> Flight:
        """Simulate one throw in every simulation, with the parts that already lie in the pallets."""
        part, hidden, step = context.part, context.hidden, self.config.timestep
        height = self._loads.height[part]
        radius = np.sqrt(plans.u[:, 2] ** 2 - height**2)
        load = Load(self._loads.mass[part], self._loads.inertia[part], radius, height)
        motion, flight_time = plans.motion, plans.u[:, 3]
        delay = hidden.delay if self.scene.stoppers is None else np.zeros_like(hidden.delay)
        release = motion.duration + delay
        clock = Clock.releasing_at(release, step)
        settle = SETTLE if self.scene.pallets else 0.0
        # However short its plan is, the flight is recorded at least so long.
        least = MIN_CONTACT_FLIGHT if self.config.release == "contact" else MIN_FRAMES / self.config.camera.rate
        flight_limit = np.maximum(LATEST_FLIGHT * flight_time, least)
        end = release + flight_limit + MARGIN + settle
        steps = step_counts(end - clock.start, step)
        self.write(motion.sample(clock.start[:, None]).angle[:, 0], part, load.radius + hidden.radius, context.lying)
        control = self._controls(motion, load, clock, part, int(steps.max()))
        if (row := self.record_row) is not None:
            angle, speed, reach, time = plans.u[row]
            angle = angle + np.arcsin(height[row] / reach)
            start = reach * np.array([np.cos(angle), 0.0, np.sin(angle)])
            velocity = speed * reach * np.array([-np.sin(angle), 0.0, np.cos(angle)])
            target = np.array([context.goal[row, 0], 0.0, context.goal[row, 1]])
            body = int(self.scene.bodies[part[row]])
            self.record_throw(body, control[row, : steps[row]], (start, velocity, time), target)
        record = roll_out(self.batch, control, steps, ("qpos", "qvel", "sensordata"))
        return self._flight(record, clock, steps, part)

    def write(self, angle: Floats, part: Ints, radius: Floats, lying: Floats) -> None:
        """Set up the simulations: arm at rest at `angle` (N,), part at `radius` (N,), other parts at `lying`."""
        scene, batch, rows = self.scene, self.batch, np.arange(len(part))
        height = self._loads.height[part]
        weight = ~np.isnan(lying[..., 0])
        poses = np.where(weight[..., None], lying, 0.0)
        poses[..., 0] += np.where(weight, 0.0, PARKING_DISTANCE + np.arange(len(scene.parts)))
        cos, sin = np.cos(angle), np.sin(angle)
        poses[rows, part] = np.stack([radius * cos - height * sin, radius * sin + height * cos, angle], axis=-1)
        weight[rows, part] = True
        batch.state[:] = 0.0
        qpos = batch.bind("qpos")
        qpos[:, 0] = angle
        qpos[:, scene.first_qpos[:, None] + np.arange(3)] = poses
        batch.expand("body_gravcomp")[:, scene.bodies] = np.where(weight, 0.0, 1.0)
        batch.expand("site_pos")[rows, scene.seats[part]] = np.stack([radius, np.zeros_like(radius), height], axis=-1)
        if scene.stoppers is not None:
            distance = np.array([p.support for p in scene.parts])[part] + STOPPER_GAP + STOPPER_WIDTH / 2
            place, (inner, outer) = batch.expand("body_pos"), scene.stoppers
            place[:, inner, 0] = radius - distance[:, 1]
            place[:, outer, 0] = radius + distance[:, 0]
        batch.set_const()

    def _controls(self, motion: ArmMotion, load: Load, clock: Clock, part: Ints, steps: int) -> Floats:
        """References of the motor and activations of the grips (N, steps, nu + neq)."""
        model, count = self.scene.model, len(part)
        control = np.zeros((count, steps, int(model.nu) + int(model.neq)))
        control[..., :3] = motor_references(motion, load, clock, self.arm, self.config.timestep, steps)
        if self.scene.stoppers is None:
            is_held = np.arange(steps) <= clock.release_step[:, None]
            for column in np.moveaxis(int(model.nu) + self.scene.grips[part], -1, 0):
                control[np.arange(count), :, column] = is_held
        return control

    def _flight(self, record: dict[str, Floats], clock: Clock, steps: Ints, part: Ints) -> Flight:
        scene, rows = self.scene, np.arange(len(part))
        first = scene.first_qpos[part][:, None] + np.arange(3)
        last = steps - 1
        # Contacts of the thrown part with each pallet and other part (N, M, Q + P - 1).
        contacts = np.array([contact_columns(scene, p) for p in range(len(scene.parts))])[part]
        found, distance = (
            np.take_along_axis(record["sensordata"], contacts[:, k][:, None, :], axis=2) for k in range(2)
        )
        in_contact = found > 0.0
        touch = np.zeros_like(in_contact)
        # A sensor measures at the beginning of its step, the recorded pose is from the end.
        touch[:, :-1] = in_contact[:, 1:] & (distance[:, 1:] < TOUCH_DISTANCE)
        columns = scene.first_qpos[:, None] + np.arange(3)
        return Flight(
            pose=np.take_along_axis(record["qpos"], first[:, None, :], axis=2),
            velocity=np.take_along_axis(record["qvel"], first[:, None, :], axis=2),
            arm_angle=record["qpos"][..., 0],
            arm_speed=record["qvel"][..., 0],
            torque=record["sensordata"][..., TORQUE],
            touch=touch,
            pushed=np.asarray(in_contact.any(axis=2)),
            clock=clock,
            last_step=last,
            step=self.config.timestep,
            final_pose=record["qpos"][rows, last][:, columns],
            final_velocity=record["qvel"][rows, last][:, columns],
        )
