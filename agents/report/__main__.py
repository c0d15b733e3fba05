"""Make pages, tables and figures from results/*.json: `python -m agents.report`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pnt_gym.constants import WORLD

from ..ground.cli import UsageError, check_libraries, run
from ..ground.drawings import svg
from ..ground.files import check_form, lock_folder
from ..ground.outputs import deliver_text
from ..ground.places import MADE
from ..ground.tables import console
from ..ground.versions import world_of
from ..reproduce import record
from ..results import content, study
from . import contents, page, pictures, room, submissions, templates
from .blocks import makers_from, rewrite
from .figures import KINDS, USUAL
from .openings import small_picture
from .page import Chapter, sections
from .pays import crossover_grid, curves_figures, improvement_grid, mismatch_figures
from .questions import DRAWINGS, QUESTIONS
from .speeds import KNOWN
from .submissions import BLOCK, TITLE


@dataclass(frozen=True)
class Arguments:
    """Write results/README.md, results/tables, results/figures and results/report.html from results/*.json."""

    results: Path = MADE / "results"
    """Folder of the results."""
    readme: Path = MADE / "README.md"
    """README whose marked tables are written anew, as are the tables of the pages of results."""
    trust: bool = False
    """Import the modules of environments that files of results name, whose code then runs."""


INDEX = "README.md"
"""Page of the results folder that lists the questions."""
DRAWN = {"methods": pictures.figures, "curves": curves_figures, "mismatch": mismatch_figures}
"""Figures of studies that have any."""
COMPUTED = {"curves": (improvement_grid,), "mismatch": (crossover_grid,)}
"""Tables of studies that their plans cannot describe."""


def main(arguments: Arguments) -> None:
    """Write everything; files are replaced one by one, each at once."""
    check_libraries("matplotlib", "jinja2")
    results = arguments.results
    chapters = read(results, trust=arguments.trust)
    if not chapters:
        raise UsageError(f"{str(results)!r} holds no results yet; `python -m agents.benchmark` makes some")
    parts = sections(chapters, results)
    with lock_folder(results):
        # The drawings that belong to questions and to no chapter, by file name.
        drawn: dict[str, str] = {}
        for question in QUESTIONS:
            if (opening := question.opening(results)) is not None:
                drawn[small_picture(question.name)] = opening.picture()
            draw = DRAWINGS.get(question.name)
            contents = None if draw is None else question.read(results)
            if draw is None or contents is None:
                continue
            if question.answer_from(contents, results) is not None:
                with check_form(results / f"{question.sources[0]}.json"):
                    drawn[question.picture] = svg(draw(contents))
        for name, text in {**drawn, **_figures(chapters)}.items():
            deliver_text(results / "figures" / name, text)
        for section in parts:
            for chapter in section.chapters:
                deliver_text(results / "tables" / f"{chapter.name}.md", page.tables(chapter, section))
        deliver_text(results / INDEX, page.index(parts, room.grid(results)))
        deliver_text(results / "report.html", page.html(parts))
        # The README, and the pages of results beside the index, whose blocks are written anew.
        pages = (arguments.results / f"{question.name}.md" for question in QUESTIONS)
        for document in [path for path in (arguments.readme, *pages) if path.is_file()]:
            rewrite(document, makers_from(results))
    console().print(f"report of {len(chapters)} results in {results / 'report.html'}")


def _figures(chapters: Sequence[Chapter]) -> dict[str, str]:
    """The drawings of all chapters by file name."""
    return {name: text for chapter in chapters for name, text in chapter.figures.items()}


def read(results: Path, *, trust: bool = False) -> list[Chapter]:
    """A chapter per file of results whose form is known; one per paper in that of a reproduction.

    Args:
        results: folder of the files.
        trust: import the modules of environments that files name.

    Raises:
        UsageError: a file is not valid JSON, or holds other things than its keys promise.
    """
    files = ((path, contents.read(path, trust=trust)) for path in sorted(results.glob("*.json")))
    chapters: list[Chapter] = []
    for path, data in files:
        with check_form(path):
            own = _chapters(path.stem, data, results) if isinstance(data, dict) else []
            world = world_of(data) if own else WORLD
            chapters += [
                replace(chapter, name=chapter.name or path.stem, source=path.stem, world=world) for chapter in own
            ]
    handed_in = submissions.grid(results)
    return [*chapters, *([Chapter(TITLE, (handed_in,), name=BLOCK, source=BLOCK)] if handed_in.rows else [])]


def _chapters(name: str, data: Mapping[str, Any], results: Path) -> list[Chapter]:
    """The chapters of one file; none for a form that has no tables here."""
    if record.matches(data):
        return page.chapters(data, results / "figures")
    if content.matches(data):
        return [benchmark_chapter(name, data)]
    if study.matches(data):
        drawn = DRAWN[data["study"]](data) if data["study"] in DRAWN else {}
        computed = [table(data) for table in COMPUTED.get(data["study"], ())]
        return [Chapter(name, (*templates.grids(data), *computed), drawn)]
    if grids := tuple(table(data) for names, table in KNOWN if names <= set(data)):
        return [Chapter(name, grids)]
    return []


def benchmark_chapter(name: str, data: Mapping[str, Any]) -> Chapter:
    """Tables and figures of a benchmark."""
    kind = KINDS.get(data["trial"], USUAL)
    prefix = "" if name == "benchmark" else f"{name}_"
    figures = {f"{prefix}{file}": text for file, text in kind.figures(data).items()}
    return Chapter(name, tuple(kind.grids(data)), figures)


if __name__ == "__main__":
    run(main, Arguments, "agents.report")
