"""Throw for hours, in every environment and level: does memory stay flat, every number one, and every object outside?

`python benchmarks/soak.py` throws 100,000 times, in rounds over all environments and levels, with actions from none to
wild; robots of a line choose at random, now and then what there is not. It keeps what it has done in `--state` and goes
on from there; a kill costs one round. Exit code 1 at a find: a warning, a number that is none, an object that went
through a wall, ended below the floor, was lifted twice along a line or is missing from a shift's figures, or memory
that grows by more than 5 % after the first three rounds.
"""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import gc
import json
import resource
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import gymnasium as gym
import numpy as np

import pnt_gym
from agents.ground.files import write_json
from agents.judging.throws import results
from pnt_gym.cells.base.stage import BELT_THICKNESS
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.scene import FLOOR_DROP, SENSORS, bin_panels
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.scene import TABLE_THICKNESS, tray_panels
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.engine import mujoco
from pnt_gym.errors import ConfigError, PntGymError

CELLS: Final = 16
STEPS: Final = 4
"""Throws of every cell in a round."""
SETTLED: Final = 3
"""Rounds before memory has to stay as it is."""
GROWTH: Final = 0.05
"""What it may grow by."""
FAR: Final = 20.0
"""No object ends farther away [m]."""
SOFT: Final = 0.02
"""The floor has MuJoCo's own softness: at rest an object lies g (0.02 s)^2, 4 mm, deep in it, arriving deeper [m]."""
ACTIONS: Final = (0.0, 0.5, 1.0, 3.0)
"""Half range of the actions of each step; beyond 1 they are clipped."""
SHIFT: Final = 8.0
"""That shifts of a line last [s]; throws go by the table, in most rounds to the end of the first shift."""
DECISIONS: Final = 48
"""Of every line in a round."""
THROWN: Final = {"name": "skills3, thrown", "base": "skills3", "throws": "full"}
"""A line whose throws are simulated, as often as in other cells."""
RULED_OUT: Final = 0.1
"""Share of decisions that the mask rules out."""


class Solids(NamedTuple):
    """What no centre of an object may be in: upright boxes of N cells, and everything below a height."""

    half: np.ndarray
    """(N, K, 3) [m]"""
    centre: np.ndarray
    """(N, K, 3) [m]"""
    floor: float
    """[m]"""


def pairs() -> Iterator[tuple[str, Any]]:
    """Every environment with every shipped level that it takes."""
    for env_id in pnt_gym.ENV_IDS:
        config = type(gym.make(env_id).unwrapped.core.config)  # pyright: ignore
        if config is LineConfig:
            yield from ((env_id, {"name": name, "base": name, "duration": SHIFT}) for name in config.level_names())
            yield env_id, THROWN
            continue
        for level in config.level_names():
            with contextlib.suppress(ConfigError):  # not every task can be had in every level
                gym.make(env_id, level=level).close()
                yield env_id, level


def conveyor_solids(config: ConveyorConfig, thrown: Any) -> Solids:
    """Belt and bins; of random bins the one that was aimed at."""
    bins, belt, count = config.bins, config.belt, len(thrown.target)
    if bins.random is None:
        places = np.tile([(b.x, b.y) for b in bins.fixed], (count, 1, 1))
        openings = np.tile([b.size for b in bins.fixed], (count, 1, 1))
    else:
        places, openings = thrown.target[:, None, :2], thrown.opening[:, None]
    half, middle = bin_panels(openings.reshape(-1, 2), bins)
    rims = np.concatenate([places, np.full((*places.shape[:2], 1), bins.rim)], axis=-1)
    middle = middle.reshape(count, -1, 5, 3) + rims[:, :, None]
    size = np.array([belt.x[1] - belt.x[0], belt.y[1] - belt.y[0], BELT_THICKNESS]) / 2
    place = np.array([sum(belt.x) / 2, sum(belt.y) / 2, belt.height - BELT_THICKNESS / 2])
    floor = min(bins.rim - bins.depth - bins.wall - FLOOR_DROP, belt.height - 0.3)
    return Solids(
        np.concatenate([half.reshape(count, -1, 3), np.tile(size, (count, 1, 1))], axis=1),
        np.concatenate([middle.reshape(count, -1, 3), np.tile(place, (count, 1, 1))], axis=1),
        floor,
    )


