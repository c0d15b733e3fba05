"""Guards of committed numbers: every result has its chapter, and the README's tables are what the results give."""

from __future__ import annotations

from agents.ground.places import SHIPPED as ROOT
from agents.report.__main__ import read_chapters
from agents.report.readme import with_blocks

RESULTS = ROOT / "results"


def test_every_result_has_a_chapter_with_its_conditions() -> None:
    chapters = {chapter.title: chapter for chapter in read_chapters(RESULTS)}
    for title in ("benchmark", "physics", "perf_planner", "perf_envs"):
        assert chapters[title].parts[0].note
        for grid in chapters[title].parts:
            assert grid.rows
            assert {len(row) for row in grid.rows} == {len(grid.header)}


def test_readme_tables_equal_the_results() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert with_blocks(text, RESULTS) == text, "run python -m agents.report"
