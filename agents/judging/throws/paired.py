"""Throws as paired observations of a sequential comparison."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.core import Core

from ...controllers.adaptive import has_feedback
from ..figure import Figure
from ..measures import Measure
from .data import Throws

RUN: Final = 10
"""Throws of a row in one block, in cells whose episodes are long; an episode of fewer throws is whole."""
MEASURES: Final = {
    "landing_error_m": Measure(Figure("landing error", "mm", 1000.0), 0.100, "{a} lands {amount} closer than {b}", -1),
    "success": Measure(Figure("success", "%", 100.0), 1.0, "{a} succeeds in {amount} more of the throws than {b}"),
    # Only cycles under half a second, which few cells have, can differ by more.
    "sorted_per_min": Measure(Figure("sorted/min"), 120.0, "{a} sorts {amount} a minute more than {b}"),
}
"""Measures of throws."""


def depend(core: Core) -> bool:
    """Whether throws of a row depend on the row's earlier throws by more than chance: on feedback, or on success."""
    return has_feedback(core) or (core.cell.episode > 1 and core.cell.terminates)


def run_length(core: Core) -> int:
    """Number of throws of each row in a block: an episode, or its first part where throws do not depend."""
    return core.cell.episode if depend(core) else min(core.cell.episode, RUN)


def observations(throws: Throws, core: Core, rows: int) -> Mapping[str, Floats]:
    """Figures of each throw, or of each row's run where the throws of a row depend on one another.

    The figures of a run are its mean landing error, its share of successes, and its sorted picks over its time.

    Args:
        throws: whole blocks of throws.
        core: the cells.
        rows: number of rows side by side.
    """
    length = run_length(core) if depend(core) else 1

    def runs(column: Floats) -> Floats:
        return column.reshape(-1, length, rows) if length > 1 else column[:, None, None]

    error, seconds = runs(throws.landing_error), runs(throws.cycle_time)
    measured = np.isfinite(error)
    total = np.where(measured, error, 0.0).sum(axis=1)
    count = measured.sum(axis=1)
    mean = np.divide(total, count, out=np.full_like(total, np.nan), where=count > 0)
    columns = {
        "landing_error_m": mean,
        "success": runs(throws.is_success.astype(np.float64)).mean(axis=1),
        "sorted_per_min": 60.0 * runs(throws.sorted.astype(np.float64)).sum(axis=1) / seconds.sum(axis=1),
    }
    return {name: column.ravel() for name, column in columns.items()}
