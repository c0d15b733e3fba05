"""Throws as arrays, and their figures for tables and JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints

from ...ground import metrics
from ...ground.files import jsonable
from ...ground.infos import results

FIELDS: Final = {
    "item": ("item", np.int64),
    "landing_error": ("landing_error", np.float64),
    "is_success": ("is_success", np.bool_),
    "cycle_time": ("cycle_time", np.float64),
    "clipped": ("residual_clipped", np.bool_),
}
"""Fields of a throw that every cell's info has: key and type in the info by our name."""
METRES: Final = {"landing_along": "landing_along_m", "landing_across": "landing_across_m"}
"""Names with unit of some cells' lengths in JSON records."""
FIRST: Final = 10
"""Number of throws that count as the beginning of a shift."""
FAILURES: Final = ("unpicked", "dropped", "recontact", "rim")
"""Causes of failure in order of precedence; `rim`: the target was reached, but the object did not stay."""


@final
@dataclass(frozen=True)
class Throws:
    """N throws in the order of counting, one array entry each."""

    item: Ints
    """Index into the core's `item_names`."""
    landing_error: Floats
    is_success: Bools
    cycle_time: Floats
    clipped: Bools
    """Whether the action was infeasible and a shortened one was executed."""
    reward: Floats
    info: dict[str, NDArray[Any]]
    """All other values of the cell's info, by key."""
    errors: tuple[str, ...] = ()
    """Keys of the values from which a controller learns: the errors of the core's correction."""

    @classmethod
    def of(cls, info: Mapping[str, Any], reward: NDArray[Any], errors: tuple[str, ...]) -> Self:
        """Throws of one step of a vector environment, from its info and rewards."""
        columns = results(info, len(reward))
        fields: dict[str, Any] = {name: columns.pop(key).astype(kind) for name, (key, kind) in FIELDS.items()}
        return cls(**fields, reward=np.array(reward, dtype=np.float64), info=columns, errors=errors)

    def __len__(self) -> int:
        return len(self.item)

    @property
    def sorted(self) -> Bools:
        """Whether each object ended in a bin of its kind (N,); the success in cells without `sorted`."""
        return self.info.get("sorted", self.is_success).astype(np.bool_)

    @property
    def picked(self) -> Bools:
        """Whether the cup held each object when the throw began (N,); True in cells without `picked`."""
        return self.info.get("picked", np.full(len(self), True)).astype(np.bool_)

    def flag(self, name: str) -> Bools | None:
        """Mask of a failure of `FAILURES` (N,); None in cells without it."""
        if name == "unpicked":
            return ~self.picked if "picked" in self.info else None
        return self.info[name].astype(np.bool_) if name in self.info else None

    @property
    def error(self) -> Floats:
        """Errors in the coordinates that actions correct (N, E)."""
        columns = [self.info[name].astype(np.float64) for name in self.errors]
        return np.stack(columns, axis=-1) if columns else np.zeros((len(self), 0))


def summary(throws: Throws) -> dict[str, float | int | None]:
    """Figures of all throws, by the names of the JSON contract."""
    rate = metrics.wilson(int(throws.is_success.sum()), len(throws))
    pace = metrics.throughput(throws.sorted, throws.cycle_time)
    where = metrics.landing(throws.landing_error)
    return {
        "picks": len(throws),
        "picks_per_min": pace.attempted,
        "sorted_per_min": pace.sorted,
        "success_rate": rate.value,
        "success_low": rate.low,
        "success_high": rate.high,
        "landing_error_mean_m": where.mean,
        "landing_error_p95_m": where.p95,
        "landing_error_iqm_m": where.iqm,
        "landing_near_share": where.near,
        **over_the_shift(throws.landing_error, throws.info.get("pick_in_shift")),
        **scatter(throws),
        "cycle_time_mean_s": pace.cycle_time,
        **sorting(throws),
        "clipped_rate": float(throws.clipped.mean()),
        "reward_mean": float(throws.reward.mean()),
        "unmeasured": where.unmeasured,
        **failures(throws),
        **{f"{name}_rate": float(flag.mean()) for name, flag in throws.info.items() if flag.dtype == np.bool_},
    }


