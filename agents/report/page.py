"""The results as one HTML page and as Markdown pages: an index of questions, and a page of tables for each file."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final, final

from pnt_gym.constants import WORLD
from pnt_gym.errors import one_sentence
from pnt_gym.reading import text_of

from ..ground.cli import UsageError
from ..ground.files import MOST_RESULTS, check_form, read_yaml
from ..ground.tables import Grid, html_text, markdown_text
from ..reproduce.record import Record, all_grids, overview_grids, verdicts
from . import contents
from .openings import Opening, small_picture
from .questions import QUESTIONS, Question

TEMPLATE = Path(__file__).with_name("page.html")
OPENING = (
    "The analytic planner is the baseline. Learning controllers correct its release and are judged on throws that no "
    "training used. Differences between controllers have 95 % intervals from throws that are paired by seed. Commands "
    "of the repository made every number on these pages from seeded simulations."
)
BOARDS = (
    "**[Leaderboard](../docs/leaderboard.md)**: who sorts most at the conveyor, in cells that nobody measured, along a "
    "line and with a picture; yours goes there with three commands."
)
CAPTIONS: Final = read_yaml(Path(__file__).with_name("captions.yaml"), "captions")
"""Words for drawings, by the kind of what they belong to and the name of the file."""
UNASKED = "Further results"
"""Title of the chapters that belong to no question: a user's own benchmarks."""


@final
@dataclass(frozen=True)
class Chapter:
    """The tables of one file of results, or of one paper.

    Attributes:
        title: what it is about.
        parts: its tables.
        figures: SVG texts by file name.
        note: what stands under the title.
        name: of the page of its tables.
        source: name of the file of results, without ".json".
        world: in which its figures were measured.
    """

    title: str
    parts: tuple[Grid, ...]
    figures: Mapping[str, str] = field(default_factory=dict[str, str])
    note: str = ""
    name: str = ""
    source: str = ""
    world: int = WORLD

    @property
    def older(self) -> str:
        """Sentence on figures of an older world; empty for other figures."""
        return contents.older(self.world)


@final
@dataclass(frozen=True)
class Section:
    """A question with its answer, and the chapters that belong to it.

    Attributes:
        title: the question, or `UNASKED`.
        chapters: with every table.
        answer: the sentences with the numbers; empty for no question.
        picture: file of a drawing; empty for none.
        page: name of the question's own page; empty where the folder has none.
        command: what makes the numbers; empty for no question.
        opening: a sentence, five numbers and a small picture; None where there is no page to open.
    """

    title: str
    chapters: Sequence[Chapter]
    answer: str = ""
    picture: str = ""
    page: str = ""
    command: str = ""
    opening: Opening | None = None


def sections(chapters: Sequence[Chapter], results: Path) -> list[Section]:
    """The questions that the results in a folder answer, each with its chapters; then the chapters without one."""
    answered = [(question, answer) for question in QUESTIONS if (answer := question.answered(results)) is not None]
    known = [_section(question, answer, chapters, results) for question, answer in answered]
    asked = {name for question, _ in answered for name in question.chapters}
    unasked = [chapter for chapter in chapters if chapter.source not in asked]
    return [*known, Section(UNASKED, unasked)] if unasked else known


def _section(question: Question, answer: str, chapters: Sequence[Chapter], results: Path) -> Section:
    page = f"{question.name}.md"
    tables = [
        replace(chapter, title=title or chapter.title)
        for name, title in question.chapters.items()
        for chapter in chapters
        if chapter.source == name
    ]
    page = page if (results / page).is_file() else ""
    opening = question.opening(results) if page else None
    return Section(question.title, tables, answer, question.picture, page, question.command, opening)


def html(parts: Sequence[Section]) -> str:
    """The results as HTML; figures are images in the folder `figures` beside the page, in which nothing can run."""
    from jinja2 import Environment  # noqa: PLC0415 - needed for reports only

    environment = Environment(autoescape=True, trim_blocks=True)
    environment.filters["text"] = html_text
    environment.filters["caption"] = caption
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    return template.render(sections=parts, opening=OPENING) + "\n"


