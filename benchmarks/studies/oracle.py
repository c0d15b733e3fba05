"""What controllers leave that simulate their throws before: the scatter of the release, and where an action ends."""

from __future__ import annotations

from contextlib import closing
from typing import final

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Actions, Controller, Observation
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import throw_held_out
from agents.judging.throws.data import summary
from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.cells import CELLS
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


def figures(settings: Settings, amount: Amount) -> Figures:
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
