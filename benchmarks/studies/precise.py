"""Cells that separate good controllers: what the oracle sorts there, and what an error of some size costs it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from agents.controllers.oracle import Oracle
from agents.controllers.protocol import Observation
from agents.ground import metrics
from benchmarks.studies.cells import CELLS, Amount, Figures, Settings, infos, make_seeded_cells, zero_actions
from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.config import ConveyorConfig

MEAN_OF_RAYLEIGH: Final = np.sqrt(np.pi / 2.0)
"""Mean distance of a point with normal coordinates of deviation 1."""


def figures(settings: Settings, amount: Amount) -> Figures:
    """Success of picked objects: of the planner, of the oracle, and of the oracle with normal errors added.

    Args:
        settings: `level`; `errors_m`, the mean landing errors that are added, alike in both directions.
        amount: throws.
    """
    picked, planned = _throw(settings, amount, zero_actions)
    _, exact = _throw(settings, amount, lambda core: _oracle(core, 0.0))
    near, far = (
        _throw(settings, amount, lambda core, error=error: _oracle(core, error))[1] for error in settings["errors_m"]
    )
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
    config = ConveyorConfig.load(settings["level"])
    core = make_seeded_cells(config, "independent", CELLS, amount.seed, amount.threads)
    info = infos(core, act(core), amount.throws)
    return info["picked"].astype(np.bool_), info["is_success"].astype(np.bool_)


def _oracle(core: Core, error: float) -> Callable[[int], Floats]:
    """Actions of the oracle, with normal errors added whose mean size is `error` [m]."""
    if core.correction is None:
        raise RuntimeError(f"level {core.config.name!r}: actions do not shift the landing")
    oracle, scale = Oracle(core, core.correction), core.correction.scale
    random = np.random.default_rng(0)  # the same errors, but for their size, in every case

    def act(_: int) -> Floats:
        actions = oracle.act(Observation(core.cell.observe(), core.cell.context.kind))
        errors = error / MEAN_OF_RAYLEIGH * random.standard_normal(actions.shape)
        return np.clip(actions + errors / scale, -1.0, 1.0)

    return act
