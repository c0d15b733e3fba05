"""Chances of throws by the table, in machine code; see `pnt_gym.compiled`."""

from __future__ import annotations

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel_part


@kernel_part
def landing_chance(
    kind: int, percent: float, distance: float, settings: Floats, edges: Floats, landed: Floats
) -> float:
    """Chance that a held object ends in its bin, as `Chances.landing_chance`."""
    setting = 0
    for p in range(1, len(settings)):
        if abs(percent - settings[p]) < abs(percent - settings[setting]):
            setting = p
    part = 0
    while part < len(edges) and edges[part] < distance:
        part += 1
    return landed[kind, setting, part]
