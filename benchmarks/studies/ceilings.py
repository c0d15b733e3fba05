"""How much of what any order of picks could bring in a shift controllers of a line bring."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from time import process_time
from typing import Final

import numpy as np

from agents.dispatchers import registry
from agents.dispatchers.prices import find_bound
from agents.dispatchers.registry import ENV, line_core
from agents.dispatchers.search import shift_values
from agents.ground.environments import Env, make_vector, stream_seed
from agents.results.study import Amount, Figures, Settings
from pnt_gym.arrays import Floats, Ints

BOUNDS: Final = {"bound by draws": True, "bound of expected values": False}
"""Whether a bound knows the draws of the shift, by what rows call it."""


def shifts(settings: Settings, amount: Amount) -> Iterator[Figures]:
    """What controllers and bounds of a line bring in the same shifts.

    Of each shift a row has the value and the seconds; beside them those of the first controller and of both bounds, and
    the processor time of a shift [s].

    Args:
        settings: `level`, and the names of the `controllers`.
        amount: shifts.
    """
    seeds = np.array([stream_seed("evaluate", amount.seed, k) for k in range(amount.throws)])
    with closing(make_vector(ENV, settings["level"], amount.throws, 1)) as env:
        found = {name: _bounds(env, seeds, is_drawn=is_drawn) for name, is_drawn in BOUNDS.items()}
        found |= {name: _values(name, env, seeds) for name in settings["controllers"]}
        duration = line_core(env).config.duration
    others = dict(zip(("first", "drawn", "expected"), (settings["controllers"][0], *BOUNDS), strict=True))
    for name, (values, seconds) in found.items():
        yield {
            "controller": name,
            "shifts": _rows(values, duration),
            **{label: _rows(found[other][0], duration) for label, other in others.items()},
            "seconds": round(seconds / amount.throws, 3),
        }


def _rows(values: Floats, duration: float) -> list[list[float]]:
    return [[round(float(value), 4), duration] for value in values]


def _bounds(env: Env, seeds: Ints, *, is_drawn: bool) -> tuple[Floats, float]:
    """Bounds of the shifts of some seeds, and the processor time [s]."""
    env.reset(seed=seeds.tolist())
    cell, begin = line_core(env).cell, process_time()
    values = [find_bound(cell.chooser.tables, riders, is_drawn=is_drawn).value for riders in cell.stream.riders]
    return np.array(values), process_time() - begin


def _values(name: str, env: Env, seeds: Ints) -> tuple[Floats, float]:
    """Values that a controller brings in the shifts of some seeds, and the processor time [s]."""
    core, begin = line_core(env), process_time()
    controller = registry.make(name, core)
    controller.reset(0)
    per_minute = shift_values(controller, env, seeds)
    return per_minute * core.config.duration / 60.0, process_time() - begin
