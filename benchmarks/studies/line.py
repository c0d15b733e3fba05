"""What throwing makes of an order of picks: work shifts of a line, by the tables of throws or really thrown."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Final

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Controller, Observation
from agents.dispatchers import registry
from agents.dispatchers.decisions import make_release
from agents.dispatchers.registry import ENV, NAMES, line_core
from agents.ground import metrics
from agents.ground.environments import Env, make_vector, stream_seed
from agents.ground.places import SHIPPED, at
from agents.judging import losses, trials
from agents.judging.shifts import Shifts, run_shifts
from agents.line.plans import money_per_hour
from agents.results.study import Amount, Figures, Settings
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.throws import Release

LEARNED: Final = SHIPPED / "results" / "policies" / "PnTLine-v0"
"""Run folders of what was learned, LEVEL/NAME."""
RELEASE: Final = "PnTRelease-v0"
"""Environment in which learners practise single throws."""
ROWS: Final = 32
"""Cells in which they practise side by side."""


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


def robots(settings: Settings, amount: Amount) -> Iterator[Figures]:
    """Figures of a line with the planner's throws and with throws that learners correct, and what the latter gain.

    Each learner practises flights of the line's first robot.

    Args:
        settings: `level`, the name of the `controller`, how many `rows` work side by side, the name of the `learner`,
            its number of `throws`, and the `seeds` of its practice.
        amount: shifts.
    """
    config = LineConfig.load({"name": "robots", **settings["level"]})
    with closing(make_vector(ENV, config, settings["rows"], 1)) as env:
        core = line_core(env)
        controller = registry.make(settings["controller"], core)
        planned = _shifts(controller, env, amount)
        yield {"release": "planner", **_worth([planned], config, planned)}
        learned = list[Shifts]()
        for seed in settings["seeds"]:
            core.use(_practised(settings["learner"], config, settings["throws"], seed))
            learned.append(_shifts(controller, env, amount))
        yield {"release": settings["learner"], **_worth(learned, config, planned)}


def _practised(name: str, config: LineConfig, throws: int, seed: int) -> Release:
    """A learner that has practised flights of a line's first robot, as a function that corrects throws."""
    cell = config.cell_of(0).model_copy(update={"fidelity": "flight"})
    with closing(make_vector(RELEASE, cell, ROWS, 1)) as env:
        learner = make_controller(name, env)
        learner.reset(seed)
        learner = trials.of(env).practise(learner, throws, seed)
    return lambda observation, kind: learner.act(Observation(observation, kind))


def _worth(runs: list[Shifts], config: LineConfig, planned: Shifts) -> Figures:
    """What the same shifts bring, on average over runs, with what they bring over others."""
    paces = np.mean([shifts.figures["shift_sorted_per_min"] for shifts in runs], axis=0)
    shares = np.mean([shifts.figures["shift_recovery"] for shifts in runs], axis=0)
    money = [money_per_hour(shifts, config, None) for shifts in runs]
    energy = [losses.energy(shifts, None)["energy_per_sorted_j"] for shifts in runs]
    return {
        "recovery": vars(metrics.interval(shares)),
        "gained": vars(metrics.difference(shares, planned.figures["shift_recovery"])),
        "sorted_per_min": vars(metrics.interval(paces)),
        "energy_per_sorted_j": None if None in energy else float(np.mean(np.array(energy, dtype=np.float64))),
        "money_per_hour": float(np.mean(np.array(money))) if all(each is not None for each in money) else None,
    }


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
