"""Parts of a published policy's card that depend on the kind of trial."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

from .record import Record


@final
@dataclass(frozen=True)
class Card:
    """Texts and figures of the cards of one kind of trial."""

    judged: str
    """Key of the number of evaluated units in a summary."""
    header: tuple[str, ...]
    cells: Callable[[Mapping[str, Any]], list[str]]
    """Cells of one level's row in the table of figures, without the level."""
    reward: Callable[[Mapping[str, Any]], Sequence[float]]
    """Rewards for model hubs, from the report of an evaluation."""
    rewarded: str
    """Name of that reward."""
    metrics: Mapping[str, str]
    """Names of further figures for model hubs, by key of the summary."""
    film: str
    """Text of the link to the film."""
    use: tuple[str, ...]
    """Commands that use the policy."""
    graph: str
    """Inputs and outputs of the ONNX graph."""
    actions: str
    """Shape and type of the graph's actions."""


def usual_card(record: type[Record], unit: str, option: str) -> Card:
    """Default card of a kind of trial: the figures of its record.

    Args:
        record: record of the kind of trial.
        unit: name of the counted unit, in the plural.
        option: option of commands with the number of units.
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
