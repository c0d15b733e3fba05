"""The oracle: what it leaves of the errors of its throws, and which cells separate it from controllers that err."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from functools import partial
from typing import Any, final

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Actions, Controller, Observation
from agents.ground import metrics
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import throw_held_out
from agents.judging.throw_record import summary
from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.cells import CELLS, oracle_actions, throw, zero_actions
from pnt_gym.arrays import Bools
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.core import Core


@final
class FixedPoint(Controller):
    """The best of four previews, each from the one before by the whole error: action <- action - error / scale."""

    name = "fixed_point"

    def __init__(self, core: Core, correction: Correction) -> None:
        self._core, self._correction = core, correction

    def act(self, observation: Observation) -> Actions:
        """The best of the four for each throw, (N, E)."""
        trial = best = np.zeros((len(observation.kind), self._correction.count))
        smallest = np.full((len(best), 1), np.inf)
        for _ in range(4):
            preview = self._core.preview(trial)
            error = np.stack([getattr(preview, name) for name in self._correction.errors], axis=-1)
            size = np.nan_to_num(np.hypot.reduce(error / self._correction.tolerance, axis=1, keepdims=True), nan=np.inf)
            best, smallest = np.where(size < smallest, trial, best), np.minimum(size, smallest)
            trial = np.clip(trial - np.nan_to_num(error) / self._correction.scale, -1.0, 1.0)
        return best.astype(np.float32)


@final
class Watched(Controller):
    """A controller whose throws are simulated once more without what is drawn anew in each."""

    name = "watched"

    def __init__(self, controller: Controller, core: Core) -> None:
        self._controller, self._core = controller, core
        self.previewed = np.zeros(0)
        self.at_bound = np.zeros(0)

    def act(self, observation: Observation) -> Actions:
        """Actions of the controller (N, E)."""
        actions = self._controller.act(observation)
        preview = self._core.preview(actions)
        thrown = ~getattr(preview, "dropped", np.zeros(len(actions), dtype=np.bool_))
        self.previewed = np.append(self.previewed, preview.landing_error[thrown])
        self.at_bound = np.append(self.at_bound, (np.abs(actions) > 0.999).any(axis=1))
        return actions


def previews(settings: Settings, amount: Amount) -> Figures:
    """Figures of a controller, lengths in m.

    `previewed` is what it has simulated of its own throws, all hidden values known; what was thrown adds to it is drawn
    anew in every throw. `at_bound` is the share of throws whose action ends at the edge of its range.

    Args:
        settings: `env`, `level`, and `controller`, a name or "fixed_point".
        amount: throws.
    """
    with closing(make_vector(settings["env"], settings["level"], CELLS, 1)) as env:
        core, name = core_of(env), settings["controller"]
        if core.correction is None:
            raise RuntimeError(f"level {core.config.name!r}: actions do not shift the landing")
        fixed = name == FixedPoint.name
        watched = Watched(FixedPoint(core, core.correction) if fixed else make_controller(name, env), core)
        worth = summary(throw_held_out(watched, env, amount.throws, amount.seed))
    return {
        "previewed_mean_m": float(np.nanmean(watched.previewed)),
        "at_bound": float(watched.at_bound.mean()),
        **{name: worth[name] for name in ("landing_error_mean_m", "landing_error_p95_m", "success_rate")},
    }


def errors(settings: Settings, amount: Amount) -> Figures:
    """Success of picked objects: of the planner, of the oracle, and of the oracle with normal errors added.

    Args:
        settings: `level`; `errors_m`, the mean landing errors that are added, alike in both directions.
        amount: throws.
    """
    picked, planned = _successes(settings, amount, zero_actions)
    _, exact = _successes(settings, amount, oracle_actions)
    near, far = (
        _successes(settings, amount, partial(oracle_actions, error=error))[1] for error in settings["errors_m"]
    )
    return {
        "picked": float(picked.mean()),
        "analytic": float(planned[picked].mean()),
        "oracle": vars(metrics.wilson(int(exact[picked].sum()), int(picked.sum()))),
        "near": float(near[picked].mean()),
        "far": float(far[picked].mean()),
        "difference": vars(metrics.difference(near[picked].astype(float), far[picked].astype(float))),
    }


def _successes(settings: Settings, amount: Amount, act: Callable[[Core], Any]) -> tuple[Bools, Bools]:
    """Which objects were picked, and which throws succeeded."""
    info = throw(settings["level"], amount, act)
    return info["picked"].astype(np.bool_), info["is_success"].astype(np.bool_)
