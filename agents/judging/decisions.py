"""Shifts of lines, decision by decision: the one loop in which controllers work them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Ints

from ..controllers.protocol import Observation
from ..dispatchers.registry import the_line
from ..ground.cli import UsageError
from ..ground.environments import Env

Act = Callable[[Observation], NDArray[Any]]
"""What is chosen in N lines (N,), such as the `act` of a controller."""
Progress = Callable[[float], object]
"""Told how many shifts have been worked since it was told last; also parts of them."""


class Decided(NamedTuple):
    """One decision in each of N lines, carried out."""

    seen: Observation
    shift: Ints
    """Shifts that were over in each line when it was taken (N,)."""
    over: Bools
    """It ended its shift (N,)."""
    info: Mapping[str, Any]
    seconds: float
    """In which all were taken [s]."""


def observed_line(features: NDArray[Any]) -> Observation:
    """What controllers see of N lines whose environment returned (N, D); a line has no kind."""
    return Observation(np.asarray(features, dtype=np.float32), np.zeros(len(features), dtype=np.int64))


def worked_by(act: Act, env: Env, seed: int | list[int], each: int) -> Iterator[Decided]:
    """Work shifts one after the other in every line, until so many are over in each.

    Args:
        act: says what is chosen.
        env: lines.
        seed: of the environment, or one of each line's stream.
        each: shifts of every line.

    Raises:
        UsageError: the environment ends shifts before they are over.
    """
    shift = np.zeros(env.num_envs, dtype=np.int64)
    features, _ = env.reset(seed=seed)
    while (shift < each).any():
        seen = observed_line(features)
        begin = time.perf_counter()
        action = act(seen)
        seconds = time.perf_counter() - begin
        features, _, _, over, info = env.step(action)
        _check_whole(over, info)
        yield Decided(seen, shift, over, info, seconds)
        shift = shift + over


def single_shifts(act: Act, env: Env, seeds: Ints, progress: Progress | None = None) -> Iterator[Decided]:
    """Work one shift in every line; lines that are through with theirs begin others, which nobody asked for.

    Args:
        act: says what is chosen.
        env: lines.
        seeds: of their streams (N,).
        progress: told of shifts and parts of them.
    """
    core, before = the_line(env), 0.0
    for one in worked_by(act, env, seeds.tolist(), 1):
        yield one
        if progress is not None:
            working = (one.shift == 0) & ~one.over
            gone = float(np.where(working, core.cell.state.clock / core.config.duration, 1.0).sum())
            progress(gone - before)
            before = gone


def _check_whole(over: Bools, info: Mapping[str, Any]) -> None:
    """Make sure that shifts have figures where they are over (N,)."""
    figures = info.get("final_info", {}).get("_shift_value_per_min", np.zeros(len(over), dtype=np.bool_))
    if (over & ~figures).any():
        raise UsageError("the environment cuts shifts short of their end; leave max_episode_steps out")
