"""A line as one MuJoCo model, to be looked at: every robot with its cup and its bins, and the belt that they share.

Nothing is simulated in it: hands are put where they are, and objects are drawn beside it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.stage import ITEM_RGBA, light_stage
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.scene import add_bins, add_cup, add_ground, lip_length
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.engine import MjData, MjModel, MjSpec, mujoco
from pnt_gym.robots.brush import FIXED_GROUP, MOTOR, PAINT, Brush
from pnt_gym.robots.t3kr.kinematics import closed_pose
from pnt_gym.robots.t3kr.model import T3krHandles, add_t3kr, qpos_columns

MARGIN: Final = 0.5
"""The belt is seen so far beyond the outermost windows, at its begin at least from where the camera stands [m]."""
UNUSED_RGBA: Final = (0.62, 0.64, 0.66, 1.0)
"""Of a bin that its robot brings nothing to."""
DULL: Final = 0.72
"""A bin has the colour of what it takes, so much darker."""
HOOD: Final = (0.16, 0.30)
"""Half the length along the belt, and the height, of what hides where objects come from and go to [m]."""


@final
@dataclass(frozen=True)
class LineScene:
    """The compiled line, and where its robots' joints stand in it."""

    model: MjModel
    data: MjData
    columns: Ints
    """Of qpos, for each robot those that `closed_pose` fills (R, 15)."""
    belt: tuple[float, float]
    """From where to where it is seen along x [m]."""

    def pose(self, tips: Floats) -> None:
        """Put the tips of the robots' cups at places (R, 3) [m], each from its robot's base."""
        self.data.qpos[self.columns] = closed_pose(tips)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)


def build_scene(config: LineConfig) -> LineScene:
    """Compile the line."""
    spec, belt = mujoco.MjSpec(), extent(config)
    _add_surroundings(spec, config, belt)
    handles = [_add_robot(spec, config, index) for index in range(len(config.robots))]
    model = spec.compile()
    columns = np.stack([qpos_columns(model, robot) for robot in handles])
    return LineScene(model, mujoco.MjData(model), columns, belt)


def extent(config: LineConfig) -> tuple[float, float]:
    """From where to where the belt is seen along x [m]."""
    low, high = config.reach
    return min(low, config.robots[0].x + config.cell.belt.pick_x[0] - MARGIN), high + MARGIN


def _add_surroundings(spec: MjSpec, config: LineConfig, belt: tuple[float, float]) -> None:
    """Light, floor, the belt, and hoods over its ends."""
    light_stage(spec, ambient=0.30, diffuse=0.35)
    middle, own = sum(belt) / 2, config.cell.belt
    light = spec.worldbody.add_light(
        pos=[middle, -1.5, 3.0], dir=[-0.25, 0.45, -1.0], diffuse=np.full(3, 0.55), specular=np.full(3, 0.2)
    )
    light.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    long = config.cell.model_copy(update={"belt": own.model_copy(update={"x": belt})})
    add_ground(spec, long, 12.0)
    half, height = HOOD
    brush = Brush(spec.worldbody.add_body(name="hoods"), FIXED_GROUP)
    for x in (belt[0] + half, belt[1] - half):
        width = (own.y[1] - own.y[0]) / 2 + 0.03
        brush.box((x, sum(own.y) / 2, own.height + height / 2 - 0.03), (half, width, height / 2 + 0.03), MOTOR)
        brush.box((x, sum(own.y) / 2, own.height + height + 0.006), (half + 0.01, width + 0.01, 0.006), PAINT)


def _add_robot(spec: MjSpec, config: LineConfig, index: int) -> T3krHandles:
    """One of the robots with its cup and its bins, at its place."""
    cell, own = config.cell_of(index), mujoco.MjSpec()
    robot = add_t3kr(own)
    add_cup(own, lip_length(cell))
    add_bins(own, cell)
    for number, colour in enumerate(bin_colours(config, index)):
        for geom in own.body(f"bin_{number}").geoms:
            geom.rgba = colour
    prefix = f"{index}_"
    spec.attach(own, prefix=prefix, frame=spec.worldbody.add_frame(pos=[config.robots[index].x, 0.0, 0.0]))
    return robot.prefixed(prefix)


def bin_colours(config: LineConfig, index: int) -> Floats:
    """Of each bin of one of the robots (B, 4): that of the first item that it brings there."""
    cell: ConveyorConfig = config.cell_of(index)
    brought = cell.acceptance() & config.able()[index][:, None]
    own = ITEM_RGBA[brought.argmax(axis=0)] * np.array([DULL, DULL, DULL, 1.0])
    return np.where(brought.any(axis=0)[:, None], own, np.array(UNUSED_RGBA))
