"""Cards of published policies: what hubs read, and what of a training is drawn."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from agents.judging.shift_trial import ShiftTrial
from agents.judging.throw_record import CARD
from agents.judging.throw_trial import ThrowTrial
from agents.publish.card import PARTS, card, curve, metadata

ASKED: dict[str, Any] = {
    "env": "theirs:Own-v0", "level": "x", "algo": "tqc", "steps": 500, "seed": 3, "action_mode": "aim|<b>",
    "stack": 1, "over": "analytic", "fidelity": "full", "full_last": 0,
}  # fmt: skip


def figures(reward: float) -> dict[str, Any]:
    throws = [{"reward": reward}, {"reward": reward + 0.2}]
    rates = {"success_rate": 0.98765, "success_low": 0.9, "success_high": 1.0, "sorted_per_min": 60.71234}
    errors = {"landing_error_mean_m": 0.01234, "landing_error_p95_m": 0.0333, "landing_near_share": 0.925}
    return {"picks": 2, "seed": 7, "throws": throws, **rates, **errors}


FIGURES = {"waste": figures(0.5), "unseen": figures(0.7)}


def test_hubs_find_policy_task_licence_and_figures() -> None:
    told = metadata(ASKED, FIGURES, CARD)
    names = ("library_name", "pipeline_tag", "license")
    assert [told[name] for name in names] == ["stable-baselines3", "reinforcement-learning", "mit"]
    assert {"reinforcement-learning", "stable-baselines3", "pnt_gym", "Own-v0", "tqc"} <= set(told["tags"])
    (model,) = told["model-index"]
    assert model["name"] == "TQC"
    assert [result["dataset"]["config"] for result in model["results"]] == ["waste", "unseen"]
    for result, reward in zip(model["results"], ("0.60 +/- 0.10", "0.80 +/- 0.10"), strict=True):
        assert result["task"]["type"] == "reinforcement-learning"
        assert result["dataset"]["type"] == "Own-v0"
        assert all(set(metric) == {"type", "value", "name", "verified"} for metric in result["metrics"])
        assert not any(metric["verified"] for metric in result["metrics"])
        assert {metric["type"]: metric["value"] for metric in result["metrics"]} == {
            "mean_reward": reward,
            "success_rate": 0.9877,
            "landing_error_mean_m": 0.0123,
            "sorted_per_min": 60.7123,
        }


def test_a_card_names_what_is_there_and_nothing_else() -> None:
    whole = card(ASKED, "home", FIGURES, "Own-v0-home-tqc-seed3", {*PARTS, "replay.mp4", "curve.png"}, ThrowTrial)
    bare = card(ASKED, "home", FIGURES, "Own-v0-home-tqc-seed3", {"policy.npz", "curve.png"}, ThrowTrial)
    assert yaml.safe_load(whole.split("---\n")[1]) == metadata(ASKED, FIGURES, CARD)
    assert "# TQC on theirs:Own-v0, level home\n" in whole
    assert "| waste | 12.3 mm | 33.3 mm | 92.5 % | 98.8 % (90.0..100.0) | 60.7 |" in whole
    assert "2 held-out throws per level (seed 7)" in whole
    assert r"aim\|\<b>" in whole
    for file in (*PARTS, "replay.mp4"):
        assert (f"`{file}`" in whole) == (file in PARTS)
        assert (file in bare) == (file == "policy.npz")
    assert "(replay.mp4)" in whole
    assert "\n\n\n" not in whole + bare


def test_a_card_tells_what_stands_between_the_policy_and_the_cell() -> None:
    plain, between = (
        card(ASKED | more, "home", FIGURES, "x", set(), ThrowTrial) for more in ({}, {"stack": 8, "over": "ema"})
    )
    assert "It sees the last 8 observations of a shift, oldest first. Its action is added to that of `ema`." in between
    assert "observations of a shift" not in plain
    assert "added to" not in plain


def test_a_card_tells_that_a_policy_learned_from_flights_alone() -> None:
    flown, mostly = ({"fidelity": "flight", "full_last": last} for last in (0, 100))
    told = ["flights" in card(ASKED | more, "home", FIGURES, "x", set(), ThrowTrial) for more in ({}, flown, mostly)]
    assert told == [False, True, False]


def test_the_curve_is_that_of_the_training(tmp_path: Path) -> None:
    rows = np.array([[256, 1.5, 0.25, 0.1, 0.3], [512, 3.0, 0.5, np.nan, 0.4], [600, 3.9, 0.75, 0.05, 0.5]])
    np.savetxt(tmp_path / "progress.csv", rows, delimiter=",", header="throws,...", comments="")
    left, right = curve(tmp_path / "progress.csv", ThrowTrial).axes
    np.testing.assert_allclose(left.lines[0].get_xydata(), rows[:, [0, 2]] * [1, 100])
    np.testing.assert_allclose(right.lines[0].get_xydata(), rows[:, [0, 3]] * [1, 1000])
    assert left.get_ylim()[0] == right.get_ylim()[0] == 0.0
    assert (left.get_ylabel(), right.get_ylabel()) == ("success [%]", "landing error, mean [mm]")
    left, right = curve(tmp_path / "progress.csv", ShiftTrial).axes
    np.testing.assert_allclose(right.lines[0].get_xydata(), rows[:, [0, 3]])
    assert (left.get_xlabel(), right.get_ylabel()) == ("decisions", "value per minute")
