"""What the study of the order of picks found, held to what the levels say."""

import json

import pytest

from agents.places import SHIPPED as ROOT
from pnt_gym.cells.conveyor.config import ConveyorConfig


@pytest.fixture(scope="module")
def study():
    return json.loads((ROOT / "results" / "dispatch.json").read_text(encoding="utf-8"))


def test_the_default_patience_is_the_tuned_one(study):
    assert ConveyorConfig.model_fields["patience"].default == study["best_patience"]
    assert ConveyorConfig.load("dense").patience == study["best_patience"]


def test_on_a_dense_belt_the_shipped_rule_picks_a_tenth_more_than_the_first(study):
    found = study["dispatch"]["dense"][ConveyorConfig.load("dense").dispatch]
    assert found["picks_per_min_gain"]["value"] >= 0.10
    assert found["sorted_per_min_gain"]["low"] > 0.0
    assert 1.5 < study["dispatch"]["dense"]["first"]["passed_per_pick"]["value"] < 3.0