def index(parts: Sequence[Section], further: Grid | None = None) -> str:
    """The index as Markdown: a table of questions with small pictures, and tables of what has no page.

    Args:
        parts: the sections.
        further: a table over several of them, which stands at the end; none without rows.
    """
    lines = ["# Results", "", OPENING, ""]
    older = contents.older(min((chapter.world for section in parts for chapter in section.chapters), default=WORLD))
    lines += [older, ""] if older else []
    opened = [section for section in parts if section.opening is not None]
    lines += [BOARDS, "", "|  |  |", "| --- | --- |", *map(_row, opened), ""] if opened else []
    for section in (section for section in parts if section.opening is None):
        lines += [f"## {markdown_text(section.title)}", ""]
        lines += [section.answer, ""] if section.answer else []
        links = tables_line({chapter.name: chapter.title for chapter in section.chapters})
        lines += [links, ""] if links else []
    if further is not None and further.rows:
        lines += [f"## {markdown_text(further.headline)}", "", further.markdown(), "", markdown_text(further.note), ""]
    return "\n".join([*lines, "`python -m agents.report` writes these pages from the JSON files beside them.", ""])


def _row(section: Section) -> str:
    """A row of the table of questions: a small picture; the question, which leads to its page, and a sentence."""
    assert section.opening is not None
    picture = f"![{section.opening.unit}](figures/{small_picture(Path(section.page).stem)})"
    short = section.opening.short.replace("|", "\\|")
    return f"| {picture} | **[{markdown_text(section.title)}]({section.page})**<br>{short} |"


def tables_line(titles: Mapping[str, str]) -> str:
    """Links to pages of tables, from a page of results; empty without one."""
    links = [f"[{markdown_text(title)}](tables/{name}.md)" for name, title in titles.items()]
    return f"Tables: {', '.join(links)}" if links else ""


def tables(chapter: Chapter, section: Section) -> str:
    """A page of the folder `tables` beside `figures`: every table of a chapter, with a link to its question."""
    lines = [f"# {markdown_text(chapter.title)}", ""]
    lines += [f"These tables belong to [{section.title}](../{section.page})", ""] if section.page else []
    lines += [chapter.older, ""] if chapter.older else []
    lines += [markdown_text(chapter.note), ""] if chapter.note else []
    for grid in chapter.parts:
        lines += [f"## {markdown_text(grid.headline)}", ""] if grid.headline != chapter.title else []
        lines += [grid.markdown(), ""]
        lines += [markdown_text(grid.note), ""] if grid.note else []
    lines += ["## Pictures", ""] if chapter.figures else []
    for name in chapter.figures:
        lines += [caption(name), "", f"![{caption(name)}](../figures/{name})", ""]
    return "\n".join(lines)


def caption(file: str) -> str:
    """Words for a drawing; the words of its name where it has no others."""
    name, known = Path(file).stem, {name: words for of in CAPTIONS.values() for name, words in of.items()}
    ending = next((ending for ending in CAPTIONS["benchmarks"] if name.endswith(f"_{ending}")), name)
    return known.get(name) or known.get(ending) or name.replace("_", " ")


USED: Final = ("python", "pnt_gym", "mujoco", "numpy", "scipy", "casadi")
"""Packages that a reproduction depends on."""
FILE: Final = "reproduction.json"


def chapters(record: Record, drawings: Path) -> list[Chapter]:
    """One chapter a paper: its tables, and those of its drawings that lie in the folder."""
    versions = ", ".join(f"{name} {record['versions'][name]}" for name in USED if name in record["versions"])
    found: list[Chapter] = []
    for paper in record["papers"]:
        names = record["figures"][paper]
        for name in names:
            if re.fullmatch(r"[\w.-]+\.svg", name) is None:
                words = one_sentence(repr(name), 80)
                raise UsageError(f"drawing {words} is no name of an .svg file in {str(drawings)!r}")
        files = [drawings / name for name in names]
        drawn = {file.name: _read(file) for file in files if file.is_file()}
        # What the figures were made with, and what the verdicts count.
        counts = ", ".join(f"{count} {verdict}" for verdict, count in verdicts(record, paper).rows)
        seconds = sum(value for name, value in record["seconds"].items() if name.startswith(f"{paper}/"))
        note = f"`{record['command']}`: {counts}; {seconds:.0f} s of processor time. Versions: {versions}."
        found.append(Chapter(record["titles"][paper], tuple(all_grids(record, paper)), drawn, note, paper))
    return found


def table(results: Path, name: str) -> Grid | None:
    """A table of a paper's overview by the name "paper/table"; None if there is no such table.

    Raises:
        UsageError: nothing was reproduced yet, or the record has another form.
    """
    record = contents.read(results / FILE)
    paper, _, table_name = name.partition("/")
    with check_form(results / FILE):
        return overview_grids(record, paper).get(table_name) if paper in record["papers"] else None


def _read(file: Path) -> str:
    with check_form(file):
        return text_of(file, MOST_RESULTS)
