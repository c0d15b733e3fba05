"""Cells that separate good controllers: what the oracle sorts there, and what an error of some size costs it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from agents.ground import metrics
from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.cells import oracle_actions, throw, zero_actions
from pnt_gym.arrays import Bools
from pnt_gym.cells.base.core import Core


def figures(settings: Settings, amount: Amount) -> Figures:
    """Success of picked objects: of the planner, of the oracle, and of the oracle with normal errors added.

    Args:
        settings: `level`; `errors_m`, the mean landing errors that are added, alike in both directions.
        amount: throws.
    """
    picked, planned = _throw(settings, amount, zero_actions)
    _, exact = _throw(settings, amount, oracle_actions)
    near, far = (_throw(settings, amount, partial(oracle_actions, error=error))[1] for error in settings["errors_m"])
    return {
        "picked": float(picked.mean()),
        "analytic": float(planned[picked].mean()),
        "oracle": vars(metrics.wilson(int(exact[picked].sum()), int(picked.sum()))),
        "near": float(near[picked].mean()),
        "far": float(far[picked].mean()),
        "difference": vars(metrics.mean_difference(near[picked].astype(float), far[picked].astype(float))),
    }


def _throw(settings: Settings, amount: Amount, act: Callable[[Core], Any]) -> tuple[Bools, Bools]:
    """Which objects were picked, and which throws succeeded."""
    info = throw(settings["level"], amount, act)
    return info["picked"].astype(np.bool_), info["is_success"].astype(np.bool_)
