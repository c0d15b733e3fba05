"""Doing one piece of the benchmark: learn, throw the held-out objects or work the held-out shifts, keep every one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from pnt_gym.arrays import Bools
from pnt_gym.cells.line.config import LineConfig

from ..controllers import Learner, make_controller
from ..controllers.apart import Apart
from ..controllers.between import as_seen
from ..controllers.own import run_policy
from ..controllers.protocol import Controller
from ..dispatchers.registry import line_of
from ..dispatchers.scored import run_scores
from ..ground.environments import Env, core_of, make_vector, stream_seed
from ..jobs.work import Job
from ..judging.evaluation import held_out, practise
from ..judging.throws import FAILURES, Throws
from ..judging.work_shifts import worked
from ..learning import runs
from ..lessons.training import line_settings, more_price
from . import lines
from .entries import TRAINED, labels_of, settings_of
from .plan import Piece, Plan, pieces

OUTCOMES = {
    "sorted": "s",
    "astray": "a",
    "unpicked": "p",
    "dropped": "d",
    "recontact": "t",
    "rim": "r",
    "missed": "m",
}
"""Letter of each outcome: sorted; a success in a bin of another kind; not picked; lost on the way to the release;
touched again by the robot; crossed the opening only; or missed it, which every failure counts as in a cell that does
not tell how a throw failed."""


Able: TypeAlias = Callable[[str, Env], Controller]
"""Gives a controller of a name that has learned, for the cells that it is evaluated in."""


def jobs(plan: Plan) -> list[Job]:
    """The plan's work, as processes do it side by side."""
    return [Job(piece.name, piece.key, partial(run_piece, piece), piece.cost) for piece in pieces(plan)]


def run_piece(piece: Piece, kept: Path) -> dict[str, Any]:
    """Results of a piece of work; training leaves its run in the folder `kept` and goes on from there."""
    results: list[dict[str, Any]] = []
    named = list(zip(labels_of(piece.entry), (piece.entry.controller, *piece.entry.also), strict=True))
    for throws, seconds, able in _learn(piece, kept):
        for level, (label, name) in product(piece.levels, named):
            with closing(_cells(piece, level)) as env:
                found = _judged(able(name, env), env, piece, level)
            head = {"label": label, "controller": name, "throws": throws}
            more = {"seed": piece.seed, "level": level, "train_level": piece.train_level, "learn_seconds": seconds}
            results.append({**head, **more, "columns": found})
    return {"results": results}


def _judged(controller: Controller, env: Env, piece: Piece, level: str) -> dict[str, Any]:
    """What is kept of the throws, or of the shifts at a line, by which a controller is judged."""
    plan, line = piece.plan, line_of(env)
    if line is None:
        return columns(held_out(controller, env, plan.picks_of(level), plan.seed, online=piece.entry.online))
    shifts = piece.entry.shifts or plan.shifts
    return lines.columns(worked(controller, env, shifts, stream_seed("evaluate", plan.seed)), line)


def _cells(piece: Piece, level: str, count: int | None = None) -> Env:
    return make_vector(piece.plan.env, piece.configs.get(level, level), count or piece.plan.num_envs, threads=1)


def columns(throws: Throws) -> dict[str, Any]:
    """Throws as columns, rounded to 0.01 mm and 0.1 ms; cells without an along and across tell the error alone."""
    told = {"along_m": "landing_along", "across_m": "landing_across"}
    places = {column: throws.told[name] for column, name in told.items() if name in throws.told}
    return {
        "item": throws.item.tolist(),
        **{column: _rounded(values, 5) for column, values in (places or {"error_m": throws.landing_error}).items()},
        "cycle_s": _rounded(throws.cycle_time, 4),
        "outcome": _outcomes(throws),
        **({"pick": throws.told["pick_in_shift"].tolist()} if "pick_in_shift" in throws.told else {}),
        "clipped": int(throws.clipped.sum()),
        "recontact": int(_flag(throws, "recontact").sum()),
        **_counts(throws),
    }


def _counts(throws: Throws) -> dict[str, float]:
    """Of all throws together, as far as the cell tells: objects in any bin and where they belong, passed, and joules.

    Those that were lost on the way are counted beside the letters, which tell of none that was sorted nevertheless.
    """
    told, found = throws.told, dict[str, float]()
    if "belongs" in told:
        found |= {"ended": int((told["ended_in"] >= 0).sum()), "belong": int(told["belongs"].sum())}
    for name in ("passed", "dropped"):
        if name in told:
            found[name] = int(told[name].sum())
    return found | ({"energy_j": round(float(told["energy"].sum()), 1)} if "energy" in told else {})


def _outcomes(throws: Throws) -> str:
    """One letter of `OUTCOMES` per throw."""
    *letters, missed = OUTCOMES.values()
    kinds = [throws.sorted, throws.is_success, *(_flag(throws, name) for name in FAILURES)]
    return "".join(np.select(kinds, letters, missed))


