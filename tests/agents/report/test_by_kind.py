"""What a benchmark of grasps says of each kind."""

from agents.report import tables
from agents.report.tables import kind_table


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
    assert grid.header[:3] == ["controller", "paper_ball", "can"]
    assert grid.rows[0][:4] == ["centre", "67/33/33", "100/0/0", "-"]
    assert grid.rows[1][:4] == ["flattest", "100/0/100", "100/0/100", "-"]


def test_landings_of_a_kind_are_those_of_its_objects_that_flew():
    thrown = {"along_m": [0.003, None, -0.03, 0.01], "across_m": [0.004, None, 0.0, 0.0]}
    data = {
        "plan": {"env": "PnTGrasp-v0", "inline": {}},
        "results": [
            result("centre", "spss", [0, 0, 0, 1], tries=5, **thrown),
            result("centre", "ssss", [2, 2, 2, 0], tries=4, **thrown),
        ],
    }
    grid = tables.landings(data, "grasp")
    (row,) = grid.rows
    assert row[:5] == ["centre", "15/10/-6", "10/10/+10", "18/18/-14", "-"]


def test_there_is_no_table_where_nothing_is_grasped():
    data = {"plan": {"env": "PnTRelease-v0", "inline": {}}, "results": [result("analytic", "s", [0])]}
    assert not kind_table(data, "grasp").rows
    assert not tables.landings(data, "grasp").rows
