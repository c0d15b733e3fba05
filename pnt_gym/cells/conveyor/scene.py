"""The conveyor cell as MuJoCo models: belt, bins and the thrown object, with the robot and its cup or without.

All values that differ between throws (the object's shape, size, mass and drag, a bin drawn per throw) are fields of the
model that the plant overwrites per simulation; the models are compiled once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import CUP_RADIUS
from pnt_gym.cells.base.sorting import Bins
from pnt_gym.cells.base.stage import (
    BELT_THICKNESS,
    SURROUNDINGS_SOLREF,
    add_contact_sensor,
    add_floor,
    add_free_object,
    add_motion_sensors,
    add_place_sensor,
    add_torque_sensors,
    light_stage,
)
from pnt_gym.cells.conveyor import scene_kernel
from pnt_gym.cells.conveyor.arm import arm_of
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.robot import RobotSheet
from pnt_gym.constants import AIR_DENSITY, AIR_VISCOSITY
from pnt_gym.engine import MjModel, MjSpec, mujoco
from pnt_gym.palette import BELT, BINS, HAND, LIP
from pnt_gym.robots.arm.model import add_serial_arm
from pnt_gym.robots.joints import RobotModel
from pnt_gym.robots.rails.model import add_rails
from pnt_gym.robots.specification import LOOP_SOLIMP, LOOP_SOLREF, set_options
from pnt_gym.robots.t3kr.model import add_t3kr

CUP_LENGTH: Final = 0.050
FLOOR_DROP: Final = 0.02
"""Distance of the floor below the bins' bottoms [m]."""

BOTTOM_PANEL: Final = 4
"""Index of the bottom among the panels of a bin."""

_OBJECT_BIT, _CUP_BIT = 1, 2

SENSORS: Final = {
    "object_position": slice(0, 3),
    "object_velocity": slice(3, 6),
    "any_contact": slice(6, 8),
    "hand_position": slice(8, 11),
    "cup_contact": slice(11, 13),
    "torque": slice(13, None),
}
"""Columns of sensordata; without the robot only the object's. A contact is (number, smallest distance [m]).

A robot of M motors has M torques."""


@dataclass(frozen=True)
class Surroundings:
    """A compiled cell, with the robot or without, and the ids of the object and of the bins."""

    model: MjModel
    object_body: int
    object_geom: int
    object_qpos: int
    object_qvel: int
    bin_bodies: tuple[int, ...]
    bin_geoms: tuple[int, ...]
    """The first panel of each bin, before its other panels."""
    has_draught: bool
    """Whether the air of the cell moves in some throws."""


@final
@dataclass(frozen=True)
class Scene(Surroundings):
    """A compiled cell with the robot, and the ids of the grip, of the cup and of their actuators."""

    robot: RobotModel
    grip_site: int
    grip_equality: int
    spin_controls: slice
    cup_geoms: tuple[int, ...]
    """Solid part of the cup, and the lip if it is compliant."""
    tcp_site: int
    swing: slice
    """Actuators that act as the lip's spring about three axes; empty for a rigid lip."""
    swing_controls: slice
    push_controls: slice
    """Controls of the actuator that stands for blown air; empty without blown air."""


def build_scene(config: ConveyorConfig, rods: str = "four") -> Scene:
    """Compile the cell with its robot.

    Args:
        config: the cell.
        rods: "four" (the default) or "eight" rods in the robot.
    """
    spec = _empty_stage(config)
    robot = add_robot(spec, config.robot, rods)
    add_cup(spec, config.lip_length)
    _add_object_and_bins(spec, config)
    _add_grip(spec, config)
    add_motion_sensors(spec)
    add_contact_sensor(spec, mujoco.mjtObj.mjOBJ_GEOM, "object")
    # Add the sensors of the hand, in the order and widths of `SENSORS`.
    add_place_sensor(spec, robot.tcp)
    add_contact_sensor(spec, mujoco.mjtObj.mjOBJ_GEOM, "object", "cup")
    add_torque_sensors(spec, robot.actuators)
    model = spec.compile()
    swing = _actuators(model, "swing_x", 3 * config.swings)
    return Scene(
        **_ids(model, config),
        robot=robot,
        grip_site=model.site("grip").id,
        grip_equality=model.equality("grip").id,
        spin_controls=_controls(model, _actuators(model, "spin_x", 3)),
        cup_geoms=tuple(model.geom(part).id for part in ("cup", "lip")[: 1 + config.swings]),
        tcp_site=model.site(robot.tcp).id,
        swing=swing,
        swing_controls=_controls(model, swing),
        push_controls=_controls(model, _actuators(model, "push", int(config.pushes))),
    )


