"""The report's chapters on reproduced papers, from a record made here: it prints what the record holds."""

import json
from pathlib import Path
from typing import Any

import pytest

from agents.ground.cli import UsageError
from agents.ground.tables import Grid
from agents.report import __main__, page
from agents.report.__main__ import Arguments, main
from agents.report.blocks import fill, makers_from
from agents.report.page import Chapter, sections
from agents.reproduce.record import headlines

OVERVIEW = Grid("Picks, published and ours", ["picks/min", "inside 15 %"], [["a throw | published", "30"]], "Under it.")
PART = Grid("What a part found", ["figure", "note"], [["x", "<i>y</i>"]])


def row(quantity: str, published: Any, reproduced: Any, verdict: str, paper: str = "one") -> dict[str, Any]:
    found = {"quantity": quantity, "published": published, "reproduced": reproduced, "unit": "m", "verdict": verdict}
    return {**found, "tolerance": None, "note": "a | b", "paper": paper}


def record() -> dict[str, Any]:
    rows = [
        row("one/statement/gain", 57.5, 135.3, "misprint"),
        {**row("table1/a/15", 30.0, 30.4, "reproduced"), "tolerance": 0.5},
        row("table1/b/15", None, 28.0, "ours"),
        row("headroom/15", None, None, "ours"),
        row("two/length", 0.32, 0.32, "reproduced", "two"),
    ]
    return {
        "command": "python -m agents.reproduce all",
        "versions": {"python": "3", "casadi": "3.7", "torch": "2"},
        "seconds": {"one/table1": 3.0, "two/example": 1.0},
        "papers": ["one", "two"],
        "titles": {"one": "One et al. <2022>", "two": "Two 2023"},
        "figures": {"one": ["one_drawing.svg", "gone.svg"], "two": []},
        "data": {},
        "overview": {
            "one": {"grids": {"table1": OVERVIEW._asdict(), "nothing": Grid("n", ["a"], [])._asdict()}, "notes": {}},
            "two": {"grids": {}, "notes": {}},
        },
        "grids": {"one": [PART._asdict(), Grid("none", ["a"], [])._asdict()], "two": [PART._asdict()]},
        "rows": rows,
    }


@pytest.fixture
def results(tmp_path: Path) -> Path:
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "one_drawing.svg").write_text("<?xml?>\n<svg>drawing</svg>\n")
    (tmp_path / "reproduction.json").write_text(json.dumps(record()))
    return tmp_path


@pytest.fixture
def chapters(results: Path) -> list[Chapter]:
    return __main__.read(results)


def test_every_paper_has_a_chapter_with_its_overview_first(chapters: list[Chapter]) -> None:
    assert [chapter.title for chapter in chapters] == [
        "One et al. <2022>", "Two 2023",
    ]  # fmt: skip
    first, second = chapters
    headlines_of_first = ["Picks, published and ours", "One et al. <2022>: what does not agree", "What a part found"]
    assert [grid.headline for grid in first.parts] == headlines_of_first
    assert [grid.headline for grid in second.parts] == ["What a part found"]
    assert first.parts[0].note == "Under it."


def test_what_does_not_agree_is_what_is_published_and_not_found_again(chapters: list[Chapter]) -> None:
    assert chapters[0].parts[1].rows == [["gain", "57.5 m", "135.3 m", "misprint", "a | b"]]


def test_the_note_counts_figures_of_ours_apart(chapters: list[Chapter]) -> None:
    assert chapters[0].note == (
        "`python -m agents.reproduce all`: 1 misprint, 1 reproduced, 2 ours, not compared; "
        "3 s of processor time. Versions: python 3, casadi 3.7."
    )


def test_only_drawings_that_exist_are_in_the_page_and_text_is_text(results: Path, chapters: list[Chapter]) -> None:
    assert set(chapters[0].figures) == {"one_drawing.svg"}
    text = page.html(sections(chapters, results))
    assert text.startswith("<!DOCTYPE html>")
    assert [text.count(tag) for tag in ("<html ", "<style>", "</style>", "<body>", "</body>", "</html>")] == [1] * 6
    assert '<img src="figures/one_drawing.svg"' in text
    assert '<td class="left">a throw | published</td>' in text
    assert "&lt;i&gt;y&lt;/i&gt;" in text
    assert "One et al. &lt;2022&gt;" in text
    assert "<p>Under it.</p>" in text
    main(Arguments(results, results / "none.md"))
    written = (results / "tables" / "one.md").read_text()
    assert "(../figures/one_drawing.svg)" in written
    assert "| a throw \\| published | 30 |" in written
    assert "\nUnder it.\n" in written
    assert "<i>" not in written.replace("\\<i>", "")


def test_a_readme_shows_a_table_of_an_overview_with_its_note(results: Path) -> None:
    text = fill("<!-- table:one/table1 -->\n<!-- /table -->\n", makers_from(results))
    assert text == f"<!-- table:one/table1 -->\n{OVERVIEW.markdown()}\n\nUnder it.\n<!-- /table -->\n"
    for unknown in ("one/none", "nobody/table1", "none"):
        with pytest.raises(UsageError, match=f"unknown table '{unknown}'"):
            fill(f"<!-- table:{unknown} -->\n<!-- /table -->\n", makers_from(results))


def test_the_terminal_shows_every_table() -> None:
    shown = headlines(record())
    assert [grid.headline for grid in shown] == [
        "Picks, published and ours", "One et al. <2022>: what does not agree", "What a part found",
        "One et al. <2022>: verdicts", "What a part found", "Two 2023: verdicts",
    ]  # fmt: skip
    assert shown[3].rows == [["misprint", "1"], ["reproduced", "1"], ["ours, not compared", "2"]]


def test_a_record_of_another_form_is_refused_in_a_sentence(results: Path) -> None:
    old = {name: value for name, value in record().items() if name not in ("overview", "grids", "titles")}
    (results / "reproduction.json").write_text(json.dumps(old))
    with pytest.raises(UsageError, match=r"has 3 problems:\n- key 'titles' is missing\n- key 'ove"):
        __main__.read(results)
    with pytest.raises(UsageError, match=r"has 3 problems:\n- key 'titles' is missing\n- key 'ove"):
        fill("<!-- table:one/table1 -->\n<!-- /table -->\n", makers_from(results))
