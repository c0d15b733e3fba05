"""The physics of N throws: per-simulation objects and bins, references, one `Batch.rollout`, and what came of it.

Each throw starts at rest with the robot exactly closed at the pick and the object under the cup, so its outcome is a
pure function of the pick and the release: the same alone, in a batch, and again later.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final, final

import numpy as np

from pnt_gym.cells.context import Context
from pnt_gym.cells.fluid import fluid_coefficients, geom_placement, solid_shell_inertia
from pnt_gym.cells.items import contact_solref
from pnt_gym.cells.outcome import Flight, Outcome, Simulated, lies_in
from pnt_gym.cells.recording import Recording
from pnt_gym.cells.rollout import staged_rollout
from pnt_gym.cells.scene import LIP_GAP, SENSORS, Scene, bin_panels, build_scene
from pnt_gym.config import CellConfig
from pnt_gym.engine import Batch, MjData, MjModel, mujoco
from pnt_gym.planning.arrays import Bools, Floats, Ints, length
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.planning.plan import ReleaseBatch
from pnt_gym.planning.trajectory import HandPath
from pnt_gym.robots.t3kr.pose import closed_pose, qpos_columns
from pnt_gym.robots.t3kr.reference import joint_knots, knot_count, upsample

SETTLE: Final = 0.35
"""Simulated after the planned landing, so that the object comes to lie [s]."""
KNOT_SPACING: Final = 0.004
"""Inverse kinematics and dynamics are evaluated this often and interpolated in between [s]."""
LATEST_FLIGHT: Final = 1.25
"""A late release may lengthen the flight by this factor."""


@final
class ConveyorPlant:
    """N copies of the cell's physics on one `mujoco.batch.Batch`.

    Args:
        config: the cell.
        count: simulations N.
        threads: worker threads; results do not depend on it.
    """

    def __init__(self, config: CellConfig, count: int, threads: int = 1) -> None:
        self.config = config
        self.scene: Scene = build_scene(config)
        self.batch = Batch(self.scene.model, nsim=count, nthread=threads)
        model, robot = self.scene.model, self.scene.robot
        self._robot_qpos = qpos_columns(model, robot)
        self._controls = int(model.nu) + int(model.neq)
        self.record_row: int | None = None
        """The simulation whose throws are kept in `recording`, for pictures; None keeps nothing."""
        self.recording: Recording | None = None

    def throw(
        self,
        context: Context,
        release: ReleaseBatch,
        release_time: Floats,
        path: HandPath,
        jitter: bool = True,
    ) -> Outcome:
        """Simulate one throw in every simulation and judge it; arguments and errors are those of `fly`."""
        return self._outcome(context, self.fly(context, release, release_time, path, jitter))

    def fly(
        self,
        context: Context,
        release: ReleaseBatch,
        release_time: Floats,
        path: HandPath,
        jitter: bool = True,
    ) -> Simulated:
        """Simulate one throw in every simulation.

        Args:
            context: the N picks.
            release: the planned releases.
            release_time: when the valve is commanded (N,) [s].
            path: the hand's cycle.
            jitter: whether the release time carries its random part.

        Raises:
            PhysicsError: the engine warned, or stopped a simulation.
        """
        objects = context.objects
        free_at = release_time + (objects.delay if jitter else objects.delay - objects.jitter)
        step = self.config.timestep
        release_step = np.ceil(free_at / step - 1e-9).astype(np.int64)
        # The reference is shifted by less than a step, so that the release falls exactly on a step.
        shift = release_step * step - free_at
        settled = free_at + LATEST_FLIGHT * release.flight_time + SETTLE
        steps = np.ceil(np.maximum(path.duration + shift, settled) / step).astype(np.int64)
        self._write_models(context)
        self._write_states(context)
        control = self._references(path, context.cup_offset, shift, int(steps.max()))
        self._write_grip(control, context, release_step)
        if self.record_row is not None:
            self.recording = self._record(self.record_row, control, context, release)
        sensors = self._rollout(control, steps)
        hand = sensors[..., SENSORS["hand_position"]]
        planned = path.sample(free_at[:, None]).position[:, 0] + context.cup_offset
        return Simulated(
            flight=Flight.from_sensors(sensors, release_step, steps - 1),
            hand=hand,
            start=-shift,
            tracking_error=length(hand[np.arange(len(steps)), release_step] - planned),
            peak_torque=np.abs(sensors[..., SENSORS["torque"]]).max(axis=(1, 2)),
        )

    def pose(self, context: Context, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation as it stands before the throw, for a picture."""
        self._write_models(context)
        self._write_states(context)
        model, data = self.batch.get_model(row), self.batch.get_data(row)
        mujoco.mj_forward(model, data)
        return model, data

    def _record(self, row: int, control: Floats, context: Context, release: ReleaseBatch) -> Recording:
        time = np.linspace(0.0, float(release.flight_time[row]), 40)[:, None]
        fall = np.array([0.0, 0.0, -0.5 * GRAVITY])
        return Recording(
            model=self.batch.get_model(row),
            state=self.batch.state[row].copy(),
            control=control[row].copy(),
            plan=release.position[row] + release.velocity[row] * time + fall * time**2,
            target=context.target[row].copy(),
        )

    def _rollout(self, control: Floats, steps: Ints) -> Floats:
        """Recorded sensordata (N, M, columns); throws last from 0.8 to 1.5 s."""
        widths = [("sensordata", int(self.scene.model.nsensordata))]
        return staged_rollout(self.batch, control, steps, widths)["sensordata"]

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

    def _write_states(self, context: Context) -> None:
        """Robot closed and at rest at the pick, object under the cup."""
        batch, scene = self.batch, self.scene
        batch.state[:] = 0.0
        qpos = batch.bind("qpos")
        cup = context.pick + context.cup_offset
        qpos[:, self._robot_qpos] = closed_pose(cup, scene.robot)
        first = scene.object_qpos
        qpos[:, first : first + 2] = cup[:, :2] + context.grasp
        qpos[:, first + 2] = cup[:, 2] - context.objects.com_depth
        qpos[:, first + 3] = np.cos(context.objects.yaw / 2)
        qpos[:, first + 6] = np.sin(context.objects.yaw / 2)
        batch.bind("eq_active")[:] = 1.0

    def _write_models(self, context: Context) -> None:
        """Per-simulation object and, where it is drawn per throw, bin."""
        o, batch = context.objects, self.batch
        body, geom, site = self.scene.object_body, self.scene.object_geom, self.scene.grip_site
        place = geom_placement(o.shape, o.size)
        batch.expand("body_mass")[:, body] = o.mass
        batch.expand("body_inertia")[:, body] = solid_shell_inertia(o.mass, o.size, o.shape)
        batch.expand("geom_type")[:, geom] = place.type
        batch.expand("geom_size")[:, geom] = place.size
        batch.expand("geom_quat")[:, geom] = place.quat
        batch.expand("geom_rbound")[:, geom] = place.rbound
        batch.expand("geom_aabb")[:, geom] = place.aabb.reshape(batch.expand("geom_aabb")[:, geom].shape)
        batch.expand("geom_pos")[:, geom, 2] = o.com_depth - LIP_GAP - o.size[:, 2] / 2
        batch.expand("geom_fluid")[:, geom] = fluid_coefficients(o.shape, o.size, o.drag)
        batch.expand("geom_friction")[:, geom] = np.stack(
            [o.friction, 0.1 * o.rolling_friction, o.rolling_friction], axis=-1
        )
        batch.expand("geom_solref")[:, geom] = contact_solref(o.restitution)
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

    def _outcome(self, context: Context, simulated: Simulated) -> Outcome:
        target, opening, bins = context.target, context.opening, self.config.bins
        flight = simulated.flight
        landing = flight.landing(target[:, 2])
        miss = landing - target[:, :2]
        along, across = context.to_throw_frame(miss)
        in_opening: Bools = np.asarray((np.abs(miss) <= opening / 2).all(axis=1))
        position, velocity = flight.final()
        in_bin = lies_in(position, velocity, target[:, :2], opening, bins.rim, bins.rim - bins.depth)
        nothing = np.zeros(len(along))
        return Outcome(
            landing=landing,
            landing_along=along,
            landing_across=across,
            landing_error=np.sqrt(along**2 + across**2),
            in_opening=in_opening,
            in_bin=in_bin,
            sorted=in_opening & in_bin,
            rim=in_opening & ~in_bin,
            recontact=flight.recontact(),
            final=position,
            cycle_time=nothing,
            wait_time=nothing,
            peak_torque=simulated.peak_torque,
            tracking_error=simulated.tracking_error,
            clipped=nothing > 0.0,
        )


def _in_body_axes(vector: Floats, yaw: Floats) -> Floats:
    """World vectors (N, 3) in the axes of bodies turned by yaw (N,) about z."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y = vector[:, 0], vector[:, 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x, vector[:, 2]], axis=-1)
