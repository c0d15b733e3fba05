"""What a camera over the bins must see, and how soon a kind of item is learned that nobody has practised.

Camera: shifts of `day` with what ships, at other noises of the bin's camera and with landings that it misses.
Newcomers: shifts of `newcomers`, in flights alone, in which three kinds come that the controllers do not know; the
floor of each is what the static policy leaves of it once the kind's mean landing is taken off, which nobody knows
beforehand. Every row of the cell is a trial of its own, in which the throws of each kind are counted that came down. A
kind is learned after as many throws as it takes until the mean of the next three is within 1.1 times its floor.

Run: python benchmarks/study_adaptation.py --json results/adaptation.json      (20 minutes)
"""

from __future__ import annotations

import sys
from contextlib import closing
from typing import Any, Final

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Controller
from agents.ground.environments import Env, core_of, make_vector
from agents.ground.files import write_json
from agents.ground.metrics import mean_interval, paired_mean
from agents.ground.versions import versions
from agents.judging.loop import held_out
from agents.judging.throws.data import Throws
from benchmarks.study import study_options, study_parser

ENV: Final = "PnTAdapt-v0"
CONTROLLERS: Final = ("static", "ema", "kalman", "in_context", "oracle_drift")
CAMERAS: Final[dict[str, dict[str, float]]] = {
    "exact": {"noise": 0.0, "unseen": 0.0},
    "5 mm": {"noise": 0.005, "unseen": 0.0},
    "10 mm": {"noise": 0.010, "unseen": 0.0},
    "20 mm": {"noise": 0.020, "unseen": 0.0},
    "5 mm, 30 % unseen": {"noise": 0.005, "unseen": 0.3},
    "blind": {"noise": 0.005, "unseen": 1.0},
}
ROWS: Final = 32
NEW: Final = ("pet_half_full", "wet_paper", "sticky_pot")
SHIFT: Final = 130
"""Picks in a shift with newcomers."""
TRIALS: Final = 12
"""Shifts with newcomers, in each of all rows."""
NEAR_FLOOR: Final = 1.1
NEXT: Final = 3
COUNTED: Final = 8
"""Throws of a kind that are told one by one."""


def by_shift(throws: Throws, picks: int) -> Any:
    """Mean landing error of every shift (S,) [m]."""
    return np.nanmean(throws.landing_error.reshape(-1, picks, ROWS), axis=1).ravel()


def camera(shifts: int, seed: int, threads: int) -> dict[str, Any]:
    """Landing errors by camera and controller, and what each is less than that of `static`, shift by shift."""
    found: dict[str, Any] = {}
    for name, feedback in CAMERAS.items():
        with closing(make_vector(ENV, {"base": "day", "feedback": feedback}, ROWS, threads)) as env:
            picks = core_of(env).cell.episode
            errors = {
                who: by_shift(held_out(make_controller(who, env), env, shifts * picks, seed), picks)
                for who in CONTROLLERS
            }
        found[name] = {
            who: {"error": vars(mean_interval(e)), "over_static": vars(paired_mean(e, errors["static"]))}
            for who, e in errors.items()
        }
        print(f"{name:20}", {who: round(1000 * float(e.mean()), 1) for who, e in errors.items()}, flush=True)
    return found


def numbered(throws: Throws, kind: int) -> Any:
    """Of throws of a kind that came down, which one of its row each is, the first being 1; 0 for others (N,)."""
    mine = (throws.item == kind) & np.isfinite(throws.landing_error)
    grid = mine.reshape(-1, ROWS)
    return (np.cumsum(grid, axis=0) * grid).ravel()


def newcomers(seed: int, threads: int) -> dict[str, Any]:
    """Errors after so many throws of each kind, against its floor, and what the known kinds feel of it."""
    level = {"base": "newcomers", "fidelity": "flight", "picks_per_shift": SHIFT}
    with closing(make_vector(ENV, level, ROWS, threads)) as env:
        names = core_of(env).item_names
        thrown = {who: _trials(make_controller(who, env), env, seed) for who in CONTROLLERS[:-1]}
    new = [names.index(name) for name in NEW]
    errors = {who: [_by_number(trials, kind) for kind in new] for who, trials in thrown.items()}
    return {
        "trials": TRIALS * ROWS,
        "kinds": {
            name: _kind({who: found[k] for who, found in errors.items()}, _floor(thrown["static"], new[k]))
            for k, name in enumerate(NEW)
        },
        "known_mean_m": {
            who: float(np.nanmean(np.concatenate([t.landing_error[~np.isin(t.item, new)] for t in trials])))
            for who, trials in thrown.items()
        },
    }


def _trials(controller: Controller, env: Env, seed: int) -> list[Throws]:
    """Shifts from whose beginning nothing is known of the newcomers."""
    found: list[Throws] = []
    for trial in range(TRIALS):
        controller.reset(0)
        found.append(held_out(controller, env, ROWS * SHIFT, seed + trial))
    print(f"newcomers by {controller.name}", flush=True)
    return found


def _by_number(trials: list[Throws], kind: int) -> list[float]:
    """Mean error of the first, second ... throw of a kind, and of all later ones [m]."""
    number = np.concatenate([numbered(throws, kind) for throws in trials])
    error = np.concatenate([throws.landing_error for throws in trials])
    parts = [number == k for k in range(1, COUNTED + 1)]
    return [float(error[rows].mean()) for rows in (*parts, number > COUNTED)]


def _floor(trials: list[Throws], kind: int) -> float:
    """Mean distance of the landings of a kind from their mean, along and across [m]."""
    columns = [np.stack([t.told["landing_along"], t.told["landing_across"]], axis=1)[t.item == kind] for t in trials]
    landings = np.concatenate(columns).astype(np.float64)
    landings = landings[np.isfinite(landings).all(axis=1)]
    return float(np.hypot(*(landings - landings.mean(axis=0)).T).mean())


def _kind(errors: dict[str, list[float]], floor: float) -> dict[str, Any]:
    """Of one kind: errors by controller, its floor [m], throws until it is near, and what they cost in all."""
    return {
        "floor_m": floor,
        "error_m": errors,
        "throws_to_floor": {who: _until(found, NEAR_FLOOR * floor) for who, found in errors.items()},
        "regret_m": {who: float(np.sum(np.array(found[:COUNTED]) - floor)) for who, found in errors.items()},
    }


def _until(errors: list[float], near: float) -> int | None:
    """Throws after which the mean of all that follow is near; None for more than are counted."""
    following = [float(np.mean(errors[k : k + NEXT])) for k in range(COUNTED - NEXT + 1)]
    return next((k for k, error in enumerate(following) if error <= near), None)


def main() -> None:
    options = study_options(study_parser(__doc__, 32, "camera, in shifts"))
    if options.throws % ROWS > 0:
        sys.exit(f"--throws is {options.throws}; shifts come {ROWS} at a time")
    result = {
        "shifts": options.throws,
        "seed": options.seed,
        "versions": versions(),
        "camera": camera(options.throws, options.seed, options.threads),
        "newcomers": newcomers(options.seed, options.threads),
    }
    if options.json:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
