"""Make tables, figures and a page from results/*.json: `python -m agents.report`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..ground.cli import UsageError, run
from ..ground.files import held, of_its_form, read_json
from ..ground.outputs import deliver_text
from ..ground.places import MADE
from ..ground.tables import console
from ..reproduce.grids import plain
from .kinds import kind_of
from .methods import methods_figures
from .page import Chapter, markdown_page, page
from .readme import update_readme
from .reproduction import is_reproduction, paper_chapters
from .speeds import TABLES
from .study import is_study, study_grids


@dataclass(frozen=True)
class Arguments:
    """Write results/README.md, results/figures/*.svg and results/report.html from what results/*.json holds."""

    results: Path = MADE / "results"
    """Folder of the results."""
    readme: Path = MADE / "README.md"
    """README whose marked tables are written anew."""


ENTRIES = ("quantity", "published", "reproduced", "unit", "verdict", "note")
"""What `python -m agents.reproduce` and others alike say of a figure."""
DRAWN = {"methods": methods_figures}
"""Figures of studies that have any."""


def main(arguments: Arguments) -> None:
    """Write everything; files are replaced one by one, each at once."""
    chapters = read_chapters(arguments.results)
    if not chapters:
        raise UsageError(f"{str(arguments.results)!r} holds no results yet; `python -m agents.benchmark` makes some")
    with held(arguments.results):
        for chapter in chapters:
            for name, text in chapter.figures.items():
                deliver_text(arguments.results / "figures" / name, text)
        deliver_text(arguments.results / "README.md", markdown_page(chapters))
        deliver_text(arguments.results / "report.html", page(chapters))
        if arguments.readme.is_file():
            update_readme(arguments.readme, arguments.results)
    console().print(f"report of {len(chapters)} results in {arguments.results / 'report.html'}")


def read_chapters(results: Path) -> list[Chapter]:
    """A chapter per file of results whose form is known; one per paper in that of a reproduction.

    Raises:
        UsageError: a file is not valid JSON, or holds other things than its keys promise.
    """
    files = ((path, read_json(path)) for path in sorted(results.glob("*.json")))
    chapters: list[Chapter] = []
    for path, data in files:
        with of_its_form(path):
            chapters += _chapters(path.stem, data, results) if isinstance(data, dict) else []
    return chapters


def _chapters(name: str, data: Mapping[str, Any], results: Path) -> list[Chapter]:
    """The chapters of one file; none for a form that has no tables here."""
    if is_reproduction(data):
        return paper_chapters(data, results / "figures")
    if {"plan", "table", "comparisons", "results"} <= set(data):
        return [benchmark_chapter(name, data)]
    if is_study(data):
        drawn = DRAWN[data["study"]](data) if data["study"] in DRAWN else {}
        return [Chapter(name, tuple(study_grids(data)), drawn)]
    if grids := tuple(table(data) for names, table in TABLES if names <= set(data)):
        return [Chapter(name, grids)]
    rows = data.get("rows")
    if isinstance(rows, list) and rows and all({*ENTRIES} <= {*row} for row in rows):
        return [Chapter(name, (plain("Published and reproduced", rows),))]
    return []


def benchmark_chapter(name: str, data: Mapping[str, Any]) -> Chapter:
    """Tables and figures of a benchmark."""
    kind = kind_of(data)
    prefix = "" if name == "benchmark" else f"{name}_"
    figures = {f"{prefix}{file}": text for file, text in kind.figures(data).items()}
    return Chapter(name, tuple(kind.grids(data)), figures)


if __name__ == "__main__":
    run(main, Arguments, "agents.report")
