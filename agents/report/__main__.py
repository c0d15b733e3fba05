"""Make tables, figures and a page from results/*.json: `python -m agents.report`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agents.cli import UsageError, run
from agents.files import read_json, write_text
from agents.report.figures import benchmark_figures
from agents.report.measures import (
    environment_note,
    environment_table,
    is_environments,
    is_physics,
    is_planner,
    physics_note,
    physics_table,
    planner_note,
    planner_table,
)
from agents.report.page import page
from agents.report.readme import update_readme
from agents.report.reproduction import TITLES, is_reproduction, of_paper, paper_grids, reproduction_note
from agents.report.reproduction_figures import reproduction_figures
from agents.report.tables import (
    benchmark_note,
    benchmark_table,
    comparison_table,
    failure_table,
    other_levels_table,
    published_table,
)
from agents.tables import console
from agents.versions import ROOT


@dataclass(frozen=True)
class Arguments:
    """Write results/README.md, results/figures/*.svg and results/report.html from what results/*.json holds."""

    results: Path = ROOT / "results"
    """Folder of the results."""
    readme: Path = ROOT / "README.md"
    """README whose marked tables are written anew."""


@dataclass(frozen=True)
class Chapter:
    """One part of the report."""

    title: str
    parts: tuple[tuple[str, str], ...]
    """Headline and Markdown table each."""
    figures: Mapping[str, str]
    """SVG text by file name."""
    note: str


_MEASURES = (
    (is_physics, "Levels and mismatch, without learning", physics_table, physics_note),
    (is_planner, "The planner's speed", planner_table, planner_note),
    (is_environments, "Throws per second", environment_table, environment_note),
)


def main(arguments: Arguments) -> None:
    """Write everything; files are replaced one by one, each at once."""
    chapters = read_chapters(arguments.results)
    if not chapters:
        raise UsageError(f"{str(arguments.results)!r} holds no results yet; `python -m agents.benchmark` makes some")
    for chapter in chapters:
        for name, text in chapter.figures.items():
            write_text(arguments.results / "figures" / name, text)
    write_text(arguments.results / "README.md", readme_text(chapters))
    write_text(arguments.results / "report.html", page(chapters))
    if arguments.readme.is_file():
        update_readme(arguments.readme, arguments.results)
    console().print(f"report of {len(chapters)} results in {arguments.results / 'report.html'}")


def read_chapters(results: Path) -> list[Chapter]:
    """A chapter per file of results whose form is known; one per paper in that of a reproduction.

    Raises:
        UsageError: a file is not valid JSON.
    """
    made: list[Chapter] = []
    for path in sorted(results.glob("*.json")):
        data = read_json(path)
        if isinstance(data, dict) and is_reproduction(data):
            made += [paper_chapter(paper, data, results / "figures") for paper in data["papers"]]
        else:
            found = chapter(path.stem, data)
            made += [found] if found is not None else []
    return made


def chapter(name: str, data: Any) -> Chapter | None:
    """The chapter of one file; None for a form that has no tables here."""
    if not isinstance(data, dict):
        return None
    if {"plan", "table", "comparisons", "results"} <= set(data):
        return benchmark_chapter(name, data)
    for fits, headline, table, note in _MEASURES:
        if fits(data):
            return Chapter(name, ((headline, table(data)),), {}, note(data))
    if isinstance(data.get("rows"), list) and data["rows"] and {"quantity", "published"} <= set(data["rows"][0]):
        return Chapter(name, (("Published and reproduced", published_table(data)),), {}, "")
    return None


def paper_chapter(paper: str, data: Mapping[str, Any], drawings: Path) -> Chapter:
    """Tables of one paper's reproduction, and those of its drawings that lie in the folder."""
    rows = of_paper(data, paper)
    parts = tuple((grid.headline, grid.markdown()) for grid in paper_grids(paper, rows))
    files = [drawings / name for name in data["figures"][paper]]
    drawn = {file.name: file.read_text(encoding="utf-8") for file in files if file.is_file()}
    figures = {**reproduction_figures(paper, rows), **drawn}
    return Chapter(f"reproduction: {TITLES.get(paper, paper)}", parts, figures, reproduction_note(paper, data))


def benchmark_chapter(name: str, data: Mapping[str, Any]) -> Chapter:
    """Tables and figures of a benchmark."""
    plan = data["plan"]
    parts = [("Every controller on the same held-out throws", benchmark_table(data))]
    more = other_levels_table(data)
    parts += [("Further levels", more)] if more is not None else []
    for level in plan["levels"]:
        if any(c["level"] == level for c in data["comparisons"]):
            parts.append((f"Paired differences, level {level} (95 % intervals)", comparison_table(data, level)))
        parts.append((f"What failed, level {level}", failure_table(data, level)))
    note = benchmark_note(data)
    prefix = "" if name == "benchmark" else f"{name}_"
    figures = {f"{prefix}{file}": text for file, text in benchmark_figures(data).items()}
    return Chapter(name, tuple(parts), figures, note)


def readme_text(chapters: list[Chapter]) -> str:
    """results/README.md."""
    lines = ["# Results", "", "Generated by `python -m agents.report` from the JSON files beside this one.", ""]
    for found in chapters:
        lines += [f"## {found.title}", ""]
        lines += [found.note, ""] if found.note else []
        for headline, table in found.parts:
            lines += [f"### {headline}", "", table, ""]
        for name in found.figures:
            lines += [f"![{Path(name).stem.replace('_', ' ')}](figures/{name})", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    run(main, Arguments, "agents.report")