def add_robot(spec: MjSpec, sheet: RobotSheet, rods: str = "four") -> RobotModel:
    """Add the robot of a sheet, or its stand-in where only the sheet is known."""
    if sheet.model is not None:
        return add_serial_arm(spec, arm_of(sheet))
    return add_t3kr(spec, rods="eight" if rods == "eight" else "four") if sheet.has_model else add_rails(spec)


def _actuators(model: MjModel, first: str, count: int) -> slice:
    """Indices of `count` actuators from the one named `first` on; for 0 the name need not exist."""
    start = int(model.actuator(first).id) if count > 0 else 0
    return slice(start, start + count)


def _controls(model: MjModel, actuators: slice) -> slice:
    """Columns of the controls of actuators with one control each."""
    start = int(model.actuator_ctrladr[actuators.start])
    return slice(start, start + actuators.stop - actuators.start)


def build_free_scene(config: ConveyorConfig) -> Surroundings:
    """Compile the cell without its robot."""
    spec = _empty_stage(config)
    _add_object_and_bins(spec, config)
    add_motion_sensors(spec)
    add_contact_sensor(spec, mujoco.mjtObj.mjOBJ_GEOM, "object")
    return Surroundings(**_ids(spec.compile(), config))


def bin_panels(size: Floats, bins: Bins) -> scene_kernel.Panels:
    """Half extents and centres of a bin's five panels, relative to the centre of its opening.

    Args:
        size: inner opening along x and y (N, 2) [m].
        bins: depth and wall thickness.
    """
    panels = scene_kernel.Panels(*np.empty((2, len(size), scene_kernel.PANELS, 3)))
    scene_kernel.bin_panels(np.ascontiguousarray(size), bins.depth, bins.wall, panels)
    return panels


def _bin_places(config: ConveyorConfig) -> list[tuple[float, float, tuple[float, float]]]:
    """Centre and opening of each modelled bin; a random bin starts at the middle of its range."""
    bins = config.bins
    if bins.random is None:
        return [(b.x, b.y, b.size) for b in bins.fixed]
    r = bins.random
    return [(sum(r.x) / 2, sum(r.y) / 2, (r.side[1], r.side[1]))]


def _empty_stage(config: ConveyorConfig) -> MjSpec:
    """A model with air, light, floor and belt, without object and bins."""
    spec = mujoco.MjSpec()
    # Air is unmodelled by the planner: there is none at mismatch 0.
    set_options(spec, config.timestep, density=AIR_DENSITY * config.mismatch, viscosity=AIR_VISCOSITY * config.mismatch)
    light_stage(spec, ambient=0.35, diffuse=0.45)
    spec.worldbody.add_light(pos=[0.6, -1.4, 1.6], dir=[-0.3, 0.6, -1.0], diffuse=np.full(3, 0.5))
    add_ground(spec, config, 3.0)
    return spec


def _add_object_and_bins(spec: MjSpec, config: ConveyorConfig) -> None:
    """Add the bins, and a free body whose frame is at its centre of mass, with one geom of any shape."""
    # Mass, inertia and size stand in until the plant writes those of each object.
    add_free_object(
        spec,
        0.02,
        1e-5,
        0.03,
        contype=_OBJECT_BIT,
        conaffinity=_OBJECT_BIT | _CUP_BIT,
        condim=6,  # without rolling friction a round object rolls off anything
        priority=1,  # the item's friction and rebound count, not those of the surroundings
    )
    add_bins(spec, config)


def _ids(model: MjModel, config: ConveyorConfig) -> dict[str, Any]:
    """The fields of `Surroundings`."""
    joint, bins = model.joint("object"), [model.body(f"bin_{i}").id for i in range(len(_bin_places(config)))]
    return {
        "model": model,
        "object_body": model.body("object").id,
        "object_geom": model.geom("object").id,
        "object_qpos": int(joint.qposadr[0]),
        "object_qvel": int(joint.dofadr[0]),
        "bin_bodies": tuple(bins),
        "bin_geoms": tuple(int(model.body_geomadr[body]) for body in bins),
        "has_draught": config.drift.draught.moves,
    }


