"""Evaluation: exactly the throws asked for, the same objects for everyone, the contract's figures."""

from __future__ import annotations

import json

import numpy as np
import pytest
from toy_cell import PoseVectorEnv, ToyVectorEnv

from agents.controllers import Observation, Outcome, make_controller
from agents.environments import make_vector, stream_seed
from agents.evaluation import Throws, evaluate, failures, practise, summary, throw_records
from pnt_gym.errors import PntGymError


class Recorder:
    """Does nothing and remembers what it was shown."""

    name = "recorder"

    def __init__(self, action: float = 0.0) -> None:
        self.action = action
        self.seen: list[np.ndarray] = []
        self.learned: list[Outcome] = []

    def reset(self, seed: int) -> None:
        self.seen.clear()

    def act(self, observation: Observation) -> np.ndarray:
        self.seen.append(observation.features)
        return np.full((len(observation.kind), 2), self.action, dtype=np.float32)

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
    throws = evaluate(Recorder(), ToyVectorEnv(4), picks, 0, progress=told.append)
    assert len(throws) == picks == sum(told)
    assert throws.target.shape == (picks, 2)


def test_controllers_meet_the_same_objects() -> None:
    one, two = Recorder(0.0), Recorder(0.7)
    a, b = evaluate(one, ToyVectorEnv(4), 40, 3), evaluate(two, ToyVectorEnv(4), 40, 3)
    assert np.array_equal(np.concatenate(one.seen), np.concatenate(two.seen))
    assert np.array_equal(a.item, b.item)
    assert not np.array_equal(a.landing_error, b.landing_error)


def test_another_seed_means_other_objects() -> None:
    one, two = Recorder(), Recorder()
    evaluate(one, ToyVectorEnv(4), 8, 0)
    evaluate(two, ToyVectorEnv(4), 8, 1)
    assert not np.isin(np.concatenate(one.seen)[:, 0], np.concatenate(two.seen)[:, 0]).any()


def test_practice_and_evaluation_never_share_an_object() -> None:
    student = Student()
    env = ToyVectorEnv(4)
    practise(student, env, 40, 0)
    practice = np.concatenate(student.seen)[:, 0]
    student.seen.clear()
    evaluate(student, env, 40, 0)
    assert not np.isin(np.concatenate(student.seen)[:, 0], practice).any()


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
    evaluate(student, env, 8, 0)
    assert sum(len(o.error) for o in student.learned) == 10
    evaluate(student, env, 8, 0, online=True)
    assert sum(len(o.error) for o in student.learned) == 18


def test_those_who_do_not_learn_do_not_practise() -> None:
    recorder = Recorder()
    practise(recorder, ToyVectorEnv(4), 40, 0)
    assert not recorder.seen


def test_summary_agrees_with_the_throws() -> None:
    throws = evaluate(make_controller("random", ToyVectorEnv(4)), ToyVectorEnv(4), 60, 0)
    figures = summary(throws)
    assert figures["success_rate"] == pytest.approx(throws.is_success.mean())
    assert figures["success_low"] < figures["success_rate"] < figures["success_high"]
    assert figures["landing_error_mean_m"] == pytest.approx(
        np.hypot(throws.landing_along, throws.landing_across).mean()
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
        target=np.zeros((count, 2)),
        landing_error=zeros,
        landing_along=zeros,
        landing_across=zeros,
        error=np.zeros((count, 2)),
        is_success=flags[0],
        cycle_time=zeros + 1,
        recontact=flags[1],
        rim=flags[2],
        clipped=zeros.astype(bool),
        reward=zeros,
    )
    assert sum(failures(throws).values()) == pytest.approx(0.5)


def test_unmeasured_landings_become_null_not_nan() -> None:
    throws = evaluate(Recorder(), ToyVectorEnv(4), 4, 0)
    throws.landing_error[1] = throws.landing_along[1] = np.nan
    assert throw_records(throws, ToyVectorEnv(4).core.item_names)[1]["landing_error_m"] is None
    assert summary(throws)["unmeasured"] == 1


def test_errors_beyond_the_landing_are_recorded_by_their_names() -> None:
    env = PoseVectorEnv(4)
    throws = evaluate(make_controller("analytic", env), env, 6, 0)
    throws.error[2, 3] = np.nan
    records = throw_records(throws, env.core.item_names, env.core.correction)
    assert [r["error_phi"] for r in records] == throws.error[:, 2].tolist()
    assert records[2]["error_dy"] is None
    plain = throw_records(throws, env.core.item_names)
    assert set(records[0]) - set(plain[0]) == set(env.core.correction.errors)
    toy = ToyVectorEnv(4)
    (record,) = throw_records(evaluate(Recorder(), toy, 1, 0), toy.core.item_names, toy.core.correction)
    assert set(record) == set(plain[0])


def test_an_action_mode_without_a_correction_has_no_errors_to_learn_from() -> None:
    env = ToyVectorEnv(4, action_mode="release_xyz")
    throws = evaluate(make_controller("random", env), env, 10, 0)
    assert throws.error.shape == (10, 0)
    assert np.isfinite(throws.landing_error).all()


def test_unknown_environment_is_named() -> None:
    with pytest.raises(PntGymError, match="unknown environment 'PnTConveyer-v0'; known are PnTConveyor-v0"):
        make_vector("PnTConveyer-v0")
