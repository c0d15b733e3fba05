"""What a line needs: plans, tables and the sentence at the end."""

import json

import pytest

from agents.line.plan import Arguments, down, line_up, make_plans
from pnt_gym.cells.line.config import LineConfig
from tests.tools.commands import output_of

LEVEL = LineConfig.load("skills3")


def asked(**changes):
    return Arguments(level="skills3", **changes)


def test_more_robots_than_a_level_has_stand_on_as_its_last():
    robots = line_up(LEVEL, 4)
    assert [robot.x for robot in robots] == pytest.approx([0.0, 1.4, 2.8, 4.2])
    assert robots[3].skills == LEVEL.robots[2].skills
    assert len({robot.name for robot in robots}) == 4


def test_every_combination_is_a_plan_with_the_stream_of_the_level():
    plans = list(
        make_plans(LEVEL, asked(robots=(2, 3), speeds=(0.3, 0.4), percents=(30.0, 40.0), skills=("level", "all")))
    )
    assert len(plans) == 16
    for told, config in plans:
        assert len(config.robots) == told["robots"]
        assert config.cell.belt.speed == told["belt_speed"]
        assert config.cell.limits.percent == (told["percent"],)
        assert config.arrivals == LEVEL.arrivals
        assert config.can_take().all() == (told["skills"] == "all")


def test_a_robot_is_down_from_the_middle_of_the_shift_on():
    config = down(LEVEL, asked(minutes=30.0, down="second:10"))
    assert [(one.robot, one.start, one.end) for one in config.down] == [("second", 900.0, 1500.0)]
    assert down(LEVEL, asked(down="nobody:10")) is LEVEL


def test_it_says_which_plan_is_enough_and_writes_what_it_found(tmp_path):
    line = "line plan --level skills3 --robots 1 3 --shifts 2 --minutes 0.2 --recovery 0.2"
    said = output_of(f"{line} --json plans.json --picture plans.svg", tmp_path)
    plans = json.loads((tmp_path / "plans.json").read_text())["plans"]
    assert [plan["robots"] for plan in plans] == [1, 3]
    assert plans[1]["recovery"] > plans[0]["recovery"] > 0.0
    assert all(plan["recovery_low"] <= plan["recovery"] <= plan["recovery_high"] for plan in plans)
    assert "the smallest plan with a recovery of 20.0 %:" in " ".join(said.split())
    assert (tmp_path / "plans.svg").read_text().startswith("<?xml")
