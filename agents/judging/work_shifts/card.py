"""Texts and figures of the cards of policies that choose objects on lines."""

from __future__ import annotations

from typing import Final

from ...ground.tables import percent
from ..card import Card

CARD: Final = Card(
    judged="shifts",
    header=("value/min (95 % interval)", "sorted/min", "recovery", "recovery of value", "ms/decision"),
    cells=lambda summary: [
        f"{summary['value_per_min']:.1f} ({summary['value_per_min_low']:.1f}..{summary['value_per_min_high']:.1f})",
        f"{summary['sorted_per_min']:.1f}",
        *(percent(summary[name]) for name in ("recovery", "value_recovery")),
        f"{summary['ms_per_decision']:.2f}",
    ],
    reward=lambda found: found["by_shift"]["value_per_min"],
    rewarded="value per minute of a shift",
    metrics={
        "sorted_per_min": "sorted picks per minute",
        "recovery": "share of all objects that came which was sorted",
        "value_recovery": "share of their value",
    },
    film="A film of the line at work",
    use=(
        "pnt-gym evaluate --controller {name} --shifts 100",
        "pnt-gym play --controller {name} --video line.mp4",
    ),
    graph="`observation` (N, D) to the choice `action` (N,) and the `scores` (N, C) of all that there are",
    actions="(N,) int64",
)
