"""Losses of work shifts: what became of objects and of energy, and of the throws behind a line's table of chances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.line.chances import table_path
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.reading import AccessError, json_of

from ..ground import metrics
from ..ground.files import jsonable
from .shifts import Shifts

ENTRY: Final = "counted"
"""Entry of a table's file."""
LANDINGS: Final = 60
"""Landings of each item that are kept at most, for pictures."""
FATES: Final = ("sorted", "misplaced", "missed", "lost", "unsealed", "passed", "out_of_reach")
"""Fates of objects: in a bin that takes the object; in another bin; thrown into no bin; lost from the cup on the way;
past the end after picks that did not seal; past the end without a pick, though a robot could have thrown the object;
past the end, because no robot can throw the object from where it lies into a bin that takes it."""
WORDS: Final[Mapping[str, str]] = {
    "sorted": "sorted",
    "misplaced": "in a wrong bin",
    "missed": "thrown, missed the bin",
    "lost": "lost on the way to the release",
    "unsealed": "passed the end, cup did not seal",
    "passed": "passed the end, not tried",
    "out_of_reach": "passed the end, out of reach",
}
"""Fates in words."""


class CountedThrows(NamedTuple):
    """Columns of N simulated throws, from which losses are counted.

    Attributes:
        kind: index of the item (N,).
        percent: speed setting (N,) [%].
        hits: whether the throw was a success (N,).
        picked: whether the cup sealed (N,).
        lost: whether the object left the cup before its release (N,).
        ended_in: index of the bin in which the object lies, -1 for none (N,).
        energy: energy of the throw (N,) [J].
        miss: landing from the middle of the opening (N, 2) [m].
    """

    kind: Ints
    percent: Floats
    hits: Bools
    picked: Bools
    lost: Bools
    ended_in: Ints
    energy: Floats
    miss: Floats


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
    def of(cls, items: int, throws: CountedThrows) -> Self:
        """Counts of N simulated throws of K items."""
        kind, picked, missing = throws.kind, throws.picked, throws.picked & (throws.ended_in < 0)
        groups = [~missing & picked & ~throws.hits, missing & throws.lost, missing & ~throws.lost]
        strayed, lost, missed = (np.bincount(kind[group], minlength=items) for group in groups)
        landed, settings = np.isfinite(throws.miss).all(axis=1), np.unique(throws.percent)
        energy = [
            [metrics.mean(throws.energy[(kind == k) & (throws.percent == p)]) for p in settings] for k in range(items)
        ]
        return cls(
            held=np.bincount(kind[picked], minlength=items),
            missed=missed,
            lost=lost,
            strayed=strayed,
            percent=settings,
            energy=np.array(energy),
            landings=tuple(throws.miss[landed & (kind == k)][:LANDINGS] for k in range(items)),
        )

    def as_json(self) -> dict[str, Any]:
        """The counts as values of JSON."""
        return {
            "held": self.held.tolist(),
            "missed": self.missed.tolist(),
            "lost": self.lost.tolist(),
            "strayed": self.strayed.tolist(),
            "percent": self.percent.tolist(),
            "energy": jsonable(self.energy, 2),
            "landings": [jsonable(points, 4) for points in self.landings],
        }

    @classmethod
    def from_json(cls, entry: Any) -> Self:
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