def floor_height(config: ConveyorConfig) -> float:
    """Height of the floor [m]."""
    bins = config.bins
    return min(bins.rim - bins.depth - bins.wall - FLOOR_DROP, config.belt.height - 0.3)


def add_ground(spec: MjSpec, config: ConveyorConfig, half: float) -> None:
    """Add belt and floor; the floor is drawn `half` [m] to every side."""
    add_floor(spec, floor_height(config), half, solref=SURROUNDINGS_SOLREF)
    belt = config.belt
    spec.worldbody.add_geom(
        name="belt",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[(belt.x[1] - belt.x[0]) / 2, (belt.y[1] - belt.y[0]) / 2, BELT_THICKNESS / 2],
        pos=[sum(belt.x) / 2, sum(belt.y) / 2, belt.height - BELT_THICKNESS / 2],
        rgba=BELT,
        surfacevel=[belt.speed, 0, 0, 0, 0, 0],
        solref=SURROUNDINGS_SOLREF,
    )


def add_cup(spec: MjSpec, lip: float) -> None:
    """Add the cup, which collides with the object after the release, too.

    A compliant lip of a length `lip` [m] collides with nothing and is only drawn.
    """
    # The solid cup begins where the lip ends.
    parts = [("cup", lip, CUP_LENGTH, _CUP_BIT, HAND)]
    if lip > 0.0:
        parts.append(("lip", 0.0, lip, 0, LIP))
    for name, low, high, touches, colour in parts:
        spec.body("platform").add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[CUP_RADIUS, (high - low) / 2, 0],
            pos=[0, 0, (low + high) / 2],
            rgba=colour,
            mass=0,
            contype=touches,
            conaffinity=0,
            group=2,
        )


def _add_grip(spec: MjSpec, config: ConveyorConfig) -> None:
    """Add the constraint that holds the object, rigidly or at the lip, and the actuators for spin and push."""
    spec.body("object").add_site(name="grip", size=[0.004, 0.004, 0.004], group=4)
    spec.add_equality(
        name="grip",
        # A compliant lip holds the object's place and lets the object turn.
        type=mujoco.mjtEq.mjEQ_CONNECT if config.swings else mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        name1="tcp",
        name2="grip",
        solref=LOOP_SOLREF,
        solimp=LOOP_SOLIMP,
    )
    for axis, gear in (("x", 3), ("y", 4), ("z", 5)):
        motor = spec.add_actuator(
            name=f"spin_{axis}", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="object", gear=np.eye(6)[gear]
        )
        motor.set_to_motor()
    if config.swings:
        # Add the lip as a spring and damper about three axes of the hand.
        for axis, gear in (("x", 3), ("y", 4), ("z", 5)):
            spring = spec.add_actuator(
                name=f"swing_{axis}",
                trntype=mujoco.mjtTrn.mjTRN_SITE,
                target="grip",
                refsite="tcp",
                gear=np.eye(6)[gear],
            )
            spring.set_to_motor()
            spring.gaintype = mujoco.mjtGain.mjGAIN_AFFINE
            spring.gainprm = np.zeros(10)
    if config.pushes:
        push = spec.add_actuator(name="push", trntype=mujoco.mjtTrn.mjTRN_JOINT, target="object", gear=-np.eye(6)[2])
        push.set_to_motor()


def add_bins(spec: MjSpec, config: ConveyorConfig) -> None:
    """Add the bodies `bin_0`, `bin_1` and so on, each with the panels of `bin_panels`."""
    for index, (x, y, size) in enumerate(_bin_places(config)):
        centre = (x, y)
        body = spec.worldbody.add_body(name=f"bin_{index}", pos=[*centre, config.bins.rim])
        half, middle = bin_panels(np.array([size]), config.bins)
        for k in range(5):
            body.add_geom(
                name=f"bin_{index}_{k}",
                type=mujoco.mjtGeom.mjGEOM_BOX,
                size=half[0, k],
                pos=middle[0, k],
                rgba=BINS[index % len(BINS)],
                solref=SURROUNDINGS_SOLREF,
            )
