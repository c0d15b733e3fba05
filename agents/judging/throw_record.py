"""The record of a trial by throws: its figures, each declared once, for evaluations and for benchmarks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.core import Core

from ..controllers.adaptive import has_feedback
from ..ground import metrics
from ..ground.versions import versions
from .figures import Figure, Kind, count, mean, rate, ratio, share, total
from .record import Card, Record, Result, Summary, summarise
from .rows import Rows
from .throws import METRES, OUTCOMES, PLACES, ThrowColumns, Throws, kept_columns, kept_rows, live_rows, throw_records

FIRST: Final = 10
"""Number of throws that count as the beginning of a shift."""
RUN: Final = 10
"""Throws of a row in one block, in cells whose episodes are long; an episode of fewer throws is whole."""


def landing(part: str) -> Kind:
    """A figure of the landing errors: a field of `metrics.Landing`."""
    return lambda error: getattr(metrics.landing(error.ravel()), part)


MM: Final = ("mm", 1000.0)
PERCENT: Final = ("%", 100.0)
ERROR: Final = ("error_m",)
PACE: Final = Figure(
    "sorted/min",
    kind=rate,
    of=("sorted", "cycle_s"),
    # Only cycles under half a second, which few cells have, can differ by more.
    cap=120.0,
    words="{a} sorts {amount} a minute more than {b}",
)
LANDING: Final = Figure("landing error", *MM, of=ERROR, cap=0.100, words="{a} lands {amount} closer than {b}", sign=-1)
SUCCESS: Final = Figure(
    "success", *PERCENT, of=("success",), cap=1.0, words="{a} succeeds in {amount} more of the throws than {b}"
)
COMMON: Final = {
    "picks_per_min": Figure("picks per minute, attempted", kind=rate, of=("throw", "cycle_s"), head="picks/min"),
    "sorted_per_min": Figure("sorted per minute", kind=rate, of=("sorted", "cycle_s"), head="sorted/min"),
    "success_rate": Figure(
        "success",
        *PERCENT,
        kind=share,
        of=("success", "throw"),
        ends=("success_low", "success_high"),
        head="success (95 % interval)",
    ),
    "landing_error_mean_m": Figure("landing error, mean", *MM, kind=landing("mean"), of=ERROR, head="landing error"),
    "landing_error_p95_m": Figure(
        "landing error, 95th percentile", *MM, kind=landing("p95"), of=ERROR, head="95th percentile"
    ),
    "landing_error_iqm_m": Figure(kind=landing("iqm"), of=ERROR),
    "landing_near_share": Figure("landings within 30 mm", *PERCENT, kind=landing("near"), of=ERROR, head="under 30 mm"),
    "landing_error_first_10_m": Figure(
        "landing error, first 10 of a shift",
        *MM,
        kind=lambda error, pick: mean(error[pick < FIRST]),
        of=(*ERROR, "pick"),
    ),
    "landing_error_second_half_m": Figure(
        "landing error, second half of a shift",
        *MM,
        kind=lambda error, pick: mean(error[pick >= (pick.max() + 1) // 2]),
        of=(*ERROR, "pick"),
    ),
    "cycle_time_mean_s": Figure("cycle time, mean", "s", digits=3, of=("cycle_s",)),
    "recovery": Figure("recovery: sorted of all that passed", *PERCENT, kind=ratio, of=("sorted", "offered")),
    "purity": Figure("purity: share of what is in bins", *PERCENT, kind=ratio, of=("belong", "ended")),
    "pick_rate": Figure("picks that sealed", *PERCENT, of=("picked",)),
    "drop_rate": Figure("lost on the way, of those", *PERCENT, kind=ratio, of=("dropped", "picked")),
    "tries_per_pick": Figure("tries to grasp a pick", digits=2, of=("tries",)),
    "energy_per_pick_j": Figure("energy per pick", "J", of=("energy_j",)),
    "unmeasured": Figure(kind=landing("unmeasured"), of=ERROR),
}
"""Figures of evaluations and of benchmarks, those that the rows allow."""
FAILED: Final = {
    "missed": "missed the target",
    "rim": "reached it, did not stay",
    "recontact": "touched again by the robot",
    "dropped": "lost on the way to the release",
    "unpicked": "not picked",
}
"""Outcomes that fail, in words."""
CLIPPED: Final = Figure("corrections clipped", *PERCENT, of=("clipped",))


@final
class ThrowRecord(Record):
    """Record of throws.

    Args:
        throws: the throws and their results.
        core: the cells in which the throws were carried out.
        settings: further entries of the report, such as whether the controller went on learning.
    """

    figures: ClassVar[Mapping[str, Figure]] = {"landing_error_m": LANDING, "sorted_per_min": PACE}
    measured: ClassVar[Mapping[str, Figure]] = {"landing_error_m": LANDING, "success": SUCCESS, "sorted_per_min": PACE}
    shown: ClassVar[Mapping[str, Figure]] = {
        "picks": Figure(kind=count, of=("throw",)),
        **COMMON,
        "objects_passed": Figure(kind=total, of=("passed",)),
        **{
            f"failed_{name}": Figure(f"failed: {text}", *PERCENT, of=(f"share_{name}",))
            for name, text in FAILED.items()
        },
        "clipped_rate": CLIPPED,
        "reward_mean": Figure(of=("reward",)),
    }
    kept: ClassVar[Mapping[str, Figure]] = {
        **COMMON,
        "landing_error_mean_m": replace(
            COMMON["landing_error_mean_m"], ends=("landing_error_low_m", "landing_error_high_m")
        ),
        **{f"share_{name}": Figure() for name in OUTCOMES},
        "clipped_rate": CLIPPED,
        "recontact_rate": Figure(of=("recontact",)),
    }
    heads = (
        "landing_error_mean_m",
        "landing_error_p95_m",
        "landing_near_share",
        "success_rate",
        "picks_per_min",
        "sorted_per_min",
    )
    step = "throws"

    def __init__(self, throws: Throws, core: Core, settings: Mapping[str, Any]) -> None:
        self.throws = throws
        self._core, self._settings = core, settings
        length = run_length(core) if depend(core) else 1
        self.rows = Rows.of(live_rows(throws), length, settings["num_envs"])

    def summary(self) -> dict[str, Any]:
        """Figures of all throws, by the names of the JSON contract."""
        return summary(self.throws)

    def report(self) -> dict[str, Any]:
        """Summary, purity of each bin, settings, and under `throws` a mapping for each throw."""
        names = self._core.cell.target_names if "belongs" in self.throws.info else ()
        return {
            **self.summary(),
            **({"purity_by_bin": purity_by_bin(self.throws, names)} if names else {}),
            **({"by_kind": by_kind(self.throws, self._core.item_names)} if "tries" in self.throws.info else {}),
            "dwell_s": self._core.dwell,
            **self._settings,
            "action_mode": self._core.action_mode,
            "versions": versions(),
            "throws": throw_records(self.throws, self._core.item_names),
        }

    def columns(self) -> dict[str, Any]:
        """Throws as columns, rounded."""
        return kept_columns(self.throws)

    @classmethod
    def form(cls) -> type[ThrowColumns]:
        """Form of the columns of throws."""
        return ThrowColumns

    @classmethod
    def rows_of(cls, columns: Mapping[str, Any], num_envs: int) -> Rows:
        """Rows of the throws that a benchmark keeps; throws of one shift depend on one another."""
        return Rows.of(kept_rows(columns), max(columns.get("pick", (0,))) + 1, num_envs)

    @classmethod
    def summarise(cls, results: Sequence[Result], num_envs: int) -> dict[str, Any]:
        """Figures of one controller over its seeds, without those that are not defined."""
        return {name: value for name, value in super().summarise(results, num_envs).items() if value is not None}

    @classmethod
    def further(cls, results: Sequence[Result], rows: Rows) -> dict[str, Any]:
        """Bias and spread of the landings, landing errors by seed, and over the shift if there are any."""
        error = rows["error_m"]
        found: dict[str, Any] = {
            "landing_error_by_seed_m": [float(np.nanmean(seed_errors)) for seed_errors in error],
            **_figures({name: rows[name] for name in PLACES if name in rows}),
        }
        if "pick" in rows:
            pick = rows["pick"]
            found["shifts"] = error.shape[1] // rows.length
            found["landing_error_by_pick_m"] = [float(np.nanmean(error[pick == k])) for k in range(rows.length)]
        return found

    @classmethod
    def objects(cls, columns: Mapping[str, Any]) -> list[int] | None:
        """Items of the throws; None in cells with shifts, whose streams do not depend on the picks."""
        return None if "pick" in columns else columns["item"]

    @classmethod
    def lines(cls, summary: Summary) -> list[tuple[str, str]]:
        """Lines of all figures that the cell has; bias and spread of each error and the bins stand at the end."""
        biases = (key for key in summary if key.startswith("bias_") and "seen" not in key)
        bins = summary.get("purity_by_bin", {}).items()
        return [
            *super().lines(summary),
            *(_line(summary, key) for key in biases),
            *((f"purity of bin {name}", COMMON["purity"].text(purity)) for name, purity in bins),
        ]


def summary(throws: Throws) -> dict[str, Any]:
    """Figures of throws, by the names of the JSON contract: those of `ThrowRecord`, of errors and of flags."""
    info = throws.info
    names = dict.fromkeys([*(name for name in METRES if name in info), *throws.errors])
    return {
        **summarise(ThrowRecord.shown, Rows.of(live_rows(throws))),
        **_figures({METRES.get(name, name).removeprefix("landing_"): info[name] for name in names}),
        **{f"{name}_rate": float(flag.mean()) for name, flag in info.items() if flag.dtype == np.bool_},
    }


def _figures(columns: Mapping[str, Floats]) -> dict[str, float]:
    """Mean and standard deviation of each error that was measured."""
    figures: dict[str, float] = {}
    for name, column in columns.items():
        values = column[np.isfinite(column)]
        if values.size > 0:
            figures |= {f"bias_{name}": float(values.mean()), f"spread_{name}": float(values.std())}
    return figures


def _line(summary: Summary, bias: str) -> tuple[str, str]:
    """Label and text of bias and spread of one error; in millimetres if the name of the figure ends in `_m`."""
    name = bias.removeprefix("bias_")
    values = [summary[bias], summary[f"spread_{name}"]]
    label, metres = f"bias / spread {name.removesuffix('_m').replace('_', ' ')}", name.endswith("_m")
    return label, " / ".join(f"{1000 * v:.1f}" if metres else f"{v:.3g}" for v in values) + " mm" * metres


def purity_by_bin(throws: Throws, names: Sequence[str]) -> dict[str, float | None]:
    """Share of the objects in each bin that belong there, by the bin's name; None for an empty bin."""
    purity = metrics.purity(throws.info["ended_in"], throws.info["belongs"], len(names))
    return {name: part if np.isfinite(part) else None for name, part in zip(names, purity.by_bin, strict=True)}


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


def depend(core: Core) -> bool:
    """Whether throws of a row depend on the row's earlier throws by more than chance: on feedback, or on success."""
    cell = getattr(core, "cell", None)  # a user's environment need not have one
    return has_feedback(core) or (cell is not None and cell.episode > 1 and cell.terminates)


def run_length(core: Core) -> int:
    """Number of throws of each row in a block: an episode, or its first part where throws do not depend."""
    return core.cell.episode if depend(core) else min(core.cell.episode, RUN)


CARD: Final = Card(
    judged="picks",
    figures={name: ThrowRecord.shown[name] for name in ThrowRecord.heads if name != "picks_per_min"},
    reward=lambda found: [throw["reward"] for throw in found["throws"]],
    rewarded="reward of a throw",
    metrics={
        "success_rate": "share of throws that succeed",
        "landing_error_mean_m": "landing error, mean [m]",
        "sorted_per_min": "sorted picks per minute",
    },
    film="A film of some throws",
    use=("pnt-gym evaluate --controller {name} --picks 200", "pnt-gym play --controller {name} --video throws.mp4"),
)
"""Texts and figures of the cards of policies that correct throws."""
