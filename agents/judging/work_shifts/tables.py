"""Tables of work shifts on the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from rich.table import Table

from ...ground import metrics
from ...ground.tables import Grid, gain_text, interval_text, percent, success_text, value_table
from ..record import Row, Summary
from .fates import fate_words

ENERGY: Final = {"energy_per_pick_j": "energy per pick", "energy_per_sorted_j": "energy per sorted object"}
"""Labels of the figures of energy, which a table without counts of energy lacks."""


def shifts_table(title: str, summary: Summary) -> Table:
    """Table of all figures of work shifts, one figure per line."""
    low, high = summary["value_per_min_low"], summary["value_per_min_high"]
    rows = [
        ("value per minute", f"{summary['value_per_min']:.1f} ({low:.1f} .. {high:.1f})"),
        ("sorted per minute", f"{summary['sorted_per_min']:.1f}"),
        ("picks per minute, attempted", f"{summary['picks_per_min']:.1f}"),
        ("success", success_text(summary)),
        ("recovery: sorted of all that came", percent(summary["recovery"])),
        ("recovery of value", percent(summary["value_recovery"])),
        *_loss_rows(summary),
        ("value that passed the end, per minute", f"{summary['passed_value_per_min']:.1f}"),
        ("tried in vain, of what passed it", percent(summary["passed_tried"])),
        (_purity_label(summary), percent(summary["purity"])),
        *((f"purity of bin {name}", percent(share)) for name, share in summary["purity_by_bin"].items() if share < 1.0),
        ("picks that sealed", percent(summary["pick_rate"])),
        *(
            (
                f"robot {name}: at work, picks in a shift, standstill for each",
                f"{percent(share)}, {picks:.0f}, {_seconds(wait)}",
            )
            for name, share, picks, wait in zip(
                *(summary[key] for key in ("robots", "utilisation", "picks_by_robot", "wait_by_robot_s")), strict=True
            )
        ),
        ("cycle time, mean", f"{summary['cycle_time_mean_s']:.3f} s"),
        ("standstill above the belt, mean", f"{summary['wait_time_mean_s']:.3f} s"),
        *((text, f"{summary[key]:.1f} J") for key, text in ENERGY.items() if summary.get(key) is not None),
        ("time of a decision", f"{summary['ms_per_decision']:.2f} ms"),
        ("choices that were not there", str(summary["invalid_actions"])),
    ]
    return value_table(title, rows)


def _loss_rows(summary: Summary) -> Iterator[tuple[str, str]]:
    """Rows of the causes for which objects were not sorted, and of the items, the worst one first."""
    for name, share in summary["fates"].items():
        if name != "sorted" and (name != "lost" or summary["fates_split"]):
            yield f"failed: {fate_words(name, summary['fates_split'])}", percent(share)
    for item, shares in sorted(summary["fates_by_item"].items(), key=lambda entry: entry[1]["sorted"]):
        loss = max((name for name in shares if name != "sorted"), key=shares.__getitem__)
        words = f"{percent(shares[loss])} {fate_words(loss, summary['fates_split'])}"
        yield f"{item}: recovery, largest loss", f"{percent(shares['sorted'])}, {words}"


def _purity_label(summary: Summary) -> str:
    """Label of the purity; a table of throws knows no strays."""
    strays = "" if summary["simulated"] else ", without strays"
    return f"purity: share of what is in bins{strays}"


def _seconds(time: float | None) -> str:
    """Text of a time [s]; "-" for None."""
    return "-" if time is None else f"{time:.3f} s"


def shifts_comparison(title: str, rows: Sequence[Row], base: str | None) -> Table:
    """Table of a line's controllers over the same shifts, one per line, with paired gains over controller `base`.

    A controller that worked fewer shifts is compared on these shifts alone.
    """
    compared = next((summary["by_shift"]["value_per_min"] for name, _, summary in rows if name == base), None)
    values = [summary["by_shift"]["value_per_min"] for _, _, summary in rows]
    lines = [
        [
            name,
            f"{count} decisions" if count else "-",
            interval_text(metrics.mean_interval(value)),
            "-" if name == base else gain_text(value, compared),
            f"{summary['sorted_per_min']:.1f}",
            percent(summary["recovery"]),
            f"{summary['ms_per_decision']:.2f}",
        ]
        for (name, count, summary), value in zip(rows, values, strict=True)
    ]
    header = ("controller", "learned from", "value/min (95 % interval)", f"over {base}", "sorted/min", "recovery")
    return Grid(title, (*header, "ms/decision"), lines).terminal()
