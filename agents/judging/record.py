"""Records of a controller's throws or work shifts in a trial: rows, and every figure, table and comparison of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Final, TypeAlias, final

import numpy as np
from rich.table import Table

from pnt_gym.arrays import Floats

from ..ground.files import jsonable
from ..ground.tables import Grid, value_table
from .figures import Figure, count, rate
from .rows import Columns, FigureColumns, Rows, Values, numbers

Summary: TypeAlias = Mapping[str, Any]
Result: TypeAlias = Mapping[str, Any]
"""Benchmark result of one controller, seed and level: `columns`, `seed`, `learn_seconds` and more."""
Row: TypeAlias = tuple[str, int, Summary]
"""A controller's name, the number of steps that it learned from, and its summary."""
DIGITS: Final = 6
"""Decimals that a benchmark keeps."""


class Record:
    """Results of a controller in U units of a trial, such as throws or work shifts, as rows.

    A subclass needs `figures` alone. The first figure compares controllers in tables.

    Args:
        columns: numbers or truth values of every unit (U,) by name; None or NaN where a unit has none.

    Raises:
        UsageError: a column of a figure is missing, or a column holds other than one number for each unit.
    """

    figures: ClassVar[Mapping[str, Figure]]
    """Figures by which controllers are compared unit by unit."""
    measured: ClassVar[Mapping[str, Figure]] = {}
    """Figures of a sequential comparison, the first of which decides; empty: `figures`."""
    shown: ClassVar[Mapping[str, Figure]] = {}
    """Figures of a summary, in the order of its table; empty: the count and `figures`, with intervals."""
    kept: ClassVar[Mapping[str, Figure]] = {}
    """Figures of a benchmark's table; empty: those of a summary."""
    heads: ClassVar[tuple[str, ...]] = ()
    """Figures of a summary in tables of several controllers; empty: all of `figures`."""
    step: ClassVar[str] = ""
    """Name of the steps that controllers learn from, in the plural, for tables."""
    timings: ClassVar[frozenset[str]] = frozenset()
    """Columns with times of the computation, which no repetition gives again."""

    def __init__(self, columns: Mapping[str, Values]) -> None:
        needed = [column for name, figure in self.figures.items() for column in figure.columns(name)]
        self.rows = Rows.of(numbers(type(self).__name__, columns, needed))

    # One record

    def summary(self) -> dict[str, Any]:
        """Every figure that the rows allow; a figure with an interval has its ends beside it."""
        return summarise(self.of(), self.rows)

    def observations(self) -> dict[str, Floats]:
        """Each figure of a sequential comparison for units that do not depend on one another (N,), in SI units."""
        found: dict[str, Floats] = {}
        for name, figure in (self.measured or self.figures).items():
            (values,), *seconds = figure.units(name, self.rows)
            found[name] = 60.0 * values / seconds[0][0] if figure.kind is rate else values
        return found

    def report(self) -> dict[str, Any]:
        """Content of `agents.evaluate --json`: the summary, and under `throws` a mapping for each step."""
        return {**self.summary(), "throws": mappings({name: rows[0] for name, rows in self.rows.columns.items()})}

    def columns(self) -> dict[str, Any]:
        """Columns that a benchmark keeps, rounded."""
        return {name: jsonable(rows[0], DIGITS) for name, rows in self.rows.columns.items()}

    def picture(self) -> str | None:
        """Drawing of the record as SVG; None where the kind of trial has no drawing."""
        return None

    # All records of a kind

    @classmethod
    def of(cls) -> Mapping[str, Figure]:
        """Figures of a summary by name."""
        if cls.shown:
            return cls.shown
        first, figure = next(iter(cls.figures.items()))
        ends = {name: (f"{name}_low", f"{name}_high") for name in cls.figures}
        figures = {name: replace(f, ends=ends[name], head=f.head or f.label) for name, f in cls.figures.items()}
        return {"count": Figure(kind=count, of=figure.columns(first)[:1]), **figures}

    @classmethod
    def measures(cls) -> dict[str, Figure]:
        """Figures of a sequential comparison as it takes them, the first of which decides."""
        return {name: figure.compared() for name, figure in (cls.measured or cls.figures).items()}

    @classmethod
    def form(cls) -> type[Columns]:
        """Form of the columns that a benchmark keeps, for whoever reads a file of results."""
        needed = {column for name, figure in cls.figures.items() for column in figure.columns(name)}
        return type("RecordColumns", (FigureColumns,), {"figures": frozenset(needed)})

    @classmethod
    def rows_of(cls, columns: Mapping[str, Any], num_envs: int) -> Rows:
        """Rows of the columns that a benchmark keeps of one seed."""
        del num_envs
        return Rows.of({name: values for name, values in columns.items() if isinstance(values, list)})

    @classmethod
    def summarise(cls, results: Sequence[Result], num_envs: int) -> dict[str, Any]:
        """Figures of one controller over its seeds; all seeds had the same units.

        Args:
            results: result of each seed.
            num_envs: number of rows side by side in which the results were collected.
        """
        rows = Rows.join([cls.rows_of(result["columns"], num_envs) for result in results])
        return {
            "seeds": [result["seed"] for result in results],
            **summarise(cls.kept or cls.of(), rows),
            **cls.further(results, rows),
            "learn_seconds": float(np.mean([result["learn_seconds"] for result in results])),
        }

    @classmethod
    def further(cls, results: Sequence[Result], rows: Rows) -> dict[str, Any]:
        """Further entries of a benchmark's table, from the results of all seeds and their rows."""
        del results, rows
        return {}

    @classmethod
    def paired_columns(
        cls, results: Sequence[Result], sides: Sequence[Sequence[Result]], num_envs: int
    ) -> dict[str, tuple[Floats, ...]]:
        """Columns of one controller for the paired comparison with another one.

        Args:
            results: results of the controller, one for each seed.
            sides: the results of both controllers; the units that both have are compared.
            num_envs: number of rows side by side in which the results were collected.

        Returns:
            Columns (S, N) of each figure, for S seeds and N pairs; for a rate two columns, the count and the time.
        """
        rows = Rows.join([cls.rows_of(result["columns"], num_envs) for result in results])
        others = [cls.rows_of(side[0]["columns"], num_envs) for side in sides]
        columns: dict[str, tuple[Floats, ...]] = {}
        for name, figure in cls.figures.items():
            common = min(figure.units(name, other)[0].shape[1] for other in others)
            columns[name] = tuple(column[:, :common] for column in figure.units(name, rows))
        return columns

    @classmethod
    def objects(cls, columns: Mapping[str, Any]) -> list[int] | None:
        """Objects that must be equal for two results to be paired; None where streams do not depend on actions."""
        del columns
        return None

    # Tables

    @classmethod
    def side_by_side(cls) -> dict[str, Figure]:
        """Figures of tables of several controllers by name."""
        figures = cls.of()
        return {name: figures[name] for name in cls.heads or cls.figures}

    @classmethod
    def lines(cls, summary: Summary) -> list[tuple[str, str]]:
        """Lines of the table of one summary: label and text of each figure that the summary has."""
        named = {name: figure for name, figure in cls.of().items() if figure.label and name in summary}
        return [(figure.label, figure.shown(name, summary)) for name, figure in named.items()]

    @classmethod
    def table(cls, title: str, summary: Summary) -> Table:
        """Table of one summary, one figure per line."""
        return value_table(title, cls.lines(summary))

    @classmethod
    def comparison(cls, title: str, rows: Sequence[Row], base: str | None = None) -> Table:
        """Table of controllers, one per line.

        Args:
            title: title of the table.
            rows: name, number of learning steps and summary of each controller.
            base: name of the controller with which all others are compared, where units are paired.
        """
        del base
        heads = cls.side_by_side()
        header = ("controller", "learned from", *(figure.head for figure in heads.values()))
        lines = [
            [name, cls.learned(steps), *(figure.shown(key, summary) for key, figure in heads.items())]
            for name, steps, summary in rows
        ]
        return Grid(title, header, lines).terminal()

    @classmethod
    def learned(cls, steps: int) -> str:
        """Text of the number of steps that a controller learned from."""
        return f"{steps} {cls.step}".rstrip() if steps else "-"


