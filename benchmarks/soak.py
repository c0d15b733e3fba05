"""Run environments or lines for hours, and look for growing memory, invalid numbers, lost objects and wrong counts.

`python benchmarks/soak.py throws` throws 100,000 times, in rounds over all environments and levels, with actions from
zero to far outside of the range. Robots of a line choose at random, and now and then name a choice that does not exist.
The command keeps finished rounds in `--state` and goes on from there, so a kill costs one round. The exit code is 1
after a finding: a warning; a number that is not finite; an object that went through a wall, ended below the floor, was
lifted twice along a line, is missing from a shift's figures or counted twice; memory that grows by more than 5 % after
the first three rounds.

`python benchmarks/soak.py shifts` takes 100,000 decisions at lines of 1 to 4 robots that stand up to 100 km from the
origin, in shifts of a minute to four hours. Further findings are a reset or a thousand decisions that take too long,
time that runs backwards, and memory that grows within a shift.
"""

from __future__ import annotations

import contextlib
import json
import sys
import time
import warnings
from argparse import Namespace
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import gymnasium as gym
import numpy as np

import pnt_gym
from agents.ground.files import write_json
from agents.judging.throws import results
from benchmarks.checks import check_parser, choices, end, growth, memory
from benchmarks.soak_shifts import GROWTH, LONGEST, RULED_OUT, Books, no_numbers, random_level, work
from benchmarks.soak_walls import through
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.engine import mujoco
from pnt_gym.errors import ConfigError, PntGymError

CELLS: Final = 16
ROUNDS, SHARE = 3, 0.05
"""Of throws before memory has to stay as it is, and what of it may come to it afterwards."""
SHIFTS: Final = 5
"""Before memory has to stay as it is."""
MOST: Final = 8000
"""Decisions of one shift; those of a longer one that come then are not taken."""
ACTIONS: Final = (0.0, 0.5, 1.0, 3.0)
"""Half range of the actions of each step; beyond 1 they are clipped."""
SHIFT: Final = 8.0
"""That shifts of a line last in rounds of throws [s]; throws go by the table, in most to the end of the first shift."""
DECISIONS: Final = 48
"""Of every line in a round."""
THROWN: Final = {"name": "skills3, thrown", "base": "skills3", "throws": "full"}
"""A line whose throws are simulated, as often as in other cells."""


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


@contextlib.contextmanager
def watch_plant(plant: Any) -> Iterator[Callable[[], list[Any]]]:
    """A function that returns inputs and results of the plant's throws; at the conveyor without the robot.

    The function returns the throws since its last call.
    """
    physics, name = (plant.free, "fall") if hasattr(plant, "free") else (plant, "fly")
    watch, last = getattr(physics, name), list[Any]()

    def record(*arguments: Any) -> Any:
        last.append((arguments, watch(*arguments)))
        return last[-1][1]

    def take_records() -> list[Any]:
        records, last[:] = list(last), []
        return records

    setattr(physics, name, record)
    yield take_records
    delattr(physics, name)  # or it would wait for the next collection, with all it flew


def soak_round(env_id: str, level: Any, number: int) -> list[str]:
    """What is wrong with some throws or decisions; their number is all that they depend on."""
    name, finds = f"{env_id} {level if isinstance(level, str) else level['name']} round {number}", list[str]()
    random = np.random.default_rng(number)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        env: Any = gym.make_vec(env_id, num_envs=CELLS, level=level, threads=1).unwrapped
        env.reset(seed=1000 * number)
        with contextlib.closing(env):
            try:
                faults = check_decisions(env, random) if isinstance(env.core, LineCore) else check_throws(env, random)
                finds.extend(f"{name}: {fault}" for fault in faults)  # those before an error are kept
            except PntGymError as error:
                finds.append(f"{name}: {type(error).__name__}: {error}")
    return finds + [f"{name}: warned {w.message}" for w in caught]


def check_throws(env: Any, random: np.random.Generator) -> Iterator[str]:
    """What is wrong with some throws."""
    with watch_plant(env.core.cell.plant) as last:
        for scale in ACTIONS:
            context = env.core.context
            observation, reward, *_ = env.step(scale * random.uniform(-1.0, 1.0, env.action_space.shape))
            yield from no_numbers(observation, reward)
            throws = last()  # none in a step in which all hands only grasp
            fault = through(env.core, context, throws[-1]) if throws else None
            if fault:
                yield f"actions to {scale}: {fault}"


