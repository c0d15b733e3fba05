"""What the same throws are on another processor: the same bits, or how far apart."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np

from agents.benchmark.run import run_piece
from agents.results.plan import Plan, pieces
from agents.results.study import Amount, Figures, Settings
from pnt_gym.arrays import Floats

NUMBERS: Final = ("along_m", "across_m", "cycle_s")
"""Columns of numbers that a row of results keeps of each throw."""
NEAR_M: Final = 1e-4
"""Distance of two landings up to which they count as the same place [m]."""


def figures(settings: Settings, amount: Amount) -> Figures:
    """Differences of the rows of a controller here and on a processor that environment variables imitate.

    Args:
        settings: `level`; `controller` and its `practice` throws; `variables`, which tell OpenBLAS, NumPy or numba what
            processor there is.
        amount: throws.
    """
    plan = _plan(settings, amount)
    here, there = (_elsewhere(plan, variables) for variables in ({}, settings["variables"]))
    landed = [np.hypot(_numbers(columns, "along_m"), _numbers(columns, "across_m")) for columns in (here, there)]
    apart = np.hypot(*(_numbers(there, name) - _numbers(here, name) for name in ("along_m", "across_m")))
    differing = [_numbers(there, name) != _numbers(here, name) for name in NUMBERS]
    is_measured = np.isfinite(landed[0]) & np.isfinite(landed[1])
    outcomes = [a != b for a, b in zip(here["outcome"], there["outcome"], strict=True)]
    return {
        "throws": len(apart),
        "differing": float((np.any(differing, axis=0) & is_measured).mean()),
        "apart_p99_m": float(np.quantile(apart[is_measured], 0.99)),
        "apart_most_m": float(apart[is_measured].max()),
        "far": float((apart[is_measured] > NEAR_M).mean()),
        "outcomes": float(np.mean(outcomes)),
        "mean_m": float(abs(landed[0][is_measured].mean() - landed[1][is_measured].mean())),
    }


def _numbers(columns: dict[str, Any], name: str) -> Floats:
    """A column (N,), NaN where a throw has no value."""
    return np.array([np.nan if value is None else value for value in columns[name]], dtype=np.float64)


def _plan(settings: Settings, amount: Amount) -> dict[str, Any]:
    entry = {"label": "judged", "controller": settings["controller"], "throws": [settings.get("practice", 0)]}
    level = {"inline": {"level": settings["level"]}, "levels": ["level"], "train_level": "level"}
    return {
        "name": "processors",
        **level,
        "picks": amount.throws,
        "seed": amount.seed,
        "seeds": [0],
        "entries": [entry],
    }


def _elsewhere(plan: dict[str, Any], variables: dict[str, str]) -> dict[str, Any]:
    """Columns of a plan's only row, from a process of its own."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", **variables}
    command = [sys.executable, "-m", __name__, json.dumps(plan)]
    return json.loads(subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout)


def main(plan: str) -> None:
    """Print the columns of a plan's only row."""
    (piece,) = pieces(Plan.model_validate_json(plan))
    with TemporaryDirectory() as folder:
        (result,) = run_piece(piece, Path(folder))["results"]
    print(json.dumps(result["columns"]))


if __name__ == "__main__":
    main(sys.argv[1])
