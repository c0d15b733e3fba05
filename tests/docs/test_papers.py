"""The tables "From equation to code" of the papers' pages: functions and parts exist."""

import re

import pytest

from agents.ground.files import read_json
from agents.reproduce.__main__ import PARTS_HELP
from agents.reproduce.finding import judge_statements
from agents.reproduce.papers import PAPERS, PART_NAMES, PUBLISHED_RESULTS, package
from docs.pages import made
from docs.pages.throw import resolve

RESULTS = read_json(PUBLISHED_RESULTS)
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


SENTENCES = (
    ("hassan", "is {:.1f} % off on average, and", ("table1/constant-jerk-overlap/mean-difference",)),
    ("hassan", "the jerk reaches {:.2f} times its limit", ("table1/constant-jerk-overlap/peak-jerk",)),
    ("hassan", "nothing is exceeded, and the table is {:.1f} % off", ("table1/constant-jerk-stops/mean-difference",)),
    (
        "miyashita",
        "may lose {:.0f} rad/s² of acceleration",
        ("miyashita/claim/margins-withstand-lost-acceleration",),
    ),
    ("choe", "the acceleration is {:.0f} % of its peak", ("choe/claim/larger-radius-larger-acceleration",)),
    (
        "choe",
        "Lamé curves are {:.0f} to {:.0f} % quicker",
        (
            "choe/claim/shorter-cycle-than-lame/equal-tops-strict",
            "choe/claim/shorter-cycle-than-lame/equal-crests-strict",
        ),
    ),
    (
        "leveziel",
        "would close in {:.1f} to {:.1f} ms",
        ("leveziel/closing/speed-limited smallest", "leveziel/closing/speed-limited largest"),
    ),
)
"""Figures in the prose of papers' pages: page, sentence, and the quantities (and details) that it states."""
HOLD = {
    "hassan": ("hassan/claim/equivalent-to-the-double-s", "table1/peak-acceleration", "table1/peak-velocity"),
    "miyashita": ("miyashita/fig-7/without-margin", "miyashita/fig-10/position", "miyashita/fig-10/speed"),
    "choe": ("choe/fig-8/proposed", "choe/claim/shorter-cycle-than-symmetric-ellipse"),
    "leveziel": ("leveziel/formula/J_x", "leveziel/cycle/success"),
}
"""Statements that the pages say hold."""


@pytest.mark.parametrize(("paper", "sentence", "names"), SENTENCES)
def test_figures_in_the_prose_are_those_of_the_results(paper, sentence, names):
    rows = {row["quantity"]: row for row in RESULTS["rows"]}
    values = []
    for name in names:
        quantity, _, detail = name.partition(" ")
        values.append(1000.0 * rows[quantity][detail] if detail else rows[quantity]["reproduced"])
    page = " ".join((made.DOCS / "papers" / f"{paper}.md").read_text(encoding="utf-8").split())
    assert sentence.format(*values) in page


@pytest.mark.parametrize("paper", PAPERS)
def test_what_the_pages_say_holds_was_reproduced(paper):
    verdicts = judge_statements(row for row in RESULTS["rows"] if row["paper"] == paper)
    assert {name: verdicts[name] for name in HOLD[paper]} == dict.fromkeys(HOLD[paper], "reproduced")
