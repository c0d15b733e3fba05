"""Fits of blind twins: cells with drawn hidden parameters, whose logs are fitted as if they were real."""

from __future__ import annotations

from contextlib import closing
from typing import Any, Final

import numpy as np

from agents.controllers import make_controller
from agents.fitting.parameters import PARAMETERS
from agents.fitting.twins import ENV, judge_fit, study_twin
from agents.judging.trials import open_trial
from benchmarks.studies.cells import Amount, Figures, Settings
from pnt_gym.cells.conveyor.config import ConveyorConfig

LANDINGS: Final = 40
"""Landings of a log."""
SETS: Final = 1000
"""Seeds of a set of twins."""
THROWS: Final = 400
"""Throws by which a level forecasts a twin."""


def figures(settings: Settings, amount: Amount) -> list[Figures]:
    """Coverage and error of each parameter, and alarms and forecasts, over the twins of one set."""
    config = ConveyorConfig.load(settings["level"]).model_copy(update={"fidelity": "flight"})
    options = {name: settings[name] for name in ("hidden", "draught", "planned") if name in settings}
    judged, verdicts = list[dict[str, Any]](), list[dict[str, float]]()
    for twin in range(amount.throws):
        seed = amount.seed + SETS * int(settings["set"]) + twin
        cell, fitted, seconds = study_twin(config, seed, LANDINGS, **options)
        judged.append(judge_fit(cell, fitted))
        verdict = {
            "alarms [%]": 100.0 * (not fitted.fits),
            "scatter told [%]": 100.0 * next(f.alarms for f in fitted.misfit if f.name == "scatter"),
            "fit [s]": seconds,
        }
        if settings.get("forecast"):
            verdict |= _forecasts(cell.truth, fitted.level, config, seed)
        verdicts.append(verdict)
    means = {name: float(np.mean([verdict[name] for verdict in verdicts])) for name in verdicts[0]}
    return [*_rows(judged), *({"kind": "verdict", "figure": name, "value": value} for name, value in means.items())]


def _rows(judged: list[dict[str, Any]]) -> list[Figures]:
    """A row for each parameter, for camera and encoder together, for the delays of items, and for all parameters."""
    names = [parameter.name for parameter in PARAMETERS]
    groups = {name: [twin[name] for twin in judged] for name in (*names, "camera_at_picks")}
    groups["delays"] = [part for twin in judged for name, part in twin.items() if name.startswith("delay_")]
    groups["all parameters"] = [twin[name] for twin in judged for name in names]
    return [
        {
            "kind": "posterior", "figure": name, "coverage": float(np.mean([part["holds"] for part in parts])),
            "error": float(np.median([part["error"] for part in parts])),
        }
        for name, parts in groups.items()
    ]  # fmt: skip


def _forecasts(truth: ConveyorConfig, fitted: ConveyorConfig, default: ConveyorConfig, seed: int) -> dict[str, float]:
    """Errors of the success and of the landing error that the fitted and the default level forecast for a twin."""
    true, *forecasts = (_performance(config, seed) for config in (truth, fitted, default))
    errors: dict[str, float] = {}
    for name, forecast in zip(("fitted", "default"), forecasts, strict=True):
        errors[f"success by the {name} level, off by [points]"] = 100.0 * abs(forecast[0] - true[0])
        errors[f"landing by the {name} level, off by [mm]"] = 1e3 * abs(forecast[1] - true[1])
    return errors


def _performance(config: ConveyorConfig, seed: int) -> tuple[float, float]:
    """Success and mean landing error [m] of the planner on the same objects."""
    with closing(open_trial(ENV, config, 50, 1)) as trial:
        summary = trial.run(make_controller("analytic", trial.env), THROWS, seed).summary()
    return summary["success_rate"], summary["landing_error_mean_m"]
