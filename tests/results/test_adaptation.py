"""What the benchmark of shifts and the study of adapting found, held to what the pages say of it."""

import json

import numpy as np
import pytest
import yaml

from agents.ground.places import SHIPPED as ROOT
from pnt_gym.cells.conveyor.config import ConveyorConfig


def read(name):
    return json.loads((ROOT / "results" / f"{name}.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def table():
    return {(row["controller"], row["level"]): row for row in read("benchmark_adapt")["table"]}


@pytest.fixture(scope="module")
def cameras():
    rows = [row for row in read("adaptation")["rows"] if row["part"] == "camera"]
    return {(row["camera"], row["controller"]): row["error_m"]["value"] for row in rows}


@pytest.fixture(scope="module")
def kinds():
    rows = [row for row in read("adaptation")["rows"] if row["part"] == "newcomers"]
    return {(row["kind"], row["controller"]): row for row in rows}


@pytest.mark.parametrize("level", ["day", "drift_mix"])
def test_who_adapts_comes_closer_and_who_knows_comes_closest(table, level):
    names = ("static", "recursive_ridge", "ema", "in_context", "oracle_drift")
    errors = [table[name, level]["landing_error_mean_m"] for name in names]
    assert errors == sorted(errors, reverse=True)
    assert table["kalman", level]["landing_error_mean_m"] < table["ema", level]["landing_error_mean_m"]


def test_the_millimetres_that_were_asked_for_on_day(table):
    most = {"static": 17.5, "ema": 13.0, "kalman": 12.0, "in_context": 12.5}
    for name, millimetres in most.items():
        assert 1000 * table[name, "day"]["landing_error_mean_m"] <= millimetres, name
    adapting = ("kalman", "in_context", "oracle_drift")
    late = {name: table[name, "day"]["landing_error_second_half_m"] for name in adapting}
    assert max(late.values()) <= 0.0115
    assert late["kalman"] <= 1.05 * late["oracle_drift"]


def test_the_millimetres_that_were_asked_for_on_drift_mix(table):
    for name, millimetres in {"static": 21.0, "kalman": 14.5, "in_context": 14.5}.items():
        assert 1000 * table[name, "drift_mix"]["landing_error_mean_m"] <= millimetres, name


def test_without_drift_adapting_costs_less_than_a_millimetre(table):
    still = table["static", "waste"]["landing_error_mean_m"]
    for name in ("ema", "kalman", "in_context"):
        assert table[name, "waste"]["landing_error_mean_m"] <= still + 0.001, name


def test_success_does_not_see_drift(table):
    rates = [table[name, "day"]["success_rate"] for name in ("static", "ema", "kalman", "in_context", "oracle_drift")]
    assert max(rates) - min(rates) < 0.03


@pytest.mark.parametrize(("level", "shifts"), [("day", 32), ("drift_mix", 256)])
def test_five_seeds_and_so_many_shifts_stand_behind_each_line(table, level, shifts):
    for name in ("static", "ema", "kalman", "in_context", "oracle_drift"):
        assert table[name, level]["seeds"] == [0, 1, 2, 3, 4]
        assert table[name, level]["shifts"] == shifts


def test_so_many_shifts_of_drift_mix_tell_the_mean_to_a_quarter_of_a_millimetre(table):
    for name in ("kalman", "in_context"):
        row = table[name, "drift_mix"]
        assert 0.0 < row["landing_error_high_m"] - row["landing_error_low_m"] < 2 * 0.00025, name


@pytest.mark.parametrize("name", ["kalman", "in_context"])
def test_the_first_shifts_of_drift_mix_are_hard_ones(table, name):
    results = read("benchmark_adapt")["results"]
    found = [one["columns"] for one in results if (one["label"], one["level"]) == (name, "drift_mix")]
    columns = [np.array([one[c][: 32 * 50] for one in found], dtype=float) for c in ("along_m", "across_m")]
    assert len(found) == 5
    assert np.nanmean(np.hypot(*columns)) == pytest.approx(0.0150, abs=0.0001)


@pytest.mark.parametrize("level", ["steps", "day_far", "steps_far", "drift_mix_far"])
def test_on_other_drifts_than_they_learned_those_that_adapt_stay_between_static_and_oracle(table, level):
    names = ("static", "recursive_ridge", "ema", "kalman", "oracle_drift")
    errors = [table[name, level]["landing_error_mean_m"] for name in names]
    assert errors == sorted(errors, reverse=True)
    assert table["in_context", level]["landing_error_mean_m"] < table["kalman", level]["landing_error_mean_m"] + 0.0005


def test_what_reinforcement_learns_takes_back_more_than_half_of_what_kalman_does(table):
    error = {name: table[name, "day"]["landing_error_mean_m"] for name in ("static", "recurrent_ppo", "kalman")}
    assert 0.5 < (error["static"] - error["recurrent_ppo"]) / (error["static"] - error["kalman"]) < 0.6
    assert len(table["recurrent_ppo", "day"]["seeds"]) == 5
    for level in ("steps", "day_far"):
        errors = [table[name, level]["landing_error_mean_m"] for name in ("static", "recurrent_ppo", "kalman")]
        assert errors == sorted(errors, reverse=True), level


def test_sac_with_a_stack_gains_nothing_on_the_static_policy(table):
    assert table["sac", "day"]["landing_error_mean_m"] > 0.98 * table["static", "day"]["landing_error_mean_m"]


def test_twice_the_drift_costs_who_adapts_a_quarter_of_what_it_costs_who_does_not(table):
    def cost(name):
        return table[name, "day_far"]["landing_error_mean_m"] - table[name, "day"]["landing_error_mean_m"]

    assert cost("static") > 0.007
    for name in ("kalman", "in_context"):
        assert 0.0 < cost(name) < 0.25 * cost("static"), name
    for name in ("ema", "kalman", "in_context"):
        more = table[name, "steps"]["landing_error_mean_m"] - table[name, "day"]["landing_error_mean_m"]
        assert 0.0005 < more < 0.0015, name


def test_a_worse_camera_over_the_bins_is_worth_less(cameras):
    for who in ("ema", "kalman", "in_context"):
        errors = [cameras[name, who] for name in ("exact", "10 mm", "20 mm")]
        assert errors == sorted(errors), who
    kalman = {camera: error for (camera, who), error in cameras.items() if who == "kalman"}
    assert 0.001 < kalman["20 mm"] - kalman["5 mm"] < 0.0014
    assert 0.0003 < kalman["5 mm, 30 % unseen"] - kalman["5 mm"] < 0.0007
    assert kalman["20 mm"] < min(cameras["20 mm", who] for who in ("ema", "in_context"))
    assert kalman["blind"] == pytest.approx(cameras["blind", "ema"], rel=1e-9)
    assert kalman["blind"] == pytest.approx(cameras["blind", "static"], rel=0.03)


@pytest.mark.parametrize("kind", ["wet_paper", "sticky_pot"])
@pytest.mark.parametrize("who", ["ema", "kalman", "in_context"])
def test_three_throws_take_most_of_what_a_new_kind_is_off_by(kinds, kind, who):
    static, learner = kinds[kind, "static"], kinds[kind, who]
    assert min(static["error_m"]) > 2.5 * static["floor_m"]
    assert learner["error_m"][3] < 1.25 * learner["floor_m"]
    assert learner["regret_m"] < 0.2 * static["regret_m"]


@pytest.mark.parametrize("kind", ["pet_half_full", "wet_paper", "sticky_pot"])
@pytest.mark.parametrize(("who", "most"), [("ema", 5), ("kalman", 3), ("in_context", 3)])
def test_so_many_throws_bring_a_new_kind_near_its_floor(kinds, kind, who, most):
    assert kinds[kind, who]["throws_to_floor"] <= most


@pytest.mark.parametrize("who", ["ema", "kalman", "in_context"])
def test_known_kinds_do_not_feel_the_new_ones(kinds, who):
    assert kinds["wet_paper", who]["known_mean_m"] < kinds["wet_paper", "static"]["known_mean_m"] + 0.0004


def test_the_level_on_the_page_is_one():
    page = (ROOT / "docs" / "drift.md").read_text(encoding="utf-8")
    text = page.split("```yaml\n")[1].split("```")[0]
    config = ConveyorConfig.load(yaml.safe_load(text))
    assert config.drift.moves
    assert (config.feedback.noise, config.picks_per_shift) == (0.010, 100)
