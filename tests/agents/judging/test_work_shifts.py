"""How controllers of a line are judged: by command, from Python, and on the same streams."""

from io import StringIO

import gymnasium as gym
import numpy as np
import pytest
from rich.console import Console

from agents.dispatchers import registry
from agents.dispatchers.rules import IndexRule
from agents.ground.cli import UsageError
from agents.ground.files import json_text
from agents.judging import losses, trials
from agents.judging.evaluation import evaluate
from agents.judging.losses import Counted, Fates
from agents.judging.shift_record import ShiftRecord
from agents.judging.shifts import Shifts, run_shifts
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.observation import decoded
from pnt_gym.reading import parsed_json
from tests.tools.commands import figures_of
from tests.tools.line import vector_lines

LEVEL = {"base": "value", "duration": 10.0}
CONTRACT = {
    "env", "controller", "level", "seed", "picks", "picks_per_min", "sorted_per_min", "success_rate", "success_low",
    "success_high", "cycle_time_mean_s", "dwell_s", "throws", "recovery", "purity", "pick_rate", "value_per_min",
    "utilisation",
}  # fmt: skip


def test_the_command_writes_the_contract_and_a_picture(tmp_path):
    (tmp_path / "short.yaml").write_text("base: skills3\nduration: 6.0\n")
    line = "evaluate --env PnTLine-v0 --level short.yaml --controller price --shifts 3 --num-envs 2 --picture who.svg"
    told = figures_of(line, tmp_path)
    assert set(told) >= CONTRACT
    assert told["shifts"] == len(told["by_shift"]["value_per_min"]) == 3
    assert len(told["throws"]) == told["picks"]
    assert {one["shift"] for one in told["throws"]} == {0, 1, 2}
    assert len(told["utilisation"]) == len(told["robots"]) == 3
    sorted_ = sum(one["sorted"] and one["start"] + one["cycle_time"] <= 6.0 for one in told["throws"])
    assert sorted_ == sum(told["by_shift"]["sorted"])
    assert (tmp_path / "who.svg").read_text().startswith("<?xml")


def test_the_first_shifts_of_many_are_those_of_few():
    few, many = (run_shifts(IndexRule("atc", "atc"), vector_lines(LEVEL)[0], count, 5) for count in (4, 9))
    np.testing.assert_array_equal(few.value, many.value[:4])
    assert len(many.value) == 9


def by_hand():
    """Two shifts of ten seconds at `skills3`, of seven decisions in all."""
    both = {
        "value_per_min": [12.0, 6.0], "sorted_per_min": [18.0, 6.0], "recovery": [0.5, 0.25],
        "value_recovery": [0.4, 0.2], "purity": [0.75, np.nan], "passed_value_per_min": [30.0, 10.0],
        "passed_tried": [0.2, np.nan], "utilisation": [[1.0, 0.5, 0.0], [0.5, 0.5, 0.0]],
        "picks_by_robot": [[3, 1, 0], [1, 2, 0]],
        "recovery_by_item": [[0.5, np.nan, 1.0, 0.0], [0.1, np.nan, 0.0, 0.0]],
        "passed_by_item": [[2, 0, 0, 1], [0, 0, 4, 1]], "passed_tried_by_item": [[1, 0, 0, 0], [0, 0, 1, 0]],
        "out_of_reach_by_item": [[0, 0, 0, 0], [0, 0, 2, 0]],
        "sorted_by_item": [[1, 0, 2, 0], [1, 0, 0, 0]], "misplaced_by_item": [[1, 0, 0, 0], [0, 0, 0, 0]],
        "on_floor_by_item": [[0, 0, 0, 0], [0, 1, 0, 0]],
    }  # fmt: skip
    decisions = {
        "shift": [0, 0, 0, 0, 1, 1, 1], "by": [0, 0, 1, 0, 0, 1, 1], "object": range(7), "item": [2, 0, 0, 0, 2, 0, 1],
        "true_kind": [2, 2, 0, 0, 2, 0, 1], "bin": [0, 1, 1, 1, 0, 1, 2], "percent": [40.0] * 7,
        "start": [0.0, 2.0, 3.0, 9.5, 0.0, 1.0, 2.0], "cycle_time": [1.0] * 7,
        "wait_time": [0.1, 0.3, 0.0, 0.4, 0.0, 0.6, 0.0], "value": [1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0],
        "picked": [1, 1, 1, 1, 0, 1, 1], "is_success": [1, 1, 1, 1, 0, 1, 0], "sorted": [1, 0, 1, 1, 0, 1, 0],
        "ended_in": [0, 1, 1, 1, -1, 1, -1],
    }  # fmt: skip
    told = {f"shift_{name}": np.array(values) for name, values in both.items()}
    return Shifts(told, {name: np.array(values) for name, values in decisions.items()}, 2, 10, 0.05)


