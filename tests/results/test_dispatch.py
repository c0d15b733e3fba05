"""What the study of the order of picks found, held to what the levels say."""

import json

import pytest

from agents.ground.places import SHIPPED as ROOT
from pnt_gym.cells.conveyor.config import ConveyorConfig


@pytest.fixture(scope="module")
def study():
    return json.loads((ROOT / "results" / "dispatch.json").read_text(encoding="utf-8"))["rows"]


def test_no_patience_gains_more_than_the_default(study):
    """By more than the tuning tells apart: 0.2 % of picks a minute, on average of the levels."""
    default = ConveyorConfig.model_fields["patience"].default
    assert ConveyorConfig.load("dense").patience == default
    gains: dict[float, list[float]] = {}
    for row in study:
        if row["part"] == "tuning":
            gains.setdefault(row["patience"], []).append(row["gain"])
    mean = {patience: sum(of) / len(of) for patience, of in gains.items()}
    assert [len(of) for of in gains.values()] == [4] * 6
    assert max(mean.values()) - mean[default] < 0.002
    assert mean[default] - min(mean.values()) > 0.01


def test_on_a_dense_belt_the_shipped_rule_picks_a_tenth_more_than_the_first(study):
    dense = {row["rule"]: row for row in study if row["part"] == "dispatch" and row["level"] == "dense"}
    shipped = dense[ConveyorConfig.load("dense").dispatch]
    assert shipped["picks_per_min_gain"]["value"] >= 0.10
    assert shipped["sorted_per_min_gain"]["low"] > 0.0
    assert 1.5 < dense["first"]["passed_per_pick"]["value"] < 3.0
