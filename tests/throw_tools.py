"""What several tests need: cells made from a level and a few changes, and many throws at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pnt_gym import goal_residual, residual, toss_residual
from pnt_gym.cells.context import Context
from pnt_gym.cells.movers import straight_back
from pnt_gym.cells.objects import Objects
from pnt_gym.cells.picks import PickPlanner
from pnt_gym.config import CellConfig, load
from pnt_gym.envs.conveyor_core import ConveyorCore
from pnt_gym.planning.trajectory import JerkTrajectory

CONVEYOR = ("PnTConveyor-v0", "PnTRelease-v0")
ONE_JOINT = ("OneJointThrow-v0", "OneJointSort-v0", "OneJointAssembly-v0")
GRIPPER = ("GripperToss-v0",)
MODES = {
    **{env_id: residual.ACTION_SIZE for env_id in CONVEYOR},
    **{env_id: goal_residual.ACTION_SIZE for env_id in ONE_JOINT},
    **{env_id: toss_residual.ACTION_SIZE for env_id in GRIPPER},
}
"""Action modes of every environment, with the numbers in one action; the first is the default."""
FEATURES = {**dict.fromkeys(CONVEYOR, 26), **dict.fromkeys(ONE_JOINT, 14), **dict.fromkeys(GRIPPER, 15)}
"""Numbers in one observation."""
HARD = {**dict.fromkeys(CONVEYOR, "waste"), **dict.fromkeys((*ONE_JOINT, *GRIPPER), "late")}
"""A level of every environment in which much is drawn or unknown."""


def zeros(env_id: str, *shape: int) -> np.ndarray:
    """Actions of zero in the default mode."""
    return np.zeros((*shape, next(iter(MODES[env_id].values()))), dtype=np.float32)


# Spread and suction without any effect; what is left of the mismatch at m = 1 is the air.
NO_DELAY = {"valve": 0.0, "tau": 0.0, "jitter": 0.0}
NO_SPREAD = {
    "mass": 0.0, "size": 0.0, "size_axis": 0.0, "drag": 0.0, "seal": 0.0, "com_depth": 0.0, "grasp": 0.0,
    "height": 0.0, "belt_speed": 0.0, "spin": 0.0, "spin_per_offset": 0.0, "feedforward": 0.0,
    "residue_chance": 0.0,
}  # fmt: skip


def item(name: str, **changes: Any) -> dict[str, Any]:
    """A user's item: a 20 g sphere of 60 mm with a drag coefficient of 0.5."""
    sphere = {
        "name": name, "shape": "ellipsoid", "size": (0.06, 0.06, 0.06), "mass": 0.02, "drag": 0.5, "seal_force": 10.0,
        "friction": 0.5, "rolling_friction": 0.006, "restitution": 0.2, "source": "a test object",
    }  # fmt: skip
    return sphere | changes


def vary(level: str = "nominal", **changes: Any) -> CellConfig:
    """A shipped level with some values replaced; mappings replace single keys of a section."""
    data = load(level).model_dump(exclude_unset=True)
    for key, value in changes.items():
        data[key] = {**data.get(key, {}), **value} if isinstance(value, Mapping) and key != "bins" else value
    return load(data)


def make_core(
    level: str | CellConfig = "nominal",
    count: int = 1,
    *,
    picks: str = "independent",
    mode: str = "release_point",
    seed: int = 0,
    threads: int = 1,
) -> ConveyorCore:
    """Cells with their first picks drawn; row i has its own generator of seed + i."""
    core = ConveyorCore(level, picks, mode, count, threads)
    core.reset(np.arange(count), [np.random.default_rng(seed + i) for i in range(count)], seeded=True)
    return core


def with_objects(core: ConveyorCore, **fields: Any) -> None:
    """Overwrite hidden values of the objects under the cups."""
    context = core.context
    core.cell.context = replace(context, objects=replace(context.objects, **fields))


def planned(config: CellConfig, objects: Objects, x: np.ndarray) -> tuple[Context, np.ndarray]:
    """Contexts of objects met at belt coordinate x, and which of them can be thrown."""
    planner = PickPlanner(config)
    return planner.plan(objects, planner.pick_point(objects, x))


def same_bits(a: Any, b: Any) -> bool:
    """Whether two arrays agree in shape, type and every bit."""
    a, b = np.asarray(a), np.asarray(b)
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


def straight_cycle(motion, limits, wait, following, clearance):
    """The whole path of straight throws: throw, way back, wait, approach."""
    back = straight_back(motion.stop, following, wait, limits, clearance)
    return JerkTrajectory.concatenate(motion.pick, [*motion.parts, back.segments])
