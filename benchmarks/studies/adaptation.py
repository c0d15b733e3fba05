"""What a camera over the bins must see, and how soon a kind of item is learned that nobody has practised."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from typing import Final

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Controller
from agents.ground import metrics
from agents.ground.cli import UsageError
from agents.ground.environments import Env, core_of, make_vector
from agents.judging.loop import throw_held_out
from agents.judging.throws import Throws
from agents.results.study import Amount, Figures, Settings
from pnt_gym.arrays import Floats, Ints

ENV: Final = "PnTAdapt-v0"
NEAR_FLOOR: Final = 1.1
"""A kind is learned when its error is at most so many times its floor."""
NEXT: Final = 3
"""Throws over whose mean that is judged."""
COUNTED: Final = 8
"""Throws of a kind that are told one by one."""


def camera(settings: Settings, amount: Amount) -> list[Figures]:
    """Landing errors of controllers, and what each is less than that of the first one, shift by shift.

    Args:
        settings: `level`, the names of the `controllers`, and how many `rows` there are side by side.
        amount: shifts.

    Raises:
        UsageError: they do not fill all rows.
    """
    if amount.throws % settings["rows"] > 0:
        raise UsageError(f"throws is {amount.throws}; shifts come {settings['rows']} at a time")
    with closing(make_vector(ENV, settings["level"], settings["rows"], 1)) as env:
        picks = core_of(env).cell.episode
        errors = {
            name: _by_shift(throw_held_out(make_controller(name, env), env, amount.throws * picks, amount.seed), env)
            for name in settings["controllers"]
        }
    static = next(iter(errors.values()))
    return [
        {"controller": name, "error_m": vars(metrics.interval(e)), "over_static_m": vars(metrics.difference(e, static))}
        for name, e in errors.items()
    ]


def _by_shift(throws: Throws, env: Env) -> Floats:
    """Mean landing error of every shift (S,) [m]."""
    return np.nanmean(throws.landing_error.reshape(-1, core_of(env).cell.episode, env.num_envs), axis=1).ravel()


def newcomers(settings: Settings, amount: Amount) -> Iterator[Figures]:
    """Errors after so many throws of each new kind, against its floor, and what the known kinds feel of it.

    The floor of a kind is what the first controller leaves of it once the kind's mean landing is taken off, which
    nobody knows beforehand. Every row of the cells is a trial of its own.

    Args:
        settings: `level`, the names of the `controllers` and of the `new` kinds, how many `rows` there are
            side by side, and how many `trials` each has.
        amount: the seed alone.
    """
    rows, count = settings["rows"], settings["trials"]
    with closing(make_vector(ENV, settings["level"], rows, 1)) as env:
        names, controllers = core_of(env).item_names, settings["controllers"]
        trials = {name: _trials(make_controller(name, env), env, count, amount.seed) for name in controllers}
    new = [names.index(name) for name in settings["new"]]
    known_errors = {name: _error_of_known_kinds(throws, new) for name, throws in trials.items()}
    for kind in new:
        floor = _floor(trials[controllers[0]], kind)
        for name in controllers:
            errors = _by_number(trials[name], kind, rows)
            yield {
                "kind": names[kind],
                "controller": name,
                **_learning_figures(errors, floor),
                "known_mean_m": known_errors[name],
            }


def _trials(controller: Controller, env: Env, count: int, seed: int) -> list[Throws]:
    """Shifts from whose beginning nothing is known of the newcomers."""
    trials: list[Throws] = []
    for trial in range(count):
        controller.reset(0)
        trials.append(throw_held_out(controller, env, env.num_envs * core_of(env).cell.episode, seed + trial))
    return trials


def _error_of_known_kinds(trials: list[Throws], new: list[int]) -> float:
    """Mean error of the kinds that are not new [m]."""
    return float(np.nanmean(np.concatenate([t.landing_error[~np.isin(t.item, new)] for t in trials])))


def _throw_numbers(throws: Throws, kind: int, rows: int) -> Ints:
    """Number of each landed throw of a kind among those of its row, from 1 on; 0 for other throws (N,)."""
    landed = (throws.item == kind) & np.isfinite(throws.landing_error)
    grid = landed.reshape(-1, rows)
    return (np.cumsum(grid, axis=0) * grid).ravel()


def _by_number(trials: list[Throws], kind: int, rows: int) -> list[float]:
    """Mean error of the first, second ... throw of a kind, and of all later ones [m]."""
    number = np.concatenate([_throw_numbers(throws, kind, rows) for throws in trials])
    error = np.concatenate([throws.landing_error for throws in trials])
    parts = [number == k for k in range(1, COUNTED + 1)]
    return [float(error[rows].mean()) for rows in (*parts, number > COUNTED)]


def _floor(trials: list[Throws], kind: int) -> float:
    """Mean distance of the landings of a kind from their mean, along and across [m]."""
    columns = [np.stack([t.info["landing_along"], t.info["landing_across"]], axis=1)[t.item == kind] for t in trials]
    landings = np.concatenate(columns).astype(np.float64)
    landings = landings[np.isfinite(landings).all(axis=1)]
    return float(np.hypot(*(landings - landings.mean(axis=0)).T).mean())


def _learning_figures(errors: list[float], floor: float) -> Figures:
    """Errors and floor of a kind [m], throws until it is near the floor, and what these cost in all."""
    return {
        "floor_m": floor,
        "error_m": errors,
        "throws_to_floor": _until(errors, NEAR_FLOOR * floor),
        "regret_m": float(np.sum(np.array(errors[:COUNTED]) - floor)),
    }


def _until(errors: list[float], near: float) -> int | None:
    """Throws after which the mean of all that follow is near; None for more than are counted."""
    following = [float(np.mean(errors[k : k + NEXT])) for k in range(COUNTED - NEXT + 1)]
    return next((k for k, error in enumerate(following) if error <= near), None)
