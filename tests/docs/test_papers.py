"""The tables "From equation to code" of the papers' pages: functions and parts exist."""

import re

import pytest

from agents.reproduce.__main__ import PARTS_HELP
from agents.reproduce.papers import PAPERS, PART_NAMES, package
from docs.pages import made
from docs.pages.throw import resolve

ROW = re.compile(r"^\|.*\| `((?:pnt_gym|papers)\.[\w.]+)` \| `([\w-]+)` \| [^|]+ \|$", re.MULTILINE)


def rows(paper):
    """Function and part of every row."""
    text = (made.DOCS / "papers" / f"{paper}.md").read_text(encoding="utf-8")
    table = text.partition("| in the paper | in our symbols |")[2].partition("\n\n")[0]
    found = ROW.findall(table)
    assert len(found) == table.count("\n") - 1  # the head and its line aside
    return found


@pytest.mark.parametrize("paper", PAPERS)
def test_functions_and_parts_of_a_papers_table_exist(paper):
    assert len(rows(paper)) > 9
    for name, part in rows(paper):
        assert resolve(name) is not None
        assert part in package(paper).PARTS


@pytest.mark.parametrize("paper", PAPERS)
def test_the_help_names_the_parts_that_there_are(paper):
    assert PART_NAMES[paper] == tuple(package(paper).PARTS)
    text = PARTS_HELP.partition(f"{paper.capitalize()}: ")[2]
    names = [name.partition(" ")[0] for name in text.split(", ")][: len(PART_NAMES[paper])]
    assert [name.rstrip(".") for name in names] == list(PART_NAMES[paper])
