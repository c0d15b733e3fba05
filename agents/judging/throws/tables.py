"""Tables of throws on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from rich.table import Table

from ...ground.tables import Grid, millimetres, percent, success_text, value_table
from ..record import Row, Summary

SORTING: Final = {
    "recovery": "recovery: sorted of all that passed",
    "purity": "purity: share of what is in bins",
    "pick_rate": "picks that held",
    "drop_rate": "lost on the way, of those",
}
"""Shares by which a sorter is judged, where its cell tells them."""
SHIFT: Final = {
    "landing_error_first_10_m": "landing error, first 10 of a shift",
    "landing_error_second_half_m": "landing error, second half of a shift",
}
"""Figures of cells in which a throw teaches something for those after it."""
FAILURES: Final = {
    "failed_missed": "failed: missed the target",
    "failed_rim": "failed: reached it, did not stay",
    "failed_recontact": "failed: touched again by the robot",
    "failed_dropped": "failed: lost on the way to the release",
    "failed_unpicked": "failed: not picked",
}
"""Figures of some cells, and what they are called."""


def summary_table(title: str, summary: Summary) -> Table:
    """Every figure of one evaluation that its cell tells, one per line."""
    rows = [
        ("picks per minute, attempted", f"{summary['picks_per_min']:.1f}"),
        ("sorted per minute", f"{summary['sorted_per_min']:.1f}"),
        ("success", success_text(summary)),
        ("landing error, mean", millimetres(summary["landing_error_mean_m"])),
        ("landing error, 95th percentile", millimetres(summary["landing_error_p95_m"])),
        ("landings within 30 mm", percent(summary["landing_near_share"])),
        *((text, millimetres(summary[key])) for key, text in SHIFT.items() if summary.get(key) is not None),
        *(scatter_row(summary, key) for key in summary if key.startswith("bias_") and "seen" not in key),
        ("cycle time, mean", f"{summary['cycle_time_mean_s']:.3f} s"),
        *((text, percent(summary[key])) for key, text in SORTING.items() if key in summary),
        *((f"purity of bin {name}", percent(share)) for name, share in summary.get("purity_by_bin", {}).items()),
        *([("energy per pick", f"{summary['energy_per_pick_j']:.1f} J")] if "energy_per_pick_j" in summary else []),
        *((text, percent(summary[key])) for key, text in FAILURES.items() if key in summary),
        ("corrections clipped", f"{100 * summary['clipped_rate']:.1f} %"),
    ]
    return value_table(title, rows)


def comparison_table(title: str, rows: Sequence[Row]) -> Table:
    """Controllers side by side; each row is a name, its throws of practice or training, and its summary."""
    header = ("controller", "learned from", "landing error", "95th pct", "under 30 mm", "success (95 % interval)")
    lines = [
        [
            name,
            f"{throws} throws" if throws else "-",
            *landing_cells(summary),
            f"{summary['picks_per_min']:.1f}",
            f"{summary['sorted_per_min']:.1f}",
        ]
        for name, throws, summary in rows
    ]
    return Grid(title, (*header, "picks/min", "sorted/min"), lines).terminal()


def landing_cells(summary: Summary) -> list[str]:
    """Landing error, its 95th percentile, the share of landings within 30 mm, and success."""
    errors = (summary["landing_error_mean_m"], summary["landing_error_p95_m"])
    return [*map(millimetres, errors), percent(summary["landing_near_share"]), success_text(summary)]


def scatter_row(summary: Summary, bias: str) -> tuple[str, str]:
    """Bias and spread of one error; in millimetres where its name says that it is in metres."""
    name = bias.removeprefix("bias_")
    values = [summary[bias], summary[f"spread_{name}"]]
    label, metres = f"bias / spread {name.removesuffix('_m').replace('_', ' ')}", name.endswith("_m")
    return label, " / ".join(f"{1000 * v:.1f}" if metres else f"{v:.3g}" for v in values) + " mm" * metres
