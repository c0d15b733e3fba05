"""Fits of blind twins, whose logs are fitted as if they were real, and what a fit is worth to a learner."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from typing import Any, Final, final

import numpy as np

from agents.controllers import make_controller
from agents.controllers.protocol import Actions, Controller, Observation, to_action
from agents.controllers.trackers import Kalman
from agents.fit.log import ThrowLog
from agents.fit.misfit import TESTS
from agents.fit.parameters import PARAMETERS, read_level
from agents.fit.twins import CELLS, ENV, Twin, judge, study_twin
from agents.judging.trials import open_trial
from agents.results.study import Amount, Figures, Settings, share
from pnt_gym.arrays import Floats
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.conveyor.config import ConveyorConfig

LANDINGS: Final = 40
"""Landings of a log."""
SETS: Final = 1000
"""Seeds of a set of twins."""


def twins(settings: Settings, amount: Amount) -> list[Figures]:
    """Coverage and error of each parameter, and alarms and forecasts, over the twins of one set."""
    config, _ = read_level(settings["level"])
    options = {name: settings[name] for name in ("hidden", "draught", "planned") if name in settings}
    judged, alarms, verdicts = list[dict[str, Any]](), list[dict[str, bool]](), list[dict[str, float]]()
    for seed in seeds(settings, amount):
        cell, fitted, seconds = study_twin(config, seed, LANDINGS, **options)
        judged.append(judge(cell, fitted))
        tests = {finding.name: finding.alarms for finding in fitted.misfit}
        called = {"any test": not fitted.fits, **{name: tests[name] for name in TESTS}}
        alarms.append({**called, "blow-off named": fitted.blows})
        verdict = {"fit [s]": seconds}
        if "forecast" in settings:
            verdict |= _forecasts(cell.truth, fitted.level, config, seed, settings["forecast"])
        verdicts.append(verdict)
    shares = {name: share([alarm[name] for alarm in alarms]) for name in alarms[0]}
    raised = [{"kind": "alarm", "figure": name, "alarms": part} for name, part in shares.items()]
    return [*_posterior_rows(judged), *raised, *mean_rows("verdict", verdicts)]


def seeds(settings: Settings, amount: Amount) -> range:
    """Seeds of the twins of a set."""
    first = amount.seed + SETS * int(settings["set"])
    return range(first, first + amount.throws)


def mean_rows(kind: str, verdicts: Sequence[dict[str, float]]) -> list[Figures]:
    """A row with the mean over twins for each figure."""
    names = list(verdicts[0])
    return [
        {"kind": kind, "figure": name, "value": float(np.mean([verdict[name] for verdict in verdicts]))}
        for name in names
    ]


def _posterior_rows(judged: list[dict[str, Any]]) -> list[Figures]:
    """A row for each parameter, for camera and encoder together, for the delays of items, and for all parameters."""
    names = [parameter.name for parameter in PARAMETERS]
    groups = {name: [twin[name] for twin in judged] for name in (*names, "camera_at_picks")}
    for group, start in {"delays": "delay_", "seals": "seal_"}.items():
        groups[group] = [part for twin in judged for name, part in twin.items() if name.startswith(start)]
    groups["all parameters"] = [twin[name] for twin in judged for name in names]
    return [
        {
            "kind": "posterior", "figure": name, "coverage": share([part["holds"] for part in parts]),
            "error": float(np.median([part["error"] for part in parts])),
        }
        for name, parts in groups.items()
    ]  # fmt: skip


def _forecasts(
    truth: ConveyorConfig, fitted: ConveyorConfig, default: ConveyorConfig, seed: int, throws: int
) -> dict[str, float]:
    """Errors of the success and of the landing error that the fitted and the default level forecast for a twin."""
    levels = (level.model_copy(update={"fidelity": truth.fidelity}) for level in (truth, fitted, default))
    true, *forecasts = (_performance(level, seed, throws) for level in levels)
    errors: dict[str, float] = {}
    for name, forecast in zip(("fitted", "default"), forecasts, strict=True):
        errors[f"success by the {name} level, off by [points]"] = 100.0 * abs(forecast[0] - true[0])
        errors[f"landing by the {name} level, off by [mm]"] = 1e3 * abs(forecast[1] - true[1])
    return errors


def _performance(config: ConveyorConfig, seed: int, throws: int) -> tuple[float, float]:
    """Success and mean landing error [m] of the planner on the same objects."""
    with closing(open_trial(ENV, config, 50, 1)) as trial:
        summary = trial.run(make_controller("analytic", trial.env), throws, seed).summary()
    return summary["success_rate"], summary["landing_error_mean_m"]


PRACTICE: Final = 1200
"""Simulated throws of a ridge regression's practice."""
THROWS: Final = 800
"""Throws of a twin by which a controller is judged."""
SHIPPED: Final = "shipped:waste-sac"
FITTED, TRUE, DEFAULT = (f"ridge trained on the {level} level" for level in ("fitted", "true", "default"))


