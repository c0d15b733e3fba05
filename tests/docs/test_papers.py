"""The tables "From equation to code" of the papers' pages: functions and parts exist."""

import re

import pytest

from agents.ground.files import read_json
from agents.reproduce import finding
from agents.reproduce.__main__ import PARTS_HELP
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


REPRODUCED = "reproduced"
SENTENCES = (
    ("hassan", "is {:.1f} % off on average, and", (("table1/constant-jerk-overlap/mean-difference", REPRODUCED),)),
    ("hassan", "the jerk reaches {:.2f} times its limit", (("table1/constant-jerk-overlap/peak-jerk", REPRODUCED),)),
    (
        "hassan",
        "nothing is exceeded, and the table is {:.1f} % off",
        (("table1/constant-jerk-stops/mean-difference", REPRODUCED),),
    ),
    (
        "hassan",
        "The printed gains of {:g}, {:g} and {:g} %",
        tuple(
            (f"hassan/statement/gain-{pair}", "published")
            for pair in ("proposed-over-pick-and-place", "proposed-over-existing", "existing-over-pick-and-place")
        ),
    ),
    ("hassan", "misses its target by {:.1f} mm", (("hassan/example/throw-2-landing", REPRODUCED),)),
    (
        "miyashita",
        "may lose {:.0f} rad/s² of acceleration",
        (("miyashita/claim/margins-withstand-lost-acceleration", REPRODUCED),),
    ),
    ("miyashita", "every gain from {:g} to {:g}", (("miyashita/fig-10/T-0.3-0.1/angle", "gains"),)),
    ("miyashita", "the mean error of the angle is up to {:.1f}°", (("miyashita/fig-10/T-0.1-0.1/angle", REPRODUCED),)),
    (
        "miyashita",
        "{:.0f} to {:.0f} % of the throws without margin roll",
        tuple((f"miyashita/disturbed/{name}", REPRODUCED) for name in ("all-effects", "friction")),
    ),
    (
        "miyashita",
        "at {:.0f} to {:.0f} % of random goals",
        tuple((f"miyashita/acceptance/delay-5ms/K-{gain}", REPRODUCED) for gain in ("1", "0.5")),
    ),
    (
        "choe",
        "the acceleration is {:.0f} % of its peak",
        (("choe/claim/larger-radius-larger-acceleration", REPRODUCED),),
    ),
    (
        "choe",
        "Lamé curves are {:.0f} to {:.0f} % quicker",
        tuple(
            (f"choe/claim/shorter-cycle-than-lame/{kind}-strict", REPRODUCED) for kind in ("equal-tops", "equal-crests")
        ),
    ),
    (
        "choe",
        "plans {:.1f} % of them, with falling paths run backwards {:.1f} %, and",
        tuple((f"choe/claim/random-points/{name}", REPRODUCED) for name in ("as-printed", "falling-reversed")),
    ),
    (
        "miyashita",
        "halfway they lie up to {:.0f} mm",
        (("miyashita/claim/vertical-speed-chooses-path", REPRODUCED),),
    ),
    ("leveziel", "makes {:.0f} cycles a minute", (("leveziel/cycle/picks-per-minute", REPRODUCED),)),
    ("leveziel", "motors do {:.1f} J", (("leveziel/cycle/motor-work", REPRODUCED),)),
    ("leveziel", "takes {:.1f} J at least", (("leveziel/cycle/suction-work", REPRODUCED),)),
    (
        "leveziel",
        "would close in {:.1f} to {:.1f} ms",
        tuple(("leveziel/closing/speed-limited", entry) for entry in ("smallest", "largest")),
    ),
)
"""Figures in the prose of papers' pages: page, sentence, and the quantities and entries that it states."""
UNITS = {"ms": 1000.0, "mm": 1000.0}
"""Factors of sentences whose unit is not the quantity's."""
NAMES = re.compile(r"\b(?:Fig\.|Eq\.|Algorithm|Table) \w+")
SETTINGS = ("A stopper of 2 mm", "at 30 % of the limits", "17 vertical speeds", "70 picks", "30 of grippers")
"""Numbers of pages that are settings of ours, no figures."""
HOLD = {
    "hassan": (
        "hassan/claim/equivalent-to-the-double-s",
        "hassan/figure-12/continuous",
        "table1/peak-acceleration",
        "table1/peak-velocity",
    ),
    "miyashita": (
        "miyashita/fig-7/without-margin",
        "miyashita/claim/vertical-speed-chooses-path",
        *(f"miyashita/fig-10/{figure}" for figure in ("position", "angle", "speed")),
    ),
    "choe": ("choe/fig-8/proposed", "choe/claim/shorter-cycle-than-symmetric-ellipse", "choe/claim/random-points"),
    "leveziel": ("leveziel/formula/J_x", "leveziel/cycle/success"),
}
"""Statements that the pages say hold."""


def findings(paper):
    """The section "What we found" of a paper's page."""
    page = (made.DOCS / "papers" / f"{paper}.md").read_text(encoding="utf-8")
    return " ".join(page.partition("## What we found")[2].partition("\n## ")[0].replace("**", "").split())


def filled(sentence, names):
    """A sentence with the figures of the results."""
    rows = {row["quantity"]: row for row in RESULTS["rows"]}
    values = []
    for quantity, entry in names:
        value = rows[quantity][entry]
        values += [value[0], value[-1]] if isinstance(value, list) else [value]
    factor = next((factor for unit, factor in UNITS.items() if sentence.endswith(f" {unit}")), 1.0)
    return sentence.format(*(factor * value for value in values))


@pytest.mark.parametrize(("paper", "sentence", "names"), SENTENCES)
def test_figures_in_the_prose_are_those_of_the_results(paper, sentence, names):
    assert filled(sentence, names) in findings(paper)


@pytest.mark.parametrize("paper", PAPERS)
def test_every_number_in_the_prose_is_a_figure_of_the_results(paper):
    text = findings(paper)
    for known in (*SETTINGS, *(filled(sentence, names) for page, sentence, names in SENTENCES if page == paper)):
        text = text.replace(known, "")
    assert re.findall(r".{0,30}\d.{0,30}", NAMES.sub("", text)) == []


@pytest.mark.parametrize("paper", PAPERS)
def test_what_the_pages_say_holds_was_reproduced(paper):
    verdicts = finding.judge(row for row in RESULTS["rows"] if row["paper"] == paper)
    assert {name: verdicts[name] for name in HOLD[paper]} == dict.fromkeys(HOLD[paper], "reproduced")
