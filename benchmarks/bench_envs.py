"""Throws per second of the vector environment, of the bare physics inside it, and of single environments in a loop.

A decision at a line is a throw here.

The bare rate is measured in the same run: the very controls and states of each throw are rolled out again by
`Batch.rollout` alone. Its share of the step is what planning, references and bookkeeping leave to the physics.

Run: python benchmarks/bench_envs.py --json bench.json
"""

from __future__ import annotations

import argparse
import os
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

import pnt_gym
from agents.ground.files import write_json

SEED = 0
FLIGHT = {"name": "waste, fidelity: flight", "base": "waste", "fidelity": "flight"}
LINE_FLIGHT = {"name": "skills3, throws: flight", "base": "skills3", "throws": "flight"}
LINE_FULL = {"name": "skills3, throws: full", "base": "skills3", "throws": "full"}
LEVELS = {
    "PnTConveyor-v0": ("waste", FLIGHT),
    "PnTRelease-v0": ("waste", FLIGHT),
    "PnTLine-v0": ("single", LINE_FLIGHT, LINE_FULL),
}
"""What is measured where nothing else is asked for; the other environments at their default."""
ACTIONS = 0.1
"""Random actions up to this: large enough to be planned for, too small to be shortened often."""


class Tap:
    """A batch that remembers its rollouts, so that they can be repeated without anything around them."""

    def __init__(self, batch: Any) -> None:
        self._batch = batch
        self.calls: list[tuple[Any, tuple[Any, ...], dict[str, Any]]] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._batch, name)

    def forget(self) -> None:
        """Begin anew."""
        self.calls = []

    def rollout(self, *args: Any, **options: Any) -> Any:
        """Roll out and remember."""
        self.calls.append((self._batch.state.copy(), args, options))
        return self._batch.rollout(*args, **options)

    def repeat(self) -> None:
        """The remembered rollouts again, from the same states, without recording."""
        for state, args, options in self.calls:
            self._batch.state[:] = state
            self._batch.rollout(*args, **{key: value for key, value in options.items() if key != "record"})

    @property
    def steps(self) -> int:
        """Physics steps of all simulations."""
        return sum(int(args[0]) * len(options["ids"]) for _, args, options in self.calls)


Clock = tuple[float, float]


def timed(action: Callable[[], object]) -> Clock:
    """Wall and processor seconds, the latter of all threads."""
    wall, cpu = time.perf_counter(), time.process_time()
    action()
    return time.perf_counter() - wall, time.process_time() - cpu


class Vector:
    """A vector environment and the physics inside it."""

    def __init__(self, env_id: str, level: Any, cells: int, threads: int) -> None:
        self.cells, self.threads = cells, threads
        self._env = gym.make_vec(env_id, num_envs=cells, level=level, threads=threads)
        self._taps: list[Tap] = []
        for plant in plants(self._env.unwrapped.core.cell):
            for physics in (plant, *([plant.free] if hasattr(plant, "free") else [])):  # with and without the robot
                physics.batch = Tap(physics.batch)
                self._taps.append(physics.batch)
        self._info = self._env.reset(seed=SEED)[1]
        self._rng = np.random.default_rng(SEED)
        self._rounds: list[tuple[Clock, Clock, int]] = []

    def round(self) -> None:
        """One step and its physics alone, in turn so that both see the same noise."""
        actions = action_of(self._env, self._info, self._rng)
        for tap in self._taps:
            tap.forget()
        step = timed(lambda: self._stepped(actions))
        bare = timed(lambda: [tap.repeat() for tap in self._taps])
        self._rounds.append((step, bare, sum(tap.steps for tap in self._taps)))

    def _stepped(self, actions: Any) -> None:
        self._info = self._env.step(actions)[-1]

    def figures(self) -> dict[str, float]:
        """Rates by the least time of all rounds but the first, which warms up."""
        rounds = self._rounds[1:]
        step, bare = (min(r[k][0] for r in rounds) for k in (0, 1))
        steps = statistics.mean(r[2] for r in rounds)
        return {
            "cells": self.cells,
            "threads": self.threads,
            "env_throws_per_s": self.cells / step,
            "bare_throws_per_s": self.cells / bare,
            "env_over_bare": bare / step,
            "env_over_bare_cpu": min(r[1][1] for r in rounds) / min(r[0][1] for r in rounds),
            "physics_us_per_step": 1e6 * bare / max(steps, 1) * self.threads,
            "physics_steps_per_throw": steps / self.cells,
        }


