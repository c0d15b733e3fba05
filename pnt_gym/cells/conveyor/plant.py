"""The physics of N throws: objects and bins of each simulation, references, rollouts and their results.

Each throw starts with the robot's loops exactly closed at the pick and the object under the cup, at rest or with the
belt. So the result of a throw is a pure function of the pick and the release: the same alone, in a batch, and later.

A throw is simulated with the whole robot until the object has fallen clear of the cup, and then without the robot: the
hand's way back does not change the flight of the object. Where geometry cannot rule out that the cup touches the object
again, the whole throw is simulated with the robot.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, compute_by_mask, concatenate_records, in_order, length, recompute_rows, take
from pnt_gym.cells.base.bodies import turn_back, yaw_attitude
from pnt_gym.cells.base.parallel import call_in_threads, split_rows
from pnt_gym.cells.base.plant import Plant, roll_out, simulation_ids, touching
from pnt_gym.cells.base.recorded import (
    MotorRecord,
    ObjectFlight,
    Touchdown,
    joined_touchdown,
    loads_between,
    loads_of_steps,
    touchdown,
)
from pnt_gym.cells.base.settling import passive_restitution
from pnt_gym.cells.conveyor import scene_kernel
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.swing import springs
from pnt_gym.cells.conveyor.free import FreeObjects, write_models
from pnt_gym.cells.conveyor.hand import HandCycle, ThrowClock
from pnt_gym.cells.conveyor.outcome import Effort, SimulatedThrows
from pnt_gym.cells.conveyor.scene import SENSORS, Scene, build_scene
from pnt_gym.errors import PhysicsError
from pnt_gym.palette import ITEMS
from pnt_gym.robots.joints import CONTROLS, JointMotion, knot_count, qpos_columns, qvel_columns, upsample


@final
@dataclass(frozen=True)
class FullSimulation:
    """N throws simulated with the robot from beginning to end."""

    flown: SimulatedThrows
    flight: ObjectFlight
    hand: Floats
    """Cup tip (N, M, 3) at the start of each step [m]."""
    start: Floats
    """Time on the path's clock at the first step (N,) [s]."""