def _flag(throws: Throws, name: str) -> Bools:
    found = throws.flag(name)
    return np.zeros(len(throws), dtype=np.bool_) if found is None else found


def _rounded(values: np.ndarray, digits: int) -> list[float | None]:
    return [round(float(v), digits) if np.isfinite(v) else None for v in values]


def _learn(piece: Piece, kept: Path) -> Iterator[tuple[int, float, Able]]:
    """Throws or decisions learned from, seconds it took, and what knows them, for each count of the piece."""
    if piece.entry.controller in TRAINED:
        yield from _train(piece, kept)
        return
    if piece.entry.controller == lines.FOUND and piece.throws[0] > 0:
        yield _search(piece)
        return
    with closing(_cells(piece, piece.train_level)) as env:
        controller = _made(piece, piece.entry.controller, env)
        controller.reset(piece.seed)
        began = time.perf_counter()
        practise(controller, env, piece.throws[0], piece.seed)
        seconds = round(time.perf_counter() - began, 1)
    yield piece.throws[0], seconds, partial(_transfer, controller, piece)


def _search(piece: Piece) -> tuple[int, float, Able]:
    """The same of a search, which is for the whole of its decisions at once."""
    began = time.perf_counter()
    level = LineConfig.load(piece.configs.get(piece.train_level, piece.train_level), throws="table")
    found = lines.searched(level, piece.throws[0], piece.seed)
    return piece.throws[0], round(time.perf_counter() - began, 1), lambda name, env: found


def _train(piece: Piece, kept: Path) -> Iterator[tuple[int, float, Able]]:
    """Train, or go on training, and yield the policy at each count of throws or decisions."""
    from ..learning.progress import Stop  # noqa: PLC0415 - imports torch
    from ..learning.sb3 import build  # noqa: PLC0415
    from ..learning.vec_env import SameStepVecEnv  # noqa: PLC0415
    from ..lessons.course import in_flight, learn  # noqa: PLC0415

    algo, folder = piece.entry.controller, kept / f"{piece.name}-{piece.key}-run"
    settings = settings_of(piece.entry, piece.plan.env)
    cells = _cells(piece, piece.train_level, settings.get("n_envs"))
    core = core_of(cells)
    asked = {
        "env": piece.plan.env,
        "level": piece.train_level,
        "algo": algo,
        "steps": max(piece.throws),
        "seed": piece.seed,
        "num_envs": cells.num_envs,
        "action_mode": core.action_mode,
        "checkpoint_every": max(piece.throws),
        "stack": piece.entry.stack,
        "over": piece.entry.over,
        "fidelity": piece.entry.fidelity,
    }
    settings = line_settings(asked, settings, cells)
    quick, price = in_flight(cells, asked, threads=1), more_price(settings, cells)
    env = SameStepVecEnv(as_seen(cells, asked), even=algo in runs.ON_POLICY, price=price)
    if runs.checkpoints(folder):
        model = runs.restore(folder, env)
    else:
        model = build(algo, env, settings, piece.seed)
        runs.create(folder, asked, settings, core.config, model)
    for throws in piece.throws:
        began = time.perf_counter()
        if model.num_timesteps < throws:
            leg = {**asked, "checkpoint_every": throws}
            learn(model, env, folder, leg, Stop(), quick=quick, until=throws, quiet=True)
        seconds = round(time.perf_counter() - began, 1)
        place = next(p for p in runs.checkpoints(folder) if int(p.name) >= throws)
        yield throws, seconds, _policy(folder, place, asked, piece)
    env.close()
    if quick is not None:
        quick.close()


def _policy(folder: Path, place: Path, asked: Mapping[str, Any], piece: Piece) -> Able:
    """What a training has left in a checkpoint, as a controller of the level that is evaluated."""
    if asked["algo"] in runs.CHOOSING:
        scores = run_scores(folder, place)
        return lambda name, env: scores
    actor = runs.load_actor(folder, place)
    return lambda name, env: run_policy(actor, asked, env, piece.name, name)


def _transfer(controller: Controller, piece: Piece, name: str, env: Env) -> Controller:
    """The same knowledge in a controller of the level that is evaluated; one for each cell, where all learn on."""
    count = env.num_envs if piece.entry.online else 1
    able = [_informed(controller, piece, name, env) for _ in range(count)]
    return Apart(able) if piece.entry.online else able[0]


def _informed(controller: Controller, piece: Piece, name: str, env: Env) -> Controller:
    able = _made(piece, name, env)
    able.reset(piece.seed)
    if isinstance(able, Learner) and isinstance(controller, Learner) and max(piece.throws) > 0:
        able.restore(controller.state())
    return able


def _made(piece: Piece, name: str, env: Env) -> Controller:
    """A controller by name; the settings of the entry are those of its own."""
    options = piece.entry.options if name == piece.entry.controller else {}
    if line_of(env) is None:
        return make_controller(name, env, **options)
    return lines.controller(piece.entry.label, name, env, options)