def summarise(figures: Mapping[str, Figure], rows: Rows) -> dict[str, Any]:
    """Every figure that rows allow, by name."""
    found: dict[str, Any] = {}
    for name, figure in figures.items():
        found |= figure.summary(name, rows)
    return found


def mappings(columns: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Columns (U,) as a mapping of JSON values for each unit."""
    rows = zip(*map(jsonable, columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


@final
@dataclass(frozen=True)
class Card:
    """Texts and figures of the cards of one kind of trial."""

    judged: str
    """Key of the number of evaluated units in a summary."""
    figures: Mapping[str, Figure]
    """Figures of the table of levels."""
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
    graph: str = "`observation` (N, D) to `action` (N, A)"
    """Inputs and outputs of the ONNX graph."""
    actions: str = "(N, A) float32"
    """Shape and type of the graph's actions."""

    @property
    def header(self) -> list[str]:
        """Names of the columns of the table of levels, without the level."""
        return [figure.head for figure in self.figures.values()]

    def cells(self, summary: Summary) -> list[str]:
        """Cells of one level's row in the table of figures, without the level."""
        return [figure.shown(name, summary) for name, figure in self.figures.items()]


def usual_card(record: type[Record], unit: str, option: str) -> Card:
    """Default card of a kind of trial: the figures of its record.

    Args:
        record: record of the kind of trial.
        unit: name of the counted unit, in the plural.
        option: option of commands with the number of units.
    """
    first, figure = next(iter(record.figures.items()))
    return Card(
        judged="count",
        figures=record.side_by_side(),
        reward=lambda report: [row[figure.columns(first)[0]] for row in report["throws"]],
        rewarded=f"{figure.label} of one of the {unit}",
        metrics={name: shown.label for name, shown in record.figures.items()},
        film=f"A film of some {unit}",
        use=(
            f"pnt-gym evaluate --controller {{name}} --{option} 200",
            "pnt-gym play --controller {name} --video film.mp4",
        ),
    )
