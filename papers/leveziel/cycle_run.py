"""Simulation of the cork's cycle of Leveziel et al. (Fig. 8): down, close, up, across, open, back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, in_order
from pnt_gym.cells.base.plant import Recording, roll_out, touching
from pnt_gym.cells.base.recorded import MotorRecord
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig, Table, Tray
from pnt_gym.cells.gripper.motion import TossPlans, ease
from pnt_gym.cells.gripper.outcome import Outcome, RecordedThrows, judge
from pnt_gym.cells.gripper.plant import GripperPlant
from pnt_gym.cells.gripper.scene import SENSORS
from pnt_gym.robots.gripper import MOTOR_SPEED, JointLimits
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD
from pnt_gym.robots.gripper.references import closed_pose, motor_references

from .motion import joint_move

RISE, ACROSS = 0.050, 0.070
"""Displacements along z and y [m] (section VI-B)."""
HEIGHT: Final = -0.197
"""z of the platform on the way across, which is not published [m]: the pads then grip 2 mm above the table."""
PHASES: Final = ("lower", "close", "lift", "across", "stand", "open", "back", "rest")
PAUSE: Final = 0.040
"""Standstill above the drop before and after the claws open [s]."""
REST: Final = 0.120
"""Simulated time after the robot's return [s], so that the cork comes to rest."""


class Course(NamedTuple):
    """The commanded course of a cycle."""

    pose: Floats
    """Poses (M, 4), one per physics step: x, y, z [m], theta [rad]."""
    phases: dict[str, slice]
    """Steps of every phase."""
    ends: dict[str, float]
    """End of every phase [s]."""


@final
@dataclass(frozen=True)
class Cycles:
    """N simulated cycles, M steps each."""

    config: GripperConfig
    plans: TossPlans
    """Plans whose motion from grip to drop takes as long as lift and way across together."""
    course: Course
    angle: Floats
    """Motor angles (N, M, 4) [rad]."""
    platform: Floats
    """Simulated poses of the platform (N, M, 4): x, y, z [m], theta [rad]."""
    force: Floats
    """Force of the right and the left finger's spring at its pad (N, M, 2) [N]."""
    cork: Floats
    """Middle of the cork (N, M, 3) [m]."""
    pads: Bools
    """Whether the right and the left pad touch the cork (N, M, 2)."""
    torque: Floats
    """Motor torques (N, M, 4) [N m]."""
    outcome: Outcome
    recording: Recording
    """Recording of the first cycle."""

    @property
    def time(self) -> Floats:
        """Time of every step (M,) [s]."""
        return np.asarray(np.arange(len(self.course.pose)) * self.config.timestep, dtype=np.float64)

    def phase_steps(self, phase: str) -> slice:
        """Steps of a phase."""
        return self.course.phases[phase]


def cycle_config(mismatch: float) -> GripperConfig:
    """Configuration of the cell: a table below the pick, and a box for corks 70 mm away along y."""
    y = 0.5 * ACROSS
    return GripperConfig.load(
        "drop",
        name="cork cycle",
        mismatch=mismatch,
        items=("cork",),
        table=Table(x=(-0.06, 0.06), y=(-0.085, -0.005), pick_x=(0.0, 0.0), pick_y=(-y, -y)),
        tray=Tray(x=0.0, y=y, rim=-0.345),
        motion={"drop_height": HEIGHT, "rest": PAUSE},
    )


