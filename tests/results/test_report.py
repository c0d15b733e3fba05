"""Guards of committed numbers: every result has its page, and documents say what the results give."""

import re

import pytest
from matplotlib.figure import Figure

from agents.ground import drawings
from agents.ground.places import SHIPPED as ROOT
from agents.report import __main__, page, room
from agents.report.blocks import fill, makers_from
from agents.report.page import UNASKED, sections
from agents.report.questions import QUESTIONS

RESULTS = ROOT / "results"
pytestmark = pytest.mark.usefixtures("results_as_they_stand")


@pytest.fixture(scope="module")
def chapters():
    """Chapters without their drawings, which the tests of the report look at."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", lambda *_, **__: None)
        patch.setattr(drawings, "small_svg", str)
        return __main__.read(RESULTS)


def test_every_result_belongs_to_a_question_and_has_tables_with_their_conditions(chapters):
    parts = sections(chapters, RESULTS)
    assert [section.title for section in parts] == [question.title for question in QUESTIONS]
    assert UNASKED not in [section.title for section in parts]
    for section in parts:
        assert section.page
        assert any(character.isdigit() for character in section.answer)
        assert (RESULTS / "figures" / section.picture).is_file()
        for chapter in section.chapters:
            assert chapter.note or chapter.parts[0].note
            assert all({len(row) for row in grid.rows} == {len(grid.header)} for grid in chapter.parts)


def test_the_index_is_what_the_results_give(chapters):
    text = (RESULTS / "README.md").read_text(encoding="utf-8")
    assert page.index(sections(chapters, RESULTS), room.grid(RESULTS)) == text, "run python -m agents.report"


@pytest.mark.parametrize("name", ["README.md", *(f"results/{question.name}.md" for question in QUESTIONS)])
def test_blocks_of_documents_equal_the_results(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    assert fill(text, makers_from(RESULTS)) == text, "run python -m agents.report"


@pytest.mark.parametrize("name", [question.name for question in QUESTIONS])
def test_a_page_of_results_is_read_in_minutes(name):
    """Its text without tables and without what is folded: at 200 words a minute, two minutes."""
    text = (RESULTS / f"{name}.md").read_text(encoding="utf-8")
    lines = re.sub("<details>.*?</details>", "", text, flags=re.DOTALL).splitlines()
    # The line about an older world goes when the page is measured anew.
    words = sum(len(line.split()) for line in lines if not line.startswith(("|", "Measured in world")))
    assert words < 700, words
