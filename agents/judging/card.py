"""What the card of a published policy says of one kind of task."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from .record import Record


@final
@dataclass(frozen=True)
class Card:
    """What cards say of policies of one kind of task."""

    judged: str
    """Key of the figure that tells how many of what it was judged on."""
    header: tuple[str, ...]
    cells: Callable[[Mapping[str, Any]], list[str]]
    """Of a table of figures by level, but for the level."""
    reward: Callable[[Mapping[str, Any]], Sequence[float]]
    """What hubs are told as rewards, of an evaluation."""
    rewarded: str
    """What that reward is called."""
    metrics: Mapping[str, str]
    """Figures beside it that hubs are told, and what they are called there."""
    film: str
    """Text of the link to the film."""
    use: tuple[str, ...]
    """Commands."""
    graph: str
    """What the graph gives."""
    actions: str
    """The same where it is called."""


def usual_card(record: type[Record], unit: str, option: str) -> Card:
    """The card of a kind of task that has none of its own: the figures of its record.

    Args:
        record: of the kind of task.
        unit: that is counted, in the plural.
        option: of commands that says how many units are counted.
    """
    first = next(iter(record.figures))
    return Card(
        judged="count",
        header=tuple(figure.label for figure in record.figures.values()),
        cells=lambda summary: [record.interval_text(name, summary) for name in record.figures],
        reward=lambda report: [row[first] for row in report["throws"]],
        rewarded=f"{record.figures[first].label} of one of the {unit}",
        metrics={name: figure.label for name, figure in record.figures.items()},
        film=f"A film of some {unit}",
        use=(
            f"pnt-gym evaluate --controller {{name}} --{option} 200",
            "pnt-gym play --controller {name} --video film.mp4",
        ),
        graph="`observation` (N, D) to `action` (N, A)",
        actions="(N, A) float32",
    )
