"""What throwing makes of an order of picks: work shifts of a line, by the tables of throws or really thrown."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Final

from agents.controllers.protocol import Controller
from agents.dispatchers import registry
from agents.dispatchers.decisions import make_release
from agents.dispatchers.registry import ENV, NAMES, line_core
from agents.ground import metrics
from agents.ground.environments import Env, make_vector, stream_seed
from agents.ground.places import SHIPPED, at
from agents.judging.shifts import Shifts, run_shifts
from agents.results.study import Amount, Figures, Settings
from pnt_gym.cells.line.core import LineCore

LEARNED: Final = SHIPPED / "results" / "policies" / "PnTLine-v0"
"""Run folders of what was learned, LEVEL/NAME."""


def orders(settings: Settings, amount: Amount) -> Figures:
    """Figures of a controller, under `full` really thrown and under `table` by the tables of throws.

    Args:
        settings: `level`, the name of the `controller`, and how many `rows` work side by side.
        amount: shifts.
    """
    level, figures = {"name": settings["level"]["base"], **settings["level"]}, Figures()
    for throws in ("full", "table"):
        with closing(make_vector(ENV, {**level, "throws": throws}, settings["rows"], 1)) as env:
            controller = _controller(settings["controller"], level["base"], line_core(env))
            figures[throws] = _figures(_shifts(controller, env, amount))
    return figures


def release(settings: Settings, amount: Amount) -> Iterator[Figures]:
    """Figures with each release and each order on the same shifts, and what each brings in over the first row.

    Args:
        settings: `level`, the `releases`, names of controllers of single throws or run folders by what rows call them,
            the names of the `orders`, and how many `rows` work side by side.
        amount: shifts.
    """
    level, first = settings["level"], None
    with closing(make_vector(ENV, level, settings["rows"], 1)) as env:
        core = line_core(env)
        for label, name in settings["releases"].items():
            core.use(make_release(str(at(name)) if "/" in name else name, core.config))
            for order in settings["orders"]:
                shifts = _shifts(_controller(order, level["base"], core), env, amount)
                first = shifts if first is None else first
                yield {"release": label, "order": order, **_figures(shifts, first)}


def _controller(name: str, level: str, core: LineCore) -> Controller:
    """A controller by name, or what was learned for a level."""
    return registry.make(name if name in NAMES else str(LEARNED / level / name), core)


def _shifts(controller: Controller, env: Env, amount: Amount) -> Shifts:
    controller.reset(amount.seed)
    return run_shifts(controller, env, amount.throws, stream_seed("evaluate", amount.seed))


def _figures(shifts: Shifts, first: Shifts | None = None) -> Figures:
    """What is kept of shifts, with the gain over others where there are any."""
    picked = shifts.decisions["picked"].astype(bool)
    values = shifts.value
    return {
        "value_per_min": vars(metrics.interval(values)),
        "value_per_min_by_shift": values.tolist(),
        **({} if first is None else {"gain": vars(metrics.interval((values - first.value) / first.value.mean()))}),
        "picks": len(picked),
        "pick_rate": float(picked.mean()),
        "success": float(shifts.decisions["is_success"].astype(bool)[picked].mean()),
        "invalid": shifts.invalid,
    }
