"""What the benchmark of lines and the study of throws found, held to what the pages say of it."""

import json

import numpy as np
import pytest

from agents.dispatchers.settings import PLANNERS
from agents.ground.places import SHIPPED as ROOT
from agents.report.line import CLASS_BLIND, best, by_seed, value
from agents.report.tables import rows_of
from pnt_gym.cells.line.config import LineConfig

ALONE = [name for name in PLANNERS if name != "guided_beam"]
"""Planners that nobody guides."""
LEVELS = sorted({*LineConfig.level_names()} - {"nominal"})


def read(name):
    return json.loads((ROOT / "results" / f"{name}.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def data():
    return read("benchmark_line")


def named(data, level, label):
    """What was measured of a label, after all it learned."""
    return [row for row in rows_of(data, [level]) if row["label"] == label][-1]


def of(data, level, names):
    """The best of some controllers."""
    return best(rows_of(data, [level]), names)


def gain(one, other):
    """How much more one brings in than another on the shifts that both have worked."""
    return ahead(value(one), value(other))[0]


def ahead(one, other):
    """The same of values, and the least of its interval of two standard errors."""
    shared = min(len(one), len(other))
    share = (one[:shared] - other[:shared]) / other[:shared].mean()
    return share.mean(), share.mean() - 2.0 * share.std() / np.sqrt(shared)


def test_every_level_that_is_told_of_has_been_measured_on_a_hundred_shifts(data):
    assert sorted(data["plan"]["levels"]) == LEVELS
    for level in LEVELS:
        rows = rows_of(data, [level])
        wanted = {"random", "fifo", "spt", "value_rate", "atc", "pair", "beam", "index", "residual_ppo", "maskable_ppo"}
        assert wanted <= {row["label"] for row in rows}
        assert all(row["invalid_actions"] == 0 for row in rows)
        assert all(row["shifts"] == 100 for row in rows)


def test_what_was_asked_of_the_order_of_picks(data):
    assert gain(of(data, "single", None), named(data, "single", "fifo")) > 0.12
    assert gain(of(data, "value", None), named(data, "value", "fifo")) > 0.50
    assert gain(of(data, "value", None), of(data, "value", CLASS_BLIND)) > 0.06
    assert gain(of(data, "skills3", None), of(data, "skills3", CLASS_BLIND)) > 0.15
    assert gain(of(data, "skills3_burst", None), of(data, "skills3_burst", CLASS_BLIND)) > 0.10


@pytest.mark.parametrize("level", LEVELS)
def test_no_planner_is_ahead_of_the_one_that_is_guided(data, level):
    guided, best_alone = named(data, level, "guided_beam"), of(data, level, ALONE)
    assert of(data, level, PLANNERS)["label"] == "guided_beam"
    if level.startswith("skills3"):
        assert ahead(value(guided), value(best_alone))[1] > 0.0


@pytest.mark.parametrize(("level", "least"), [("skills3", 0.135), ("skills3_burst", 0.10)])
def test_a_beam_that_leaves_to_others_is_far_ahead_of_class_blind_rules(data, level, least):
    planner = of(data, level, ALONE)
    assert planner["label"] == "price_beam"
    assert gain(planner, of(data, level, CLASS_BLIND)) > least
    assert ahead(value(planner), value(named(data, level, "price")))[1] > 0.0


@pytest.mark.parametrize("name", ["price_beam", "index"])
def test_on_skills3_two_robots_are_always_at_work_and_the_third_waits_for_what_comes(data, name):
    first, second, third = named(data, "skills3", name)["utilisation"]
    assert 0.965 < second < first < 0.995
    assert 0.7 < third < 0.8


@pytest.mark.parametrize("level", LEVELS)
def test_an_index_learned_from_reward_comes_up_to_the_best_planner(data, level):
    assert gain(named(data, level, "index"), of(data, level, PLANNERS)) > -0.02


@pytest.mark.parametrize("level", ["skills3", "skills3_burst"])
def test_longer_returns_bring_more_where_a_robot_leaves_to_others(data, level):
    """In every seed."""
    short, long = (by_seed(data, named(data, level, name)) for name in ("residual_ppo", "residual_ppo_long"))
    assert len(long) == 5
    assert min(one.mean() for one in long) > max(one.mean() for one in short)


@pytest.mark.parametrize("level", sorted({*LEVELS} - {"skills3_burst"}))
def test_every_seed_of_residual_ppo_comes_up_to_the_best_planner(data, level):
    """To the best that nobody guides, and to the guided one too, on skills3 with the longer returns."""
    seeds = by_seed(data, named(data, level, "residual_ppo"))
    assert len(seeds) == 5
    assert all(ahead(one, value(of(data, level, ALONE)))[0] > -0.02 for one in seeds)
    best_of = by_seed(data, named(data, level, "residual_ppo_long")) if level == "skills3" else seeds
    assert all(ahead(one, value(of(data, level, PLANNERS)))[0] > -0.02 for one in best_of)


def test_each_of_five_seeds_on_skills3_burst_is_ahead_of_price_and_of_the_robots_own_planner(data):
    seeds = by_seed(data, named(data, "skills3_burst", "residual_ppo"))
    assert len(seeds) == 5
    for one in seeds:
        assert ahead(one, value(named(data, "skills3_burst", "price")))[1] > 0.0
        assert ahead(one, value(named(data, "skills3_burst", "beam")))[1] > 0.0


def test_every_search_for_an_index_on_skills3_burst_is_ahead_of_every_planner_that_nobody_guides(data):
    searches = by_seed(data, named(data, "skills3_burst", "index_searched"))
    planner = value(of(data, "skills3_burst", ALONE))
    assert len(searches) == 5
    for one in (value(named(data, "skills3_burst", "index")), *searches):
        assert ahead(one, planner)[1] > 0.0


def test_every_seed_on_value_takes_most_of_what_the_planner_has_over_the_rule(data):
    row, atc, beam = (named(data, "value", name) for name in ("residual_ppo", "atc", "beam"))
    assert row["throws"] == 500_000
    for one in by_seed(data, row):
        assert ahead(one, value(atc))[0] > 0.6 * gain(beam, atc)


@pytest.mark.parametrize("level", ["skills3", "skills3_burst"])
def test_where_skills_differ_leaving_to_others_beats_every_robots_own_planner(data, level):
    price = named(data, level, "price")
    assert gain(price, of(data, level, CLASS_BLIND)) > 0.05
    assert gain(price, of(data, level, ("beam", "joint_beam"))) > 0.02


@pytest.mark.parametrize("level", LEVELS)
def test_what_begins_as_the_rule_is_ahead_of_what_begins_as_nothing(data, level):
    """In every seed, after as many decisions."""
    plain = max(one.mean() for one in by_seed(data, named(data, level, "maskable_ppo")))
    assert min(one.mean() for one in by_seed(data, named(data, level, "residual_ppo"))) > plain


@pytest.mark.parametrize("level", LEVELS)
def test_what_begins_as_nothing_stays_behind_a_rule_where_there_is_little_to_gain(data, level):
    behind = gain(named(data, level, "maskable_ppo"), of(data, level, CLASS_BLIND)) < 0.0
    assert behind == (level in {"single", "speed", "line3"})


def test_tables_stand_in_for_throws_within_four_percent():
    rows = [row for row in read("line")["rows"] if row["part"] != "release"]
    assert len(rows) == 21
    for row in rows:
        full, by_table = (row[throws]["value_per_min"]["value"] for throws in ("full", "table"))
        assert full == pytest.approx(by_table, rel=0.04), (row["level"], row["controller"])


def test_a_learned_release_and_a_learned_order_keep_their_worth_beside_each_other():
    rows = [row for row in read("line")["rows"] if row["part"] == "release"]
    value = {(row["release"], row["order"]): row["value_per_min"]["value"] for row in rows}
    for order in ("fifo", "atc", "residual_ppo"):
        assert 1.1 < value["learned", order] / value["analytic", order] < 1.25
    for release in ("analytic", "learned"):
        assert value[release, "residual_ppo"] / value[release, "fifo"] > 1.6
