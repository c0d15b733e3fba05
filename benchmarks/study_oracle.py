"""What the oracle reaches, and what is left of its errors: the scatter of the release, and where an action ends.

Each case is thrown by the analytic planner, by a fixed point with gain 1 (action <- action - error / scale, four
previews, the best one thrown) and by the oracle, on the same objects. `previewed` is what a controller has simulated
of its own throws, all hidden values known; what `thrown` adds to it is drawn anew in every throw. `at_bound` is the
share of throws whose action ends at the edge of its range.

Run: python benchmarks/study_oracle.py --throws 400 --json results/oracle.json      (minutes)
"""

from __future__ import annotations

import sys
from contextlib import closing
from typing import Any, Final, final

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Actions, Controller, Observation
from agents.ground.environments import core_of, make_vector
from agents.ground.files import write_json
from agents.judging.loop import held_out
from agents.judging.throws.data import summary
from benchmarks.study import study_options, study_parser
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.core import Core

FILM: Final = {
    "name": "film",
    "shape": "box",
    "size": [0.25, 0.20, 0.003],
    "mass": 0.010,
    "drag": 1.1,
    "seal_force": 6.0,
    "friction": 0.4,
    "restitution": 0.1,
    "rolling_friction": 0.0001,
    "source": "a sheet whose drag area by mass is 5.5 m2/kg, between film and bag",
}
WIDE: Final = {"along": 0.5, "across": 0.15}
_FAST: Final = {"base": "waste", "limits": {"percent": [60]}}
_FILM: Final = {
    "base": "waste",
    "items": ["film"],
    "extra_items": [FILM],
    "bins": {"random": {"side": [0.30, 0.35]}},
}
CASES: Final[dict[str, tuple[str, Any]]] = {
    "waste": ("PnTRelease-v0", "waste"),
    "unseen": ("PnTRelease-v0", "unseen"),
    "waste at 60 % of the limits": ("PnTRelease-v0", _FAST),
    "the same, actions of 0.50 and 0.15 m": ("PnTRelease-v0", {**_FAST, "action": WIDE}),
    "film": ("PnTRelease-v0", _FILM),
    "film, actions of 0.50 and 0.15 m": ("PnTRelease-v0", {**_FILM, "action": WIDE}),
    "one joint, `late`": ("OneJointThrow-v0", "late"),
    "one joint, `contact`": ("OneJointThrow-v0", "contact"),
    "gripper, `late`": ("GripperToss-v0", "late"),
}
CELLS: Final = 50


@final
class FixedPoint(Controller):
    """The best of four previews, each from the one before by the whole error."""

    name = "fixed_point"

    def __init__(self, core: Core, correction: Correction) -> None:
        self._core, self._correction = core, correction

    def act(self, observation: Observation) -> Actions:
        """The best of the four for each throw, (N, E)."""
        trial = best = np.zeros((len(observation.kind), self._correction.count))
        smallest = np.full((len(best), 1), np.inf)
        for _ in range(4):
            seen = self._core.preview(trial)
            error = np.stack([getattr(seen, name) for name in self._correction.errors], axis=-1)
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
        """Those of the controller, (N, E)."""
        actions = self._controller.act(observation)
        seen = self._core.preview(actions)
        thrown = ~getattr(seen, "dropped", np.zeros(len(actions), dtype=np.bool_))
        self.previewed = np.append(self.previewed, seen.landing_error[thrown])
        self.at_bound = np.append(self.at_bound, (np.abs(actions) > 0.999).any(axis=1))
        return actions


def studied(case: str, throws: int, seed: int, threads: int) -> dict[str, dict[str, float]]:
    """Figures of each controller, lengths in m."""
    env_id, level = CASES[case]
    found: dict[str, dict[str, float]] = {}
    with closing(make_vector(env_id, level, CELLS, threads)) as env:
        core = core_of(env)
        if core.correction is None:
            raise RuntimeError(f"case {case!r}: actions do not shift the landing")
        planner, oracle = (make_controller(name, env) for name in ("analytic", "oracle"))
        for one in (planner, FixedPoint(core, core.correction), oracle):
            watched = Watched(one, core)
            thrown = held_out(watched, env, throws, seed)
            told = summary(thrown)
            found[one.name] = {
                "previewed_mean_m": float(np.nanmean(watched.previewed)),
                "at_bound": float(watched.at_bound.mean()),
                **{name: float(told[name]) for name in ("landing_error_mean_m", "landing_error_p95_m", "success_rate")},
            }
    return found


def main() -> None:
    options = study_options(study_parser(__doc__, 400, "case and controller"))
    result: dict[str, Any] = {"throws": options.throws, "seed": options.seed, "oracle": {}}
    for case in CASES:
        result["oracle"][case] = found = studied(case, options.throws, options.seed, options.threads)
        for name, figures in found.items():
            print(f"{case:<38}{name:<13}" + "  ".join(f"{key} {value:.4f}" for key, value in figures.items()))
            sys.stdout.flush()
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
