"""The measurements of the study of places, with few tries."""

import pytest

from agents.results.study import Amount
from benchmarks.studies import grasping

LEARNED = {"kinds": "grasp_unseen", "tries": 300, "seed": 0}


@pytest.mark.parametrize(
    ("measure", "settings"),
    [
        (grasping.place, {"kinds": "grasp", "place": "true surface"}),
        (grasping.network, {**LEARNED, "sees": "depth"}),
    ],
)
def test_each_measurement_gives_shares_of_tries(measure, settings, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("STEPS", "QUICK_STEPS"):
        monkeypatch.setattr(f"agents.grasping.practice.{name}", 20)
    figures = measure(settings, Amount(40, 1))
    assert figures["count"] == 40
    assert 0.0 <= figures["kept"] <= figures["held"] <= 1.0
    assert figures["held_low"] <= figures["held"] <= figures["held_high"]
