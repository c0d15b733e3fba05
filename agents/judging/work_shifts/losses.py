"""Causes of losses and energy of work shifts, by the names of the JSON contract."""

from __future__ import annotations

from typing import Any

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.config import LineConfig

from .counted import Counted, read_counted
from .data import Shifts
from .fates import FATES, Fates


def losses_summary(shifts: Shifts, config: LineConfig) -> dict[str, Any]:
    """Shares of all fates, of all objects and by item, and the energy of a pick and of a sorted object [J]."""
    counted = read_counted(config)
    fates = Fates.of_shifts(shifts, config, counted)
    by_item = zip(config.cell.items, fates.shares_by_item().tolist(), strict=True)
    return {
        "simulated": "lost" in shifts.decisions,
        "fates": fates.shares(),
        "fates_split": fates.splits,
        "fates_by_item": {
            item: dict(zip(FATES, shares, strict=True)) for item, shares in by_item if np.isfinite(shares).all()
        },
        **energy_summary(shifts, counted),
    }


def energy_summary(shifts: Shifts, counted: Counted | None) -> dict[str, float | None]:
    """Energy of a pick and of a sorted object [J]; None where nobody has counted any."""
    energy = decision_energy(shifts, counted)
    if energy is None or not np.isfinite(energy).any():
        return {"energy_per_pick_j": None, "energy_per_sorted_j": None}
    sorted_count = float(shifts.decisions["sorted"].sum())
    total = float(np.nansum(energy))
    per_sorted = total / sorted_count if sorted_count else None
    return {"energy_per_pick_j": float(np.nanmean(energy)), "energy_per_sorted_j": per_sorted}


def decision_energy(shifts: Shifts, counted: Counted | None) -> Floats | None:
    """Energy of each decision (T,) [J], simulated, or the mean of the throws behind the table; None if unknown."""
    decisions = shifts.decisions
    if "energy" in decisions:
        return decisions["energy"].astype(np.float64)
    if counted is None:
        return None
    return counted.energy_of(decisions["true_kind"], decisions["percent"].astype(np.float64))
