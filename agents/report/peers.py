"""Controllers in cells like those of other papers, beside what these papers publish."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..ground.metrics import wilson
from ..ground.tables import Grid, percent
from .tables import who

Data = Mapping[str, Any]
PUBLISHED: Final[Mapping[str, tuple[tuple[str, float], ...]]] = {
    "cubes": (("SAC", 0.956), ("TD3", 0.939), ("PPO", 0.448)),
    "boxes": (("TossingBot, known objects", 0.847), ("TossingBot, new objects", 0.823)),
}
"""Shares of throws that succeed, by level. Cubes: 10,000 throws of each tuned policy, simulated, in results/*_opt.csv
of the code of Louette et al. 2024 (arXiv 2406.13453). Boxes: real throws of what was grasped, Zeng et al. 2019 (arXiv
1903.11239)."""
SOURCES: Final = {"cubes": "Louette et al. 2024", "boxes": "Zeng et al. 2019"}


def peers_table(data: Data) -> Grid:
    """Success of ours and of theirs, level by level."""
    rows: list[list[str]] = []
    for level in data["plan"]["levels"]:
        count = data["plan"]["picks_on"].get(level, data["plan"]["picks"])
        for row in (row for row in data["table"] if row["level"] == level):
            success = wilson(round(row["success_rate"] * count), count)
            interval = f"{100 * success.value:.2f} % ({100 * success.low:.2f}..{100 * success.high:.2f})"
            rows.append([level, *who(row), f"{count:,}", interval, f"{row['sorted_per_min']:.1f}"])
        rows += [[level, name, "-", "-", percent(share), "-"] for name, share in PUBLISHED.get(level, ())]
    levels = [f"`{level}`: {SOURCES[level]}" for level in data["plan"]["levels"] if level in SOURCES]
    note = (
        f"Rows without throws are published ({'; '.join(levels)}); their cells differ from these as the levels say. "
        f"Intervals are Wilson's at 95 %. Environment `{data['plan']['env']}`, full physics, held-out throws; "
        "controllers that learn do so on the level itself."
    )
    header = ("level", "controller", "throws to learn", "throws", "success", "sorted/min")
    return Grid("Cells of other papers", header, rows, note)
