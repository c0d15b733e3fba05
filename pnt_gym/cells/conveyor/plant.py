"""The physics of N throws: per-simulation objects and bins, references, rollouts, and what came of it.

Each throw starts at rest with the robot exactly closed at the pick and the object under the cup, so its outcome is a
pure function of the pick and the release: the same alone, in a batch, and again later.

A throw is simulated with the whole robot until the object has fallen clear of the cup, and then without it: what the
hand does on its way back no longer matters to the object. Where geometry cannot rule out that the cup meets the object
again, the whole throw is simulated with the robot.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, length, made_anew, take
from pnt_gym.cells.base.alone import Fall, fall, write_object
from pnt_gym.cells.base.plant import ObjectFlight, Plant, staged_rollout, touching
from pnt_gym.cells.base.stage import ITEM_RGBA
from pnt_gym.cells.conveyor.clearance import vertical
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.hand import Course, HandCycle
from pnt_gym.cells.conveyor.outcome import Flown
from pnt_gym.cells.conveyor.scene import (
    LIP_GAP,
    SENSORS,
    FreeScene,
    Scene,
    Surroundings,
    bin_panels,
    build_free_scene,
    build_scene,
)
from pnt_gym.engine import Batch
from pnt_gym.robots.t3kr.kinematics import closed_pose
from pnt_gym.robots.t3kr.model import qpos_columns
from pnt_gym.robots.t3kr.references import JointMotion, joint_knots, knot_count, upsample


@final
@dataclass(frozen=True)
class Followed:
    """N throws simulated with the robot from beginning to end."""

    flown: Flown
    hand: Floats
    """Cup tip (N, M, 3) at the start of each step [m]."""
    start: Floats
    """Time on the path's own clock at the first step (N,) [s]."""


