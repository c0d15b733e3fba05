"""What the benchmark found, held to what was asked of learning."""

import json

import pytest

from agents.ground.places import SHIPPED as ROOT


@pytest.fixture(scope="module")
def table():
    data = json.loads((ROOT / "results" / "benchmark.json").read_text(encoding="utf-8"))
    return {(row["label"], row["throws"], row["level"]): row for row in data["table"]}


@pytest.mark.parametrize(("level", "most"), [("waste", 1.2), ("unseen", 1.25)])
def test_sac_comes_this_near_to_the_floor(table, level, most):
    row = table["sac", 10000, level]
    assert row["times_floor"] <= most
    assert len(row["seeds"]) == 10


@pytest.mark.parametrize("level", ["waste", "unseen"])
def test_from_ten_thousand_throws_sac_makes_more_than_ridge_does_of_a_thousand(table, level):
    assert table["sac", 10000, level]["landing_error_mean_m"] < table["ridge", 1000, level]["landing_error_mean_m"]