def read(config: LineConfig) -> Counted | None:
    """Counts in the file of a line's table, or of one that a command has made; None without a file with counts."""
    for place in (table_path(config), config.made_table()):
        try:
            counted = Counted.from_json(json_of(place)[ENTRY])
        except (AccessError, OSError, ValueError, LookupError, TypeError):
            continue
        if len(counted.missed) == len(config.cell.items) == len(counted.landings):
            return counted
    return None


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
    def of(cls, shifts: Shifts, config: LineConfig, counted: Counted | None) -> Self:
        """Fates of the objects that came in some shifts.

        Args:
            shifts: the shifts.
            config: level of the line.
            counted: what became of the throws behind the table; used where a table gave the results.
        """
        sorted_, misplaced, floor, passed, tried, unreached = (
            shifts.figures[f"shift_{name}_by_item"].astype(np.float64)
            for name in ("sorted", "misplaced", "on_floor", "passed", "passed_tried", "out_of_reach")
        )
        if "lost" in shifts.decisions:
            # Numbers of objects that were lost on the way by shift and item (S, K).
            in_time = shifts.decisions["start"] + shifts.decisions["cycle_time"] <= config.duration
            rows = in_time & shifts.decisions["lost"].astype(bool) & (shifts.decisions["ended_in"] < 0)
            counts = np.zeros_like(floor)
            np.add.at(counts, (shifts.decisions["shift"][rows], shifts.decisions["true_kind"][rows]), 1.0)
            lost, strayed, splits = np.minimum(counts, floor), np.zeros_like(floor), True
        elif counted is not None:
            _, lost_share, strayed_share = counted.shares()
            lost, strayed, splits = floor * lost_share, floor * strayed_share, True
        else:
            lost, strayed, splits = np.zeros_like(floor), np.zeros_like(floor), False
        thrown = sorted_, misplaced + strayed, floor - lost - strayed, lost
        return cls(np.stack([*thrown, tried, passed - tried - unreached, unreached], axis=-1), splits)

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


def summary(shifts: Shifts, config: LineConfig) -> dict[str, Any]:
    """Shares of all fates, of all objects and by item, and the energy of a pick and of a sorted object [J]."""
    counted = read(config)
    fates = Fates.of(shifts, config, counted)
    by_item = zip(config.cell.items, fates.shares_by_item().tolist(), strict=True)
    return {
        "simulated": "lost" in shifts.decisions,
        "fates": fates.shares(),
        "fates_split": fates.splits,
        "fates_by_item": {
            item: dict(zip(FATES, shares, strict=True)) for item, shares in by_item if np.isfinite(shares).all()
        },
        **energy(shifts, counted),
    }


def energy(shifts: Shifts, counted: Counted | None) -> dict[str, float | None]:
    """Energy of a pick, and of a sorted object with its interval over shifts [J]; None where nobody has counted any."""
    names = "energy_per_pick_j", *(f"energy_per_sorted_j{end}" for end in ("", "_low", "_high"))
    energy = decision_energy(shifts, counted)
    if energy is None or not np.isfinite(energy).any():
        return dict.fromkeys(names)
    sorted_ = shifts.figures["shift_sorted_by_item"].sum(axis=1)
    per_pick = float(np.nanmean(energy))
    if not sorted_.any():
        return {**dict.fromkeys(names), names[0]: per_pick}
    per_sorted = metrics.rate(shift_energy(shifts, energy), sorted_, 1.0)
    return dict(zip(names, (per_pick, per_sorted.value, per_sorted.low, per_sorted.high), strict=True))


def shift_energy(shifts: Shifts, energy: Floats) -> Floats:
    """Energy of each shift (S,) [J], of that of each decision (T,); NaN counts as none."""
    sums: Floats = np.zeros(len(shifts.value))
    np.add.at(sums, shifts.decisions["shift"], np.nan_to_num(energy))
    return sums


def decision_energy(shifts: Shifts, counted: Counted | None) -> Floats | None:
    """Energy of each decision (T,) [J], simulated, or the mean of the throws behind the table; None if unknown."""
    decisions = shifts.decisions
    if "energy" in decisions:
        return decisions["energy"].astype(np.float64)
    if counted is None:
        return None
    # Mean energy of throws (N,) [J], at the nearest speed setting.
    kind = decisions["true_kind"]
    percent = decisions["percent"].astype(np.float64)
    setting = np.abs(percent[:, None] - counted.percent).argmin(axis=1)
    return counted.energy[kind, setting]