@final
class Observer(Controller):
    """The planner, that keeps what a policy would have observed before each throw."""

    name = "observer"

    def __init__(self, planner: Controller) -> None:
        self._planner = planner
        self.parts: list[Observation] = []

    def act(self, observation: Observation) -> Actions:
        """Actions of the planner (N, A)."""
        self.parts.append(observation)
        return self._planner.act(observation)


@final
class Corrected(Controller):
    """A policy minus the effects of delay, camera and encoder on each throw, as one log of the planner's throws tells.

    Args:
        policy: acts in the level in which it was trained.
        correction: meaning of an action.
        observation: what the policy would have observed before each logged throw.
        log: the throws.
        config: the level that is known of the cell.
    """

    name = "corrected"

    def __init__(
        self, policy: Controller, correction: Correction, observation: Observation, log: ThrowLog, config: Any
    ) -> None:
        self._policy, self._correction = policy, correction
        # Constant states: the log is of one state of the cell, so nothing walks.
        self._tracker = Kalman(config.belt.camera_x, walk=(0.0, 0.0, 0.0, 0.0), noise=config.feedback.noise)
        self._tracker.begin(np.array([True]))
        # The planner's landing is the policy's prediction of it, minus the offset that the policy would have asked for.
        offset = policy.act(observation) * correction.scale
        excess = landing_errors(log) + offset
        features = observation.features.astype(np.float64)
        for row in np.flatnonzero(np.isfinite(excess).all(axis=1)):
            self._tracker.learn(features[row : row + 1], excess[row : row + 1], np.array([True]))

    def act(self, observation: Observation) -> Actions:
        """Actions of the policy, corrected (N, A)."""
        effect = np.concatenate(
            [self._tracker.effect(throw[None]) for throw in observation.features.astype(np.float64)]
        )
        return to_action(self._policy.act(observation) * self._correction.scale - effect, self._correction)


def landing_errors(log: ThrowLog) -> Floats:
    """Landings of a log against their targets, along and to the left of each throw (N, 2) [m]."""
    way = log.target - log.pick[:, :2]
    ex, ey = (way / np.hypot(*way.T)[:, None]).T
    x, y = (log.landing - log.target).T
    return np.stack([x * ex + y * ey, y * ex - x * ey], axis=1)


def learners(settings: Settings, amount: Amount) -> list[Figures]:
    """Landing error and success on twins of learners that were trained on three levels, and of corrected policies."""
    config, _ = read_level(settings["level"])
    errors, successes = list[dict[str, float]](), list[dict[str, float]]()
    for seed in seeds(settings, amount):
        twin, fitted, _ = study_twin(config, seed, LANDINGS)
        observation = observe_log(twin, seed)
        levels = {FITTED: fitted.level, TRUE: twin.truth, DEFAULT: config}
        with closing(open_trial(ENV, twin.truth, 50, 1)) as trial:
            correction = trial.core.correction
            policies = {name: train_ridge(level, seed) for name, level in levels.items()}
            policies[SHIPPED] = make_controller(SHIPPED, trial.env)
            for name in (DEFAULT, SHIPPED):
                policies[f"{name}, corrected"] = Corrected(policies[name], correction, observation, twin.log, config)
            summaries = {name: trial.run(policy, THROWS, seed).summary() for name, policy in policies.items()}
        errors.append({name: 1e3 * summary["landing_error_mean_m"] for name, summary in summaries.items()})
        successes.append({name: 100.0 * summary["success_rate"] for name, summary in summaries.items()})
    return [*mean_rows("landing [mm]", errors), *mean_rows("success [%]", successes), *_difference_rows(errors)]


def train_ridge(level: ConveyorConfig, seed: int) -> Controller:
    """A ridge regression that has practised in a level."""
    with closing(open_trial(ENV, level, 50, 1)) as trial:
        controller = make_controller("ridge", trial.env)
        controller.reset(seed)
        return trial.practise(controller, PRACTICE, seed)


def observe_log(twin: Twin, seed: int) -> Observation:
    """What a policy would have observed before each throw of a twin's log, which is thrown once more."""
    with closing(open_trial(ENV, twin.truth, CELLS, 1)) as trial:
        observer = Observer(make_controller("analytic", trial.env))
        trial.run(observer, len(twin.log), seed)
    features, kind = (np.concatenate([getattr(part, name) for part in observer.parts]) for name in ("features", "kind"))
    count = len(twin.log)
    return Observation(features[:count], kind[:count])


def _difference_rows(errors: list[dict[str, float]]) -> list[Figures]:
    """What the fit loses against the truth and wins against corrections, and how often it wins."""
    losses = {f"lost against {TRUE}": [twin[FITTED] - twin[TRUE] for twin in errors]}
    gains = {
        f"won over {name}, corrected": [twin[f"{name}, corrected"] - twin[FITTED] for twin in errors]
        for name in (DEFAULT, SHIPPED)
    }
    rows = [
        {"kind": "difference [mm]", "figure": name, "value": float(np.mean(values))}
        for name, values in {**losses, **gains}.items()
    ]
    wins = [
        {"kind": "twins that win [%]", "figure": name, "value": 100.0 * float(np.mean(np.array(values) > 0.0))}
        for name, values in gains.items()
    ]
    return [*rows, *wins]
