"""What the study of neighbours found, held to what the pages and the issue say."""

import json

import pytest

from agents.ground.places import SHIPPED as ROOT


@pytest.fixture(scope="module")
def study():
    rows = json.loads((ROOT / "results" / "neighbours.json").read_text(encoding="utf-8"))["rows"]
    return {(row["gap"], row["speed"], row["hand"], row["neighbours"]): row for row in rows}


@pytest.mark.parametrize("gap", ["centre", "edge"])
@pytest.mark.parametrize("neighbours", ["ghosts", "solid"])
def test_a_hand_that_rides_slips_less_than_a_millimetre(study, gap, neighbours):
    for speed in (0.25, 0.8):
        standing, riding = (study[gap, speed, hand, neighbours] for hand in ("stands", "rides"))
        assert standing["slip_mean_m"] == pytest.approx(0.1 * speed, rel=0.01)
        assert riding["slip_p95_m"] < 1e-3
        assert riding["disturbed"]["value"] <= standing["disturbed"]["value"]


@pytest.mark.parametrize("gap", ["centre", "edge"])
@pytest.mark.parametrize("hand", ["stands", "rides"])
def test_picks_that_touch_nobody_are_found_on_a_fast_belt(study, gap, hand):
    ghosts, solid = (study[gap, 0.8, hand, which] for which in ("ghosts", "solid"))
    assert solid["disturbed"]["value"] < 0.3 * ghosts["disturbed"]["value"]
    assert solid["picks_per_min_interval"]["value"] > 0.95 * ghosts["picks_per_min_interval"]["value"]
