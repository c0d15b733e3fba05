"""What a benchmark of grasps says of each kind."""

from agents.report.by_kind import kind_table


def result(label, outcome, items, **counts):
    return {"label": label, "level": "grasp", "columns": {"item": items, "outcome": outcome, **counts}}


def test_shares_of_a_kind_are_those_of_its_throws():
    data = {
        "plan": {"env": "PnTGrasp-v0", "inline": {}},
        "results": [
            result("centre", "spdm", [0, 0, 0, 1], tries=5),
            result("flattest", "ssss", [0, 0, 0, 1], tries=4),
        ],
    }
    grid = kind_table(data, "grasp")
    assert list(grid.header) == ["kind", "centre", "flattest"]
    assert grid.rows[0] == ["paper_ball", "67 / 33 / 33 %", "100 / 0 / 100 %"]
    assert grid.rows[1] == ["can", "100 / 0 / 0 %", "100 / 0 / 100 %"]
    assert grid.rows[2][1:] == ["-", "-"]


def test_there_is_no_table_where_nothing_is_grasped():
    data = {"plan": {"env": "PnTRelease-v0", "inline": {}}, "results": [result("analytic", "s", [0])]}
    assert not kind_table(data, "grasp").rows
