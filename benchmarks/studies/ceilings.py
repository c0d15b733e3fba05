"""How much of what any order of picks could bring in a shift controllers of a line bring."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Any, Final

import numpy as np

from agents.dispatchers import registry
from agents.dispatchers.clairvoyant import Clairvoyant
from agents.dispatchers.prices import find_bound
from agents.dispatchers.registry import ENV, FORESEEING, line_core
from agents.dispatchers.search import shift_values
from agents.ground.environments import Env, make_vector, stream_seed
from agents.results.study import Amount, Figures, Settings
from pnt_gym.arrays import Ints

FIRST: Final = "fifo"
"""The controller over which others win."""


def shifts(settings: Settings, amount: Amount) -> Iterator[Figures]:
    """What controllers of a line bring in the same shifts, and how much any order could.

    Of each shift a row has the value and the seconds that it lasts; beside them those of `fifo` and of both bounds.

    Args:
        settings: `level`, and the names of the `controllers`.
        amount: shifts.
    """
    level, seeds = _held_out(settings, amount)
    with closing(make_vector(ENV, level, 1, 1)) as env:
        duration = line_core(env).config.duration
        drawn, expected, foreseen = np.array([_ceilings(env, seed) for seed in seeds]).T
    values = {FORESEEING: foreseen}
    with closing(make_vector(ENV, level, amount.throws, 1)) as env:
        for name in settings["controllers"]:
            values[name] = shift_values(registry.make(name, line_core(env)), env, seeds) * duration / 60.0
    beside = {"first": values[FIRST], "drawn": drawn, "expected": expected}
    for name, own in values.items():
        columns = {"shifts": own, **beside}
        yield {
            "controller": name,
            **{label: [[round(float(value), 4), duration] for value in column] for label, column in columns.items()},
        }


def closest(settings: Settings, amount: Amount) -> Iterator[Figures]:
    """How close controllers of a line come to the bound by draws in any of many shifts.

    Args:
        settings: `level`, and the names of the `controllers`.
        amount: shifts.
    """
    level, seeds = _held_out(settings, amount)
    with closing(make_vector(ENV, level, amount.throws, 1)) as env:
        core = line_core(env)
        env.reset(seed=seeds.tolist())
        tables, minutes = core.cell.chooser.tables, core.config.duration / 60.0
        bounds = np.array(
            [find_bound(tables, riders, is_drawn=True).value for riders in core.cell.stream.riders.copy()]
        )
        for name in settings["controllers"]:
            shares = shift_values(registry.make(name, core), env, seeds) * minutes / bounds
            yield {"controller": name, "closest": float(shares.max())}


def _held_out(settings: Settings, amount: Amount) -> tuple[dict[str, Any], Ints]:
    """The level with its name, by which tuned settings are found, and the seeds of its shifts."""
    level = {"name": settings["level"]["base"], **settings["level"]}
    return level, np.array([stream_seed("evaluate", amount.seed, k) for k in range(amount.throws)])


def _ceilings(env: Env, seed: int) -> tuple[float, float, float]:
    """The bounds of a shift by its draws and of expected values, and what the order of one who knows it brings."""
    env.reset(seed=int(seed))
    core = line_core(env)
    tables, riders = core.cell.chooser.tables, core.cell.stream.riders[0].copy()
    foreseeing = Clairvoyant(FORESEEING, core)
    per_minute = shift_values(foreseeing, env, np.array([seed]))
    bound = find_bound(tables, riders, is_drawn=False)
    return foreseeing.bounds[0], bound.value, float(per_minute[0]) * core.config.duration / 60.0