def plants(cell: Any) -> list[Any]:
    """What throws in a cell; on a line what throws for its robots, nothing where they go by a table."""
    if hasattr(cell, "plant"):
        return [cell.plant]
    return [core.cell.plant for core in getattr(cell.throws, "cores", [])]


def action_of(env: Any, info: dict[str, Any], random: np.random.Generator) -> Any:
    """Corrections at random; on a line choices that there are."""
    if "action_mask" in info:
        return np.where(info["action_mask"], random.random(info["action_mask"].shape), -1.0).argmax(axis=-1)
    return random.uniform(-ACTIONS, ACTIONS, env.action_space.shape).astype(np.float32)


class Singles:
    """Single environments stepped one after the other."""

    def __init__(self, env_id: str, level: Any, cells: int) -> None:
        self._envs = [gym.make(env_id, level=level, disable_env_checker=True) for _ in range(cells)]
        self._infos = [env.reset(seed=SEED + row)[1] for row, env in enumerate(self._envs)]
        self._rng = np.random.default_rng(SEED)
        self._times: list[float] = []

    def round(self) -> None:
        """One step of every environment."""
        self._times.append(timed(self._loop)[0])

    def throws_per_s(self) -> float:
        """By the least time of all rounds but the first."""
        return len(self._envs) / min(self._times[1:])

    def _loop(self) -> None:
        for row, env in enumerate(self._envs):
            _, _, terminated, truncated, self._infos[row] = env.step(action_of(env, self._infos[row], self._rng))
            if terminated or truncated:
                self._infos[row] = env.reset()[1]


def bench(env_id: str, options: argparse.Namespace) -> dict[str, Any]:
    levels = (options.level,) if options.level else LEVELS.get(env_id, ("nominal",))
    singles = [Singles(env_id, level, options.singles) for level in levels]
    vectors = [(k, Vector(env_id, level, options.cells, t)) for k, level in enumerate(levels) for t in options.threads]
    for _ in range(options.rounds + 1):
        for each in (*singles, *(vector for _, vector in vectors)):
            each.round()
    rates, names = [one.throws_per_s() for one in singles], [x if isinstance(x, str) else x["name"] for x in levels]
    rows = [{"level": names[k], **v.figures(), "singles_throws_per_s": rates[k]} for k, v in vectors]
    for name, rate in zip(names, rates, strict=True):
        print(f"{env_id}, {name}: {options.singles} single environments in a loop: {rate:.1f} throws/s")
    for row in rows:
        row["env_over_singles"] = row["env_throws_per_s"] / row["singles_throws_per_s"]
        bare = (
            f"bare physics {row['bare_throws_per_s']:.1f}, of which {row['env_over_bare'] * 100:.0f} % "
            f"({row['env_over_bare_cpu'] * 100:.0f} % in processor time), {row['physics_us_per_step']:.1f} us/step"
        )
        print(
            f"  {row['level']}, N={row['cells']}, {row['threads']} threads: {row['env_throws_per_s']:.1f} throws/s, "
            f"{row['env_over_singles']:.2f} x the loop; "
            f"{bare if row['physics_steps_per_throw'] else 'throws by a table, no physics'}"
        )
    return {"singles": options.singles, "singles_throws_per_s": rates[0], "vector": rows}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--env", nargs="*", default=list(pnt_gym.ENV_IDS), choices=pnt_gym.ENV_IDS)
    parser.add_argument("--level", help="default: waste at the conveyor, nominal elsewhere")
    parser.add_argument("--cells", type=int, default=64)
    parser.add_argument("--singles", type=int, default=16, help="single environments in the loop")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, nargs="*", default=[1, 2])
    parser.add_argument("--json", type=Path, help="file to write the figures to")
    options = parser.parse_args()
    result: dict[str, Any] = {"timestep": 0.001, "cpus": os.cpu_count(), "envs": {}}
    for env_id in options.env:
        result["envs"][env_id] = bench(env_id, options)
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
