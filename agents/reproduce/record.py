"""All findings about papers as one record of JSON values, and the tables of the record."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Self, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, model_validator

from ..ground.tables import Grid
from ..ground.versions import versions
from ..judging.rows import check_model
from . import finding
from .finding import Overview, Verdict, agree
from .grids import JUDGED, plain
from .papers import package

Record: TypeAlias = Mapping[str, Any]
Number = Annotated[float, Field(allow_inf_nan=False)]
Figure: TypeAlias = Number | str | None
AGREES: Final = "reproduced"


def assemble(command: str, results: Mapping[str, Mapping[str, Any]]) -> tuple[dict[str, Any], dict[str, str]]:
    """One record of the results of parts by "paper/part"; and the drawings by file name."""
    papers: dict[str, list[Mapping[str, Any]]] = {}
    for name, part in results.items():
        papers.setdefault(name.split("/")[0], []).append(part)
    rows = [row for part in results.values() for row in part["rows"]]
    overviews = {
        paper: package(paper).overview({row["quantity"]: row for row in rows if row["paper"] == paper})
        for paper in papers
    }
    figures = {
        paper: {**_join(parts, "figures"), **overviews[paper].figures} for paper, parts in papers.items()
    }  # fmt: skip
    record = {
        "command": command,
        "versions": versions(),
        "seconds": {name: part["seconds"] for name, part in results.items()},
        "papers": list(papers),
        "titles": {paper: package(paper).SHORT for paper in papers},
        "figures": {paper: list(drawn) for paper, drawn in figures.items()},
        "data": {paper: _join(parts, "data") for paper, parts in papers.items()},
        "overview": {paper: _as_json(overview) for paper, overview in overviews.items()},
        "grids": {paper: [grid for part in parts for grid in part["grids"]] for paper, parts in papers.items()},
        "rows": rows,
    }
    return record, {name: text for drawn in figures.values() for name, text in drawn.items()}


class RowForm(BaseModel):
    """Form of a row, whose verdict must be that of its values."""

    model_config = ConfigDict(frozen=True, extra="allow", strict=True)

    paper: str
    quantity: str
    published: Figure
    reproduced: Figure
    unit: str
    verdict: Verdict
    tolerance: Number | None
    note: str
    holds: bool | None = None
    statement: str = ""

    @model_validator(mode="after")
    def _check(self) -> Self:
        agrees = self.holds or (self.holds is None and agree(self.published, self.reproduced, self.tolerance))
        says = {"reproduced": True, "differs": False, "misprint": False}.get(self.verdict, bool(agrees))
        if says != bool(agrees) or (self.published is None and self.verdict != "ours"):
            raise ValueError(f"{self.quantity} has the verdict {self.verdict!r}, which its values do not give")
        return self


class RecordForm(BaseModel):
    """Form of a file of `agents.reproduce`."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    command: str
    versions: dict[str, str]
    seconds: dict[str, Number]
    papers: list[str]
    titles: dict[str, str]
    figures: dict[str, list[str]]
    data: dict[str, dict[str, Any]]
    overview: dict[str, Any]
    grids: dict[str, list[dict[str, Any]]]
    rows: list[RowForm]


def matches(data: Any) -> bool:
    """Whether a file of results is that of `python -m agents.reproduce`."""
    return isinstance(data, dict) and {"papers", "rows", "figures"} <= data.keys()


def check(path: Path, record: Record) -> None:
    """Make sure that a record has its form, and that its verdicts are those of its values.

    Raises:
        UsageError: it has another form, or a verdict is another one.
    """
    check_model(path, RecordForm, record)


def headlines(record: Record) -> list[Grid]:
    """Tables for the terminal: every table of each paper, the overview's first, and its numbers of verdicts."""
    tables = [[*all_grids(record, paper), verdicts(record, paper)] for paper in record["papers"]]
    return [grid for shown in tables for grid in shown if grid.rows]


def all_grids(record: Record, paper: str) -> list[Grid]:
    """Every table of a paper, the tables of its overview first, then those of judged rows, then ours."""
    # The published statements that no reading reproduced, one row for every reading.
    compared = _rows(record, paper)
    verdict_by_statement = finding.judge(compared)
    differing = [row for row in compared if verdict_by_statement[row.get("statement", row["quantity"])] != AGREES]
    shown = [
        *overview_grids(record, paper).values(),
        plain(f"{record['titles'][paper]}: what does not agree", differing, drop=f"{paper}/"),
        *sorted((Grid(**fields) for fields in record["grids"][paper]), key=lambda grid: JUDGED not in grid.header),
    ]
    return [grid for grid in shown if grid.rows]


def overview_grids(record: Record, paper: str) -> dict[str, Grid]:
    """Tables over several parts of a paper, by name."""
    fields_by_name = record["overview"][paper]["grids"]
    return {name: grid for name, fields in fields_by_name.items() if (grid := Grid(**fields)).rows}


def verdicts(record: Record, paper: str) -> Grid:
    """Table of the number of published statements by verdict, and of the number of figures of ours."""
    rows = {row["quantity"]: row for row in record["rows"] if row["paper"] == paper}
    names = list(finding.judge(rows.values()).values())
    lines = [[verdict, str(names.count(verdict))] for verdict in sorted(set(names))]
    ours = len(rows) - len(_rows(record, paper))
    extra_lines = [["ours, not compared", str(ours)]] if ours else []
    return Grid(f"{record['titles'][paper]}: verdicts", ["verdict", "statements"], [*lines, *extra_lines])


def _rows(record: Record, paper: str) -> list[Mapping[str, Any]]:
    """Rows of the published figures, under the paper's own conditions."""
    rows = {row["quantity"]: row for row in record["rows"] if row["paper"] == paper}.values()
    return [row for row in rows if row["published"] is not None and row["verdict"] != "ours"]


def _join(parts: Iterable[Mapping[str, Any]], entry: str) -> dict[str, Any]:
    """An entry of all parts, merged into one mapping."""
    return {name: value for part in parts for name, value in part[entry].items()}


def _as_json(overview: Overview) -> dict[str, Any]:
    """Tables of an overview with their notes, and the notes, as JSON values; drawings are separate files."""
    notes = dict(overview.notes)
    grids = {name: grid._asdict() | {"note": notes.get(name, grid.note)} for name, grid in overview.grids.items()}
    return {"grids": grids, "notes": notes}
