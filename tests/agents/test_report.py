"""The report made from the results of this repository."""

from __future__ import annotations

import pytest

from agents.report.__main__ import read_chapters
from agents.report.page import cells
from agents.versions import ROOT

CHAPTERS = {chapter.title: chapter for chapter in read_chapters(ROOT / "results")}


@pytest.mark.parametrize("title", ["benchmark", "physics", "perf_planner", "perf_envs"])
def test_every_result_has_a_chapter_with_its_conditions(title: str) -> None:
    chapter = CHAPTERS[title]
    assert chapter.note
    for _, table in chapter.parts:
        rows = cells(table)
        assert len(rows) > 1
        assert {len(row) for row in rows} == {len(rows[0])}, "text that is no row stands in a table"
