"""Throws that were carried out, as arrays, and what they are worth: figures for people, tables and JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints

from ..ground import metrics
from ..ground.files import jsonable
from ..ground.infos import results

FIELDS: Final = {
    "item": ("item", np.int64),
    "landing_error": ("landing_error", np.float64),
    "is_success": ("is_success", np.bool_),
    "cycle_time": ("cycle_time", np.float64),
    "clipped": ("residual_clipped", np.bool_),
}
"""What every cell tells of a throw: our name, and the key and type in the info."""
METRES: Final = {"landing_along": "landing_along_m", "landing_across": "landing_across_m"}
"""Numbers of some cells that records name with their unit."""
FIRST: Final = 10
"""Throws that are the beginning of a shift."""
FAILURES: Final = ("unpicked", "dropped", "recontact", "rim")
"""What stood between a throw and success, the first that holds; the last one tells a target that was reached."""


@final
@dataclass(frozen=True)
class Throws:
    """N throws in the order they are counted, one array entry each."""

    item: Ints
    """Index into the core's `item_names`."""
    landing_error: Floats
    is_success: Bools
    cycle_time: Floats
    clipped: Bools
    """The action was infeasible and another one was executed."""
    reward: Floats
    told: dict[str, NDArray[Any]]
    """What else this cell tells, by the keys of its info."""
    errors: tuple[str, ...] = ()
    """Those of the keys that a controller learns from: the errors of the core's correction."""

    @classmethod
    def of(cls, info: Mapping[str, Any], reward: NDArray[Any], errors: tuple[str, ...]) -> Self:
        """The throws of one step of a vector environment, from its info and rewards."""
        known = results(info, len(reward))
        fields: dict[str, Any] = {name: known.pop(key).astype(kind) for name, (key, kind) in FIELDS.items()}
        return cls(**fields, reward=np.array(reward, dtype=np.float64), told=known, errors=errors)

    def __len__(self) -> int:
        return len(self.item)

    @property
    def sorted(self) -> Bools:
        """Which objects ended where they belong (N,); successes, where the cell tells no more."""
        return self.told.get("sorted", self.is_success).astype(np.bool_)

    @property
    def picked(self) -> Bools:
        """Which objects were held when the throw began (N,); all, where the cell does not tell."""
        return self.told.get("picked", np.full(len(self), True)).astype(np.bool_)

    def flag(self, name: str) -> Bools | None:
        """A failure of `FAILURES` (N,); None where the cell does not tell it."""
        if name == "unpicked":
            return ~self.picked if "picked" in self.told else None
        return self.told[name].astype(np.bool_) if name in self.told else None

    @property
    def error(self) -> Floats:
        """Errors in the coordinates that actions shift (N, E)."""
        columns = [self.told[name].astype(np.float64) for name in self.errors]
        return np.stack(columns, axis=-1) if columns else np.zeros((len(self), 0))


def summary(throws: Throws) -> dict[str, float | int | None]:
    """Figures of an evaluation, by the names of the JSON contract."""
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
        **over_the_shift(throws.landing_error, throws.told.get("pick_in_shift")),
        **scatter(throws),
        "cycle_time_mean_s": pace.cycle_time,
        **sorting(throws),
        "clipped_rate": float(throws.clipped.mean()),
        "reward_mean": float(throws.reward.mean()),
        "unmeasured": where.unmeasured,
        **failures(throws),
        **{f"{name}_rate": float(flag.mean()) for name, flag in throws.told.items() if flag.dtype == np.bool_},
    }


def over_the_shift(error: Floats, pick: Ints | None) -> dict[str, float | None]:
    """Landing error at the beginning of shifts and in their second half.

    Args:
        error: of N throws (N,) [m], NaN where it is not known.
        pick: where in its shift each stands (N,), from 0 on; None where nothing tells, and then nothing is told.
    """
    if pick is None:
        return {}
    parts = {"first_10": pick < FIRST, "second_half": pick >= (pick.max() + 1) // 2}
    means = {name: error[rows & np.isfinite(error)] for name, rows in parts.items()}
    return {f"landing_error_{name}_m": float(e.mean()) if e.size else None for name, e in means.items()}


def sorting(throws: Throws) -> dict[str, float | int | None]:
    """What a sorter is judged by beside its pace, as far as the cell tells; None where nothing can be said."""
    told, found = throws.told, dict[str, float | int | None]()
    if "belongs" in told:
        found["purity"] = _finite(metrics.purity(told["ended_in"], told["belongs"]).share)
    if "passed" in told:
        found["recovery"] = metrics.recovery(throws.sorted, told["passed"])
        found["objects_passed"] = int(told["passed"].sum())
    if "picked" in told:
        found["pick_rate"] = float(throws.picked.mean())
    if "dropped" in told:
        held = throws.picked
        found["drop_rate"] = float(told["dropped"][held].mean()) if held.any() else None
    if "energy" in told:
        found["energy_per_pick_j"] = float(told["energy"].mean())
    return found


def purity_by_bin(throws: Throws, names: Sequence[str]) -> dict[str, float | None]:
    """Share of what ended in each bin that belongs there, by the bin's name; None for an empty one."""
    found = metrics.purity(throws.told["ended_in"], throws.told["belongs"], len(names))
    return {name: _finite(share) for name, share in zip(names, found.by_bin, strict=True)}


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def scatter(throws: Throws) -> dict[str, float]:
    """Mean and deviation of the landing along and across, and of the errors of the correction, in their own units."""
    found: dict[str, float] = {}
    for name in dict.fromkeys([*(name for name in METRES if name in throws.told), *throws.errors]):
        values = throws.told[name][np.isfinite(throws.told[name])]
        if values.size > 0:
            label = METRES.get(name, name).removeprefix("landing_")
            found |= {f"bias_{label}": float(values.mean()), f"spread_{label}": float(values.std())}
    return found


def failures(throws: Throws) -> dict[str, float]:
    """Share of all throws that failed, by what stood between, where the cell tells: all shares sum to the failure rate.

    A touched object is counted as touched whatever it did then; the rest either missed the target
    (opening or pose) or reached it without staying there.
    """
    failed, shares = ~throws.is_success, dict[str, float]()
    for name in FAILURES:
        flag = throws.flag(name)
        if flag is not None:
            shares[f"failed_{name}"] = float((failed & flag).mean())
            failed = failed & ~flag
    return shares | ({"failed_missed": float(failed.mean())} if FAILURES[-1] in throws.told else {})


def throw_records(throws: Throws, item_names: Sequence[str]) -> list[dict[str, Any]]:
    """One JSON object per throw: what every cell tells, then all that this one does."""
    columns = {
        "item": [item_names[i] for i in throws.item],
        "landing_error_m": throws.landing_error,
        "success": throws.is_success,
        "cycle_time_s": throws.cycle_time,
        "clipped": throws.clipped,
        "reward": throws.reward,
        **{METRES.get(name, name): column for name, column in throws.told.items()},
    }
    if {"target_x", "target_y"} <= set(columns):
        columns["target"] = np.stack([columns.pop("target_x"), columns.pop("target_y")], axis=-1)
    rows = zip(*map(jsonable, columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]
