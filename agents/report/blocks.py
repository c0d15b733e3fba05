"""Marked blocks of documents, README and pages of results, that hold what is made from results/*.json."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any, Final, TypeAlias

from pnt_gym.names import unknown_name
from pnt_gym.reading import text_of

from ..ground.cli import UsageError
from ..ground.files import MOST_RESULTS, check_form
from ..ground.outputs import deliver_text
from ..ground.tables import Grid, html_text, markdown_text
from ..results import study
from ..results.study import STUDIES
from . import contents, headline, leaderboard, line, speeds, submissions, tables, templates
from .line import gains_table, seeds_table
from .page import table as reproduced_table
from .page import tables_line
from .pays import crossover_grid
from .questions import QUESTIONS, Question
from .submissions import BLOCK as SUBMISSIONS
from .tables import first_shift_table

BLOCKS: Mapping[str, tuple[str, Callable[[Any], Grid]]] = {
    "headline": ("benchmark.json", headline.table),
    "benchmark": ("benchmark.json", tables.table),
    "grasp": ("benchmark_grasp.json", tables.table),
    "planner": ("perf_planner.json", partial(speeds.grid, "planner")),
    "environments": ("perf_envs.json", partial(speeds.grid, "environments")),
    "speed-goals": ("perf_envs.json", partial(speeds.grid, "speed-goals")),
    "shares": ("perf_shares.json", partial(speeds.grid, "shares")),
    "training-shares": ("perf_training.json", partial(speeds.grid, "training-shares")),
    "training-before": ("perf_before.json", partial(speeds.grid, "training-before")),
    "steps-before": ("perf_before.json", partial(speeds.grid, "steps-before")),
    "line": ("benchmark_line.json", line.table),
    "line-gains": ("benchmark_line.json", gains_table),
    "line-learned": ("benchmark_line.json", seeds_table),
    "adapting": ("benchmark_adapt.json", first_shift_table),
    "failures": ("benchmark.json", headline.failures),
    "peers": ("benchmark_peers.json", headline.peers),
    "crossover": ("mismatch.json", crossover_grid),
}
"""Tables in documents by name: the file of results, and what makes the table; plans of studies name further ones, and
those of papers are "paper/table"."""
LONGEST: Final = 12
"""Rows of a table that a document shows at once; a longer one is folded."""
Maker: TypeAlias = Callable[[str], str]
"""Returns the text of a block from the words after its kind."""
MARKED: Final = re.compile(r"<!-- (\w+): ?([^\n]*?) ?-->\n(.*?)<!-- /\1 -->", re.DOTALL)
"""A marked block: its kind, the words after the kind, and its text."""


def fill(text: str, makers: Mapping[str, Maker], *, is_marked: bool = True) -> str:
    """A document with its blocks `<!-- KIND:WORDS --> ... <!-- /KIND -->` made anew.

    Args:
        text: the document.
        makers: what makes the text of a block, by its kind; blocks of other kinds stay.
        is_marked: keep the marks, between which the document is made again.
    """

    def block(old: re.Match[str]) -> str:
        if old[1] not in makers:
            return old[0]
        made = makers[old[1]](old[2])
        return f"{old[0].partition(chr(10))[0]}\n{made}\n<!-- /{old[1]} -->" if is_marked else made

    return MARKED.sub(block, text)


def makers_from(results: Path) -> dict[str, Maker]:
    """What makes tables, questions and answers from a folder of results.

    A maker raises a UsageError if there is no such table, question or answer, or its results are missing.
    """
    return {
        "table": lambda name: _text(name, results),
        "question": lambda name: _question_text(name, results),
        "answer": lambda name: _answer_text(name, results),
        "short": lambda name: _answer_text(name, results, is_short=True),
    }


def rewrite(document: Path, makers: Mapping[str, Maker]) -> bool:
    """Write the marked blocks of a document anew; whether anything changed.

    Raises:
        UsageError: the document cannot be read, or a marked block cannot be made.
    """
    with check_form(document):
        text = text_of(document, MOST_RESULTS)
    changed = fill(text, makers)
    if changed != text:
        deliver_text(document, changed)
    return changed != text


def _question_text(name: str, results: Path) -> str:
    """What a page of results begins with: title, five numbers, picture, the command behind them, links to tables."""
    question, answer = _answered_question(name, results)
    opening = question.opening(results)
    picture = f"![{question.title}](figures/{question.picture})"
    # Files of results with one page of tables; the papers of a reproduction have a page each.
    pages = {page for page in question.chapters if (results / "tables" / f"{page}.md").is_file()}
    links = tables_line({page: title for page, title in question.chapters.items() if page in pages})
    tables = f"<details><summary>Every table</summary>\n\n{links}\n\n</details>" if links else ""
    numbers = answer if opening is None else opening.markdown()
    made = f"`{question.command}` makes these numbers."
    lines = [f"# {question.title}", numbers, picture, made, question.older(results), tables]
    return "\n\n".join(line for line in lines if line)


def _answer_text(name: str, results: Path, *, is_short: bool = False) -> str:
    """The answer to a question, perhaps in a sentence, and from which world it is where that is an older one."""
    question, answer = _answered_question(name, results)
    if is_short and (opening := question.opening(results)) is not None:
        answer = opening.short
    return " ".join(line for line in (answer, question.older(results)) if line)


def _answered_question(name: str, results: Path) -> tuple[Question, str]:
    """A question by its name, and its answer from the results in a folder.

    Raises:
        UsageError: there is no such question, or its results are missing.
    """
    for question in QUESTIONS:
        if question.name == name and (answer := question.answered(results)) is not None:
            return question, answer
    known = ", ".join(question.name for question in QUESTIONS)
    raise UsageError(f"no answer {name!r} from {str(results)!r}; questions are {known}, each with its results")


def _text(name: str, results: Path) -> str:
    """A table with its note; a long one is folded, as code hosts and the site unfold it."""
    grid = _table(name, results)
    note = f"\n\n{markdown_text(grid.note)}" if grid.note else ""
    if len(grid.rows) <= LONGEST:
        return f"{grid.markdown()}{note}"
    title = html_text(grid.headline or ", ".join(grid.header[:3]))
    summary = f"<details><summary>{title}: {len(grid.rows)} rows</summary>"
    return f"{summary}\n\n{grid.markdown()}{note}\n\n</details>"


def _table(name: str, results: Path) -> Grid:
    if name == SUBMISSIONS:
        return submissions.grid(results)
    if name.startswith(leaderboard.PREFIX) and name.removeprefix(leaderboard.PREFIX) in leaderboard.BOARDS:
        return leaderboard.grid(results, name.removeprefix(leaderboard.PREFIX))
    tables = {**BLOCKS, **study_blocks()}
    if name in tables:
        file, make_table = tables[name]
        with check_form(results / file):
            return make_table(contents.read(results / file))
    grid = reproduced_table(results, name) if "/" in name else None
    if grid is None:
        raise UsageError(unknown_name("table", name, tables, ", and PAPER/TABLE"))
    return grid


@cache
def study_blocks() -> Mapping[str, tuple[str, Callable[[Any], Grid]]]:
    """Tables of the shipped studies by the names of their blocks."""
    plans = [study.read(path) for path in sorted(STUDIES.glob("*.yaml"))]
    return {
        table.block: (f"{plan.study}.json", partial(templates.grid, plan, table))
        for plan in plans
        for table in plan.tables
        if table.block
    }
