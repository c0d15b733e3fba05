"""What became of the objects of work shifts: sorted, or lost to one of five causes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.config import LineConfig

from .counted import Counted
from .data import Shifts

FATES: Final = ("sorted", "misplaced", "missed", "lost", "unsealed", "passed")
"""Fates of objects: in a bin that takes the object; in another bin; thrown into no bin; lost from the cup on the way;
past the end after picks that did not seal; past the end without a pick."""
WORDS: Final[Mapping[str, str]] = {
    "sorted": "sorted",
    "misplaced": "in a wrong bin",
    "missed": "thrown, missed the bin",
    "lost": "lost on the way to the release",
    "unsealed": "passed the end, cup did not seal",
    "passed": "passed the end, not tried",
}
"""Fates in words."""


def fate_words(name: str, splits: bool) -> str:
    """A fate in words; a table without counts does not tell lost objects from missed ones."""
    return WORDS[name] if splits or name != "missed" else "missed the bin, or lost on the way"


@final
@dataclass(frozen=True)
class Fates:
    """Numbers of objects by work shift S, item K and fate."""

    counts: Floats
    """Numbers (S, K, fates); fractions where failures are split by counted shares."""
    splits: bool
    """Whether lost objects are counted apart from missed ones, and strays among misplaced ones."""

    @classmethod
    def of_shifts(cls, shifts: Shifts, config: LineConfig, counted: Counted | None) -> Self:
        """Fates of the objects that came in some shifts.

        Args:
            shifts: the shifts.
            config: level of the line.
            counted: what became of the throws behind the table; used where a table gave the results.
        """
        sorted_, misplaced, floor, passed, tried = (
            shifts.figures[f"shift_{name}_by_item"].astype(np.float64)
            for name in ("sorted", "misplaced", "on_floor", "passed", "passed_tried")
        )
        if "lost" in shifts.decisions:
            lost, strayed, splits = _count_lost(shifts.decisions, config, floor), np.zeros_like(floor), True
        elif counted is not None:
            _, lost_share, strayed_share = counted.shares()
            lost, strayed, splits = floor * lost_share, floor * strayed_share, True
        else:
            lost, strayed, splits = np.zeros_like(floor), np.zeros_like(floor), False
        columns = sorted_, misplaced + strayed, floor - lost - strayed, lost, tried, passed - tried
        return cls(np.stack(columns, axis=-1), splits)

    def shares(self) -> dict[str, float]:
        """Share of each fate among all objects that came; empty where none came."""
        counts = self.counts.sum(axis=(0, 1))
        return dict(zip(FATES, (counts / counts.sum()).tolist(), strict=True)) if counts.sum() else {}

    def shares_by_item(self) -> Floats:
        """Shares of the fates of each item (K, fates); NaN for an item that did not come."""
        counts = self.counts.sum(axis=0)
        total = counts.sum(axis=1, keepdims=True)
        return np.divide(counts, total, out=np.full_like(counts, np.nan), where=total > 0.0)

    @property
    def arrived(self) -> Floats:
        """Numbers of objects that came by item, over all shifts (K,)."""
        return self.counts.sum(axis=(0, 2))


def _count_lost(decisions: Mapping[str, NDArray[Any]], config: LineConfig, like: Floats) -> Floats:
    """Numbers of objects that were lost on the way by shift and item, in the form of `like` (S, K)."""
    in_time = decisions["start"] + decisions["cycle_time"] <= config.duration
    rows = in_time & decisions["lost"].astype(bool) & (decisions["ended_in"] < 0)
    counts = np.zeros_like(like)
    np.add.at(counts, (decisions["shift"][rows], decisions["true_kind"][rows]), 1.0)
    return np.minimum(counts, like)
