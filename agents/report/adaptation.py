"""What `benchmarks/study_adaptation.py` measured as tables: cameras over the bins, and kinds that nobody practised."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..ground.tables import Grid

Data = Mapping[str, Any]


def camera_table(data: Data) -> Grid:
    """Landing errors by what the camera over the bins sees."""
    names = list(next(iter(data["camera"].values())))
    rows = [
        [said, *(_with_interval(found[who]["error"]) for who in names)] for said, found in data["camera"].items()
    ]  # fmt: skip
    note = (
        f"Level `day`, {data['shifts']} shifts of 50 picks per row, seed {data['seed']}, full physics, what ships; "
        "95 % intervals over shifts. Noise is that of the camera along and across; a blind one sees no landing."
    )
    return Grid("What a camera over the bins must see", ["camera", *names], rows, note)


def newcomers_table(data: Data) -> Grid:
    """Kinds that nobody practised: how soon they are learned, and what that costs."""
    rows = [
        [
            kind,
            who,
            f"{1000 * found['floor_m']:.1f} mm",
            *(f"{1000 * found['error_m'][who][k]:.1f} mm" for k in (0, 1, 3, 5, -1)),
            _throws(found["throws_to_floor"][who], len(found["error_m"][who]) - 1),
            f"{1000 * found['regret_m'][who]:.0f} mm",
        ]
        for kind, found in data["newcomers"]["kinds"].items()
        for who in found["error_m"]
    ]
    known = ", ".join(f"{who} {1000 * error:.1f}" for who, error in data["newcomers"]["known_mean_m"].items())
    header = ["kind", "controller", "floor", "throw 1", "2", "4", "6", "later", "throws to 1.1 x floor", "regret"]
    note = (
        f"Flights alone, {data['newcomers']['trials']} shifts, seed {data['seed']}. Floor: what the static policy "
        "leaves once the kind's mean landing is taken off. Throws to 1.1 x floor: until the mean of the next three is. "
        f"Regret: what the first throws are above the floor, summed. Known kinds in the same shifts [mm]: {known}."
    )
    return Grid("Kinds that nobody has practised", header, rows, note)


def _throws(count: int | None, most: int) -> str:
    return f"more than {most - 3}" if count is None else str(count)


def _with_interval(found: Data) -> str:
    value, low, high = (1000 * found[name] for name in ("value", "low", "high"))
    return f"{value:.1f} mm ({low:.1f}..{high:.1f})"
