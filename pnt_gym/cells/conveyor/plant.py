"""The physics of N throws: per-simulation objects and bins, references, one `Batch.rollout`, and what came of it.

Each throw starts at rest with the robot exactly closed at the pick and the object under the cup, so its outcome is a
pure function of the pick and the release: the same alone, in a batch, and again later.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, length
from pnt_gym.cells.base.plant import ObjectFlight, Plant, staged_rollout, step_counts, touching
from pnt_gym.cells.base.stage import ITEM_RGBA
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.outcome import Flown
from pnt_gym.cells.conveyor.scene import LIP_GAP, SENSORS, Scene, bin_panels, build_scene
from pnt_gym.planning.motion.trajectory import HandPath
from pnt_gym.planning.straight.plan import ReleaseBatch
from pnt_gym.robots.t3kr.kinematics import closed_pose
from pnt_gym.robots.t3kr.model import qpos_columns
from pnt_gym.robots.t3kr.references import joint_knots, knot_count, upsample

SETTLE: Final = 0.35
"""Simulated after the planned landing, so that the object comes to lie [s]."""
KNOT_SPACING: Final = 0.004
"""Inverse kinematics and dynamics are evaluated this often and interpolated in between [s]."""
LATEST_FLIGHT: Final = 1.25
"""A late release may lengthen the flight by this factor."""


@final
@dataclass(frozen=True)
class HandCycle:
    """What N hands do: throw, follow through, and go to their next picks."""

    release: ReleaseBatch
    """The planned releases."""
    release_time: Floats
    """When the valve is commanded (N,) [s]."""
    path: HandPath
    """From lift to lift."""


@final
class ConveyorPlant(Plant[Context, HandCycle, Flown]):
    """N copies of the conveyor cell's physics; the model is the config's."""

    def __init__(self, config: ConveyorConfig, count: int, threads: int = 1) -> None:
        self.config = config
        self.scene: Scene = build_scene(config)
        super().__init__(config, self.scene.model, count, threads)
        model, robot = self.scene.model, self.scene.robot
        self._robot_qpos = qpos_columns(model, robot)
        self._rods_per_arm = robot.rods_per_arm
        self._controls = int(model.nu) + int(model.neq)

    def fly(self, thrown: Context, plans: HandCycle) -> Flown:
        """Simulate one throw in every simulation: the N picks, and what the hands do."""
        path, release, step = plans.path, plans.release, self.config.timestep
        free_at = plans.release_time + thrown.objects.delay
        release_step = np.ceil(free_at / step - 1e-9).astype(np.int64)
        # The reference is shifted by less than a step, so that the release falls exactly on a step.
        shift = release_step * step - free_at
        settled = free_at + LATEST_FLIGHT * release.flight_time + SETTLE
        steps = step_counts(np.maximum(path.duration + shift, settled), step)
        self.write(thrown)
        control = self._references(path, thrown.cup_offset, shift, int(steps.max()))
        self._write_grip(control, thrown, release_step)
        if (row := self.record_row) is not None:
            plan = release.position[row], release.velocity[row], release.flight_time[row]
            self.keep(self.scene.object_body, control[row], plan, thrown.target[row])
        sensors = staged_rollout(self.batch, control, steps, ("sensordata",))["sensordata"]
        hand = sensors[..., SENSORS["hand_position"]]
        planned = path.sample(free_at[:, None]).position[:, 0] + thrown.cup_offset
        return Flown(
            flight=ObjectFlight(
                position=sensors[..., SENSORS["object_position"]],
                velocity=sensors[..., SENSORS["object_velocity"]],
                hand_touch=touching(sensors[..., SENSORS["cup_contact"]]),
                any_touch=touching(sensors[..., SENSORS["any_contact"]]),
                release_step=release_step,
                last_step=steps - 1,
            ),
            hand=hand,
            start=-shift,
            tracking_error=length(hand[np.arange(len(steps)), release_step] - planned),
            peak_torque=np.abs(sensors[..., SENSORS["torque"]]).max(axis=(1, 2)),
        )

    def write(self, context: Context) -> None:
        """Set the simulations up: robot closed and at rest at the pick, object under the cup."""
        self._write_models(context)
        batch, scene = self.batch, self.scene
        batch.state[:] = 0.0
        qpos = batch.bind("qpos")
        cup = context.pick + context.cup_offset
        qpos[:, self._robot_qpos] = closed_pose(cup, self._rods_per_arm, scene.robot.geometry)
        first = scene.object_qpos
        qpos[:, first : first + 2] = cup[:, :2] + context.grasp
        qpos[:, first + 2] = cup[:, 2] - context.objects.com_depth
        qpos[:, first + 3] = np.cos(context.objects.yaw / 2)
        qpos[:, first + 6] = np.sin(context.objects.yaw / 2)
        batch.bind("eq_active")[:] = 1.0

    def _references(self, path: HandPath, offset: Floats, shift: Floats, steps: int) -> Floats:
        """Controls (N, steps, nu + neq) with the motors' columns filled and every equality active."""
        count = len(shift)
        control = np.zeros((count, steps, self._controls))
        control[..., int(self.scene.model.nu) :] = 1.0
        stride = max(round(KNOT_SPACING / self.config.timestep), 1)
        spacing = stride * self.config.timestep
        times = np.arange(knot_count(steps, stride)) * spacing - shift[:, None]
        position, velocity, acceleration = path.sample(times)
        position += offset[:, None]
        knots = joint_knots(position, velocity, acceleration, geometry=self.scene.robot.geometry)
        weak = 1.0 - self.config.mismatch * self.config.spread.feedforward
        upsample(replace(knots, torque=knots.torque * weak), spacing, stride, control)
        return control

    def _write_grip(self, control: Floats, context: Context, release_step: Ints) -> None:
        """Let go at the release step, and give the object its spin in that one step."""
        steps = np.arange(control.shape[1], dtype=np.int64)
        grip = int(self.scene.model.nu) + self.scene.grip_equality
        control[..., grip] = steps < release_step[:, None]
        inertia = self.batch.expand("body_inertia")[:, self.scene.object_body]
        torque = inertia * _in_body_axes(context.objects.spin, context.objects.yaw) / self.config.timestep
        control[np.arange(len(release_step)), release_step, self.scene.spin_controls] = torque

    def _write_models(self, context: Context) -> None:
        """Per-simulation object and, where it is drawn per throw, bin."""
        o, batch = context.objects, self.batch
        body, geom, site = self.scene.object_body, self.scene.object_geom, self.scene.grip_site
        self.write_object(body, geom, o.shape, o.size, o.mass, o.drag)
        batch.expand("geom_pos")[:, geom, 2] = o.com_depth - LIP_GAP - o.size[:, 2] / 2
        batch.expand("geom_friction")[:, geom] = np.stack(
            [o.friction, 0.1 * o.rolling_friction, o.rolling_friction], axis=-1
        )
        batch.expand("geom_solref")[:, geom] = o.solref
        batch.expand("geom_rgba")[:, geom] = ITEM_RGBA.take(o.kind, axis=0, mode="wrap")
        grip = np.concatenate([-context.grasp, o.com_depth[:, None]], axis=1)
        batch.expand("site_pos")[:, site] = _in_body_axes(grip, o.yaw)
        zero = np.zeros_like(o.yaw)
        batch.expand("site_quat")[:, site] = np.stack([np.cos(o.yaw / 2), zero, zero, -np.sin(o.yaw / 2)], axis=-1)
        if self.config.bins.random is not None:
            self._place_bin(context)
        batch.set_const()

    def _place_bin(self, context: Context) -> None:
        body, batch = self.scene.bin_bodies[0], self.batch
        first = int(self.scene.model.body_geomadr[body])
        panels = slice(first, first + 5)
        half, middle = bin_panels(context.opening, self.config.bins)
        batch.expand("body_pos")[:, body] = context.target
        batch.expand("geom_size")[:, panels] = half
        batch.expand("geom_pos")[:, panels] = middle
        batch.expand("geom_rbound")[:, panels] = length(half)
        aabb = np.concatenate([np.zeros_like(half), half], axis=-1)
        expanded = batch.expand("geom_aabb")
        expanded[:, panels] = aabb.reshape(expanded[:, panels].shape)


def _in_body_axes(vector: Floats, yaw: Floats) -> Floats:
    """World vectors (N, 3) in the axes of bodies turned by yaw (N,) about z."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y = vector[:, 0], vector[:, 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x, vector[:, 2]], axis=-1)
