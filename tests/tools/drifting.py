"""Cells at the belt that drift, with a camera over their bins."""

from typing import Any

import numpy as np

from pnt_gym.cells.base.core import Core
from tests.tools.throws import make_core, vary

ALL: dict[str, Any] = {
    "delay": {"even": 0.005, "step": 0.003, "film": 0.004}, "camera": {"normal": 0.008, "walk": 0.002},
    "encoder": {"normal": 0.01, "ramp": 0.01}, "draught": {"even": 0.5}, "steps_every": 3,
}  # fmt: skip
"""A drift of everything at once."""
QUICK = {"fidelity": "flight"}


def cells(count: int, level: str = "waste", seed: int = 0, **changes: Any) -> Core:
    """Cells of a level with some values replaced."""
    return make_core(vary(level, **changes), count, picks="belt", seed=seed, feedback=True)


def actions(count: int, steps: int, size: float = 0.4) -> np.ndarray:
    """Actions (steps, count, 2) of up to a size."""
    return np.random.default_rng(7).uniform(-size, size, (steps, count, 2)).astype(np.float32)