@final
class ConveyorPlant(Plant[Context, HandCycle, Flown]):
    """N copies of the conveyor cell's physics; the models are the config's."""

    def __init__(self, config: ConveyorConfig, count: int, threads: int = 1) -> None:
        self.config = config
        self.scene: Scene = build_scene(config)
        super().__init__(config, self.scene.model, count, threads)
        self._free: FreeScene = build_free_scene(config)
        self._free_batch = Batch(self._free.model, nsim=count, nthread=threads)
        model, robot = self.scene.model, self.scene.robot
        self._robot_qpos = qpos_columns(model, robot)
        self._rods_per_arm = robot.rods_per_arm
        self._controls = int(model.nu) + int(model.neq)

    def fly(self, thrown: Context, plans: HandCycle) -> Flown:
        """Simulate one throw in every simulation: the N picks, and what the hands do."""
        course = self._prepare(thrown, plans)
        rows, begin, clear = np.arange(len(course.end)), self.batch.state.copy(), course.clear(thrown)
        held = self._with_robot(rows, thrown, course, clear)
        fallen = self._without_robot(thrown, course, clear, held)
        flown = self._one_after_the_other(course, clear, held["sensordata"], fallen)
        seen = fallen.sensors[:, :: course.stride]
        position, velocity = seen[..., SENSORS["object_position"]], seen[..., SENSORS["object_velocity"]]
        up = vertical(fallen.attitude[:, :: course.stride])
        unsure = course.may_meet(thrown, (position, velocity, up), clear, fallen.steps)

        def again(rows: Ints, thrown: Context, course: Course) -> Flown:
            self.batch.state[rows] = begin[rows]
            return self._followed(rows, thrown, course, flown.flight.position.shape[1]).flown

        return made_anew(flown, unsure, again, rows, thrown, course)

    def follow(self, thrown: Context, plans: HandCycle) -> Followed:
        """As `fly`, with the robot simulated to the end and its hand recorded."""
        course = self._prepare(thrown, plans)
        return self._followed(np.arange(len(course.end)), thrown, course, int(course.end.max()))

    def write(self, context: Context) -> None:
        """Set the simulations up: robot closed and at rest at the pick, object under the cup."""
        self._write_models(self.batch, self.scene, context)
        batch, scene = self.batch, self.scene
        self._write_grip_point(context)
        batch.set_const()
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

    def _prepare(self, thrown: Context, plans: HandCycle) -> Course:
        """Set the simulations up, and keep the throw that is recorded."""
        course, plan = Course.of(thrown, plans, self.config.timestep), plans.release
        self.write(thrown)
        if (row := self.record_row) is not None:
            one = np.array([row])
            control = self._references(one, take(thrown, one), take(course, one), int(course.end[row]))
            flight = plan.position[row], plan.velocity[row], plan.flight_time[row]
            self.keep(self.scene.object_body, control[0], flight, thrown.target[row])
        return course

    def _with_robot(
        self, rows: Ints, thrown: Context, course: Course, until: Ints, width: int | None = None
    ) -> dict[str, Floats]:
        """Records of some rows up to a step of each, M steps wide or `width`."""
        control = self._references(rows, thrown, course, int(until.max()) if width is None else width)
        return staged_rollout(self.batch, control, until, ("sensordata", "qpos", "qvel"), rows)

    def _without_robot(self, thrown: Context, course: Course, clear: Ints, held: Mapping[str, Floats]) -> Fall:
        """What the objects do from where they are clear of the cup."""
        batch, scene = self._free_batch, self.scene
        self._write_models(batch, self._free, thrown)
        batch.set_const()
        batch.state[:] = 0.0
        moment = np.arange(len(clear)), clear - 1  # recorded at the end of a step
        for name, first, count in (("qpos", scene.object_qpos, 7), ("qvel", scene.object_qvel, 6)):
            batch.bind(name)[:] = held[name][moment][:, first : first + count]
        return fall(batch, self._free.object_body, course.end - clear, thrown.target[:, 2])

    def _followed(self, rows: Ints, thrown: Context, course: Course, width: int) -> Followed:
        """Throws of some rows with the robot to the end."""
        sensors = self._with_robot(rows, thrown, course, course.end, width)["sensordata"]
        flight = ObjectFlight(
            position=sensors[..., SENSORS["object_position"]],
            velocity=sensors[..., SENSORS["object_velocity"]],
            hand_touch=touching(sensors[..., SENSORS["cup_contact"]]),
            any_touch=touching(sensors[..., SENSORS["any_contact"]]),
            release_step=course.release,
            last_step=course.end - 1,
        )
        flown = Flown(flight, _astray(sensors, course), _largest_torque(sensors, course.end))
        return Followed(flown, sensors[..., SENSORS["hand_position"]], -course.shift)

    def _one_after_the_other(self, course: Course, clear: Ints, held: Floats, fallen: Fall) -> Flown:
        """Throws with the robot, and then without it."""
        sensors = np.zeros((len(held), max(int(course.end.max()), held.shape[1]), fallen.sensors.shape[2]))
        sensors[:, : held.shape[1]] = held[..., : sensors.shape[2]]
        for row, (first, steps) in enumerate(zip(clear, fallen.steps, strict=True)):
            sensors[row, first : first + steps] = fallen.sensors[row, :steps]
        with_robot = np.arange(held.shape[1], dtype=np.int64) < clear[:, None]
        hand_touch = np.zeros(sensors.shape[:2], dtype=np.bool_)
        hand_touch[:, : held.shape[1]] = touching(held[..., SENSORS["cup_contact"]]) & with_robot
        flight = ObjectFlight(
            position=sensors[..., SENSORS["object_position"]],
            velocity=sensors[..., SENSORS["object_velocity"]],
            hand_touch=hand_touch,
            any_touch=touching(sensors[..., SENSORS["any_contact"]]),
            release_step=course.release,
            last_step=clear + fallen.steps - 1,
        )
        torque = np.maximum(_largest_torque(held, clear), self._torque_ahead(course, clear))
        return Flown(flight, _astray(held, course), torque)

    def _torque_ahead(self, course: Course, clear: Ints) -> Floats:
        """Largest torque that the motion needs from a step on (N,) [N m]."""
        ahead = course.end - clear
        steps = np.minimum(np.arange(0, int(ahead.max()), course.stride, dtype=np.int64), ahead[:, None])
        return np.asarray(np.abs(self._knots(course, clear[:, None] + steps).torque).max(axis=(0, 2)))

    def _references(self, rows: Ints, thrown: Context, course: Course, steps: int) -> Floats:
        """Controls (N, steps, nu + neq) of some rows: motors, spin and grip, every other equality active."""
        control = np.zeros((len(rows), steps, self._controls))
        control[..., int(self.scene.model.nu) :] = 1.0
        stride = course.stride
        knots = self._knots(course, np.arange(knot_count(steps, stride), dtype=np.int64) * stride)
        weak = 1.0 - self.config.mismatch * self.config.spread.feedforward
        upsample(replace(knots, torque=knots.torque * weak), stride * course.step, stride, control)
        grip = int(self.scene.model.nu) + self.scene.grip_equality
        control[..., grip] = np.arange(steps, dtype=np.int64) < course.release[:, None]
        inertia = self.batch.expand("body_inertia")[rows, self.scene.object_body]
        torque = inertia * _in_body_axes(thrown.objects.spin, thrown.objects.yaw) / course.step
        # The object gets its spin in the one step in which it is let go.
        control[np.arange(len(rows)), course.release, self.scene.spin_controls] = torque
        return control

    def _knots(self, course: Course, steps: Ints) -> JointMotion:
        """What the motors should do at steps (K,) or (N, K)."""
        position, velocity, acceleration = course.hand(steps)
        return joint_knots(position, velocity, acceleration, geometry=self.scene.robot.geometry)

    def _write_grip_point(self, context: Context) -> None:
        """Where each object hangs under the cup."""
        batch, site, o = self.batch, self.scene.grip_site, context.objects
        grip = np.concatenate([-context.grasp, o.com_depth[:, None]], axis=1)
        batch.expand("site_pos")[:, site] = _in_body_axes(grip, o.yaw)
        zero = np.zeros_like(o.yaw)
        batch.expand("site_quat")[:, site] = np.stack([np.cos(o.yaw / 2), zero, zero, -np.sin(o.yaw / 2)], axis=-1)

    def _write_models(self, batch: Any, scene: Surroundings, context: Context) -> None:
        """Per-simulation object and, where it is drawn per throw, bin."""
        o, geom = context.objects, scene.object_geom
        write_object(batch, scene.object_body, geom, o.shape, o.size, o.mass, o.drag)
        batch.expand("geom_pos")[:, geom, 2] = o.com_depth - LIP_GAP - o.size[:, 2] / 2
        batch.expand("geom_friction")[:, geom] = np.stack(
            [o.friction, 0.1 * o.rolling_friction, o.rolling_friction], axis=-1
        )
        batch.expand("geom_solref")[:, geom] = o.solref
        batch.expand("geom_rgba")[:, geom] = ITEM_RGBA.take(o.kind, axis=0, mode="wrap")
        if self.config.bins.random is not None:
            self._place_bin(batch, scene, context)

    def _place_bin(self, batch: Any, scene: Surroundings, context: Context) -> None:
        body = scene.bin_bodies[0]
        first = int(scene.model.body_geomadr[body])
        panels = slice(first, first + 5)
        half, middle = bin_panels(context.opening, self.config.bins)
        batch.expand("body_pos")[:, body] = context.target
        batch.expand("geom_size")[:, panels] = half
        batch.expand("geom_pos")[:, panels] = middle
        batch.expand("geom_rbound")[:, panels] = length(half)
        aabb = np.concatenate([np.zeros_like(half), half], axis=-1)
        expanded = batch.expand("geom_aabb")
        expanded[:, panels] = aabb.reshape(expanded[:, panels].shape)


def _largest_torque(sensors: Floats, end: Ints) -> Floats:
    """Of all motors, in records (N, M, columns) up to a step of each (N,) [N m]."""
    torque = np.abs(sensors[..., SENSORS["torque"]]).max(axis=2)
    counts = np.arange(torque.shape[1], dtype=np.int64) < end[:, None]
    return np.where(counts, torque, 0.0).max(axis=1)


def _astray(sensors: Floats, course: Course) -> Floats:
    """Distance of recorded hands (N, M, columns) from their references at the moment of release (N,) [m]."""
    planned = course.path.sample(course.free_at[:, None]).position[:, 0] + course.offset
    return length(sensors[np.arange(len(planned)), course.release][:, SENSORS["hand_position"]] - planned)


def _in_body_axes(vector: Floats, yaw: Floats) -> Floats:
    """World vectors (N, 3) in the axes of bodies turned by yaw (N,) about z."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y = vector[:, 0], vector[:, 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x, vector[:, 2]], axis=-1)
