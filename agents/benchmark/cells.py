"""Doing one cell of the benchmark: learn, throw the held-out objects, keep every throw."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from agents import runs
from agents.benchmark.plan import Cell
from agents.controllers import Learner, make_controller
from agents.controllers.protocol import Controller
from agents.controllers.sb3 import Sb3
from agents.environments import make_vector
from agents.evaluation import Env, Throws, evaluate, practise
from agents.files import write_json
from agents.hyperparameters import hyperparameters
from agents.runs import ALGORITHMS
from agents.workers import quiet_interrupt

OUTCOMES = {"sorted": "s", "recontact": "t", "rim": "r", "missed": "m"}
"""Letter of each outcome: sorted, touched again by the cup, crossed the opening only, missed it."""


def settle_worker() -> None:
    """Prepare a worker process."""
    import torch  # noqa: PLC0415 - takes a second to import

    quiet_interrupt()
    torch.set_num_threads(1)


def run_cell(cell: Cell, work: Path) -> Path:
    """Do a cell and keep its results in `work`; returns their file."""
    began = time.perf_counter()
    results: list[dict[str, Any]] = []
    for throws, seconds, controller in _learn(cell, work):
        for level in cell.levels:
            env = make_vector(cell.env, level, cell.num_envs, threads=1)
            able = _transfer(controller, cell, env)
            found = evaluate(able, env, cell.picks, cell.eval_seed)
            env.close()
            head = {"label": cell.entry.label, "controller": cell.entry.controller, "throws": throws}
            more = {"seed": cell.seed, "level": level, "train_level": cell.train_level, "learn_seconds": seconds}
            results.append({**head, **more, "columns": columns(found)})
    path = work / f"{cell.name}.json"
    write_json(path, {"seconds": round(time.perf_counter() - began, 1), "results": results}, indent=None)
    return path


def columns(throws: Throws) -> dict[str, Any]:
    """Throws as columns, rounded to 0.01 mm and 0.1 ms."""
    return {
        "item": throws.item.tolist(),
        "along_m": _rounded(throws.landing_along, 5),
        "across_m": _rounded(throws.landing_across, 5),
        "cycle_s": _rounded(throws.cycle_time, 4),
        "outcome": "".join(outcome_letters(throws)),
        "clipped": int(throws.clipped.sum()),
        "recontact": int(throws.recontact.sum()),
    }


def outcome_letters(throws: Throws) -> list[str]:
    """One letter of `OUTCOMES` per throw."""
    kinds = [throws.is_success, throws.recontact, throws.rim]
    letters = [OUTCOMES["sorted"], OUTCOMES["recontact"], OUTCOMES["rim"]]
    return np.select(kinds, letters, OUTCOMES["missed"]).tolist()


def _rounded(values: np.ndarray, digits: int) -> list[float | None]:
    return [round(float(v), digits) if np.isfinite(v) else None for v in values]


def _learn(cell: Cell, work: Path) -> Iterator[tuple[int, float, Controller]]:
    """Throws learned from, seconds it took, and the controller, for each throw count of the cell."""
    if cell.entry.controller in ALGORITHMS:
        yield from _train(cell, work)
        return
    env = make_vector(cell.env, cell.train_level, cell.num_envs, threads=1)
    controller = make_controller(cell.entry.controller, env, **cell.entry.options)
    controller.reset(cell.seed)
    began = time.perf_counter()
    practise(controller, env, cell.throws[0], cell.seed)
    seconds = round(time.perf_counter() - began, 1)
    env.close()
    yield cell.throws[0], seconds, controller


def _train(cell: Cell, work: Path) -> Iterator[tuple[int, float, Controller]]:
    """Train, or go on training, and yield the policy at each throw count."""
    from agents.progress import Stop  # noqa: PLC0415 - imports torch
    from agents.sb3 import SameStepVecEnv, build  # noqa: PLC0415
    from agents.train import learn  # noqa: PLC0415

    algo, folder = cell.entry.controller, work / f"{cell.name}-run"
    env = SameStepVecEnv(make_vector(cell.env, cell.train_level, cell.num_envs, threads=1))
    core = env.env.unwrapped.core
    asked = {
        "env": cell.env,
        "level": cell.train_level,
        "algo": algo,
        "steps": max(cell.throws),
        "seed": cell.seed,
        "num_envs": cell.num_envs,
        "action_mode": core.action_mode,
        "checkpoint_every": max(cell.throws),
    }
    if runs.checkpoints(folder):
        model = runs.restore(folder, env)
    else:
        settings = {**hyperparameters(algo, cell.env), **cell.entry.options}
        model = build(algo, env, settings, cell.seed)
        runs.create(folder, asked, settings, core.config, model)
    for throws in cell.throws:
        began = time.perf_counter()
        if model.num_timesteps < throws:
            leg = {**asked, "steps": throws, "checkpoint_every": throws}
            learn(model, env, folder, leg, Stop(), quiet=True)
        seconds = round(time.perf_counter() - began, 1)
        place = next(p for p in runs.checkpoints(folder) if int(p.name) >= throws)
        yield int(place.name), seconds, Sb3(runs.load_model(folder, checkpoint=place), algo)
    env.close()


def _transfer(controller: Controller, cell: Cell, env: Env) -> Controller:
    """The same knowledge in a controller of the level that is evaluated."""
    if isinstance(controller, Sb3):
        return controller
    able = make_controller(cell.entry.controller, env, **cell.entry.options)
    able.reset(cell.seed)
    if isinstance(able, Learner) and isinstance(controller, Learner):
        able.restore(controller.state())
    return able
