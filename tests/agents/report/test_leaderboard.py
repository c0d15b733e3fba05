"""The leaderboard: sorted boards of what was handed in beside the project's controllers."""

import re

import pytest

from agents.ground.places import SHIPPED as ROOT
from agents.report import leaderboard
from agents.report.blocks import makers_from
from agents.report.leaderboard import BOARDS, US

RESULTS = ROOT / "results"


pytestmark = pytest.mark.usefixtures("results_as_they_stand")


def figures(cells):
    """Numbers of a column."""
    return [float(re.sub(r"[^\d.]", "", cell)) for cell in cells]


@pytest.mark.parametrize("name", BOARDS)
def test_a_board_is_sorted_and_its_best_is_bold(name):
    board, grid = BOARDS[name], leaderboard.grid(RESULTS, name)
    assert len(grid.rows) > 5
    columns = list(zip(*grid.rows, strict=True))
    first = figures(columns[3])
    assert first == sorted(first, reverse=True)
    knows = ["hidden" in cell for cell in columns[0]]
    assert any(knows) or name == "line"
    for number, cells in enumerate(columns[3:]):
        column = board.columns[number % len(board.columns)]
        honest = [cell for cell, cheats in zip(cells, knows, strict=True) if not cheats]
        best = (max if column.sign > 0 else min)(figures(honest))
        assert {value for value, cell in zip(figures(cells), cells, strict=True) if cell.startswith("**")} == {best}
        assert not any(cell.startswith("**") for cell, cheats in zip(cells, knows, strict=True) if cheats)


def test_what_was_handed_in_stands_on_the_board_of_its_environment():
    by = {name: {row[1] for row in leaderboard.grid(RESULTS, name).rows} for name in BOARDS}
    assert "pnt_gym" in by["conveyor"]
    assert all(US in names for names in by.values())


def test_a_board_has_another_name_than_the_table_of_its_benchmark():
    make = makers_from(RESULTS)["table"]
    assert make("leaderboard-grasp") != make("grasp")


def test_a_folder_without_results_has_empty_boards(tmp_path):
    assert [leaderboard.grid(tmp_path, name).rows for name in BOARDS] == [[]] * len(BOARDS)
