"""Texts and figures of the cards of policies that correct throws."""

from __future__ import annotations

from typing import Final

from ..card import Card
from .tables import landing_cells

CARD: Final = Card(
    judged="picks",
    header=("landing error", "95th percentile", "under 30 mm", "success (95 % interval)", "sorted/min"),
    cells=lambda summary: [*landing_cells(summary), f"{summary['sorted_per_min']:.1f}"],
    reward=lambda found: [throw["reward"] for throw in found["throws"]],
    rewarded="reward of a throw",
    metrics={
        "success_rate": "share of throws that succeed",
        "landing_error_mean_m": "landing error, mean [m]",
        "sorted_per_min": "sorted picks per minute",
    },
    film="A film of some throws",
    use=("pnt-gym evaluate --controller {name} --picks 200", "pnt-gym play --controller {name} --video throws.mp4"),
    graph="`observation` (N, D) to `action` (N, A)",
    actions="(N, A) float32",
)
