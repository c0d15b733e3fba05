"""MuJoCo model of a line for pictures: every robot with its cup and its bins, and the shared belt.

The model simulates nothing: hands are placed by their tracks, and objects are drawn as markers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.furniture import HOOD, add_belt_frame, add_stand
from pnt_gym.cells.conveyor.scene import add_bins, add_cup, add_ground, add_robot
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.engine import MjData, MjModel, mujoco
from pnt_gym.palette import UNUSED, bin_colour
from pnt_gym.robots.joints import RobotModel, qpos_columns

MARGIN: Final = 0.5
"""Length of belt that pictures show beyond the outermost windows; upstream they show at least the camera's place
[m]."""
GROUND: Final = 9.0
"""Half of the drawn floor's side [m]."""


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


def build_scene(config: LineConfig) -> LineScene:
    """Compile the model of the line."""
    spec, belt = mujoco.MjSpec(), belt_extent(config)
    # MuJoCo scales clipping planes and the free camera by the extent, which must hold the whole belt.
    spec.stat.center, spec.stat.extent = [sum(belt) / 2, 0.0, -0.3], (belt[1] - belt[0]) / 2 + 1.0
    belt_config = config.cell.belt
    add_ground(spec, config.cell.model_copy(update={"belt": belt_config.model_copy(update={"x": belt})}), GROUND)
    half, _ = HOOD
    add_belt_frame(spec, belt_config, (belt[0] + half, belt[1] - half), float(spec.geom("floor").pos[2]))
    robots = list[RobotModel]()
    for index, place in enumerate(config.robots):
        # One robot with its cup and its bins.
        cell, robot_spec, prefix = config.cell_of(index), mujoco.MjSpec(), f"{index}_"
        robot = add_robot(robot_spec, cell.robot)
        add_cup(robot_spec, cell.lip_length)
        add_bins(robot_spec, cell)
        add_stand(robot_spec, robot.mount, cell.belt.y[0], float(spec.geom("floor").pos[2]))
        for number, colour in enumerate(bin_colours(config, index)):
            for geom in robot_spec.body(f"bin_{number}").geoms:
                geom.rgba = colour
        # Robots of one model share its names, so each robot's names begin with its index.
        spec.attach(robot_spec, prefix=prefix, frame=spec.worldbody.add_frame(pos=[place.x, 0.0, 0.0]))
        robots.append(robot.with_prefix(prefix))
    model = spec.compile()
    columns = tuple(qpos_columns(model, robot) for robot in robots)
    return LineScene(model, mujoco.MjData(model), tuple(robots), columns, belt)


def belt_extent(config: LineConfig) -> tuple[float, float]:
    """Ends of the visible belt along x [m]."""
    low, high = config.reach
    return min(low, config.robots[0].x + config.cell.belt.pick_x[0] - MARGIN), high + MARGIN


def bin_colours(config: LineConfig, index: int) -> Floats:
    """Colour of each bin of one robot (B, 4): the colour of the first item that the robot throws there."""
    cell: ConveyorConfig = config.cell_of(index)
    assigned = cell.acceptance() & config.can_take()[index][:, None]
    item_colours = np.array([bin_colour(int(kind)) for kind in assigned.argmax(axis=0)])
    return np.where(assigned.any(axis=0)[:, None], item_colours, np.array(UNUSED))
