"""What became of the throws from which a line's table of chances was counted, kept in the table's file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.line.chances import table_path
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.reading import AccessError, json_of

ENTRY: Final = "counted"
"""Entry of a table's file."""
LANDINGS: Final = 60
"""Landings of each item that are kept at most, for pictures."""


@final
@dataclass(frozen=True)
class Counted:
    """Failures, energy and landings of throws by item K and speed setting P."""

    held: Ints
    """Objects that were held, and so thrown or lost (K,)."""
    missed: Ints
    """Held objects that ended in no bin, without those that were lost (K,)."""
    lost: Ints
    """Held objects that left the cup before their release and ended in no bin (K,)."""
    strayed: Ints
    """Held objects that ended in a bin without a success (K,)."""
    percent: Floats
    """Speed settings (P,) [%]."""
    energy: Floats
    """Mean energy of a throw (K, P) [J]; NaN without a throw."""
    landings: tuple[Floats, ...]
    """Landings of some throws of each item from the middle of the opening, K arrays (L, 2) [m]."""

    @classmethod
    def from_throws(
        cls, items: int, kind: Ints, percent: Floats, hits: Bools, picked: Bools, lost: Bools, ended_in: Ints,
        energy: Floats, miss: Floats,
    ) -> Self:  # fmt: skip
        """Counts of N simulated throws.

        Args:
            items: number of items K.
            kind: index of the item (N,).
            percent: speed setting (N,) [%].
            hits: whether the throw was a success (N,).
            picked: whether the cup sealed (N,).
            lost: whether the object left the cup before its release (N,).
            ended_in: index of the bin in which the object lies, -1 for none (N,).
            energy: energy of the throw (N,) [J].
            miss: landing from the middle of the opening (N, 2) [m].
        """
        settings, no_bin = np.unique(percent), picked & (ended_in < 0)
        groups = [(~no_bin & picked & ~hits), no_bin & lost, no_bin & ~lost]
        strayed, lost_count, missed = (np.bincount(kind[group], minlength=items) for group in groups)
        landed = np.isfinite(miss).all(axis=1)
        return cls(
            held=np.bincount(kind[picked], minlength=items),
            missed=missed,
            lost=lost_count,
            strayed=strayed,
            percent=settings,
            energy=np.array([[_mean(energy[(kind == k) & (percent == p)]) for p in settings] for k in range(items)]),
            landings=tuple(miss[landed & (kind == k)][:LANDINGS] for k in range(items)),
        )

    def entry(self) -> dict[str, Any]:
        """The counts as values of JSON."""
        return {
            "held": self.held.tolist(),
            "missed": self.missed.tolist(),
            "lost": self.lost.tolist(),
            "strayed": self.strayed.tolist(),
            "percent": self.percent.tolist(),
            "energy": [[round(value, 2) if np.isfinite(value) else None for value in row] for row in self.energy],
            "landings": [np.round(points, 4).tolist() for points in self.landings],
        }

    @classmethod
    def of_entry(cls, entry: Any) -> Self:
        """Counts from values of JSON."""
        return cls(
            **{name: np.array(entry[name], dtype=np.int64) for name in ("held", "missed", "lost", "strayed")},
            percent=np.array(entry["percent"], dtype=np.float64),
            energy=np.array(entry["energy"], dtype=np.float64),
            landings=tuple(np.array(points, dtype=np.float64).reshape(-1, 2) for points in entry["landings"]),
        )

    def shares(self) -> Floats:
        """Shares of missed, lost and strayed objects among the failed throws of each item (3, K)."""
        counts = np.stack([self.missed, self.lost, self.strayed]).astype(np.float64)
        total = counts.sum(axis=0)
        # Without a failed throw any failure counts as a miss.
        return np.divide(counts, total, out=np.array([[1.0], [0.0], [0.0]]) * np.ones(len(total)), where=total > 0)

    def energy_of(self, kind: Ints, percent: Floats) -> Floats:
        """Mean energy of throws (N,) [J], at the nearest speed setting."""
        setting = np.abs(percent[:, None] - self.percent).argmin(axis=1)
        return self.energy[kind, setting]


def read_counted(config: LineConfig) -> Counted | None:
    """Counts in the file of a line's table, or of one that a command has made; None without a file with counts."""
    for place in (table_path(config), config.made_table()):
        try:
            counted = Counted.of_entry(json_of(place)[ENTRY])
        except (AccessError, OSError, ValueError, LookupError, TypeError):
            continue
        if len(counted.missed) == len(config.cell.items) == len(counted.landings):
            return counted
    return None


def _mean(values: Floats) -> float:
    """Mean of the finite values; NaN without any."""
    finite = values[np.isfinite(values)]
    return float(finite.mean()) if finite.size else np.nan
