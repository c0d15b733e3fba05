"""Work shifts of lines, decision by decision, and the corrections of their throws."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Ints
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.throws import Release

from ..controllers import make_controller
from ..controllers.protocol import Observation
from ..ground.cli import UsageError, about
from ..ground.environments import Env, make_vector
from .registry import line_core

Act = Callable[[Observation], NDArray[Any]]
"""Function from observations to the choices in N lines (N,), such as the `act` of a controller."""
Progress = Callable[[float], object]
"""Function of the number of work shifts, or parts of them, since its last call."""


class DecisionStep(NamedTuple):
    """One executed decision in each of N lines."""

    observation: Observation
    shift: Ints
    """Work shifts completed in each line before the decision (N,)."""
    over: Bools
    """Whether the decision ended its work shift (N,)."""
    info: Mapping[str, Any]
    seconds: float
    """Time that the controller took for all decisions [s]."""


def observe(features: NDArray[Any]) -> Observation:
    """Observation of N lines from an environment's observations (N, D); a line has no kind."""
    return Observation(np.asarray(features, dtype=np.float32), np.zeros(len(features), dtype=np.int64))


def work_shifts(act: Act, env: Env, seed: int | list[int], count: int) -> Iterator[DecisionStep]:
    """Work shifts one after the other in every line, until `count` of them are over in each line.

    Args:
        act: function that chooses.
        env: environment of lines.
        seed: seed of the environment, or one seed for each line's stream.
        count: number of work shifts in every line.

    Raises:
        UsageError: the environment ends shifts early.
    """
    shift = np.zeros(env.num_envs, dtype=np.int64)
    seeds: Any = seed  # vector environments take a seed for each row, which the annotation of their base does not say
    features, _ = env.reset(seed=seeds)
    while (shift < count).any():
        observation = observe(features)
        begin = time.perf_counter()
        action = act(observation)
        seconds = time.perf_counter() - begin
        features, _, _, over, info = env.step(action)
        _check_figures(over, info)
        yield DecisionStep(observation, shift, over, info, seconds)
        shift = shift + over


def work_single_shifts(act: Act, env: Env, seeds: Ints, progress: Progress | None = None) -> Iterator[DecisionStep]:
    """Work one shift in every line; finished lines continue with other shifts, whose results do not count.

    Args:
        act: function that chooses.
        env: environment of lines.
        seeds: seeds of the lines' streams (N,).
        progress: called with the numbers of shifts and parts of them.
    """
    core, before = line_core(env), 0.0
    for step in work_shifts(act, env, seeds.tolist(), 1):
        yield step
        if progress is not None:
            working = (step.shift == 0) & ~step.over
            total = float(np.where(working, core.cell.state.clock / core.config.duration, 1.0).sum())
            progress(total - before)
            before = total


def _check_figures(over: Bools, info: Mapping[str, Any]) -> None:
    """Check that shifts have figures where they are over (N,)."""
    figures = info.get("final_info", {}).get("_shift_value_per_min", np.zeros(len(over), dtype=np.bool_))
    if (over & ~figures).any():
        raise UsageError("max_episode_steps ends work shifts early; leave max_episode_steps out")


ENV = "PnTRelease-v0"


def make_release(name: str, config: LineConfig) -> Release:
    """Function that corrects throws by a controller of `PnTRelease-v0`.

    Args:
        name: name of a controller that needs no practice, or a run folder.
        config: level of the line.

    Raises:
        UsageError: the controller does not exist, or belongs to another environment.
    """
    env = make_vector(ENV, config.cell_of(0), 1, 1)
    with about("release"):
        controller = make_controller(name, env)
    env.close()

    return lambda observation, kind: controller.act(Observation(observation, kind))