@final
class ConveyorPlant(Plant[Context, HandCycle, SimulatedThrows]):
    """N simulations of the conveyor cell, with models built from its config."""

    def __init__(self, config: ConveyorConfig, count: int, threads: int = 1) -> None:
        self.config = config
        self.scene: Scene = build_scene(config)
        super().__init__(config, self.scene.model, count, threads)
        self._equalities = self.batch.bind("eq_active")
        self._threads = threads
        self.free = FreeObjects(config, count, threads)
        model, robot = self.scene.model, self.scene.robot
        self._robot_qpos, self._robot_qvel = qpos_columns(model, robot), qvel_columns(model, robot)
        self._motors = np.array([int(model.joint(arm).dofadr[0]) for arm in robot.motor_joints])
        self._torques = np.arange(SENSORS["torque"].start, int(model.nsensordata))
        self._cups = np.array(self.scene.cup_geoms)
        self._cup_halves: Floats = model.geom_size[self._cups, 1]
        """Half lengths of the cylinders of a cup [m]."""
        self._controls = int(model.nu) + int(model.neq)
        swing, grip = self.scene.swing_controls, int(model.nu) + self.scene.grip_equality
        self._held = np.array([grip, *range(swing.start, swing.stop)])
        """Columns of the controls that hold an object: the grip's equality, and the springs of a lip."""
        rows = split_rows(count, threads) if config.fidelity == "full" else []  # flights alone are mostly Python
        self.parts = [(part, ConveyorPlant(config, part.stop - part.start)) for part in rows] if len(rows) > 1 else []
        """Rows and plants that simulate at the same time, one thread each; empty where this plant simulates all."""

    def fly(self, context: Context, plans: HandCycle, cells: Ints | None = None) -> SimulatedThrows:
        """Simulate one throw for each of N picks and motions of the hands.

        A throw whose contacts give its object speed until the engine warns is simulated again with contacts that give
        none, see `passive_restitution`.

        Args:
            context: the picks.
            plans: the motions.
            cells: the cells of the picks, ascending (N,); None for all cells.
        """
        cells = np.arange(len(context.pick)) if cells is None else cells
        if self.record_row is not None and self.record_row in cells:
            self._keep_throw(int(np.searchsorted(cells, self.record_row)), context, plans)
        if self.parts:
            ends = np.searchsorted(cells, [part.stop for part, _ in self.parts])
            shares = zip(pairwise([0, *map(int, ends)]), self.parts, strict=True)
            return concatenate_records(
                call_in_threads(
                    [
                        partial(self._fly_part, slice(first, end), *part, context, plans)
                        for (first, end), part in shares
                        if end > first
                    ]
                )
            )
        clock = ThrowClock.of(context, plans, self.config, self._threads)
        context = context.without_spin(clock.grips.unthrown)
        rows = np.arange(len(context.pick))
        try:
            return compute_by_mask(
                clock.grips.picked, self._simulate_throws, self._results_without_object, rows, context, clock
            )
        except PhysicsError as error:
            return self.fly(self._with_passive_contacts(context, error), plans, cells)

    def _with_passive_contacts(self, context: Context, error: PhysicsError) -> Context:
        """The picks, with contacts that give no speed where the engine warned.

        Raises:
            PhysicsError: the given one, where no contact gives speed.
        """
        objects, warned = context.objects, np.zeros(len(context.pick), dtype=np.bool_)
        warned[list(error.simulations)] = True
        largest = passive_restitution(self.config.timestep)
        gains = warned & (objects.restitution > largest)
        if not gains.any():
            raise error
        return context.replace(objects=objects.replace(restitution=np.where(gains, largest, objects.restitution)))

    def _fly_part(
        self, rows: slice, cells: slice, plant: ConveyorPlant, context: Context, plans: HandCycle
    ) -> SimulatedThrows:
        """Simulate the rows that belong to a part of the cells; an error of the physics says which cells these are."""
        try:
            return plant.fly(take(context, rows), take(plans, rows))
        except PhysicsError as error:
            raise PhysicsError(f"in the part of cells {cells.start} to {cells.stop - 1}: {error}") from error

    def follow(self, context: Context, plans: HandCycle) -> FullSimulation:
        """Simulate throws as `fly`, with the robot to the end and with the hand's positions recorded."""
        clock, rows = ThrowClock.of(context, plans, self.config), np.arange(len(context.pick))
        context = context.without_spin(clock.grips.unthrown)
        self.write(context, rows, clock)
        return self._record_to_the_end(rows, context, clock)

    def write(self, context: Context, rows: Ints | None = None, clock: ThrowClock | None = None) -> None:
        """Set up simulations for N throws: robot with closed loops at the pick, object under the cup.

        Args:
            context: the N picks.
            rows: the simulations of the picks; None for all.
            clock: paths of the throws, which may begin in motion; None for hands at rest at the picks.
        """
        batch, scene, o = self.batch, self.scene, context.objects
        rows = np.arange(len(context.pick)) if rows is None else rows
        write_models(batch, rows, scene, context, self.config)
        batch.expand("geom_rgba")[rows, scene.object_geom] = ITEMS.take(o.kind, axis=0, mode="wrap")
        # The grip points of the objects, and the lips and radii of the cups.
        batch.expand("site_pos")[rows, scene.grip_site] = -context.arm
        if self.config.swings:
            # The lips' springs, about the axes of the objects that hang at rest.
            spring = springs(context, self.config) if clock is None or clock.spring is None else clock.spring
            batch.expand("site_quat")[rows, scene.tcp_site] = o.attitude
            gains = batch.expand("actuator_gainprm")
            gains[rows, scene.swing, 1], gains[rows, scene.swing, 2] = -spring.stiffness, -spring.damping
        else:
            batch.expand("site_quat")[rows, scene.grip_site] = yaw_attitude(-o.yaw)
        if self.config.cup.fitted:
            fields = scene_kernel.CupFields(*map(batch.expand, scene_kernel.CUP_FIELDS))
            bounds = np.hypot(o.cup_radius[:, None], self._cup_halves)
            inputs = in_order(rows, self._cups, o.cup_radius, self._cup_halves, bounds)
            scene_kernel.widen_cups(*inputs, fields)
        batch.set_const(simulation_ids(batch, rows))
        batch.state[rows] = 0.0
        cup, first, qpos = context.pick + context.cup_offset, scene.object_qpos, np.zeros((len(rows), scene.model.nq))
        if clock is not None and self.config.belt.tracking:
            begin = clock.hand(np.zeros(1, dtype=np.int64))
            cup, velocity = begin.position[:, 0], begin.velocity[:, 0]
            qvel = np.zeros((len(rows), scene.model.nv))
            qvel[:, self._robot_qvel] = scene.robot.rates(cup, velocity)
            qvel[:, scene.object_qvel : scene.object_qvel + 3] = velocity
            self.qvel[rows] = qvel
        qpos[:, self._robot_qpos] = scene.robot.pose(cup)
        qpos[:, first : first + 2] = cup[:, :2] + context.grasp
        qpos[:, first + 2] = cup[:, 2] - o.com_depth
        qpos[:, first + 3 : first + 7] = o.attitude
        self.qpos[rows], self._equalities[rows] = qpos, 1.0

    def _simulate_throws(self, rows: Ints, context: Context, clock: ThrowClock) -> SimulatedThrows:
        """Simulate the throws of some rows at the config's fidelity."""
        if self.config.fidelity == "full":
            return self._simulate_with_robot(rows, context, clock)
        # Objects that may have touched something in a swing need the robot; most still fall clear, so not to the end.
        return compute_by_mask(
            clock.parting.unsure, self._simulate_with_robot, self._simulate_flights, rows, context, clock
        )

    def _results_without_object(self, rows: Ints, context: Context, clock: ThrowClock) -> SimulatedThrows:
        """Results of failed picks: NaN landings, because the object stays on the belt, and planned efforts."""
        count = len(rows)
        nowhere, no = np.full((count, 3), np.nan), np.full(count, False)
        down = Touchdown(nowhere[:, :2].copy(), nowhere, nowhere.copy(), no)
        effort = self._effort_of_plan(clock, np.zeros(count, dtype=np.int64))
        return SimulatedThrows(down, np.zeros(count), effort, clock.grips)

    def _simulate_with_robot(self, rows: Ints, context: Context, clock: ThrowClock) -> SimulatedThrows:
        """Simulate throws with the robot until objects are clear, then without; to the end where the cup may touch."""
        self.write(context, rows, clock)
        clear, scene = clock.clear(context), self.scene
        robot_record = self._roll_out_robot(rows, context, clock, clear)
        qpos, qvel = self.qpos[rows], self.qvel[rows]
        place, rate = qpos[:, scene.object_qpos :][:, :7], qvel[:, scene.object_qvel :][:, :6]
        fallen = self.free.fall(rows, context, place, rate, clock.end - clear)
        moments = slice(0, max(fallen.steps.tolist()), clock.stride)
        sensors = fallen.sensors[:, moments]
        position, velocity = sensors[..., SENSORS["object_position"]], sensors[..., SENSORS["object_velocity"]]
        attitude = fallen.attitude[:, moments]
        unsure = clock.may_meet(context, (position, velocity, attitude), clear, fallen.steps)
        records, cup = in_order(robot_record["sensordata"], fallen.sensors), SENSORS["cup_contact"].start
        down = joined_touchdown(*records, clear, fallen.steps, clock.release, cup, context.target)
        first, then = self._effort(robot_record, clear, clock.step), self._effort_of_plan(clock, clear)
        effort = Effort(np.maximum(first.torque, then.torque), first.energy + then.energy)
        astray = _tracking_error(robot_record["sensordata"], clock)
        flown = SimulatedThrows(down, astray, effort, clock.grips)
        return recompute_rows(flown, unsure, self._simulate_to_the_end, rows, context, clock)

    def _simulate_flights(self, rows: Ints, context: Context, clock: ThrowClock) -> SimulatedThrows:
        """Simulate flights after planned hand motions, and with the robot where the cup touches the object again."""
        calls: list[Callable[[], Any]] = [
            partial(self.free.predict_landings, context, clock),
            partial(self._effort_of_plan, clock, np.zeros_like(rows)),
        ]
        (down, touched), effort = call_in_threads(calls, self._threads)
        flown = SimulatedThrows(down, np.zeros(len(rows)), effort, clock.grips)
        return recompute_rows(flown, touched, self._simulate_to_the_end, rows, context, clock)

    def _simulate_to_the_end(self, rows: Ints, context: Context, clock: ThrowClock) -> SimulatedThrows:
        """Set up and simulate the throws of some rows with the robot to the end."""
        self.write(context, rows, clock)
        return self._record_to_the_end(rows, context, clock).flown

    def _keep_throw(self, index: int, context: Context, plans: HandCycle) -> None:
        """Keep a recording of the throw at an index of the picks, which is that of the recorded cell."""
        context, plans, row = take(context, [index]), take(plans, [index]), np.array([self.record_row])
        clock, plan = ThrowClock.of(context, plans, self.config), plans.release
        context = context.without_spin(clock.grips.unthrown)
        self.write(context, row, clock)
        control = self._references(row, context, clock, clock.end)
        flight = plan.position[0], plan.velocity[0], plan.flight_time[0]
        self.record_throw(self.scene.object_body, control[0], flight, context.target[0])

    def _roll_out_robot(self, rows: Ints, context: Context, clock: ThrowClock, until: Ints) -> dict[str, Floats]:
        """Roll out some rows with the robot up to a step of each (N,), where they stay; returns the recorded fields."""
        control = self._references(rows, context, clock, until)
        return roll_out(self.batch, control, until, ("sensordata", "qvel"), rows)

    def _record_to_the_end(self, rows: Ints, context: Context, clock: ThrowClock) -> FullSimulation:
        """Simulate the throws of some rows, which are already set up, with the robot to the end."""
        record = self._roll_out_robot(rows, context, clock, clock.end)
        sensors = record["sensordata"]
        motion = in_order(sensors[..., SENSORS["object_position"]], sensors[..., SENSORS["object_velocity"]])
        touches = touching(sensors[..., SENSORS["cup_contact"]]), touching(sensors[..., SENSORS["any_contact"]])
        flight = ObjectFlight(*motion, *touches, release_step=clock.release, last_step=clock.end - 1)
        effort, astray = self._effort(record, clock.end, clock.step), _tracking_error(sensors, clock)
        flown = SimulatedThrows(touchdown(flight, context.target), astray, effort, clock.grips)
        return FullSimulation(flown, flight, sensors[..., SENSORS["hand_position"]], -clock.path_delay)

    def _effort(self, record: dict[str, Floats], end: Ints, step: float) -> Effort:
        """Effort of the motors in recorded fields (N, M, columns), up to a step of each (N,)."""
        motors = MotorRecord(record["sensordata"], self._torques, record["qvel"], self._motors)
        return Effort(*loads_of_steps(motors, end, step))

    def _effort_of_plan(self, clock: ThrowClock, clear: Ints) -> Effort:
        """Effort of the motors in the planned motions from a step of each on (N,), without the object's mass."""
        ahead = clock.end - clear
        last = -(-max(ahead.tolist()) // clock.stride) * clock.stride
        steps = np.minimum(np.arange(0, last + 1, clock.stride, dtype=np.int64), ahead[:, None])
        knots = self.scene.robot.motion(*clock.hand(clear[:, None] + steps)).within_reach()
        return Effort(*loads_between(*in_order(knots.torque, knots.velocity, steps * clock.step)))

    def _references(self, rows: Ints, context: Context, clock: ThrowClock, until: Ints) -> Floats:
        """Controls (N, M, nu + neq) of some rows: motors, spin and grip, every other equality active.

        Those of a row are written up to a step of the row (N,).
        """
        steps = max(until.tolist())
        control = np.empty((len(rows), steps, self._controls))
        stride = clock.stride
        at = np.arange(knot_count(steps, stride), dtype=np.int64) * stride
        # After its last step the reference of a row stays constant; without that a hand that rides with the belt would
        # ride on until the longest throw ends, out of reach. Interpolation up to the end needs one more knot behind it.
        hand = clock.hand(np.minimum(at, until[:, None] + stride))
        knots = self.scene.robot.motion(*hand).within_reach()
        weak = 1.0 - self.config.mismatch * self.config.spread.feedforward
        knots = JointMotion(knots.position, knots.velocity, knots.acceleration, knots.torque * weak)
        upsample(knots, stride * clock.step, stride, control, until)
        motors = CONTROLS * len(knots.position)
        scene_kernel.hold_until(clock.release, motors, int(self.scene.model.nu), self._held, control, until)
        torque = context.objects.inertia * turn_back(context.objects.spin, *context.objects.turn) / clock.step
        # The object gets its spin in the step of its release: torque = inertia x spin / step.
        control[np.arange(len(rows)), clock.release, self.scene.spin_controls] = torque
        push = context.objects.mass * clock.parting.push / clock.step
        control[np.arange(len(rows)), clock.release, self.scene.push_controls] = push[:, None]
        return control


def _tracking_error(sensors: Floats, clock: ThrowClock) -> Floats:
    """Distance of the recorded hands (N, M, columns) from their references at the moment of release (N,) [m]."""
    planned = clock.path.sample(clock.free_at[:, None]).position[:, 0] + clock.offset
    return length(sensors[np.arange(len(planned)), clock.release][:, SENSORS["hand_position"]] - planned)
