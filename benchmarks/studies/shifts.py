"""What controllers sort in shifts of grasps, from the first object on and after some have been seen."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np

from agents.ground.metrics import rate, rate_difference, share_won
from agents.judging import trials
from agents.judging.evaluation import open_cells
from agents.judging.throws import Throws
from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.shift_learners import practised
from pnt_gym.arrays import Floats
from pnt_gym.cells.grasp.config import GraspConfig

ENV: Final = "PnTGrasp-v0"
ROWS: Final = 64
"""Shifts side by side; a part of what a seed means."""


class _Shifts(NamedTuple):
    """Picks of S shifts of P picks; of several seeds of a learner, the means."""

    sorted: Floats
    """(S, P)"""
    seconds: Floats
    """(S, P)"""
    info: Mapping[str, float]
    """Means over all picks."""

    def sums(self, first: int) -> Floats:
        """Objects sorted and seconds of each shift (S, 2), from an object on, counted from 1."""
        return np.stack([self.sorted[:, first - 1 :].sum(axis=1), self.seconds[:, first - 1 :].sum(axis=1)], axis=1)


def judged(settings: Settings, amount: Amount) -> Figures:
    """What a controller sorts, and how much of the way from a reference to two oracles it goes, shift by shift.

    Args:
        settings: `level`; `controller`, its `options`; `learned`, the `memory` and `picks` of a learner that practises
            first, and `seeds`, the number of such learners; `first`, the object from which late figures count;
            `reference`, `oracle` and `holds`, the same settings of these controllers, the last one an oracle of
            holds alone.
        amount: picks of each learner.
    """
    four = (settings, *(settings[name] for name in ("reference", "oracle", "holds")))
    shifts, late = [_shifts_of(one, settings["level"], amount) for one in four], settings["first"]
    own = shifts[0]
    sums, from_least, from_most, from_holds = (one.sums(late) for one in shifts)
    return {
        "rate": asdict(rate(*own.sums(1).T)),
        "late": asdict(rate(*sums.T)),
        "gain": asdict(rate_difference(*sums.T, *from_least.T)),
        "less": asdict(rate_difference(*sums.T, *from_most.T)),
        "share": asdict(share_won(sums, from_least, from_most)),
        "share_of_holds": asdict(share_won(sums, from_least, from_holds)),
        **own.info,
    }


def _shifts_of(settings: Settings, level: Mapping[str, Any], amount: Amount) -> _Shifts:
    """Shifts of a controller, the means of its seeds."""
    told, learned = (json.dumps(one) for one in (level, settings.get("learned")))
    options, seeds = json.dumps(settings.get("options", {})), range(settings.get("seeds", 1))
    runs = [_run(told, settings["controller"], options, learned, seed, amount) for seed in seeds]
    info = {name: float(np.mean([run.info[name] for run in runs])) for name in runs[0].info}
    won, spent = (np.mean([getattr(run, name) for run in runs], axis=0) for name in ("sorted", "seconds"))
    return _Shifts(won, spent, info)


@cache
def _run(level: str, controller: str, options: str, learned: str, seed: int, amount: Amount) -> _Shifts:
    """Shifts of a controller; level, options and learning as JSON, which can be remembered."""
    config, own, practice = GraspConfig.load(json.loads(level)), json.loads(options), json.loads(learned)
    state, memory = ({}, {}) if practice is None else practised(seed=seed, **practice)
    with open_cells(ENV, {"level": config, "num_envs": ROWS, "threads": 1}) as cells:
        trial = trials.of(cells)
        actor: Any = trial.controller(controller, **own, **memory)
        if state:
            actor.restore(state)
        actor.reset(0)
        record: Any = trial.run(actor, amount.throws, amount.seed)
        throws: Throws = record.throws
    # Throws come in batches of one pick of each row, shift after shift.
    columns = (throws.sorted.astype(float), throws.cycle_time)
    won, spent = (c.reshape(-1, config.picks_per_shift, ROWS).transpose(0, 2, 1) for c in columns)
    info = {
        "success": float(throws.sorted.mean()),
        "held": float(throws.picked.mean()),
        "given_up": float((throws.info["tries"] == 0).mean()),
        "dropped": float(throws.info["dropped"][throws.picked].mean()),
        "landing_error_m": float(np.nanmean(throws.landing_error)),
    }
    return _Shifts(*(c.reshape(-1, config.picks_per_shift) for c in (won, spent)), info=info)
