"""What the study of lines found, held to what the pages say of it."""

import json

import numpy as np
import pytest

from agents.places import SHIPPED as ROOT
from agents.report.line import CLASS_BLIND, PLANNERS, best, value
from pnt_gym.cells.line.config import LineConfig


@pytest.fixture(scope="module")
def data():
    return json.loads((ROOT / "results" / "line.json").read_text(encoding="utf-8"))


def gain(table, one, other):
    """How much more one brings in than another on the shifts that both have worked."""
    shared = min(len(value(table[one])), len(value(table[other])))
    return value(table[one])[:shared].mean() / value(table[other])[:shared].mean() - 1.0


def test_every_level_that_is_told_of_has_been_measured(data):
    assert set(data["line"]) == set(LineConfig.level_names()) - {"nominal"}
    for table in data["line"].values():
        assert {"random", "fifo", "spt", "value_rate", "atc", "pair", "beam"} <= set(table)
        assert all(found["invalid"] == 0 for found in table.values())


def test_what_was_asked_of_the_order_of_picks(data):
    line = data["line"]
    assert gain(line["single"], best(line["single"], tuple(line["single"])), "fifo") > 0.12
    assert gain(line["value"], best(line["value"], tuple(line["value"])), "fifo") > 0.50
    assert gain(line["value"], "beam", best(line["value"], CLASS_BLIND)) > 0.05


@pytest.mark.parametrize("level", ["skills3", "skills3_burst"])
def test_where_skills_differ_leaving_to_others_beats_every_robots_own_planner(data, level):
    table = data["line"][level]
    assert gain(table, "price", best(table, CLASS_BLIND)) > 0.05
    assert gain(table, "price", best(table, PLANNERS)) > 0.02


def test_a_policy_that_began_as_the_rule_is_better_than_the_rule(data):
    for level in ("value", "skills3_burst"):
        table = data["line"][level]
        gained = value(table["residual_ppo"]) - value(table["atc"])
        assert gained.mean() - 2.0 * gained.std() / np.sqrt(len(gained)) > 0.0
    table = data["line"]["value"]
    share = (value(table["residual_ppo"]) - value(table["atc"])).mean() / (
        value(table["beam"]) - value(table["atc"])
    ).mean()
    assert share > 0.6


def test_tables_stand_in_for_throws_within_four_percent(data):
    for level, table in data["full"].items():
        for name, found in table.items():
            shared = value(data["line"][level][name])[: data["thrown_shifts"]]
            assert value(found).mean() == pytest.approx(shared.mean(), rel=0.04), (level, name)
