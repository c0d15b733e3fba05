"""Figures of a fit as JSON values, and tables of plans and twins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.names import check_keywords

from ..ground.cli import UsageError
from ..ground.tables import Grid, throws_bar
from . import reading
from .fitted import Fitted, fit_log
from .log import ThrowLog
from .parameters import PARAMETERS, Parameter, priors, read_level
from .twins import judge, study_twin
from .words import sentences
from .writing import differences


@check_keywords
def fit(
    log: str | Path,
    level: str | Path = "waste",
    *,
    free: Sequence[str] | None = None,
    prior: Mapping[str, float] | None = None,
    free_motion: bool = False,
) -> dict[str, Any]:
    """Fit a conveyor level to a log of throws; return the figures that `agents.fit --json` writes.

    Args:
        log: CSV file with a row for each throw, see `agents.fit.log.COLUMNS`.
        level: name or file of the level about whose values the priors lie; of a line's level, that of its cell.
        free: names of the parameters that are not known; None for all.
        prior: standard deviations of priors by name, in SI units; of the logarithm for tau, drag and stiffness.
        free_motion: whether the robot moves otherwise than the level's planner, as of `--free-motion`.

    Raises:
        UsageError: the log is none of this cell's throws, or there is no such parameter.
        ConfigError: there is no such level.
    """
    if not isinstance(log, str | Path):
        raise UsageError(f"log is {log!r}; it must be a CSV file")
    config, _ = read_level(level)
    parameters = priors(config, free, prior, free_motion)
    fitted = fit_log(reading.read(Path(log), config, free_motion), config, parameters)
    return {"level": str(level), **report(fitted, fitted.posterior.samples())}


def report(fitted: Fitted, samples: Floats) -> dict[str, Any]:
    """All figures of a fit, as JSON values."""
    return {
        "throws": len(fitted.log),
        "landings": int(fitted.log.has_landing.sum()),
        "parameters": {name: asdict(part) for name, part in fitted.estimates(samples).items()},
        "combinations": {name: asdict(part) for name, part in fitted.combinations(samples).items()},
        "seals": [asdict(seal) for seal in fitted.seals],
        "tests": {finding.name: {"p": finding.chance, "alarm": finding.alarms} for finding in fitted.misfit},
        "fits": fitted.fits,
        "scatter": fitted.scatter,
        "differences": differences(fitted),
        "sentences": sentences(fitted, samples),
    }


def plan_grid(log: ThrowLog, config: ConveyorConfig) -> Grid:
    """Table of the throws of a plan."""
    rows = [
        (
            str(row + 1), config.items[log.kind[row]], f"{log.pick[row, 0]:.2f}, {log.pick[row, 1]:.2f}",
            f"{log.percent[row]:g} %", f"{log.target[row, 0]:.2f}, {log.target[row, 1]:.2f}",
            ", ".join(f"{value:.3f}" for value in log.release[row]),
        )
        for row in range(len(log))
    ]  # fmt: skip
    header = ("", "item", "pick x, y [m]", "speed", "bin x, y [m]", "release x, y, z [m]")
    return Grid(f"The next {len(log)} throws", header, rows)


def grid(
    config: ConveyorConfig,
    parameters: tuple[Parameter, ...],
    count: int,
    seed: int,
    landings: int,
    *,
    planned: bool,
) -> Grid:
    """Table of the coverage and the errors of fits of twins, with a progress bar; arguments as of `twins.make`."""
    judged, alarms = list[dict[str, Any]](), 0
    with throws_bar() as bar:
        task = bar.add_task("twins", total=count)
        for twin in range(count):
            cell, fitted, _ = study_twin(config, seed + twin, landings, parameters, planned=planned)
            judged.append(judge(cell, fitted))
            alarms += not fitted.fits
            bar.advance(task)
    labels = {**{p.name: p.label for p in PARAMETERS}, "camera_at_picks": "camera and encoder at the picks [mm]"}
    groups = {label: [twin[name] for twin in judged if name in twin] for name, label in labels.items()}
    for title, start in {"delays of items [ms]": "delay_", "chances that cups seal": "seal_"}.items():
        groups[title] = [part for twin in judged for name, part in twin.items() if name.startswith(start)]
    rows = [
        (label, f"{np.mean([p['holds'] for p in parts]):.0%}", f"{np.median([p['error'] for p in parts]):.2f}")
        for label, parts in groups.items()
        if parts
    ]
    title = f"{count} twins, {alarms / count:.0%} with an alarm; errors of parameters in deviations of the prior"
    return Grid(title, ("parameter", "95 % intervals hold", "median error"), rows)
