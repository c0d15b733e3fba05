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
    "pick_rate": "picks that sealed",
    "drop_rate": "lost on the way, of those",
}
"""Labels of the figures of sorting, which some cells have."""
SHIFT: Final = {
    "landing_error_first_10_m": "landing error, first 10 of a shift",
    "landing_error_second_half_m": "landing error, second half of a shift",
}
"""Labels of the figures of cells with shifts, in which a throw teaches something for later throws."""
FAILURES: Final = {
    "failed_missed": "failed: missed the target",
    "failed_rim": "failed: reached it, did not stay",
    "failed_recontact": "failed: touched again by the robot",
    "failed_dropped": "failed: lost on the way to the release",
    "failed_unpicked": "failed: not picked",
}
"""Labels of the shares of failures, which some cells have."""


def summary_table(title: str, summary: Summary) -> Table:
    """Table of the figures of one evaluation that the cell has, one per line."""
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
        *([("tries to grasp a pick", f"{summary['tries_per_pick']:.2f}")] if "tries_per_pick" in summary else []),
        *((f"purity of bin {name}", percent(share)) for name, share in summary.get("purity_by_bin", {}).items()),
        *([("energy per pick", f"{summary['energy_per_pick_j']:.1f} J")] if "energy_per_pick_j" in summary else []),
        *((text, percent(summary[key])) for key, text in FAILURES.items() if key in summary),
        ("corrections clipped", f"{100 * summary['clipped_rate']:.1f} %"),
    ]
    return value_table(title, rows)


def comparison_table(title: str, rows: Sequence[Row]) -> Table:
    """Table of controllers, one per line, from name, number of practice or training throws, and summary."""
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
    """Texts of the landing error, its 95th percentile, the share of landings within 30 mm, and the success rate."""
    errors = (summary["landing_error_mean_m"], summary["landing_error_p95_m"])
    return [*map(millimetres, errors), percent(summary["landing_near_share"]), success_text(summary)]


def scatter_row(summary: Summary, bias: str) -> tuple[str, str]:
    """Label and text of bias and spread of one error; in millimetres if the name of the figure ends in `_m`."""
    name = bias.removeprefix("bias_")
    values = [summary[bias], summary[f"spread_{name}"]]
    label, metres = f"bias / spread {name.removesuffix('_m').replace('_', ' ')}", name.endswith("_m")
    return label, " / ".join(f"{1000 * v:.1f}" if metres else f"{v:.3g}" for v in values) + " mm" * metres
