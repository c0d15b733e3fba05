"""MuJoCo model of a line for pictures: every robot with its cup and its bins, and the shared belt.

The model simulates nothing: hands are placed by their tracks, and objects are drawn as markers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.stage import BELT_THICKNESS, light_stage
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.scene import add_bins, add_cup, add_ground, add_robot
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.engine import MjData, MjModel, MjSpec, mujoco
from pnt_gym.palette import CLEAR, FRAME, ITEMS, PAINT, STEEL, UNUSED
from pnt_gym.robots.brush import FIXED_GROUP, Brush
from pnt_gym.robots.joints import Place, RobotModel, qpos_columns

MARGIN: Final = 0.5
"""Length of belt that pictures show beyond the outermost windows; upstream they show at least the camera's place
[m]."""
GROUND: Final = 9.0
"""Half of the drawn floor's side [m]."""
ABOVE: Final = 0.14
"""Height of the mounting plate's upper side above the robot's mount [m]."""
STAND: Final = 0.45
"""Distance of the posts from the belt, where no arm swings [m]."""
HOOD: Final = (0.16, 0.30)
"""Half the length along the belt, and the height, of the hoods that hide both ends of the belt [m]."""


@final
@dataclass(frozen=True)
class LineScene:
    """The compiled line with its robots."""

    model: MjModel
    data: MjData
    robots: tuple[RobotModel, ...]
    columns: tuple[Ints, ...]
    """Columns of qpos that the pose of each robot fills."""
    belt: tuple[float, float]
    """Ends of the visible belt along x [m]."""

    def pose(self, tips: Floats) -> None:
        """Place the tips of the robots' cups at positions (R, 3) [m], each from its robot's base."""
        for robot, columns, tip in zip(self.robots, self.columns, tips, strict=True):
            self.data.qpos[columns] = robot.pose(tip[None])[0]
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)


def build_scene(config: LineConfig) -> LineScene:
    """Compile the model of the line."""
    spec, belt = mujoco.MjSpec(), belt_extent(config)
    # Add light, floor, the belt and its frame.
    light_stage(spec, ambient=0.42, diffuse=0.26)
    # MuJoCo scales clipping planes and the free camera by the extent, which must hold the whole belt.
    spec.stat.center, spec.stat.extent = [sum(belt) / 2, 0.0, -0.3], (belt[1] - belt[0]) / 2 + 1.0
    spec.visual.map.shadowclip = 2.0  # else the shadows' borders are seen on the floor
    sun = {"diffuse": np.full(3, 0.42), "specular": np.full(3, 0.2)}
    light = spec.worldbody.add_light(pos=[sum(belt) / 2, 1.2, 3.0], dir=[0.20, -0.35, -1.0], **sun)
    light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    belt_config = config.cell.belt
    add_ground(spec, config.cell.model_copy(update={"belt": belt_config.model_copy(update={"x": belt})}), GROUND)
    # Add the belt's frame down to the floor, and hoods over both ends.
    brush = Brush(spec.worldbody.add_body(name="frame"), FIXED_GROUP)
    floor = float(spec.geom("floor").pos[2])
    middle, width = sum(belt_config.y) / 2, (belt_config.y[1] - belt_config.y[0]) / 2
    length, top = (belt[1] - belt[0]) / 2, belt_config.height - BELT_THICKNESS
    brush.box((sum(belt) / 2, middle, (top + floor) / 2), (length - 0.02, width - 0.05, (top - floor) / 2), FRAME)
    for y in belt_config.y:
        brush.box((sum(belt) / 2, y, top + BELT_THICKNESS / 2), (length, 0.012, BELT_THICKNESS / 2 + 0.004), STEEL)
    half, height = HOOD
    for x in (belt[0] + half, belt[1] - half):
        brush.box((x, middle, belt_config.height + height / 2), (half, width + 0.03, height / 2), PAINT)
        brush.box((x, middle, belt_config.height + height), (half + 0.01, width + 0.04, 0.008), STEEL)
    robots = tuple(_add_robot(spec, config, index) for index in range(len(config.robots)))
    model = spec.compile()
    columns = tuple(qpos_columns(model, robot) for robot in robots)
    return LineScene(model, mujoco.MjData(model), robots, columns, belt)


def belt_extent(config: LineConfig) -> tuple[float, float]:
    """Ends of the visible belt along x [m]."""
    low, high = config.reach
    return min(low, config.robots[0].x + config.cell.belt.pick_x[0] - MARGIN), high + MARGIN


def _add_robot(spec: MjSpec, config: LineConfig, index: int) -> RobotModel:
    """Add one robot with its cup and its bins at its place."""
    cell, robot_spec = config.cell_of(index), mujoco.MjSpec()
    robot = add_robot(robot_spec, cell.robot)
    add_cup(robot_spec, cell.lip_length)
    add_bins(robot_spec, cell)
    _add_stand(robot_spec, robot.mount, cell.belt.y[0], float(spec.geom("floor").pos[2]))
    for number, colour in enumerate(bin_colours(config, index)):
        for geom in robot_spec.body(f"bin_{number}").geoms:
            geom.rgba = colour
    # Robots of one model share its names, so each robot's names begin with its index.
    prefix = f"{index}_"
    spec.attach(robot_spec, prefix=prefix, frame=spec.worldbody.add_frame(pos=[config.robots[index].x, 0.0, 0.0]))
    return robot.with_prefix(prefix)


def _add_stand(spec: MjSpec, mount: Place, edge: float, floor: float) -> None:
    """Add the stand of a robot: a post under a mount beside the belt; else one beside the belt, and a beam over it.

    Args:
        spec: the robot's specification.
        mount: where the robot is mounted.
        edge: y of the belt's far edge [m].
        floor: height of the floor [m].
    """
    brush, (x, end, top) = Brush(spec.worldbody.add_body(name="stand"), FIXED_GROUP), mount
    if end < edge:
        brush.box((x, end, (top + floor) / 2), (0.09, 0.09, (top - floor) / 2), STEEL)
        return
    y, base = edge - STAND, top + ABOVE
    brush.box((x, y, (base + floor) / 2), (0.06, 0.06, (base - floor) / 2), STEEL)
    brush.box((x, (y + end) / 2, base + 0.05), (0.06, (end - y) / 2 + 0.06, 0.05), STEEL)


def bin_colours(config: LineConfig, index: int) -> Floats:
    """Colour of each bin of one robot (B, 4): the colour of the first item that the robot throws there."""
    cell: ConveyorConfig = config.cell_of(index)
    assigned = cell.acceptance() & config.can_take()[index][:, None]
    item_colours = ITEMS[assigned.argmax(axis=0)] * np.array([0.9, 0.9, 0.9, CLEAR])
    return np.where(assigned.any(axis=0)[:, None], item_colours, np.array(UNUSED))