def over_the_shift(error: Floats, pick: Ints | None) -> dict[str, float | None]:
    """Landing error at the beginning of shifts and in their second half.

    Args:
        error: landing errors (N,) [m], NaN where not measured.
        pick: index of each throw in its shift (N,), from 0; None in cells without shifts, for no figures.
    """
    if pick is None:
        return {}
    parts = {"first_10": pick < FIRST, "second_half": pick >= (pick.max() + 1) // 2}
    means = {name: error[rows & np.isfinite(error)] for name, rows in parts.items()}
    return {f"landing_error_{name}_m": float(e.mean()) if e.size else None for name, e in means.items()}


def sorting(throws: Throws) -> dict[str, float | int | None]:
    """Figures of sorting beside the pace, those that the cell's info allows; None where a figure is undefined."""
    info, figures = throws.info, dict[str, float | int | None]()
    if "belongs" in info:
        figures["purity"] = _finite(metrics.purity(info["ended_in"], info["belongs"]).share)
    if "passed" in info:
        figures["recovery"] = metrics.recovery(throws.sorted, info["passed"])
        figures["objects_passed"] = int(info["passed"].sum())
    if "picked" in info:
        figures["pick_rate"] = float(throws.picked.mean())
    if "dropped" in info:
        picked = throws.picked
        figures["drop_rate"] = float(info["dropped"][picked].mean()) if picked.any() else None
    if "tries" in info:
        figures["tries_per_pick"] = float(info["tries"].mean())
    if "energy" in info:
        figures["energy_per_pick_j"] = float(info["energy"].mean())
    return figures


def purity_by_bin(throws: Throws, names: Sequence[str]) -> dict[str, float | None]:
    """Share of the objects in each bin that belong there, by the bin's name; None for an empty bin."""
    purity = metrics.purity(throws.info["ended_in"], throws.info["belongs"], len(names))
    return {name: _finite(share) for name, share in zip(names, purity.by_bin, strict=True)}


def by_kind(throws: Throws, names: Sequence[str]) -> dict[str, dict[str, float]]:
    """Shares of the objects of each kind that were held, dropped on the way, and sorted, by the kind's name."""
    shares: dict[str, dict[str, float]] = {}
    for kind in np.unique(throws.item):
        rows = throws.item == kind
        columns = {"held": throws.picked, "dropped": throws.info["dropped"], "sorted": throws.sorted}
        shares[str(names[int(kind)])] = {"picks": float(rows.sum())} | {
            name: float(column[rows].mean()) for name, column in columns.items()
        }
    return shares


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def scatter(throws: Throws) -> dict[str, float]:
    """Mean and standard deviation of the landing along and across the throw, and of the correction's errors."""
    figures: dict[str, float] = {}
    for name in dict.fromkeys([*(name for name in METRES if name in throws.info), *throws.errors]):
        values = throws.info[name][np.isfinite(throws.info[name])]
        if values.size > 0:
            label = METRES.get(name, name).removeprefix("landing_")
            figures |= {f"bias_{label}": float(values.mean()), f"spread_{label}": float(values.std())}
    return figures


def failures(throws: Throws) -> dict[str, float]:
    """Share of all throws that failed, by cause, where the cell's info has causes; the shares sum to the failure rate.

    Each failed throw counts under its first cause in `FAILURES`; a throw without any cause missed the target (opening
    or pose).
    """
    failed, shares = ~throws.is_success, dict[str, float]()
    for name in FAILURES:
        flag = throws.flag(name)
        if flag is not None:
            shares[f"failed_{name}"] = float((failed & flag).mean())
            failed = failed & ~flag
    return shares | ({"failed_missed": float(failed.mean())} if FAILURES[-1] in throws.info else {})


def throw_records(throws: Throws, item_names: Sequence[str]) -> list[dict[str, Any]]:
    """One JSON object per throw: the fields of every cell, then all values of this cell's info."""
    columns = {
        "item": [item_names[i] for i in throws.item],
        "landing_error_m": throws.landing_error,
        "success": throws.is_success,
        "cycle_time_s": throws.cycle_time,
        "clipped": throws.clipped,
        "reward": throws.reward,
        **{METRES.get(name, name): column for name, column in throws.info.items()},
    }
    if {"target_x", "target_y"} <= set(columns):
        columns["target"] = np.stack([columns.pop("target_x"), columns.pop("target_y")], axis=-1)
    rows = zip(*map(jsonable, columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]
