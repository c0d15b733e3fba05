"""What the report shows of a benchmark, by the kind of task."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

from ..ground.drawings import svg
from ..ground.metrics import Interval
from ..ground.tables import Grid
from ..judging.figures import Figure
from .figures import Measure, learning_curves, line_figures, throw_figures
from .line import line_grids
from .profiles import improvement_grids
from .tables import benchmark_grids, comparison_table, conditions, other_level_tables, side_by_side

Data = Mapping[str, Any]


class Kind(NamedTuple):
    """What is shown of one kind of task.

    Attributes:
        grids: every table of a benchmark.
        figures: SVG texts by file name.
    """

    grids: Callable[[Data], list[Grid]]
    figures: Callable[[Data], dict[str, str]]


def usual_grids(data: Data) -> list[Grid]:
    """Tables of a kind of task that has none of its own: its figures side by side, and paired differences."""
    levels, who = data["plan"]["levels"], ("controller", f"{data['step']}s to learn")
    columns = {figure.label: _cell(name, figure) for name, figure in _figures(data).items()}
    note = conditions(data, f"{data['table'][0]['count']} held-out {data['unit']}", "95 % intervals")
    grids = [
        side_by_side("Every controller on the same held-out tasks", data, levels, columns, note, who),
        *other_level_tables(data, columns, who),
        *(comparison_table(data, level, _figures(data)) for level in levels),
    ]
    return [grid for grid in grids if grid.rows]


def usual_figures(data: Data) -> dict[str, str]:
    """Learning curves of a kind of task that has no drawings of its own; nothing where nobody has learned."""
    if not any(row["throws"] for row in data["table"]):
        return {}
    name, figure = next(iter(_figures(data).items()))
    label = f"{figure.label} [{figure.unit}]" if figure.unit else figure.label
    measure = Measure((name, f"{name}_low", f"{name}_high"), figure.scale, label, f"{data['step']}s learned from")
    return {"learning_curves.svg": svg(learning_curves(data, measure))}


KINDS: Final = {
    "throws": Kind(lambda data: [*benchmark_grids(data), *improvement_grids(data)], throw_figures),
    "work_shifts": Kind(line_grids, line_figures),
}


def kind_of(data: Data) -> Kind:
    """The kind of task that a benchmark was about."""
    return KINDS.get(data["trial"], Kind(usual_grids, usual_figures))


def _figures(data: Data) -> dict[str, Figure]:
    """How the figures of a benchmark are called and written."""
    return {name: Figure(**fields) for name, fields in data["figures"].items()}


def _cell(name: str, figure: Figure) -> Callable[[Data], str]:
    """What a table shows of a row."""

    def text(row: Data) -> str:
        low, high = row[f"{name}_low"], row[f"{name}_high"]
        return "-" if row[name] is None else figure.interval(Interval(row[name], low, high))

    return text
