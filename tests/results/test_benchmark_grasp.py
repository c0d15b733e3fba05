"""Guards of committed numbers: what docs/grasp.md says of places, networks, paces and tries."""

import pytest

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT

DATA = read_json(ROOT / "results" / "benchmark_grasp.json")
PACE = {(row["level"], row["label"]): row["sorted_per_min"] for row in DATA["table"]}
SHARE = {(row["level"], row["label"]): row["success_rate"] for row in DATA["table"]}
SEEDS = ("", "_seed_1", "_seed_2")
NETWORKS = tuple(f"local_mlp{seed}" for seed in SEEDS)


def gain(learned: str, reference: str, level: str = "grasp") -> dict[str, float]:
    """The paired difference of two rows in sorted objects per minute."""
    (row,) = (
        row
        for row in DATA["comparisons"]
        if (row["level"], row["learned"]["label"], row["reference"]["label"]) == (level, learned, reference)
    )
    return row["sorted_per_min"]


def test_the_level_is_as_hard_as_meant() -> None:
    rule = PACE["grasp", "flattest"]
    assert rule > 1.03 * PACE["grasp", "centre"]
    assert gain("true_surface", "flattest")["value"] > 0.05 * rule
    assert gain("true_surface", "flattest")["low"] > 0.03 * rule
    assert PACE["grasp", "flattest_naive"] < PACE["grasp", "centre"]


@pytest.mark.parametrize("network", NETWORKS)
def test_each_network_beats_the_tuned_rule(network: str) -> None:
    assert gain(network, "flattest")["low"] > 0.03 * PACE["grasp", "flattest"]


def test_colours_mislead_on_kinds_that_no_network_saw() -> None:
    coloured = [f"{name}{seed}" for name in ("local_mlp", "fitted_q") for seed in SEEDS]
    assert max(PACE["grasp_unseen", network] for network in coloured) < PACE["grasp_unseen", "flattest"]
    assert not any(gain(network, "flattest", "grasp_unseen")["low"] > 0.0 for network in coloured)
    assert all(gain(f"fitted_q{seed}", "flattest", "grasp_unseen")["high"] < 0.0 for seed in SEEDS)


def test_a_network_of_depths_is_at_least_the_tuned_rules_equal_on_unseen_kinds() -> None:
    assert gain("local_mlp_depth", "flattest", "grasp_unseen")["low"] > -1.0
    assert gain("local_mlp_depth", "centroid", "grasp_unseen")["low"] > 0.0


def test_the_oracle_is_far_above_all_others() -> None:
    for (level, label), pace in PACE.items():
        assert label == "oracle_grasp" or pace < PACE[level, "oracle_grasp"] - 5.0


def test_no_fixed_pace_reaches_the_pace_by_the_gauge() -> None:
    fixed = [PACE["grasp", f"local_mlp_pace_{pace}"] for pace in (0.3, 0.45, 0.6)]
    assert gain("local_mlp", "local_mlp_pace_0.45")["low"] > 0.0
    assert max(fixed) < PACE["grasp", "local_mlp"]


def test_a_second_try_at_the_same_place_costs_more_time_than_it_sorts() -> None:
    assert PACE["grasp", "local_mlp_one_try"] > PACE["grasp", "local_mlp_same_place"]
    assert SHARE["grasp", "local_mlp_one_try"] < SHARE["grasp", "local_mlp_same_place"]


def test_a_second_try_elsewhere_sorts_more_than_one_at_the_same_place() -> None:
    for level in ("grasp", "grasp_unseen"):
        assert gain("local_mlp", "local_mlp_same_place", level)["low"] > 0.0
        assert SHARE[level, "local_mlp"] > SHARE[level, "local_mlp_same_place"]


@pytest.mark.parametrize("label", ["fitted_q", "fitted_q_seed_1", "fitted_q_seed_2"])
def test_what_learned_from_rewards_alone_beats_the_tuned_rule(label: str) -> None:
    assert gain(label, "flattest")["low"] > 0.03 * PACE["grasp", "flattest"]
