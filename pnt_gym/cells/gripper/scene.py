"""MuJoCo model of the gripper robot's cell: robot, table, tray and the object that is picked and thrown.

Fields that differ between throws (shape, size and mass of the object) are overwritten per simulation by the plant; the
model is compiled once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
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
from pnt_gym.cells.gripper.config import GripperConfig, Tray
from pnt_gym.constants import AIR_DENSITY, AIR_VISCOSITY
from pnt_gym.engine import MjModel, MjSpec, mujoco
from pnt_gym.palette import BELT, BINS, FRAME, TABLE
from pnt_gym.robots.gripper.model import PAD_BIT, Gripper4Handles, add_gripper, set_options

SENSORS: Final = {
    "object_position": slice(0, 3),
    "object_velocity": slice(3, 6),
    "hand_position": slice(6, 9),
    "pad_contact": slice(9, 13),
    "any_contact": slice(13, 15),
    "torque": slice(15, 19),
}
"""Columns of sensordata. A contact is (number found, smallest distance [m]); the pads have one each."""
TABLE_THICKNESS: Final = 0.010
FLOOR: Final = -0.52
"""Height of the floor under table and tray [m]; lower for a deep tray."""

_OBJECT_BIT = 1
_LARGEST = 0.05
"""Half extent of the object's geom at compile time, an upper bound of all objects; larger for larger items [m]."""
_FLOOR_DROP = 0.03
"""Least distance of the floor below the tray [m]."""
_TOLERANCE = 1e-8
"""Tolerance of the solver; a hundredth of this value changes landings by micrometres."""


@final
@dataclass(frozen=True)
class Scene:
    """The compiled cell and the ids that the plant needs."""

    model: MjModel
    robot: Gripper4Handles
    table: int
    """Geom of the table, or of the belt."""
    object_body: int
    object_geom: int
    object_qpos: int
    """Address of the object's position; its quaternion follows."""
    pads: tuple[int, int]


def build_scene(config: GripperConfig) -> Scene:
    """Compile the model of the cell.

    Args:
        config: level of the cell.
    """
    spec = mujoco.MjSpec()
    m = config.mismatch
    # Air is unmodelled by the planner: there is none at mismatch 0.
    set_options(spec, config.timestep, density=AIR_DENSITY * m, viscosity=AIR_VISCOSITY * m)
    dimensions, build = config.robot.parts()
    floor = min(FLOOR, config.tray.rim - config.tray.depth - config.tray.wall - _FLOOR_DROP)
    _add_stage(spec, floor, config.robot.size)
    _add_table(spec, config, floor)
    add_bins(spec, config, floor)
    robot = add_gripper(spec, dimensions, build)
    # Bounds are compiled once, so they hold the largest of all items.
    # Add a free body whose frame is at its centre of mass, with one geom of any shape.
    half = max(_LARGEST, *(max(item.size) for item in config.item_list()))
    # Mass, inertia and size stand in until the plant writes those of each object.
    add_free_object(
        spec,
        0.005,
        1e-6,
        half,
        contype=_OBJECT_BIT,
        conaffinity=PAD_BIT,
        condim=3,
        friction=[0.5, 0.005, 0.0001],
        solref=SURROUNDINGS_SOLREF,
        group=2,
    )
    _add_sensors(spec, robot)
    spec.option.tolerance = _TOLERANCE
    model = spec.compile()
    right, left = (model.geom(name).id for name in robot.pads)
    return Scene(
        model=model,
        robot=robot,
        table=model.geom("table").id,
        object_body=model.body("object").id,
        object_geom=model.geom("object").id,
        object_qpos=int(model.joint("object").qposadr[0]),
        pads=(right, left),
    )


