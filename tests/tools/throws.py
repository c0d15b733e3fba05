"""What several tests need: cells made from a level and a few changes, and many throws at once."""

from collections.abc import Mapping
from typing import Any
from unittest import mock

import mujoco
import numpy as np

import pnt_gym
from pnt_gym.arrays import Ints
from pnt_gym.cells.base.config import Level
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.action import MODES as PICK_MODES
from pnt_gym.cells.conveyor.cell import ConveyorCell
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.hand import HandCycle
from pnt_gym.cells.conveyor.movers.straight import StraightMover, ThrowMotion
from pnt_gym.cells.conveyor.objects.drawing import ObjectMaker, SideDraws
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.outcome import SimulatedThrows
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.conveyor.sections import FollowThrough
from pnt_gym.cells.gripper.action import MODES as TOSS_MODES
from pnt_gym.cells.one_joint.action import MODES as GOAL_MODES
from pnt_gym.planning.motion.kernel import go_back
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows
from pnt_gym.planning.motion.trajectory import JerkTrajectory
from pnt_gym.planning.straight.plan import ReleaseBatch

CONVEYOR = ("PnTConveyor-v0", "PnTAdapt-v0", "PnTRelease-v0")
ONE_JOINT = ("OneJointThrow-v0", "OneJointSort-v0", "OneJointAssembly-v0")
GRIPPER = ("GripperToss-v0",)
LINE = ("PnTLine-v0",)
GRASP = ("PnTGrasp-v0",)
THROWS = tuple(env_id for env_id in pnt_gym.ENV_IDS if env_id not in (*LINE, *GRASP))
"""Environments of which a step is a throw that the action corrects; on a line it is a decision, or it is a grasp."""
MODES = {
    env_id: {name: len(mode.numbers) for name, mode in modes.items()}
    for ids, modes in ((CONVEYOR, PICK_MODES), (ONE_JOINT, GOAL_MODES), (GRIPPER, TOSS_MODES))
    for env_id in ids
} | {"PnTLine-v0": {"choice": 1}, "PnTGrasp-v0": {"grasp": 6}}
"""Action modes of every environment, with the numbers in one action; the first is the default."""
FEATURES = {
    **dict.fromkeys(CONVEYOR, 26),
    "PnTAdapt-v0": 34,
    **dict.fromkeys(ONE_JOINT, 14),
    **dict.fromkeys(GRIPPER, 15),
    **dict.fromkeys(LINE, 13 + 16 * 18),
    **dict.fromkeys(GRASP, 32),
}
"""Numbers in one observation, beside a picture."""
SHORT_LINE: dict[str, Any] = {
    "base": "skills3_burst",
    "throws": "flight",
    "duration": 5.0,
    "robots": [{"name": "first", "x": 0.0}, {"name": "second", "x": 1.4, "skills": ["tray", "can"]}],
    "down": [{"robot": "first", "start": 1.0, "end": 2.0}, {"robot": "second", "start": 0.0, "end": 0.5}],
}
"""A shift of two robots that stand still at times, with some ten decisions."""
HARD: dict[str, Any] = {
    **dict.fromkeys(CONVEYOR, "waste"),
    "PnTAdapt-v0": "drift_mix",
    **dict.fromkeys((*ONE_JOINT, *GRIPPER), "late"),
    **dict.fromkeys(LINE, SHORT_LINE),
    **dict.fromkeys(GRASP, "grasp"),
}
"""A level of every environment in which much is drawn or unknown."""


def zeros(env_id: str, *shape: int) -> np.ndarray:
    """Actions of zero in the default mode; on a line the best choices."""
    if env_id in LINE:
        return np.zeros(shape, dtype=np.int64)
    return np.zeros((*shape, next(iter(MODES[env_id].values()))), dtype=np.float32)


def some_actions(env_id: str, random: np.random.Generator, *shape: int, share: float = 1.0) -> np.ndarray:
    """Actions drawn from a share of their range; on a line one of the first choices, now and then one there is not."""
    if env_id in LINE:
        return random.choice(16, shape, p=np.repeat([0.2, 0.05 / 3], [4, 12]))
    return (share * random.uniform(-1, 1, zeros(env_id, *shape).shape)).astype(np.float32)


