"""Cases of environments: throws per second, and how much of it is physics."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np

from benchmarks.checks import random_action
from benchmarks.timing import CPU, Count, Options, Place, Row, Seconds, Timing
from pnt_gym.cells.base.parallel import call_in_threads

SEED = 0
ROUNDS, SINGLE_ROUNDS = 4, 12
"""Turns of a vector and of a single environment, which is sensitive to what else the machine does."""
THROWS, FEWEST_STEPS = 128, 6
"""Throws of a turn, and its least number of steps."""
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
        self.restart()

    def restart(self) -> None:
        """Begin again: the same steps come again."""
        self.info, self._rng = self.env.reset(seed=SEED)[1], np.random.default_rng(SEED)

    def step(self) -> None:
        """One step of all cells."""
        self.info = self.env.step(random_action(self.env, self.info, self._rng, ACTIONS))[-1]


class Single(Cells):
    """A single environment that is stepped at random."""

    def __init__(self, env_id: str, level: Any) -> None:
        self.env = gym.make(env_id, level=level, disable_env_checker=True)
        self.restart()

    def step(self) -> None:
        """One step, and the reset at the end of an episode."""
        *_, ended, cut, self.info = self.env.step(random_action(self.env, self.info, self._rng, ACTIONS))
        if ended or cut:
            self.info = self.env.reset()[1]


def open_cells(env_id: str, level: Any, count: int, threads: int = 1) -> Cells:
    """A vector environment; a single environment for one cell."""
    return Single(env_id, level) if count == 1 else Cells(env_id, level, count, threads)


class Steps:
    """Steps of cells, and the physics of the same steps alone.

    Each turn begins again and has the same steps, so the shortest of the turns counts. The physics is that of other
    cells, whose rollouts are remembered: what remembers them takes time of their steps.
    """

    def __init__(self, env_id: str, level: Any, cells: int, threads: int, throws: int) -> None:
        self._cells, self._tapped = (open_cells(env_id, level, cells, threads) for _ in range(2))
        self._plants = [[tap_batches(part) for part in parts] for parts in plants(self._tapped.env.unwrapped.core.cell)]
        self._taps, self._simulated = [tap for parts in self._plants for part in parts for tap in part], 0
        self.count = max(throws // cells, FEWEST_STEPS) if self._taps else UNSIMULATED_STEPS
        """Steps of a turn."""

    def step(self) -> Seconds:
        """The steps of a turn."""
        self._cells.restart()
        return Seconds().and_of(partial(repeat, self._cells.step, self.count))

    def simulate(self) -> Seconds:
        """The physics of the steps of a turn: what planning, references and bookkeeping leave to it."""
        self._tapped.restart()
        self._simulated, seconds = 0, Seconds()
        for _ in range(self.count if self._taps else 1):
            for tap in self._taps:
                tap.calls = []
            self._tapped.step()
            self._simulated += sum(tap.steps for tap in self._taps)
            self._repeat()  # as warm as it gets
            seconds = seconds.and_of(self._repeat)
        return seconds

    def _repeat(self) -> None:
        """The physics of the last step alone."""
        for parts in self._plants:  # one after the other, and the parts of each at the same time, as in the step
            call_in_threads([partial(repeat_all, part) for part in parts])

    def simulated(self) -> int:
        """Physics steps of a turn."""
        return self._simulated


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
    """Throws per second of a single and of a vector environment, beside the bare physics of the same throws.

    A decision at a line is a throw here, and so is a grasp.
    """
    levels, place = (options.level,) if options.level else LEVELS.get(env_id, ("nominal",)), ("envs", env_id, "rows")
    yield from (Count(("timestep",), 0.001), Count(("cpus",), os.cpu_count()))
    forms = [(1, 1), *((options.cells, threads) for threads in options.threads)]
    for k, level in enumerate(levels):
        single, count = (*place, k * len(forms), "env_throws_per_s"), 0
        for n, (cells, threads) in enumerate(forms, k * len(forms)):
            row, steps = (*place, n), Steps(env_id, level, cells, threads, options.size(THROWS))
            yield Count((*row, "level"), level if isinstance(level, str) else level["name"])
            yield from rows_of_steps(row, steps, cells, threads)
            count = count or steps.count
            step = (*row, "env_throws_per_s")
            yield Timing((*row, "env_over_single"), single, "x", count, over=step)


def rows_of_steps(row: Place, steps: Steps, cells: int, threads: int) -> Iterator[Row]:
    """Rows of the steps of cells and of their physics."""
    step, bare, throws = (*row, "env_throws_per_s"), (*row, "bare_throws_per_s"), cells * steps.count
    rounds = SINGLE_ROUNDS if cells == 1 else ROUNDS
    yield Count(row, {"cells": cells, "threads": threads})
    yield Timing(step, steps.step, "1/s", throws, rounds)
    yield Timing(bare, steps.simulate, "1/s", throws, rounds)
    yield Timing((*row, "env_over_bare"), bare, "x", throws, over=step)
    yield Timing((*row, "env_over_bare_cpu"), bare, "x", throws, clock=CPU, over=step)
    yield Timing((*row, "physics_us_per_step"), bare, "us", lambda: max(steps.simulated(), 1) / threads)
    yield Count((*row, "physics_steps_per_throw"), lambda: steps.simulated() / throws)