def summary_by_hand():
    """Their figures."""
    _, core = vector_lines({"base": "skills3", "duration": 10.0}, 1)
    return ShiftRecord(by_hand(), core, {}).summary()


def test_figures_of_shifts_by_hand():
    found = summary_by_hand()
    assert (found["shifts"], found["picks"], found["picks_per_min"]) == (2, 7, 21.0)
    assert (found["value_per_min"], found["sorted_per_min"], found["recovery"]) == (9.0, 12.0, 0.375)
    assert (found["purity"], found["passed_value_per_min"], found["passed_tried"]) == (0.75, 20.0, 0.2)
    assert found["recovery_by_item"] == [0.3, None, 0.5, 0.0]
    assert found["passed_by_item"] == [1.0, 0.0, 2.0, 1.0]
    assert found["utilisation"] == [0.75, 0.5, 0.0]
    assert found["picks_by_robot"] == [2.0, 1.5, 0.0]
    assert found["wait_by_robot_s"] == [pytest.approx(0.2), pytest.approx(0.2), None]
    assert found["wait_time_mean_s"] == pytest.approx(0.2)
    assert (found["pick_rate"], found["success_rate"]) == (pytest.approx(6 / 7), pytest.approx(5 / 7))
    assert (found["ms_per_decision"], found["invalid_actions"]) == (pytest.approx(5.0), 2)
    # The third throw into the first robot's trays ends after the shift.
    assert found["purity_by_bin"] == {"first/paper": 1.0, "first/trays": 0.0, "second/trays": 1.0}


@pytest.mark.usefixtures("desk")  # a table that somebody counted in the working folder would split the misses
def test_every_object_has_one_fate():
    found = summary_by_hand()
    counts = {"sorted": 4, "misplaced": 1, "missed": 1, "lost": 0, "unsealed": 2, "passed": 4, "out_of_reach": 2}
    assert found["fates"] == {name: pytest.approx(count / 14) for name, count in counts.items()}
    assert (found["simulated"], found["fates_split"], found["energy_per_pick_j"]) == (False, False, None)
    assert found["fates_by_item"]["tray"] == {
        "sorted": 0.4, "misplaced": 0.2, "missed": 0.0, "lost": 0.0, "unsealed": 0.2, "passed": 0.2,
        "out_of_reach": 0.0,
    }  # fmt: skip
    assert found["fates_by_item"]["can"]["missed"] == 1.0


def test_counted_throws_split_what_a_table_cannot_tell():
    shifts = by_hand()
    nothing = np.zeros(4, dtype=np.int64)
    counted = Counted(
        held=nothing + 9, missed=nothing + 1, lost=nothing + 2, strayed=nothing + 1, percent=np.array([40.0]),
        energy=np.array([[10.0], [20.0], [30.0], [np.nan]]), landings=(np.zeros((0, 2)),) * 4,
    )  # fmt: skip
    fates = Fates.of(shifts, LineConfig.load("skills3"), counted)
    assert fates.splits
    assert fates.counts.sum(axis=0)[1].tolist() == [0.0, 0.25, 0.25, 0.5, 0.0, 0.0, 0.0]
    assert fates.counts.sum() == 14.0
    energy = losses.energy(shifts, counted)
    # Three papers of 30 J, three trays of 10 J and a can of 20 J; four objects were sorted.
    assert (energy["energy_per_pick_j"], energy["energy_per_sorted_j"]) == pytest.approx((20.0, 35.0))
    assert energy["energy_per_sorted_j_low"] <= 35.0 <= energy["energy_per_sorted_j_high"]
    assert Counted.from_json(parsed_json(json_text(counted.as_json()))).energy[:3].tolist() == [[10.0], [20.0], [30.0]]


def test_simulated_throws_tell_causes_and_energy():
    level = {"base": "skills3", "duration": 8.0, "throws": "flight", "cell": {"limits": {"percent": [60]}}}
    _, core = lines = vector_lines(level)
    record = trials.of(lines[0]).run(registry.make("atc", core), 4, 0)
    found, throws = record.summary(), record.shifts.decisions
    assert (found["simulated"], found["fates_split"]) == (True, True)
    in_time = throws["start"] + throws["cycle_time"] <= 8.0
    floor = in_time & throws["picked"] & (throws["ended_in"] < 0)
    arrived = sum(found["by_shift"]["objects"])
    assert floor.sum() == sum(found["by_shift"]["on_floor"]) > 0
    assert found["fates"]["lost"] * arrived == pytest.approx((floor & throws["lost"]).sum())
    assert found["fates"]["missed"] * arrived == pytest.approx((floor & ~throws["lost"]).sum())
    assert sum(found["fates"].values()) == pytest.approx(1.0)
    hits = throws["is_success"].astype(bool)
    assert hits.any()
    openings = np.array([bin_.size for bin_ in core.config.cell.bins.fixed])[throws["bin"][hits]]
    miss = np.stack([throws["miss_x"], throws["miss_y"]], axis=1)
    assert (np.abs(miss[hits]) <= openings / 2).all()
    flown = throws["picked"].astype(bool) & ~throws["lost"]
    np.testing.assert_array_equal(np.isfinite(miss).all(axis=1), flown)
    assert found["energy_per_pick_j"] == pytest.approx(np.nanmean(throws["energy"]))