# Spread and suction without any effect; what is left of the mismatch at m = 1 is the air.
NO_DELAY = {"valve": 0.0, "tau": 0.0, "jitter": 0.0}
NO_SPREAD = {
    "mass": 0.0, "size": 0.0, "size_axis": 0.0, "drag": 0.0, "seal": 0.0, "com_depth": 0.0, "grasp": 0.0,
    "height": 0.0, "belt_speed": 0.0, "spin": 0.0, "spin_per_offset": 0.0, "feedforward": 0.0,
    "residue": 0.0, "restitution": 0.0, "friction": 0.0,
}  # fmt: skip


PLAIN: dict[str, Any] = {
    "belt": {"gap": "centre", "spacing": [0.10, 0.30], "tracking": False, "neighbours": "ghosts"},
    "bins": {"emptied": None}, "grip": {"limit": False}, "cup": {"stiffness": None, "peel": False, "fitted": False},
    "pick": {"fails": False}, "dispatch": "first",
}  # fmt: skip
"""What the levels `*_plain` switch off, for a level that has no such twin."""


def item(name: str, **changes: Any) -> dict[str, Any]:
    """A user's item: a 20 g sphere of 60 mm with a drag coefficient of 0.5."""
    sphere = {
        "name": name, "shape": "ellipsoid", "size": (0.06, 0.06, 0.06), "mass": 0.02, "drag": 0.5, "seal_force": 10.0,
        "friction": 0.5, "rolling_friction": 0.006, "restitution": 0.2, "source": "a test object",
    }  # fmt: skip
    return sphere | changes


def vary(level: str = "nominal", **changes: Any) -> ConveyorConfig:
    """A shipped level with some values replaced; mappings replace single keys of a section."""
    return ConveyorConfig.load({"base": level, "name": level, **changes})


def make_core(
    level: Level = "nominal",
    count: int = 1,
    *,
    picks: str = "independent",
    mode: str = "release_point",
    seed: int = 0,
    threads: int = 1,
    feedback: bool = False,
) -> Core:
    """Cells with their first picks drawn; row i has its own generator of seed + i."""
    core = untried(ConveyorCell(ConveyorConfig.load(level), count, picks, threads, feedback), mode)
    core.reset(np.arange(count), [np.random.default_rng(seed + i) for i in range(count)], seeded=True)
    return core


def untried(cell: ConveyorCell, mode: str | None = None) -> Core:
    """The core of a cell, without the throw that tries a level which does not ship: it takes as long as a step.

    What it finds is tested in `tests/test_fuzz.py`.
    """
    with mock.patch.object(Core, "_check_level"):
        return Core(cell, mode)


def whole_cycle(
    core: Core, plans: ReleaseBatch | None = None, following: np.ndarray | None = None
) -> tuple[ThrowMotion, HandCycle]:
    """Throws of the coming picks and whole cycles back to other picks; as planned and to their own, unless given."""
    picks, mover = core.context, core.cell.planner.mover
    plans = picks.plan if plans is None else plans
    motion = mover.throw(picks.pick, plans, picks.throw_limits, picks.ceiling)
    back = mover.back(motion, picks.pick if following is None else following, LimitRows.t3kr(picks.objects.percent))
    begin = motion.pick_velocity
    path = JerkTrajectory.concatenate(motion.pick, [motion.segments, back], begin, rides=begin is not None)
    return motion, HandCycle(plans, motion.release_time, path)


