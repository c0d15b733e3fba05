"""Logs of simulated throws for tests of fits."""

from contextlib import closing
from functools import cache
from typing import Any

import numpy as np

from agents.controllers import make_controller
from agents.fit.log import ThrowLog
from agents.judging.recorder import Recorder
from agents.judging.trials import open_trial
from pnt_gym.cells.conveyor.config import ConveyorConfig

WASTE = ConveyorConfig.load({"base": "waste", "name": "waste", "fidelity": "flight"})
QUIET: dict[str, Any] = {
    "spread": {
        "mass": 0.0, "size": 0.0, "size_axis": 0.0, "drag": 0.0, "seal": 0.0, "com_depth": 0.0, "grasp": 0.0,
        "height": 0.0, "belt_speed": 0.0, "residue": 0.0,
    },
    "noise": {"size": 0.0, "mass": 0.0, "seal": 0.0, "yaw": 0.0, "grasp": 0.0},
    "suction": {"jitter": 0.0},
    "feedback": {"noise": 0.0, "unseen": 0.0, "view": 1.0},
}  # fmt: skip
"""A level whose objects are those of the catalogue, with perfect gauges."""


def level(**changes: Any) -> ConveyorConfig:
    """The level waste with flights alone and some changes."""
    return ConveyorConfig.load({"base": "waste", "fidelity": "flight", **changes})


def throw(config: ConveyorConfig, count: int, seed: int = 0, env: str = "PnTRelease-v0") -> tuple[ThrowLog, Any]:
    """The log of some throws of the analytic planner, and their record."""
    with closing(open_trial(env, config, 8, 1)) as trial:
        recorder = Recorder(trial.core)
        record: Any = trial.run(recorder.watch(make_controller("analytic", trial.env)), count, seed)
        return recorder.log(record.throws, seed), record


@cache
def usual_log() -> ThrowLog:
    """A log of 60 throws on the level waste."""
    return throw(WASTE, 60)[0]


def same_logs(first: ThrowLog, second: ThrowLog) -> bool:
    """Whether two logs hold the same to ten digits."""
    return all(
        np.allclose(np.asarray(a, dtype=float), np.asarray(b, dtype=float), rtol=1e-9, atol=1e-9, equal_nan=True)
        for a, b in zip(vars(first).values(), vars(second).values(), strict=True)
    )
