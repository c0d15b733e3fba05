"""Blind twins: cells with hidden parameters drawn from the priors, whose logs are fitted as if they were real."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats, concatenate_records, take
from pnt_gym.cells.conveyor.config import ConveyorConfig

from ..ground.cli import UsageError
from ..ground.environments import Env, core_of, make_vector, stream_seed
from ..ground.infos import results
from . import design
from .design import DesignPool
from .fitted import Fitted, combinations, fit_log
from .log import ThrowLog, complete
from .parameters import Parameter, level_at, priors, values_at, with_seals

ENV: Final = "PnTRelease-v0"
"""Environment of the twins."""
CELLS: Final = 16
"""Cells side by side."""
SEALS: Final = 0.05
"""Largest difference of the chances that cups seal from the level's."""
MOST_THROWS: Final = 20
"""Throws of a twin per landing that its log must have, at most."""


@final
@dataclass(frozen=True)
class Twin:
    """A cell with hidden parameters, and its log."""

    scores: Floats
    """Standard scores of the hidden parameters (P,)."""
    truth: ConveyorConfig
    log: ThrowLog


def _scores(parameters: tuple[Parameter, ...], random: np.random.Generator) -> Floats:
    """Standard scores of hidden parameters (P,), such as a cell may have."""
    while True:
        scores = random.standard_normal(len(parameters))
        values = values_at(parameters, scores)
        if values.get("valve", 1.0) > 0.0 and all(values[p.name] >= p.least for p in parameters):
            return scores


def make(
    config: ConveyorConfig,
    seed: int,
    landings: int,
    *,
    hidden: Mapping[str, Any] | None = None,
    draught: float = 0.0,
    planned: bool = False,
    parameters: tuple[Parameter, ...] | None = None,
) -> Twin:
    """A twin of a level, and its log of a number of landings.

    Args:
        config: the level that is known of the cell.
        seed: of hidden parameters, objects and noise.
        landings: number of landings; the log has more throws.
        hidden: further sections of the true level, such as another jitter, of which the fit does not know.
        draught: speed of air that moves through the cell in a drawn direction [m/s].
        planned: whether throws are those of a plan for such a cell, and not those that come.
        parameters: the parameters that are not known; None for all.
    """
    parameters, random = parameters or priors(config), np.random.default_rng((seed, 1))
    drawn = level_at(config, values_at(parameters, _scores(parameters, random)))
    angle = random.uniform(0.0, 2.0 * np.pi)
    shift = random.uniform(-SEALS, SEALS)
    chances = {item.name: float(np.clip(item.pick_chance + shift, 0.01, 1.0)) for item in config.item_list()}
    whole = with_seals(drawn, chances).model_dump(exclude_unset=True)
    truth = ConveyorConfig.load(ConveyorConfig.merge(whole, hidden or {}))
    scores = np.array([parameter.score(parameter.read(truth)) for parameter in parameters])
    air = draught * np.array([np.cos(angle), np.sin(angle)])
    log = log_plan(parameters, config, truth, seed, landings) if planned else log_throws(truth, seed, landings, air)
    last = np.flatnonzero(log.has_landing)[landings - 1]
    return Twin(scores, truth, take(log, slice(int(last) + 1)))


def log_throws(truth: ConveyorConfig, seed: int, landings: int, draught: Floats) -> ThrowLog:
    """Log of at least a number of landings of the analytic planner in a cell, through which air may move.

    Args:
        truth: the cell.
        seed: of objects and noise.
        landings: number of landings.
        draught: velocity of the air along x, y [m/s], of which no level without drift can tell.
    """
    with closing(make_vector(ENV, truth, CELLS, 1)) as env:
        core, parts = core_of(env), list[tuple[ThrowLog, dict[str, Any]]]()
        env.reset(seed=stream_seed("evaluate", seed))
        for throws in range(2 * landings, MOST_THROWS * landings, landings):
            while CELLS * len(parts) < throws:
                parts.append(_throw(env, core, draught))
            known, info = take(concatenate_records(parts), slice(throws))
            log = complete(known, info, truth, np.random.default_rng((seed, 7)))
            if log.has_landing.sum() >= landings:
                return log
        raise UsageError(f"twin {seed} has fewer than {landings} landings in {MOST_THROWS * landings} throws")


def _throw(env: Env, core: Any, draught: Floats) -> tuple[ThrowLog, dict[str, Any]]:
    """What a cell knew of the planner's next throws, and the results by info key."""
    if draught.any():
        context = core.cell.context
        wind = np.tile(draught, (len(context.pick), 1))
        core.cell.context = context.replace(drift=context.drift.replace(draught=wind))
    actions = np.zeros((core.count, *core.action_space.shape), dtype=np.float32)
    known = ThrowLog.of(core.context, core.plan(actions)[0])
    return known, results(env.step(actions)[-1], core.count)


def log_plan(
    parameters: tuple[Parameter, ...], config: ConveyorConfig, truth: ConveyorConfig, seed: int, landings: int
) -> ThrowLog:
    """Log of the throws that a plan chooses for a level, thrown in a cell; enough for a number of landings."""
    with closing(DesignPool(truth, seed)) as pool:
        worth = design.information(pool.log, config, parameters, np.zeros(len(parameters)))
        thrown = pool.throw(seed)
        for throws in range(2 * landings, MOST_THROWS * landings, landings):  # a longer plan begins with a shorter one
            log = take(thrown, design.choose(worth.slopes, throws).rows)
            if log.has_landing.sum() >= landings:
                return log
        raise UsageError(f"twin {seed} has fewer than {landings} landings in {MOST_THROWS * landings} planned throws")


def judge(twin: Twin, fitted: Fitted) -> dict[str, Any]:
    """What a fit says of a twin, against the truth: error in prior deviations and whether the interval holds it."""
    samples = fitted.posterior.samples()
    parameters = fitted.posterior.parameters
    low, high = np.quantile(samples, (0.025, 0.975), axis=0)
    names = [parameter.name for parameter in parameters]
    figures: dict[str, Any] = {
        name: {
            "error": float(abs(fitted.posterior.z[k] - twin.scores[k])),
            "holds": bool(low[k] <= twin.scores[k] <= high[k]),
        }
        for k, name in enumerate(names)
    }
    seals = {item.name: item.pick_chance for item in twin.truth.item_list()}
    for seal in fitted.seals:
        true_chance = seals[seal.item]
        figures[f"seal_{seal.item}"] = {
            "error": abs(seal.mean - true_chance), "holds": bool(seal.low <= true_chance <= seal.high)
        }  # fmt: skip
    true = values_at(parameters, twin.scores)
    estimates = fitted.combinations(samples)
    for part in combinations(fitted.log, fitted.config):
        if part.name not in estimates:
            continue
        estimate, value = estimates[part.name], float(part.of(true))
        figures[part.name] = {
            "error": abs(estimate.value - value), "holds": bool(estimate.low <= value <= estimate.high)
        }  # fmt: skip
    return figures


def study_twin(
    config: ConveyorConfig,
    seed: int,
    landings: int,
    parameters: tuple[Parameter, ...] | None = None,
    **options: Any,
) -> tuple[Twin, Fitted, float]:
    """A twin, its fit, and the processor time of the fit [s]; options as of `make`."""
    twin = make(config, seed, landings, parameters=parameters, **options)
    begin = time.process_time()
    fitted = fit_log(twin.log, config, parameters or priors(config))
    return twin, fitted, time.process_time() - begin