def engine_energy(model: mujoco.MjModel, qpos: np.ndarray, qvel: np.ndarray | float) -> float:
    """Kinetic and potential energy of a state, by the engine's own account [J]."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, data)
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    return data.energy.sum()


def spy_on_plant(core: Core) -> list[tuple[Context, HandCycle, SimulatedThrows]]:
    """A list that grows with every step: what the cell hands to its plant, and what comes of it."""
    calls, plant = list[tuple[Context, HandCycle, SimulatedThrows]](), core.cell.plant
    fly = plant.fly

    def kept(context: Context, cycle: HandCycle, cells: Ints | None = None) -> SimulatedThrows:
        calls.append((context, cycle, fly(context, cycle, cells)))
        return calls[-1][2]

    plant.fly = kept
    return calls


def is_feasible(core: Core, release: ReleaseBatch) -> np.ndarray:
    """Which releases of the coming picks the robot can execute (N,)."""
    context = core.context
    return core.cell.planner.mover.is_feasible(context.pick, release, LimitRows.t3kr(context.objects.percent))


def with_objects(core: Core, **fields: Any) -> None:
    """Overwrite hidden values of the objects under the cups."""
    context = core.context
    core.cell.context = context.replace(objects=context.objects.replace(**fields))


def parts_of(objects: Objects) -> dict[str, np.ndarray]:
    """All arrays of objects by name, those of the records in them as `record.name`."""
    records = {"": objects, "measured.": objects.measured, "draws.": objects.draws}
    return {
        prefix + name: getattr(record, name)
        for prefix, record in records.items()
        for name in record.fields
        if name not in ("measured", "draws")
    } | {"fill": objects.fill}


def with_part(objects: Objects, name: str, values: np.ndarray) -> Objects:
    """Objects with other values of a name of `parts_of`."""
    if "." not in name:
        return objects.replace(**{name: values})
    record, column = name.split(".")
    return objects.replace(**{record: getattr(objects, record).replace(**{column: values})})


def planned(config: ConveyorConfig, objects: Objects, x: np.ndarray) -> tuple[Context, np.ndarray]:
    """Contexts of objects met at belt coordinate x, and which of them can be thrown."""
    planner = PickPlanner(config)
    return planner.plan(objects, planner.pick_point(objects, x))


def same_bits(a: Any, b: Any) -> bool:
    """Whether two arrays, or mappings of arrays, agree in shape, type and every bit."""
    if isinstance(a, Mapping):
        return a.keys() == b.keys() and all(same_bits(a[name], b[name]) for name in a)
    a, b = np.asarray(a), np.asarray(b)
    return a.shape == b.shape and a.dtype == b.dtype and a.tobytes() == b.tobytes()


def arrays_of(observation: Any) -> list[np.ndarray]:
    """The arrays of an observation: the observation itself, or those of a mapping."""
    return [*observation.values()] if isinstance(observation, Mapping) else [observation]


def rows_of(observations: Any, index: Any) -> Any:
    """Some rows of observations: of an array, or of each array of a mapping."""
    if isinstance(observations, Mapping):
        return {name: values[index] for name, values in observations.items()}
    return observations[index]


def same_step(a: Any, b: Any) -> bool:
    """Whether two steps of single environments gave the same to the last bit; unlike `==` where a landing is NaN."""
    return same_bits(a[0], b[0]) and repr(a[1:]) == repr(b[1:])


def objects_from_draws(normals, uniforms, config, table, side_draws=None):
    """Objects as `ObjectMaker.make`; side draws None where no effect needs them."""
    side_draws = SideDraws.none(config, *normals.shape[:-1]) if side_draws is None else side_draws
    return ObjectMaker(config, table).make(normals, uniforms, side_draws)


def straight_mover(follow: FollowThrough, workspace: EllipticWorkspace | None = None) -> StraightMover:
    """Throws along lines, with a follow-through of one's own."""
    config = ConveyorConfig.load("nominal_plain")
    motion = config.motion.model_copy(update={"follow_through": follow})
    return StraightMover(config.model_copy(update={"motion": motion}), workspace or EllipticWorkspace())


def straight_motion(pick, release, limits, follow):
    """Throws from picks to releases and on to where the hands stop."""
    return straight_mover(follow).throw(pick, release, limits, np.full(len(pick), np.inf))


def straight_cycle(motion, limits, wait, following, clearance):
    """The whole path of straight throws: throw, way back, wait, approach."""
    back = go_back(motion.stop, following, wait, limits.arrays(len(wait)), clearance)
    return JerkTrajectory.concatenate(motion.pick, [motion.segments, back])
