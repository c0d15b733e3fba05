"""Controllers through the pieces of a benchmark: after numbers of throws, against the mismatch, on other processors."""

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
from agents.results.compare import assemble
from agents.results.plan import Plan, pieces
from agents.results.study import Amount, Figures, Settings
from pnt_gym.arrays import Floats

JUDGED: Final = "judged"
"""Name of the level on which controllers are judged, in full physics."""
LEARNED: Final = "learned"
"""Name of the level on which they learn."""
FLIGHTS: Final = {"fidelity": "flight"}
"""Change of the level on which they learn, where the study says nothing else."""
KEPT: Final = ("landing_error_mean_m", "success_rate", "sorted_per_min", "learn_seconds")


def curve(settings: Settings, amount: Amount) -> list[Figures]:
    """What a controller is worth in full physics after each number of throws of which it learned.

    Args:
        settings: `env` and `level`; `practice`, the change of the level for learning, `FLIGHTS` by default; `seed` of
            the learning; and the keys of a benchmark's entry: `controller`, `throws`, ...
        amount: held-out throws.
    """
    table = _assemble(settings, [_entry(settings, "learner")], amount)["table"]
    return [{"throws": row["throws"], **{name: row[name] for name in KEPT}} for row in table]


def gain(settings: Settings, amount: Amount) -> Figures:
    """What a learner gains on the analytic planner, throw by throw, with intervals.

    Args:
        settings: as for `curve`, with one number of throws and `seeds` instead of `seed`.
        amount: held-out throws.
    """
    entries = [_entry(settings, "learner"), {"label": "analytic", "controller": "analytic", "levels": [JUDGED]}]
    (throws,) = settings["throws"]
    pairs = {"learned": [{"label": "learner", "throws": throws}], "references": [{"label": "analytic"}]}
    data = _assemble(settings, entries, amount, **pairs)
    rows = {row["label"]: row for row in data["table"]}
    (pair,) = data["comparisons"]
    return {
        "analytic_m": rows["analytic"]["landing_error_mean_m"],
        "learned_m": rows["learner"]["landing_error_mean_m"],
        **{name: {end: pair[name][end] for end in ("value", "low", "high")} for name in data["figures"]},
    }


def _entry(settings: Settings, label: str) -> dict[str, Any]:
    """The entry of a benchmark's plan that the settings describe."""
    own = {"env", "level", "practice", "seed", "seeds"}
    return {"label": label, "levels": [JUDGED], **{name: value for name, value in settings.items() if name not in own}}


def _assemble(settings: Settings, entries: list[dict[str, Any]], amount: Amount, **pairs: Any) -> dict[str, Any]:
    """Table and comparisons of a plan of one level."""
    level = settings["level"]
    plan = Plan.model_validate(
        {
            "name": "curves",
            "env": settings["env"],
            "train_level": LEARNED,
            "levels": [JUDGED],
            "inline": {JUDGED: level, LEARNED: {**level, **settings.get("practice", FLIGHTS)}},
            "picks": amount.throws,
            "seed": amount.seed,
            "seeds": settings.get("seeds") or [settings.get("seed", 0)],
            "entries": entries,
            **pairs,
        }
    )
    with TemporaryDirectory() as folder:
        results = [result for piece in pieces(plan) for result in run_piece(piece, Path(folder)).results]
    return assemble(plan, results)


NUMBERS: Final = ("along_m", "across_m", "cycle_s")
"""Columns of numbers that a row of results keeps of each throw."""
NEAR_M: Final = 1e-4
"""Distance of two landings up to which they count as the same place [m]."""


def processors(settings: Settings, amount: Amount) -> Figures:
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
        (result,) = run_piece(piece, Path(folder)).results
    print(json.dumps(result["columns"]))


if __name__ == "__main__":
    main(sys.argv[1])
