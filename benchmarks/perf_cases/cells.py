"""Cases of environments: throws per second, and how much of it is physics."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from statistics import mean
from typing import Any

import gymnasium as gym
import numpy as np

from benchmarks.checks import random_action
from benchmarks.timing import CPU, Count, Options, Place, Row, Timing
from pnt_gym.cells.base.parallel import call_in_threads

SEED, ROUNDS = 0, 5
FLIGHT = {"name": "waste, fidelity: flight", "base": "waste", "fidelity": "flight"}
LEVELS = {
    "PnTConveyor-v0": ("waste", FLIGHT),
    "PnTRelease-v0": ("waste", FLIGHT),
    "PnTLine-v0": (
        "single",
        {"name": "skills3, throws: flight", "base": "skills3", "throws": "flight"},
        {"name": "skills3, throws: full", "base": "skills3", "throws": "full"},
    ),
}
"""What is measured where no level is asked for; the other environments at their default."""
UNSIMULATED_STEPS = 100
"""Steps of a timed call where nothing is simulated: shifts begin and end in them."""
ACTIONS = 0.1
"""Random actions up to this: large enough to be planned for, too small to be shortened often."""


class Tap:
    """A batch that remembers its rollouts, so that they can be repeated without anything around them."""

    def __init__(self, batch: Any) -> None:
        self._batch = batch
        self.calls: list[tuple[Any, tuple[Any, ...], dict[str, Any]]] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._batch, name)

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
        return sum(
            int(args[0]) * (self._batch.nsim if options["ids"] is None else len(options["ids"]))
            for _, args, options in self.calls
        )


class Cells:
    """A vector environment that is stepped at random."""

    def __init__(self, env_id: str, level: Any, count: int, threads: int = 1) -> None:
        self.env: Any = gym.make_vec(env_id, num_envs=count, level=level, threads=threads)
        self.info, self._rng = self.env.reset(seed=SEED)[1], np.random.default_rng(SEED)

    def step(self) -> None:
        """One step of all cells."""
        self.info = self.env.step(random_action(self.env, self.info, self._rng, ACTIONS))[-1]


class Vector(Cells):
    """A vector environment and the physics inside it."""

    def __init__(self, env_id: str, level: Any, cells: int, threads: int) -> None:
        super().__init__(env_id, level, cells, threads)
        self._plants = [[tap_batches(part) for part in parts] for parts in plants(self.env.unwrapped.core.cell)]
        self._taps, self._steps = [tap for parts in self._plants for part in parts for tap in part], list[int]()
        self.times = 1 if self._taps else UNSIMULATED_STEPS
        """Steps of a timed call."""

    def step(self) -> None:
        """Throw once in every cell."""
        for tap in self._taps:
            tap.calls = []
        super().step()
        self._steps.append(sum(tap.steps for tap in self._taps))

    def repeat(self) -> None:
        """The physics of the last step alone: what planning, references and bookkeeping leave to it."""
        for parts in self._plants:  # one after the other, and the parts of each at the same time, as in the step
            call_in_threads([partial(repeat_all, part) for part in parts])

    def steps(self) -> float:
        """Physics steps of a step of all cells, on average without the first, which warms up."""
        return mean(self._steps[1:])


class Singles:
    """Single environments stepped one after the other."""

    def __init__(self, env_id: str, level: Any, count: int) -> None:
        self._envs = [gym.make(env_id, level=level, disable_env_checker=True) for _ in range(count)]
        self._infos = [env.reset(seed=SEED + row)[1] for row, env in enumerate(self._envs)]
        self._rng = np.random.default_rng(SEED)

    def step(self) -> None:
        """One step of every environment."""
        for row, env in enumerate(self._envs):
            *_, terminated, truncated, self._infos[row] = env.step(
                random_action(env, self._infos[row], self._rng, ACTIONS)
            )
            if terminated or truncated:
                self._infos[row] = env.reset()[1]


def plants(cell: Any) -> list[list[Any]]:
    """The parts of each plant of a cell, or of a line's robots; nothing where throws go by a table."""
    cores = {} if hasattr(cell, "plant") else getattr(cell.throws, "cores", {})
    whole = [cell.plant] if hasattr(cell, "plant") else [core.cell.plant for core in cores.values()]
    return [[part for _, part in getattr(plant, "parts", [])] or [plant] for plant in whole]


def tap_batches(plant: Any) -> list[Tap]:
    """Replace the batches of a plant, with and without the robot, by batches that remember their rollouts."""
    taps: list[Tap] = []
    for physics in (plant, *([plant.free] if hasattr(plant, "free") else [])):
        physics.batch = Tap(physics.batch)
        taps.append(physics.batch)
    return taps


def repeat_all(taps: Iterable[Tap]) -> None:
    """Repeat the rollouts of some batches, one batch after the other."""
    for tap in taps:
        tap.repeat()


def repeat(call: Callable[[], None], count: int) -> None:
    """Call a function several times."""
    for _ in range(count):
        call()


def environment(env_id: str, options: Options) -> Iterator[Row]:
    """Throws per second of a vector environment, beside the bare physics of the same throws and single environments.

    A decision at a line is a throw here.
    """
    levels, place = (options.level,) if options.level else LEVELS.get(env_id, ("nominal",)), ("envs", env_id)
    yield from (Count(("timestep",), 0.001), Count(("cpus",), os.cpu_count()))
    yield Count((*place, "singles"), options.singles)
    for k, level in enumerate(levels):
        singles = Singles(env_id, level, options.singles)
        loop: Callable[[], None] | Place = ()
        for n, threads in enumerate(options.threads, k * len(options.threads)):
            row, vector = (*place, "vector", n), Vector(env_id, level, options.cells, threads)
            yield Count((*row, "level"), level if isinstance(level, str) else level["name"])
            yield from vector_rows(row, vector, options.cells, threads)
            alone, step = (*row, "singles_throws_per_s"), (*row, "env_throws_per_s")
            decisions = options.singles * vector.times
            yield Timing(alone, loop or partial(repeat, singles.step, vector.times), "1/s", decisions, ROUNDS)
            yield Timing((*row, "env_over_singles"), alone, "x", decisions, over=step)
            if not loop and k == 0:
                yield Timing((*place, "singles_throws_per_s"), alone, "1/s", decisions)
            loop = alone  # timed once for all numbers of threads


def vector_rows(row: Place, vector: Vector, cells: int, threads: int) -> Iterator[Row]:
    """Rows of one vector environment: its step, and the physics of that step."""
    step, bare = (*row, "env_throws_per_s"), (*row, "bare_throws_per_s")
    yield Count(row, {"cells": cells, "threads": threads})
    yield Timing(step, partial(repeat, vector.step, vector.times), "1/s", cells * vector.times, ROUNDS)
    yield Timing(bare, vector.repeat, "1/s", cells, ROUNDS)
    yield Timing((*row, "env_over_bare"), bare, "x", cells, over=step)
    yield Timing((*row, "env_over_bare_cpu"), bare, "x", cells, clock=CPU, over=step)
    yield Timing((*row, "physics_us_per_step"), bare, "us", lambda: max(vector.steps(), 1.0) / threads)
    yield Count((*row, "physics_steps_per_throw"), lambda: vector.steps() / cells)
