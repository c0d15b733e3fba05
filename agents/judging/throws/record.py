"""The record of a trial by throws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final, final

from rich.table import Table

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.core import Core

from ...ground.versions import versions
from ..figure import Figure
from ..measures import Measure
from ..record import Record, Result, Row, Summary
from .columns import ThrowColumns, columns
from .data import Throws, by_kind, purity_by_bin, summary, throw_records
from .paired import MEASURES, observations
from .results import by_shift, summarise
from .tables import comparison_table, summary_table

FIGURES: Final = {
    "landing_error_m": Figure("landing error", "mm", 1000.0),
    "sorted_per_min": Figure("sorted/min"),
}


@final
class ThrowRecord(Record):
    """Record of throws.

    Args:
        throws: the throws and their results.
        core: the cells in which the throws were carried out.
        settings: further entries of the report, such as whether the controller went on learning.
    """

    figures = FIGURES

    def __init__(self, throws: Throws, core: Core, settings: Mapping[str, Any]) -> None:
        self.throws = throws
        self._core, self._settings = core, settings

    def values(self) -> Mapping[str, Floats]:
        """Landing error, and sorted picks per minute, of each throw."""
        return {
            "landing_error_m": self.throws.landing_error,
            "sorted_per_min": 60.0 * self.throws.sorted / self.throws.cycle_time,
        }

    def observations(self) -> Mapping[str, Floats]:
        """Figures of each throw, or of each row's run where the throws of a row depend on one another."""
        return observations(self.throws, self._core, self._settings["num_envs"])

    @classmethod
    def measures(cls) -> Mapping[str, Measure]:
        """Landing error, success, and sorted picks per minute."""
        return MEASURES

    def summary(self) -> dict[str, Any]:
        """Figures of all throws, by the names of the JSON contract."""
        return summary(self.throws)

    def report(self) -> dict[str, Any]:
        """Summary, purity of each bin, settings, and under `throws` a mapping for each throw."""
        names = self._core.cell.target_names if "belongs" in self.throws.info else ()
        return {
            **self.summary(),
            **({"purity_by_bin": purity_by_bin(self.throws, names)} if names else {}),
            **({"by_kind": by_kind(self.throws, self._core.item_names)} if "tries" in self.throws.info else {}),
            "dwell_s": self._core.dwell,
            **self._settings,
            "action_mode": self._core.action_mode,
            "versions": versions(),
            "throws": throw_records(self.throws, self._core.item_names),
        }

    def columns(self) -> dict[str, Any]:
        """Throws as columns, rounded."""
        return columns(self.throws)

    @classmethod
    def form(cls) -> type[ThrowColumns]:
        """Form of the columns of throws."""
        return ThrowColumns

    @classmethod
    def table(cls, title: str, summary: Summary) -> Table:
        """Table of all figures that the cell has, one per line."""
        return summary_table(title, summary)

    @classmethod
    def comparison(cls, title: str, rows: Sequence[Row], base: str | None = None) -> Table:
        """Table of controllers, one per line."""
        del base
        return comparison_table(title, rows)

    @classmethod
    def summarise(cls, results: Sequence[Result], num_envs: int) -> dict[str, Any]:
        """Figures of one controller over its seeds."""
        return summarise(results, num_envs)

    @classmethod
    def paired_columns(
        cls, results: Sequence[Result], sides: Sequence[Sequence[Result]], num_envs: int
    ) -> dict[str, tuple[Floats, ...]]:
        """Landing errors, and sorted counts with their times, per throw, or per shift in cells with shifts."""
        del sides
        error, sorted_throws, time = by_shift(results, num_envs)
        return {"landing_error_m": (error,), "sorted_per_min": (sorted_throws, time)}

    @classmethod
    def objects(cls, columns: Mapping[str, Any]) -> list[int] | None:
        """Items of the throws; None in cells with shifts, whose streams do not depend on the picks."""
        return None if "pick" in columns else columns["item"]