def tray_panels(tray: Tray, count: int) -> tuple[Floats, Floats]:
    """Half extents (P, 3) and centres (P, 3) of the tray's walls and bottom, in the world [m]."""
    centres, (x, y), wall = tray.centres(count), tray.opening, tray.wall
    middle, high = tray.rim - tray.depth / 2.0, tray.depth / 2.0
    # A compartment for each item, and a wall before, between and after them.
    length = count * (y + wall) + wall
    half, centre = [(x / 2.0 + wall, length / 2.0, wall / 2.0)], [(tray.x, tray.y, tray.rim - tray.depth - wall / 2.0)]
    for side in (-1.0, 1.0):
        half.append((wall / 2.0, length / 2.0, high))
        centre.append((tray.x + side * (x + wall) / 2.0, tray.y, middle))
    for place in (*(centres[:, 1] - (y + wall) / 2.0), centres[-1, 1] + (y + wall) / 2.0):
        half.append((x / 2.0, wall / 2.0, high))
        centre.append((tray.x, float(place), middle))
    return np.array(half), np.array(centre)


def _add_stage(spec: MjSpec, floor: float, size: float) -> None:
    """Add light, floor and sky for a robot of a size over the prototype's."""
    half = max(1.0, 0.6 * size)
    light_stage(spec)
    # In extents of the model; the camera comes close to a robot of half a metre.
    spec.visual.map.znear = 0.005
    spec.worldbody.add_light(pos=size * np.array([0.4, -0.8, 0.7]), dir=[-0.3, 0.7, -0.9], diffuse=np.full(3, 0.45))
    add_floor(spec, floor, half, contype=0, conaffinity=_OBJECT_BIT, solref=SURROUNDINGS_SOLREF, group=1)


def _add_table(spec: MjSpec, config: GripperConfig, floor: float) -> None:
    table, moving = config.table, config.table.speed > 0.0
    thickness = BELT_THICKNESS if moving else TABLE_THICKNESS
    half = np.array([table.x[1] - table.x[0], table.y[1] - table.y[0], thickness]) / 2.0
    spec.worldbody.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=half,
        pos=[sum(table.x) / 2.0, sum(table.y) / 2.0, table.height - thickness / 2.0],
        rgba=BELT if moving else TABLE,
        surfacevel=[*(table.speed * table.travel), 0, 0, 0],
        contype=0,
        conaffinity=_OBJECT_BIT,
        solref=SURROUNDINGS_SOLREF,
        group=1,
    )
    _add_post(spec, (sum(table.x) / 2.0, sum(table.y) / 2.0), (floor, table.height - thickness), config.robot.size)


def _add_post(spec: MjSpec, place: tuple[float, float], z: tuple[float, float], size: float) -> None:
    """Add a post under table or tray, for pictures only."""
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        fromto=[*place, z[0], *place, z[1]],
        size=[0.012 * size, 0, 0],
        rgba=FRAME,
        contype=0,
        conaffinity=0,
        group=1,
    )


def add_bins(spec: MjSpec, config: GripperConfig, floor: float) -> None:
    """Add the tray, whose compartments are the bins, and its post."""
    tray, count = config.tray, len(config.items)
    body = spec.worldbody.add_body(name="tray")
    _add_post(spec, (tray.x, tray.y), (floor, tray.rim - tray.depth - tray.wall), config.robot.size)
    for index, (half, centre) in enumerate(zip(*tray_panels(tray, count), strict=True)):
        body.add_geom(
            name=f"tray_{index}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=half,
            pos=centre,
            rgba=BINS[0],
            contype=0,
            conaffinity=_OBJECT_BIT,
            solref=SURROUNDINGS_SOLREF,
            group=1,
        )


def _add_sensors(spec: MjSpec, robot: Gripper4Handles) -> None:
    """Add sensors in the order and widths of `SENSORS`."""
    geom = mujoco.mjtObj.mjOBJ_GEOM
    add_motion_sensors(spec)
    add_place_sensor(spec, robot.grip)
    for pad in robot.pads:
        add_contact_sensor(spec, geom, "object", pad)
    add_contact_sensor(spec, geom, "object")
    add_torque_sensors(spec, robot.actuators)