def gripper_solids(config: GripperConfig, thrown: Any) -> Solids:
    """Table or belt, and tray."""
    table, count = config.table, len(thrown.kind)
    half, centre = tray_panels(config.tray, len(config.items))
    thick = BELT_THICKNESS if table.speed > 0.0 else TABLE_THICKNESS
    size = np.array([table.x[1] - table.x[0], table.y[1] - table.y[0], thick]) / 2
    place = np.array([sum(table.x) / 2, sum(table.y) / 2, table.height - thick / 2])
    floor = config.tray.rim - config.tray.depth - config.tray.wall - 0.2
    return Solids(
        np.tile(np.vstack([half, size]), (count, 1, 1)), np.tile(np.vstack([centre, place]), (count, 1, 1)), floor
    )


def crossings(offset: np.ndarray, half: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Steps (N, M - 1) in which a centre passes the middle of a wall, however fast: flat objects dip into its surface.

    Args:
        offset: from the wall's middle along its own axes (N, M, 2 or 3) [m].
        half: its half extents (N, 2 or 3) [m].
        free: steps that count (N, M).
    """
    rows, thin = np.arange(len(half)), half.argmin(axis=-1)
    side = offset[rows, :, thin]
    beside = np.abs(offset) < half[:, None]
    beside[rows, :, thin] = True
    here = beside.all(axis=-1) & free
    return (side[:, 1:] * side[:, :-1] <= 0.0) & here[:, 1:] & here[:, :-1]


def through(core: Any, thrown: Any, flown: Any) -> str:
    """What an object of the last throws went through; empty if nothing."""
    config = core.config
    if not isinstance(config, ConveyorConfig | GripperConfig):
        return through_pallets(core, flown[1])
    if isinstance(config, ConveyorConfig):
        (_, thrown, *_), fallen = flown
        solids, position = conveyor_solids(config, thrown), fallen.sensors[..., SENSORS["object_position"]]
        free = np.arange(position.shape[1]) < fallen.steps[:, None]
        final = position[np.arange(len(position)), fallen.steps - 1]
    else:
        solids, flight = gripper_solids(config, thrown), flown[1].flight
        position, free, final = flight.position, flight.free, flight.final()[0]
    for k in range(solids.half.shape[1]):
        crossed = crossings(position - solids.centre[:, None, k], solids.half[:, k], free)
        if crossed.any():
            row, step = np.argwhere(crossed)[0]
            return f"cell {row} went through solid {k} at {position[row, step].round(4).tolist()}"
    if not (np.abs(final) < FAR).all() or (final[:, 2] < solids.floor - SOFT).any():
        return f"an object ended at {final[np.argmin(final[:, 2])].tolist()}"
    return ""


def through_pallets(core: Any, flown: Any) -> str:
    """The same in the plane of the one-joint thrower."""
    x, y = flown.pose[..., 0], flown.pose[..., 1]
    for pallet in core.cell.job.pallets:
        for u, v, half_u, half_v, angle in pallet.walls:
            cos, sin = np.cos(angle), np.sin(angle)
            along, up = cos * (x - u) + sin * (y - v), cos * (y - v) - sin * (x - u)
            half = np.tile([half_u, half_v], (len(x), 1))
            crossed = crossings(np.stack([along, up], axis=-1), half, flown.after_release)
            if crossed.any():
                row, step = np.argwhere(crossed)[0]
                return f"cell {row} went through {pallet.name} at {flown.pose[row, step].round(4).tolist()}"
    return "" if (np.abs(flown.final_pose[..., 1]) < FAR).all() else "a part ended far away"


@contextlib.contextmanager
def watched(plant: Any) -> Iterator[Callable[[], list[Any]]]:
    """What the plant's throws were given and gave, asked for after them; at the conveyor without the robot.

    Those that were asked for are forgotten.
    """
    physics, name = (plant.free, "fall") if hasattr(plant, "free") else (plant, "fly")
    watch, last = getattr(physics, name), list[Any]()

    def told(*given: Any) -> Any:
        last.append((given, watch(*given)))
        return last[-1][1]

    def asked() -> list[Any]:
        told, last[:] = list(last), []
        return told

    setattr(physics, name, told)
    yield asked
    delattr(physics, name)  # or it would wait for the next collection, with all it flew


def soaked(env_id: str, level: Any, number: int) -> list[str]:
    """What is wrong with some throws or decisions; their number is all that they depend on."""
    name, found = f"{env_id} {level if isinstance(level, str) else level['name']} round {number}", list[str]()
    random = np.random.default_rng(number)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        env: Any = gym.make_vec(env_id, num_envs=CELLS, level=level, threads=1).unwrapped
        env.reset(seed=1000 * number)
        with contextlib.closing(env):
            try:
                finds = worked(env, random) if isinstance(env.core, LineCore) else thrown(env, random)
                found.extend(f"{name}{said}" for said in finds)  # those before an error are kept
            except PntGymError as error:
                found.append(f"{name}: {type(error).__name__}: {error}")
    return found + [f"{name}: warned {w.message}" for w in told]


def thrown(env: Any, random: np.random.Generator) -> Iterator[str]:
    """What is wrong with some throws."""
    with watched(env.core.cell.plant) as last:
        for scale in ACTIONS:
            context = env.core.context
            observation, reward, *_ = env.step(scale * random.uniform(-1.0, 1.0, env.action_space.shape))
            if not (np.isfinite(observation).all() and np.isfinite(reward).all()):
                yield ": a number is none"
            said = through(env.core, context, last()[-1])
            if said:
                yield f", actions to {scale}: {said}"


def worked(env: Any, random: np.random.Generator) -> Iterator[str]:
    """What is wrong with some decisions at lines."""
    throws, lifted = env.core.cell.throws, [set[int]() for _ in range(CELLS)]
    cores: list[Any] = getattr(throws, "cores", [])
    with contextlib.ExitStack() as ends:
        flights = [ends.enter_context(watched(core.cell.plant)) for core in cores]
        for _ in range(len(ACTIONS) if cores else DECISIONS):
            there = env.core.masks()
            score = random.random(there.shape) + there
            score = np.where(random.random((CELLS, 1)) < RULED_OUT, -score, score)
            observation, reward, _, over, info = env.step(score.argmax(axis=1))
            if not (np.isfinite(observation).all() and np.isfinite(reward).all()):
                yield ": a number is none"
            yield from lifts(results(info, CELLS), lifted)
            if over.any():
                yield from books(info["final_info"], np.flatnonzero(over), lifted)
            for core, last in zip(cores, flights, strict=True):
                yield from (f": {said}" for flown in last() if (said := through(core, flown[0][1], flown)))


def lifts(told: Mapping[str, Any], lifted: list[set[int]]) -> Iterator[str]:
    """Objects that were lifted once more; `lifted` are those of each line's shift."""
    for row in np.flatnonzero(told["picked"]):
        number = int(told["object"][row])
        if number in lifted[row]:
            yield f": line {row} lifted object {number} twice"
        lifted[row].add(number)


def books(told: Mapping[str, Any], ended: np.ndarray, lifted: list[set[int]]) -> Iterator[str]:
    """What is wrong with the figures of shifts that have ended in some lines."""
    ends = ("sorted", "misplaced", "on_floor", "passed")
    for row in ended:
        one = {name: told[f"shift_{name}"][row] for name in ("objects", *ends)}
        if sum(one[name] for name in ends) != one["objects"]:
            yield f": line {row} ends with {one}"
        busy = told["shift_utilisation"][row]
        if not ((busy >= 0.0) & (busy <= 1.0)).all():
            yield f": robots of line {row} work {busy.tolist()} of their time"
        lifted[row].clear()


def memory() -> float:
    """Of this process, without what only waits to be collected or given back [MB]."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1])
    return pages * resource.getpagesize() / 1e6


def main() -> int:
    """Throw; exit code 1 at a find."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--throws", type=int, default=100_000, metavar="N")
    parser.add_argument("--state", type=Path, default=Path("runs/soak.json"), metavar="FILE")
    parser.add_argument("--fresh", action="store_true", help="begin anew")
    arguments = parser.parse_args()
    every, state = list(pairs()), {"throws": 0, "rounds": 0, "finds": list[str]()}
    if arguments.state.is_file() and not arguments.fresh:
        state = json.loads(arguments.state.read_text(encoding="utf-8"))
    used, began, first = list[float](), time.monotonic(), state["throws"]
    while state["throws"] < arguments.throws:
        for env_id, level in every:
            state["finds"] += soaked(env_id, level, state["rounds"])
            state["throws"] += CELLS * len(ACTIONS)  # of lines fewer than they take
        state["rounds"] += 1
        used.append(memory())
        state.setdefault("memory_mb", []).append(round(used[-1], 1))
        write_json(arguments.state, state)
        pace = (state["throws"] - first) / (time.monotonic() - began)
        words = f"{state['throws']} of {arguments.throws} throws, {len(state['finds'])} finds, {used[-1]:.1f} MB"
        print(f"{words}, {pace:.0f} throws/s", flush=True)
    for said in state["finds"]:
        print(f"FIND {said}")
    # A leak stays; a single round may leave the heap in larger pieces.
    grown = min(used[-SETTLED:]) / used[SETTLED - 1] - 1.0 if len(used) >= SETTLED else 0.0
    print(f"memory grew by {100 * grown:.1f} % after round {SETTLED} of {len(used)} here; MuJoCo {mujoco.__version__}")
    return int(bool(state["finds"]) or grown > GROWTH)


if __name__ == "__main__":
    sys.exit(main())
