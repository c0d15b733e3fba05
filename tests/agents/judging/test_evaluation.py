"""Evaluation: exactly the throws asked for, the same objects for everyone, the contract's figures."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from agents.controllers import Observation, Outcome, make_controller
from agents.ground.environments import stream_seed
from agents.ground.files import jsonable
from agents.ground.tables import console
from agents.judging.loop import practise, throw_held_out
from agents.judging.record import summarise
from agents.judging.rows import Rows
from agents.judging.throw_record import ThrowRecord, purity_by_bin, summary
from agents.judging.throws import Throws, live_rows, throw_records
from pnt_gym.arrays import take
from tests.tools.toy_cell import PoseVectorEnv, ToyVectorEnv


class Recorder:
    """Does nothing and remembers what it was shown."""

    name = "recorder"

    def __init__(self, action: float = 0.0, size: int = 2) -> None:
        self.action, self.size = action, size
        self.seen: list[np.ndarray] = []
        self.learned: list[Outcome] = []

    def reset(self, seed: int) -> None:
        self.seen.clear()

    def act(self, observation: Observation) -> np.ndarray:
        self.seen.append(observation.features)
        return np.full((len(observation.kind), self.size), self.action, dtype=np.float32)

    def learn(self, outcome: Outcome) -> None:
        self.learned.append(outcome)


class Student(Recorder):
    def begin_practice(self, throws: int) -> None:
        self.announced = throws

    def end_practice(self) -> None:
        self.ended = True

    def state(self) -> dict[str, np.ndarray]:
        return {}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        pass


@pytest.mark.parametrize("picks", [1, 3, 4, 9])
def test_exactly_the_picks_asked_for(picks: int) -> None:
    told: list[int] = []
    throws = throw_held_out(Recorder(), ToyVectorEnv(4), picks, 0, progress=told.append)
    assert len(throws) == picks == sum(told)
    assert throws.info["target_x"].shape == (picks,)


def test_controllers_meet_the_same_objects() -> None:
    one, two = Recorder(0.0), Recorder(0.7)
    a, b = throw_held_out(one, ToyVectorEnv(4), 40, 3), throw_held_out(two, ToyVectorEnv(4), 40, 3)
    assert np.array_equal(np.concatenate(one.seen), np.concatenate(two.seen))
    assert np.array_equal(a.item, b.item)
    assert not np.array_equal(a.landing_error, b.landing_error)


def test_practice_and_evaluation_never_share_an_object() -> None:
    student = Student()
    env = ToyVectorEnv(4)
    practise(student, env, 40, 0)
    practice = np.concatenate(student.seen)[:, 0]
    student.seen.clear()
    throw_held_out(student, env, 40, 0)
    assert not np.isin(np.concatenate(student.seen)[:, 0], practice).any()


def test_a_practice_that_goes_on_sees_other_objects() -> None:
    parts: list[np.ndarray] = []
    for start in (0, 0, 4):
        student = Student()
        practise(student, ToyVectorEnv(4), 4, seed=3, start=start)
        parts.append(np.concatenate(student.seen))
    np.testing.assert_array_equal(parts[0], parts[1])
    assert (parts[0] != parts[2]).any(axis=1).all()


def test_roles_and_seeds_never_share_a_stream() -> None:
    seeds = {
        stream_seed(role, seed, at)
        for role in ("train", "practice", "evaluate")
        for seed in range(50)
        for at in (0, 2000)
    }
    ordered = np.sort(list(seeds))
    assert len(seeds) == 300
    assert np.diff(ordered).min() > 64  # rows of a vector environment add their index


def test_practice_is_announced_and_learned_from_but_evaluation_is_frozen() -> None:
    student = Student()
    env = ToyVectorEnv(4)
    practise(student, env, 10, 0)
    assert student.announced == 10
    assert student.ended
    assert sum(len(o.error) for o in student.learned) == 10
    throw_held_out(student, env, 8, 0)
    assert sum(len(o.error) for o in student.learned) == 10
    throw_held_out(student, env, 8, 0, online=True)
    assert sum(len(o.error) for o in student.learned) == 18


def test_summary_agrees_with_the_throws() -> None:
    throws = throw_held_out(make_controller("random", ToyVectorEnv(4)), ToyVectorEnv(4), 60, 0)
    figures = summary(throws)
    assert figures["success_rate"] == pytest.approx(throws.is_success.mean())
    assert figures["success_low"] < figures["success_rate"] < figures["success_high"]
    assert figures["landing_error_mean_m"] == pytest.approx(
        np.hypot(throws.info["landing_along"], throws.info["landing_across"]).mean()
    )
    assert figures["picks_per_min"] == pytest.approx(100.0)  # the toy needs 0.6 s a pick
    assert figures["sorted_per_min"] == pytest.approx(100.0 * throws.is_success.mean())
    records = throw_records(throws, ToyVectorEnv(4).core.item_names)
    assert len(records) == 60
    json.dumps({**figures, "throws": records}, allow_nan=False)


def test_failures_sum_to_what_failed() -> None:
    flags = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).astype(bool)
    count = flags.shape[1]
    zeros = np.zeros(count)
    throws = Throws(
        item=np.zeros(count, dtype=np.int64),
        landing_error=zeros,
        is_success=flags[0],
        cycle_time=zeros + 1,
        clipped=zeros.astype(bool),
        reward=zeros,
        info={"recontact": flags[1], "rim": flags[2]},
    )

    def failures(throws: Throws) -> dict[str, float]:
        return {name: part for name, part in summary(throws).items() if name.startswith("failed_")}

    assert sum(failures(throws).values()) == pytest.approx(0.5)
    assert failures(replace(throws, info={"rim": flags[2]})) == {"failed_rim": 0.25, "failed_missed": 0.25}
    assert failures(replace(throws, info={"recontact": flags[1]})) == {"failed_recontact": 0.25}
    assert failures(replace(throws, info={})) == {}


def told_of_five() -> Throws:
    """Sorted; in the wrong bin by its class; fallen into another bin that takes it; not picked; lost on the way."""
    flags = {
        "sorted": [1, 0, 0, 0, 0], "belongs": [1, 0, 1, 0, 0], "picked": [1, 1, 1, 0, 1], "dropped": [0, 0, 0, 0, 1],
        "rim": [0, 0, 0, 0, 0], "recontact": [0, 0, 1, 0, 0],
    }  # fmt: skip
    info: dict[str, np.ndarray] = {name: np.array(values, dtype=bool) for name, values in flags.items()}
    info |= {"ended_in": np.array([0, 1, 1, -1, -1]), "passed": np.array([0, 2, 0, 1, 0])}
    info |= {
        "item": np.zeros(5, dtype=np.int64),
        "landing_error": np.array([0.01, 0.01, 0.3, np.nan, 0.5]),
        "is_success": np.array([True, True, False, False, False]),
        "cycle_time": np.array([1.0, 1.0, 1.0, 0.5, 1.0]),
        "energy": np.array([40.0, 40.0, 40.0, 20.0, 40.0]),
        "residual_clipped": np.zeros(5, dtype=bool),
    }
    return Throws.of(info, np.zeros(5), ())


def test_what_a_sorter_is_judged_by() -> None:
    """Five throws and three objects that nobody took: exact, by hand."""
    figures, throws = summary(told_of_five()), told_of_five()
    assert figures["success_rate"] == pytest.approx(2 / 5)
    assert figures["sorted_per_min"] == pytest.approx(60 / 4.5)
    assert figures["recovery"] == pytest.approx(1 / 8)
    assert figures["objects_passed"] == 3
    assert figures["purity"] == pytest.approx(2 / 3)
    assert figures["pick_rate"] == pytest.approx(4 / 5)
    assert figures["drop_rate"] == pytest.approx(1 / 4)
    assert figures["energy_per_pick_j"] == pytest.approx(36.0)
    assert figures["unmeasured"] == 2
    assert figures["landing_near_share"] == pytest.approx(2 / 3)
    assert figures["landing_error_mean_m"] == pytest.approx(0.32 / 3)
    assert purity_by_bin(throws, ("a", "b", "c")) == {"a": 1.0, "b": 0.5, "c": None}
    assert {name: part for name, part in figures.items() if name.startswith("failed_")} == {
        "failed_unpicked": 0.2, "failed_dropped": 0.2, "failed_recontact": 0.2, "failed_rim": 0.0, "failed_missed": 0.0,
    }  # fmt: skip


def test_a_shift_without_a_pick_has_no_drop_rate_and_no_purity() -> None:
    rows = Rows.of(live_rows(take(told_of_five(), slice(3, 4))))
    names = ("drop_rate", "purity", "pick_rate", "recovery")
    figures = summarise({name: ThrowRecord.shown[name] for name in names}, rows)
    assert figures["drop_rate"] is figures["purity"] is None
    assert (figures["pick_rate"], figures["recovery"]) == (0.0, 0.0)
    json.dumps(figures, allow_nan=False)


def test_unmeasured_landings_become_null_not_nan() -> None:
    throws = throw_held_out(Recorder(), ToyVectorEnv(4), 4, 0)
    throws.landing_error[1] = throws.info["landing_along"][1] = np.nan
    record = throw_records(throws, ToyVectorEnv(4).core.item_names)[1]
    assert record["landing_error_m"] is record["landing_along_m"] is None
    assert summary(throws)["unmeasured"] == 1


def test_json_has_neither_nan_nor_infinity_wherever_they_stand() -> None:
    assert jsonable(np.array([[1.5, np.nan], [-np.inf, 2.0]])) == [[1.5, None], [None, 2.0]]
    assert jsonable(np.float64("nan")) is None
    assert jsonable(["a", True, 3, None, float("inf")]) == ["a", True, 3, None, None]


def test_equal_values_have_equal_texts_however_small_they_were() -> None:
    """A zero that was rounded from below would be written, stored and read as another text than it was found."""
    assert json.dumps(jsonable(np.array([-4e-6, 4e-6, -0.0, -6e-6]), 5)) == "[0.0, 0.0, 0.0, -1e-05]"
    assert json.dumps(jsonable([-0.0, 3, True, "-0.0"])) == '[0.0, 3, true, "-0.0"]'


def test_errors_beyond_the_landing_are_recorded_by_their_names() -> None:
    env = PoseVectorEnv(4)
    throws = throw_held_out(make_controller("analytic", env), env, 6, 0)
    throws.info["error_dy"][2] = np.nan
    records = throw_records(throws, env.core.item_names)
    assert [r["error_phi"] for r in records] == throws.error[:, 2].tolist()
    assert records[2]["error_dy"] is None
    assert np.isnan(throws.error[2, 3])
    toy = ToyVectorEnv(4)
    (record,) = throw_records(throw_held_out(Recorder(), toy, 1, 0), toy.core.item_names)
    assert set(records[0]) - set(record) == set(env.core.correction.errors)


def test_bias_and_spread_are_kept_apart_for_each_error() -> None:
    random, count = np.random.default_rng(1), 50_000
    told = {
        "landing_along": 0.03 + 0.01 * random.standard_normal(count),
        "error_phi": -0.002 + 0.004 * random.standard_normal(count),
        "unjudged": random.standard_normal(count),
    }
    told["error_phi"][7] = np.nan
    cells = ToyVectorEnv(500)
    throws = throw_held_out(make_controller("random", cells), cells, count, 0)
    figures = summary(replace(throws, info=told, errors=("error_phi",)))
    found = {name: value for name, value in figures.items() if name.startswith(("bias_", "spread_"))}
    assert set(found) == {"bias_along_m", "spread_along_m", "bias_error_phi", "spread_error_phi"}
    assert found["bias_along_m"] == pytest.approx(0.03, abs=3e-4)
    assert found["spread_along_m"] == pytest.approx(0.01, rel=0.02)
    assert found["bias_error_phi"] == pytest.approx(-0.002, abs=3e-4)
    assert found["spread_error_phi"] == pytest.approx(0.004, rel=0.02)


def test_what_a_cell_does_not_tell_is_not_asked_for() -> None:
    """A cell of another kind: no landing along or across, no rim and no touch, but flags of its own."""

    class Terse(ToyVectorEnv):
        def step(self, actions: np.ndarray) -> Any:
            *rest, info = super().step(actions)
            for name in ("landing_along", "landing_across", "rim", "recontact", "target_x", "target_y"):
                del info[name]
            return *rest, info | {"picked": np.array([True, False, True, True]), "note": np.array(["?"] * 4)}

    env = Terse(4, action_mode="release_xyz")
    throws = throw_held_out(Recorder(size=3), env, 8, 0)
    assert throws.error.shape == (8, 0)  # the action mode corrects none
    figures = summary(throws)
    assert figures["picked_rate"] == 0.75
    assert [name for name in figures if name.startswith(("failed_", "bias_", "spread_"))] == ["failed_unpicked"]
    assert figures["pick_rate"] == 0.75
    assert not {"recovery", "purity", "drop_rate", "energy_per_pick_j"} & figures.keys()
    (record, *_) = throw_records(throws, env.core.item_names)
    assert set(record) == {"item", "landing_error_m", "success", "cycle_time_s", "clipped", "reward", "picked"}
    console().print(ThrowRecord.table("terse", figures))