@pytest.mark.usefixtures("desk")
def test_the_table_has_every_figure():
    found = summary_by_hand()
    shown = Console(width=120, record=True, file=StringIO())
    shown.print(ShiftRecord.table("x", found))
    lines_of = [" ".join(line.replace("│", " ").split()) for line in shown.export_text().splitlines()]
    for line in (
        "failed: in a wrong bin 7.1 %",
        "failed: missed the bin, or lost on the way 7.1 %",
        "failed: passed the end, cup did not seal 14.3 %",
        "failed: passed the end, not tried 28.6 %",
        "failed: passed the end, out of reach 14.3 %",
        "tray: recovery, largest loss 40.0 %, 20.0 % in a wrong bin",
        "can: recovery, largest loss 0.0 %, 100.0 % missed the bin, or lost on the way",
        "value that passed the end, per minute 20.0",
        "tried in vain, of what passed it 20.0 %",
        "purity: share of what is in bins, without strays 75.0 %",
        "purity of bin first/trays 0.0 %",
        "robot first: at work, picks in a shift, standstill for each 75.0 %, 2, 0.200 s",
        "robot third: at work, picks in a shift, standstill for each 0.0 %, 0, -",
        "time of a decision 5.00 ms",
    ):
        assert line in lines_of
    assert not any("first/paper" in line or "energy" in line for line in lines_of)
    items = [line.split(":")[0] for line in lines_of if "largest loss" in line]
    assert items == ["can", "yoghurt_cup", "paper_ball", "tray"]  # the worst one first


def test_rules_take_what_their_name_says():
    env, core = vector_lines(LEVEL)
    features, _ = env.reset(seed=2)
    own = decoded(features).choices
    there = own["real"] > 0.5
    for name, key in (("fifo", own["lift"] + own["slack"]), ("spt", own["cycle"]), ("value_rate", -own["ln_rate"])):
        found = registry.make(name, core).act(type("Seen", (), {"features": features}))
        np.testing.assert_array_equal(found, np.where(there, key, np.inf).argmin(axis=1))


def test_price_leaves_to_others_what_they_can_take():
    env, _ = vector_lines({"base": "skills3", "duration": 10.0})
    features, _ = env.reset(seed=2)
    own = decoded(features)
    plain, leaving = (IndexRule("price", "atc", 1.0, share).worth(own) for share in (0.0, 0.5))
    shared = (own.choices["heirs"] > 0.5) & (own.choices["real"] > 0.5)
    assert shared.any()
    np.testing.assert_allclose(leaving[shared], 0.5 * plain[shared])
    np.testing.assert_array_equal(leaving[~shared], plain[~shared])


def test_a_learned_release_goes_on_the_line(tmp_path):
    (tmp_path / "short.yaml").write_text("base: single\nduration: 5.0\n")
    line = "evaluate --env PnTLine-v0 --level short.yaml --controller atc --shifts 1 --num-envs 1 --throws flight"
    told = [figures_of(f"{line} --release {release}", tmp_path) for release in ("analytic", "random")]
    assert [one["release"] for one in told] == ["analytic", "random"]
    assert told[0]["throws"][0]["start"] == told[1]["throws"][0]["start"]


def test_from_python_by_name_and_by_function():
    how = {"level": {"base": "single", "duration": 5.0}, "num_envs": 2}
    told = evaluate("atc", "PnTLine-v0", 3, **how)
    assert (told["env"], told["controller"], told["shifts"]) == ("PnTLine-v0", "atc", 3)
    first = evaluate(lambda observations: np.zeros(len(observations)), "PnTLine-v0", 3, **how)
    assert first["controller"] == "<lambda>"
    assert first["invalid_actions"] == 0


class Model:
    """A model as of sb3-contrib, which takes the first choice that its masks leave."""

    observation_space, action_space = gym.spaces.Box(-5.0, 5.0, (301,)), gym.spaces.Discrete(16)

    def predict(self, features, deterministic=False, action_masks=None):
        assert deterministic
        return np.argmax(action_masks, axis=1), None


def test_a_model_chooses_within_its_masks():
    told = evaluate(Model(), "PnTLine-v0", 2, level={"base": "single", "duration": 5.0}, num_envs=2)
    assert (told["controller"], told["invalid_actions"]) == ("model", 0)


def test_shifts_that_are_cut_short_are_no_shifts():
    env = gym.make_vec("PnTLine-v0", num_envs=2, level="value", max_episode_steps=5)
    with pytest.raises(UsageError, match="max_episode_steps ends work shifts early; leave max_episode_steps out"):
        evaluate("value_rate", env, picks=2)
