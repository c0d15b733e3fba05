"""Records of a controller's throws or work shifts in a trial, with summary, tables and JSON."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Final, TypeAlias

import numpy as np
from rich.table import Table

from pnt_gym.arrays import Floats

from ..ground import metrics
from ..ground.files import jsonable
from ..ground.tables import Grid, value_table
from .figure import Figure
from .form import Columns, FigureColumns
from .measures import Measure

Summary: TypeAlias = Mapping[str, Any]
Result: TypeAlias = Mapping[str, Any]
"""Benchmark result of one controller, seed and level: `columns`, `seed`, `learn_seconds` and more."""
Row: TypeAlias = tuple[str, int, Summary]
"""A controller's name, the number of steps that it learned from, and its summary."""
DIGITS: Final = 6
"""Decimals that a benchmark keeps."""


class Record(ABC):
    """Abstract: results of a controller in U units of a trial, such as throws or work shifts.

    A subclass needs `figures` and `values` alone; the other methods use these two. The first figure compares
    controllers in tables.
    """

    figures: ClassVar[Mapping[str, Figure]]
    """Figures by which controllers are compared unit by unit."""
    timings: ClassVar[frozenset[str]] = frozenset()
    """Columns with times of the computation, which no repetition gives again."""

    @abstractmethod
    def values(self) -> Mapping[str, Floats]:
        """Each figure of `figures` for every unit (U,), in SI units; NaN where a unit has none."""

    def observations(self) -> Mapping[str, Floats]:
        """Each figure of `measures` for units that do not depend on one another (U,), in SI units; NaN for none."""
        return self.values()

    @classmethod
    def measures(cls) -> Mapping[str, Measure]:
        """Figures of a sequential comparison, the first of which decides; by default only signs of differences count.

        A subclass that knows how large a difference may be gives its figures a cap, which finds differences sooner.
        """
        return {name: Measure.of_signs(figure) for name, figure in cls.figures.items()}

    def summary(self) -> dict[str, Any]:
        """Count of the units, and mean and 95 % interval of each figure as `NAME`, `NAME_low` and `NAME_high`."""
        values = self.values()
        return {"count": len(next(iter(values.values()))), **_means(values)}

    def report(self) -> dict[str, Any]:
        """Content of `agents.evaluate --json`: the summary, and under `throws` a mapping for each step."""
        columns = {name: jsonable(column) for name, column in self.values().items()}
        rows = zip(*columns.values(), strict=True)
        return {**self.summary(), "throws": [dict(zip(columns, row, strict=True)) for row in rows]}

    def columns(self) -> dict[str, Any]:
        """Columns that a benchmark keeps, rounded."""
        return {name: jsonable(np.round(column, DIGITS)) for name, column in self.values().items()}

    @classmethod
    def form(cls) -> type[Columns]:
        """Form of the columns that a benchmark keeps, for whoever reads a file of results."""
        return type("RecordColumns", (FigureColumns,), {"figures": frozenset(cls.figures)})

    def picture(self) -> str | None:
        """Drawing of the record as SVG; None where the kind of trial has no drawing."""
        return None

    @classmethod
    def table(cls, title: str, summary: Summary) -> Table:
        """Table of one summary, one figure per line."""
        return value_table(
            title, [(figure.label, cls.interval_text(name, summary)) for name, figure in cls.figures.items()]
        )

    @classmethod
    def comparison(cls, title: str, rows: Sequence[Row], base: str | None = None) -> Table:
        """Table of controllers, one per line.

        Args:
            title: title of the table.
            rows: name, number of learning steps and summary of each controller.
            base: name of the controller with which all others are compared, where units are paired.
        """
        header = ("controller", "learned from", *(figure.label for figure in cls.figures.values()))
        lines = [
            [name, str(steps) if steps else "-", *(cls.interval_text(figure, summary) for figure in cls.figures)]
            for name, steps, summary in rows
        ]
        return Grid(title, header, lines).terminal()

    @classmethod
    def summarise(cls, results: Sequence[Result], num_envs: int) -> dict[str, Any]:
        """Figures of one controller over its seeds; all seeds had the same units.

        Args:
            results: result of each seed.
            num_envs: number of rows side by side in which the results were collected.
        """
        del num_envs
        seconds = float(np.mean([result["learn_seconds"] for result in results]))
        values = {name: by_seed(results, name).mean(axis=0) for name in cls.figures}
        count = len(next(iter(values.values())))
        return {
            "seeds": [result["seed"] for result in results],
            "count": count,
            **_means(values),
            "learn_seconds": seconds,
        }

    @classmethod
    def paired_columns(
        cls, results: Sequence[Result], sides: Sequence[Sequence[Result]], num_envs: int
    ) -> dict[str, tuple[Floats, ...]]:
        """Columns of one controller for the paired comparison with another one.

        Args:
            results: results of the controller, one for each seed.
            sides: the results of both controllers.
            num_envs: number of rows side by side in which the results were collected.

        Returns:
            Columns (S, N) of each figure, for S seeds and N pairs; for a rate two columns, the count and the time.
        """
        del sides, num_envs
        return {name: (by_seed(results, name),) for name in cls.figures}

    @classmethod
    def objects(cls, columns: Mapping[str, Any]) -> list[int] | None:
        """Objects that must be equal for two results to be paired; None where streams do not depend on actions."""
        del columns
        return None

    @classmethod
    def interval_text(cls, name: str, summary: Summary) -> str:
        """Text of a summary's figure with its interval; "-" for None."""
        if summary[name] is None:
            return "-"
        interval = metrics.Interval(summary[name], summary[f"{name}_low"], summary[f"{name}_high"])
        return cls.figures[name].interval(interval)


def by_seed(results: Sequence[Result], name: str) -> Floats:
    """A column of all seeds and units (S, U), or by item or robot (S, U, K); NaN where a unit has no value."""
    return np.array([result["columns"][name] for result in results], dtype=np.float64)


def _means(values: Mapping[str, Floats]) -> dict[str, Any]:
    """Mean and 95 % interval of each figure (U,) over the units that have a value; None where no unit has one."""
    means: dict[str, Any] = {}
    for name, column in values.items():
        finite = column[np.isfinite(column)]
        interval = metrics.mean_interval(finite) if finite.size else None
        means[name] = None if interval is None else interval.value
        means |= {f"{name}_{end}": None if interval is None else getattr(interval, end) for end in ("low", "high")}
    return means
