"""Measurements of the studies of learning: curves, the mismatch map, the choice of a level, and other processors."""

from contextlib import closing
from typing import Any

import numpy as np
import pytest

from agents.controllers.protocol import Observation, Outcome
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import practise, throw_held_out
from agents.judging.throw_record import summary
from agents.results.study import Amount
from benchmarks.studies import oracle, pieces
from benchmarks.studies.learners import CmaEs, GaussianProcess, Gp
from pnt_gym.arrays import Floats
from tests.tools.nightly import with_nightly

FLIGHT: dict[str, Any] = {"base": "waste_plain", "fidelity": "flight"}
FEW = Amount(throws=32, seed=0)


def test_a_curve_has_a_row_for_each_number_of_throws() -> None:
    settings = {"env": "PnTRelease-v0", "level": FLIGHT, "seed": 1, "controller": "ridge", "throws": [16, 160]}
    rows = pieces.curve(settings, FEW)
    assert [row["throws"] for row in rows] == [16, 160]
    assert all(0.0 < row["landing_error_mean_m"] < 0.2 for row in rows)
    assert rows[1]["landing_error_mean_m"] < rows[0]["landing_error_mean_m"]


def test_nothing_is_gained_in_the_planners_own_world_and_much_in_another_one() -> None:
    settings = {"env": "PnTRelease-v0", "seeds": [0], "controller": "ridge", "throws": [160]}
    ideal, real = (pieces.gain({**settings, "level": {**FLIGHT, "mismatch": m}}, FEW) for m in (0.0, 1.0))
    assert ideal["analytic_m"] < 0.002 < ideal["learned_m"] + 0.002
    assert real["landing_error_m"]["high"] < 0.0
    assert real["learned_m"] < 0.7 * real["analytic_m"]
    assert ideal["landing_error_m"]["value"] > -0.002


@pytest.mark.nightly
def test_added_errors_have_the_size_that_is_asked_for_and_cost_success() -> None:
    level = {**FLIGHT, "items": ["cap", "cork"], "bins": {"random": {"side": [0.05, 0.06], "item_clearance": 0.03}}}
    row = oracle.errors({"level": level, "errors_m": [0.011, 0.05]}, Amount(200, 0))
    assert row["far"] < row["near"] <= row["oracle"]["value"]
    assert row["difference"]["value"] == pytest.approx(row["near"] - row["far"])


def test_other_throws_of_a_processor_are_counted_and_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    """One of four throws lands 3 and 4 mm away, and one that dropped there has no landing to compare."""
    here = {name: [0.0, 0.0, 0.0, 0.0] for name in pieces.NUMBERS} | {"outcome": ["a", "a", "b", "b"]}
    away = {"along_m": [0.0, 0.003, 0.0, None], "across_m": [0.0, 0.004, 0.0, None], "outcome": ["a", "b", "b", "b"]}
    monkeypatch.setattr(pieces, "_elsewhere", lambda _, variables: here | away if variables else here)
    row = pieces.processors({"level": FLIGHT, "controller": "analytic", "variables": {"X": "y"}}, FEW)
    assert row["throws"] == 4
    assert row["differing"] == row["outcomes"] == 0.25
    assert row["apart_most_m"] == pytest.approx(0.005)
    assert row["mean_m"] == pytest.approx(0.005 / 3.0)


@pytest.mark.nightly
def test_a_process_for_the_same_processor_has_the_same_throws() -> None:
    row = pieces.processors({"level": FLIGHT, "controller": "analytic", "variables": {}}, FEW)
    assert row == {"throws": 32, **dict.fromkeys(list(row)[1:], 0.0)}


def test_a_gaussian_process_finds_a_smooth_function_and_keeps_it() -> None:
    random = np.random.default_rng(0)
    features = random.normal(size=(200, 3))

    def truth(x: Floats) -> Floats:
        return np.stack([np.sin(x[:, 0]), 0.5 + 0.3 * x[:, 1]], axis=1)

    process = GaussianProcess()
    process.fit(features, truth(features) + 0.01 * random.normal(size=(200, 2)), seed=0)
    new = random.normal(size=(50, 3))
    assert np.abs(process.predict(new) - truth(new)).mean() < 0.05
    other = GaussianProcess()
    other.restore(process.state())
    assert np.array_equal(other.predict(new), process.predict(new))


LEARNERS = [(Gp, 16, 160, 0.6), (CmaEs, 64, 6400, 0.9)]


@pytest.mark.parametrize(("learner", "rows", "throws", "share"), with_nightly(LEARNERS, LEARNERS[:1]))
def test_learners_of_the_curves_learn(learner: Any, rows: int, throws: int, share: float) -> None:
    with closing(make_vector("PnTRelease-v0", FLIGHT, rows, 1)) as env:
        controller = learner(core=core_of(env))
        controller.reset(0)
        before = summary(throw_held_out(controller, env, 160, 0))["landing_error_mean_m"]
        practise(controller, env, throws, 0)
        after = summary(throw_held_out(controller, env, 160, 0))["landing_error_mean_m"]
    assert after < share * before


def test_a_batch_that_was_cut_short_teaches_cma_es_nothing() -> None:
    with closing(make_vector("PnTRelease-v0", FLIGHT, 16, 1)) as env:
        controller = CmaEs(core=core_of(env))
        controller.begin_practice(16)
        width = env.single_observation_space.shape[0]
        seen = Observation(np.zeros((16, width), dtype=np.float32), np.zeros(16, dtype=np.int64))
        before = controller.act(seen)
        few = Observation(seen.features[:5], seen.kind[:5])
        controller.learn(
            Outcome(few, before[:5], np.ones((5, 2)), *(np.zeros(5, dtype=t) for t in (bool, float, bool, float)))
        )
        controller.end_practice()
    assert not controller.act(seen).any()
