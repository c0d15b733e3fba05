"""Fits of blind twins: cells with drawn hidden parameters, whose logs are fitted as if they were real."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from typing import Any, Final

import numpy as np

from agents.controllers import make_controller
from agents.fit.misfit import TESTS
from agents.fit.parameters import PARAMETERS
from agents.fit.twins import ENV, judge_fit, study_twin
from agents.judging.trials import open_trial
from agents.results.study import Amount, Figures, Settings, share
from pnt_gym.cells.conveyor.config import ConveyorConfig

LANDINGS: Final = 40
"""Landings of a log."""
SETS: Final = 1000
"""Seeds of a set of twins."""


def figures(settings: Settings, amount: Amount) -> list[Figures]:
    """Coverage and error of each parameter, and alarms and forecasts, over the twins of one set."""
    config = flight_level(settings)
    options = {name: settings[name] for name in ("hidden", "draught", "planned") if name in settings}
    judged, alarms, verdicts = list[dict[str, Any]](), list[dict[str, bool]](), list[dict[str, float]]()
    for seed in seeds(settings, amount):
        cell, fitted, seconds = study_twin(config, seed, LANDINGS, **options)
        judged.append(judge_fit(cell, fitted))
        tests = {finding.name: finding.alarms for finding in fitted.misfit}
        alarms.append({"any test": not fitted.fits, **{name: tests[name] for name in TESTS}})
        verdict = {"fit [s]": seconds}
        if "forecast" in settings:
            verdict |= _forecasts(cell.truth, fitted.level, config, seed, settings["forecast"])
        verdicts.append(verdict)
    shares = {name: share([alarm[name] for alarm in alarms]) for name in alarms[0]}
    raised = [{"kind": "alarm", "figure": name, "alarms": part} for name, part in shares.items()]
    return [*_posterior_rows(judged), *raised, *mean_rows("verdict", verdicts)]


def flight_level(settings: Settings) -> ConveyorConfig:
    """The level that is known of the cells, with flights alone, as a fit takes it."""
    return ConveyorConfig.load(settings["level"]).model_copy(update={"fidelity": "flight"})


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
    groups["delays"] = [part for twin in judged for name, part in twin.items() if name.startswith("delay_")]
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