def run_cycles(count: int, *, mismatch: float, share: float, seed: int = 0) -> Cycles:
    """Simulate cycles in one batch.

    Args:
        count: number of cycles N.
        mismatch: strength of the effects that the planner does not model.
        share: share of the motors' largest speed, 70 rpm, at which the moves are commanded.
        seed: seed of the hidden values; each row draws from its own generator.
    """
    config = cycle_config(mismatch)
    cell = GripperCell(config, count)
    cell.reset(np.arange(count), [np.random.default_rng([seed, row]) for row in range(count)])
    context, plant = cell.context, cell.plant
    way = course(config, context.plans, share)
    plans = replace(context.plans, move_time=np.full(count, way.ends["across"] - way.ends["close"]))
    plant.write(context, plans)
    begin = closed_pose(way.pose[0])
    plant.batch.bind("qpos")[:, : len(begin)] = begin
    state = plant.batch.state[0].copy()
    control = _controls(plant, way, context.hidden.delay)
    steps = np.full(count, len(way.pose))
    record = roll_out(plant.batch, control, steps, ("sensordata", "qpos", "qvel"))
    # The simulator's times count from the moment the claws begin to close.
    closing = way.phases["close"].start
    sensordata = record["sensordata"]
    closed, rates = in_order(sensordata[:, closing:], record["qvel"][:, closing:])
    throws = MotorRecord(closed, plant.torques, rates, plant.motors)
    flown = RecordedThrows.of(throws, plans, steps - closing - 1, config.timestep)
    contact = sensordata[..., SENSORS["pad_contact"]].reshape(*control.shape[:2], 2, 2)
    qpos, claws = record["qpos"], PROTOTYPE_BUILD.claws
    return Cycles(
        config=config,
        plans=plans,
        course=way,
        angle=qpos[..., 0:12:3],
        platform=qpos[..., 12:16],
        force=np.abs(qpos[..., [16, 18]]) * claws.stiffness / claws.length,
        cork=sensordata[..., SENSORS["object_position"]],
        pads=touching(contact),
        torque=sensordata[..., SENSORS["torque"]],
        outcome=judge(flown, plans, config, cell.planner.return_time(plans)),
        recording=Recording(
            plant.batch.get_model(0), plant.scene.object_body, state, control[0], np.zeros((0, 3)), plans.target[0]
        ),
    )


def course(config: GripperConfig, plans: TossPlans, share: float) -> Course:
    """The commanded course by the first plan; all moves are joint-linear with trapezoidal speeds."""
    step, low, over = config.timestep, plans.pick[0], plans.release[0]
    high = low + np.array([0.0, 0.0, RISE])
    wide, shut, _, released = plans.theta[0]
    hold = float(plans.grip_time[0] - plans.closing[0])
    stand_poses = np.tile([*over, shut], (round(PAUSE / step), 1))
    rest_poses = np.tile([*high, wide], (round(REST / step), 1))
    legs = (
        _move_poses(np.append(high, wide), np.append(low, wide), share, step),
        _turn_poses(low, (wide, shut), float(plans.closing[0]), hold, step),
        _move_poses(np.append(low, shut), np.append(high, shut), share, step),
        _move_poses(np.append(high, shut), np.append(over, shut), share, step),
        stand_poses,
        _turn_poses(over, (shut, released), float(plans.opening[0]), PAUSE, step),
        _move_poses(np.append(over, released), np.append(high, wide), share, step),
        rest_poses,
    )
    ends = np.cumsum([len(leg) for leg in legs]).tolist()
    phases: dict[str, slice] = dict(zip(PHASES, map(slice, (0, *ends), ends), strict=True))
    return Course(np.concatenate(legs), phases, {name: rows.stop * step for name, rows in phases.items()})


def _move_poses(start: Floats, end: Floats, share: float, step: float) -> Floats:
    """Poses (K, 4) of a joint-linear move, one per step; the move's time is rounded up to whole steps."""
    fastest = joint_move(start, end).duration / share
    count = int(np.ceil(fastest / step))
    limits = JointLimits(MOTOR_SPEED * share * fastest / (count * step))
    return joint_move(start, end, limits=limits, samples=count + 1).pose[:-1]


def _turn_poses(place: Floats, angles: tuple[float, float], time: float, hold: float, step: float) -> Floats:
    """Poses (K, 4), one per step, in which the halves turn at one place and then rest."""
    share: Floats = np.asarray(np.arange(round((time + hold) / step)) * step / time, dtype=np.float64)
    progress = ease(share)
    theta = angles[0] + progress * (angles[1] - angles[0])
    return np.column_stack([np.tile(place, (theta.size, 1)), theta])


def _controls(plant: GripperPlant, way: Course, delay: Floats) -> Floats:
    """References and active equalities (N, M, nu + neq); the claws of row i open late by ``delay[i]`` [s]."""
    config, model = plant.config, plant.scene.model
    pose = np.repeat(way.pose[None], len(delay), axis=0)
    steps = np.arange(len(way.pose), dtype=np.int64)
    opening = way.phases["open"]
    delayed_steps: Ints = np.clip(
        steps - np.round(delay / config.timestep).astype(np.int64)[:, None], opening.start, opening.stop - 1
    )
    pose[:, opening, 3] = way.pose[delayed_steps[:, opening], 3]
    share = 1.0 - config.mismatch * config.errors.feedforward
    references = motor_references(pose, config.timestep, payload=config.item_list()[0].mass, share=share)
    control = np.ones((len(delay), len(way.pose), int(model.nu) + int(model.neq)))
    control[..., : int(model.nu)] = references.controls()
    return control
