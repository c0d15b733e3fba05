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
    return ahead(table[one], table[other])[0]


def ahead(one, other):
    """The same of figures, and the least of its interval of two standard errors."""
    shared = min(len(value(one)), len(value(other)))
    share = (value(one)[:shared] - value(other)[:shared]) / value(other)[:shared].mean()
    return share.mean(), share.mean() - 2.0 * share.std() / np.sqrt(shared)


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


@pytest.mark.parametrize(("level", "least"), [("skills3", 0.135), ("skills3_burst", 0.10)])
def test_a_beam_that_leaves_to_others_is_far_ahead_of_class_blind_rules(data, level, least):
    table = data["line"][level]
    assert best(table, PLANNERS) == "price_beam"
    assert gain(table, "price_beam", best(table, CLASS_BLIND)) > least
    assert ahead(table["price_beam"], table["price"])[1] > 0.0


@pytest.mark.parametrize("name", ["price_beam", "index"])
def test_on_skills3_two_robots_are_always_at_work_and_the_third_waits_for_what_comes(data, name):
    first, second, third = data["line"]["skills3"][name]["utilisation"]
    assert 0.965 < second < first < 0.995
    assert 0.7 < third < 0.8


def test_an_index_learned_from_reward_comes_up_to_the_best_planner_everywhere(data):
    for level, table in data["line"].items():
        assert gain(table, "index", best(table, PLANNERS)) > -0.02, level


def test_each_of_five_seeds_on_skills3_burst_is_ahead_of_price_and_of_the_robots_own_planner(data):
    seeds, table = data["learned"]["skills3_burst"]["residual_ppo"], data["line"]["skills3_burst"]
    assert len(seeds) == 5
    for found in seeds.values():
        assert ahead(found, table["price"])[1] > 0.0
        assert ahead(found, table["beam"])[1] > 0.0


def test_every_search_for_an_index_on_skills3_burst_is_ahead_of_the_best_planner(data):
    searches, table = data["learned"]["skills3_burst"]["index"], data["line"]["skills3_burst"]
    planner = table[best(table, PLANNERS)]
    assert len(searches) >= 2
    for found in (table["index"], *searches.values()):
        assert ahead(found, planner)[1] > 0.0


def test_every_seed_on_value_takes_most_of_what_the_planner_has_over_the_rule(data):
    table = data["line"]["value"]
    for found in data["learned"]["value"]["residual_ppo"].values():
        assert found["decisions"] < 520_000
        assert ahead(found, table["atc"])[0] > 0.6 * gain(table, "beam", "atc")


@pytest.mark.parametrize("level", ["skills3", "skills3_burst"])
def test_where_skills_differ_leaving_to_others_beats_every_robots_own_planner(data, level):
    table = data["line"][level]
    assert gain(table, "price", best(table, CLASS_BLIND)) > 0.05
    assert gain(table, "price", best(table, ("beam", "joint_beam"))) > 0.02


def test_a_policy_that_began_as_the_rule_is_better_than_the_rule(data):
    for level in ("value", "skills3_burst"):
        table = data["line"][level]
        gained = value(table["residual_ppo"]) - value(table["atc"])
        assert gained.mean() - 2.0 * gained.std() / np.sqrt(len(gained)) > 0.0


def test_tables_stand_in_for_throws_within_four_percent(data):
    for level, table in data["full"].items():
        for name, found in table.items():
            shared = value(data["line"][level][name])[: data["thrown_shifts"]]
            assert value(found).mean() == pytest.approx(shared.mean(), rel=0.04), (level, name)