def check_decisions(env: Any, random: np.random.Generator) -> Iterator[str]:
    """What is wrong with some decisions at lines."""
    config, stream = env.core.config, env.core.cell.stream
    books = [Books(config, x) for x in stream.x]
    cores: list[Any] = list(getattr(env.core.cell.throws, "cores", {}).values())
    with contextlib.ExitStack() as ends:
        flights = [ends.enter_context(watch_plant(core.cell.plant)) for core in cores]
        for _ in range(len(ACTIONS) if cores else DECISIONS):
            observation, reward, _, over, info = env.step(choices(env.core.masks(), random, RULED_OUT))
            yield from no_numbers(observation, reward)
            decision = results(info, CELLS)
            for row, book in enumerate(books):
                finds = [*book.after({name: values[row] for name, values in decision.items()})]
                if over[row]:
                    finds += book.at_the_end({name: values[row] for name, values in info["final_info"].items()})
                    books[row] = Books(config, env.core.cell.stream.x[row])
                yield from (f"line {row}: {fault}" for fault in finds)
            for core, last in zip(cores, flights, strict=True):
                yield from (fault for flown in last() if (fault := through(core, flown[0][1], flown)))


def soak_throws(arguments: Namespace) -> tuple[list[str], str]:
    """Throw until a number of throws is done, with those in the file of the state; returns findings and a summary."""
    every, state = list(pairs()), {"throws": 0, "rounds": 0, "finds": list[str]()}
    if arguments.state.is_file() and not arguments.fresh:
        state = json.loads(arguments.state.read_text(encoding="utf-8"))
    used, began, first = list[float](), time.monotonic(), state["throws"]
    while state["throws"] < arguments.throws:
        for env_id, level in every:
            state["finds"] += soak_round(env_id, level, state["rounds"])
            state["throws"] += CELLS * len(ACTIONS)  # of lines fewer than they take
        state["rounds"] += 1
        used.append(memory())
        state.setdefault("memory_mb", []).append(round(used[-1], 1))
        write_json(arguments.state, state)
        pace = (state["throws"] - first) / (time.monotonic() - began)
        words = f"{state['throws']} of {arguments.throws} throws, {len(state['finds'])} finds, {used[-1]:.1f} MB"
        print(f"{words}, {pace:.0f} throws/s", flush=True)
    share = growth(used, ROUNDS) / used[ROUNDS - 1] if len(used) >= ROUNDS else 0.0
    grown = f"memory grew by {100 * share:.1f} % after round {ROUNDS} of {len(used)} here"
    finds = [*state["finds"], *([grown] if share > SHARE else [])]
    return finds, f"{len(finds)} finds; {grown}; MuJoCo {mujoco.__version__}"


def soak_shifts(decisions: int, seed: int = 0, longest: float = LONGEST, limit: int = MOST) -> tuple[list[str], str]:
    """Work shifts until a number of decisions is taken.

    Args:
        decisions: in all.
        seed: of the first shift; the following ones have the following seeds.
        longest: shift [s].
        limit: largest number of decisions of one shift.

    Returns:
        Finds, and a summary.
    """
    finds, decided, shifts, completed, used = list[str](), 0, 0, 0, list[float]()
    began, hours = time.monotonic(), 0.0
    while decided < decisions:
        config = random_level(np.random.default_rng(seed + shifts), longest)
        faults, count, over = work(config, seed + shifts, min(limit, decisions - decided))
        where = f"shift {seed + shifts}, {len(config.robots)} robots from x {config.robots[0].x:.0f} m"
        finds += [f"{where}, {config.duration:.0f} s: {find}" for find in faults]
        decided, shifts, completed = decided + max(count, 1), shifts + 1, completed + over
        hours += config.duration / 3600.0
        used.append(memory())
    grown, seconds = growth(used, SHIFTS), time.monotonic() - began
    if grown > GROWTH:
        finds.append(f"memory grew by {grown:.0f} MB after {SHIFTS} shifts")
    return finds, (
        f"{decided} decisions in {shifts} shifts of {hours / shifts:.1f} h on average, {completed} to their end: "
        f"{len(finds)} finds, {used[-1]:.0f} MB ({grown:+.0f} MB), {1e3 * seconds / decided:.1f} ms a decision"
    )


def main() -> int:
    """Throw or work; exit code 1 at a find."""
    parser = check_parser(__doc__)
    kinds = parser.add_subparsers(dest="kind", required=True, metavar="throws|shifts")
    throws, shifts = kinds.add_parser("throws"), kinds.add_parser("shifts")
    throws.add_argument("--throws", type=int, default=100_000, metavar="N")
    throws.add_argument("--state", type=Path, default=Path("runs/soak.json"), metavar="FILE")
    throws.add_argument("--fresh", action="store_true", help="begin anew")
    shifts.add_argument("--decisions", type=int, default=100_000, metavar="N")
    shifts.add_argument("--seed", type=int, default=0, help="of the first shift")
    arguments = parser.parse_args()
    if arguments.kind == "throws":
        return end(*soak_throws(arguments))
    return end(*soak_shifts(arguments.decisions, arguments.seed))


if __name__ == "__main__":
    sys.exit(main())
