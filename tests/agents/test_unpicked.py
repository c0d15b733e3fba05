"""Throws that never were, because the cup did not seal or lost its object: not sorted, and no lesson to anybody."""

import json
import warnings
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from agents.controllers import Observation, Outcome, make_controller
from agents.ground.environments import make_vector
from agents.judging.evaluation import evaluate
from agents.judging.loop import practise
from agents.judging.throws import Throws
from agents.learning.progress import ProgressCallback, Stop
from agents.learning.windows import ThrowWindow
from pnt_gym.arrays import take
from tests.tools.nightly import with_nightly

LEVEL = {"base": "waste", "fidelity": "flight", "spread": {"seal": 1.0}}
"""Where some picks fail, and some seals are so weak that the object is lost on the way."""
LEARNERS = ("virtual_goal", "ridge", "mlp")


def outcomes(env, steps: int) -> tuple[list[Outcome], list[np.ndarray]]:
    """What a controller is told that throws at random, and which rows were throws (N,) of each step."""
    random, found, thrown = np.random.default_rng(0), [], []
    unpicked = dropped = 0
    features, info = env.reset(seed=5)
    for _ in range(steps):
        seen = Observation(features.copy(), info["kind"].copy())
        action = random.uniform(-0.5, 0.5, env.action_space.shape).astype(np.float32)
        features, reward, _, _, info = env.step(action)
        told = Throws.of(info, reward, env.core.correction.errors)
        found.append(Outcome(seen, action, told.error, told.is_success, told.cycle_time, told.clipped, told.reward))
        thrown.append(info["picked"] & ~info["dropped"])
        unpicked, dropped = unpicked + (~info["picked"]).sum(), dropped + info["dropped"].sum()
    assert min(unpicked, dropped) >= 3
    return found, thrown


@pytest.mark.parametrize("name", with_nightly(LEARNERS, ["virtual_goal", "ridge"]))
def test_learners_take_nothing_from_what_was_not_thrown(name: str) -> None:
    """The same knowledge, to the bit, as from the throws alone that were."""
    with closing(make_vector("PnTRelease-v0", LEVEL, 16, 1)) as env:
        told, thrown = outcomes(env, 6)
        learners = [make_controller(name, env) for _ in range(2)]
    for learner, rows in zip(learners, ([slice(None)] * 6, thrown), strict=True):
        learner.reset(0)
        for one, kept in zip(told, rows, strict=True):
            learner.learn(take(one, kept))
    one, other = (learner.state() for learner in learners)
    assert one.keys() == other.keys()
    assert len(one) > 0
    for key in one:
        assert np.array_equal(one[key], other[key]), key
        assert one[key].dtype.kind != "f" or np.isfinite(one[key]).all()


@pytest.mark.parametrize("name", LEARNERS)
def test_practice_goes_on_where_picks_fail(name: str) -> None:
    with closing(make_vector("PnTConveyor-v0", LEVEL, 16, 1)) as env:
        learner = make_controller(name, env)
        learner.reset(0)
        practise(learner, env, 64, 0)
        features, info = env.reset(seed=1)
        assert np.isfinite(learner.act(Observation(features, info["kind"]))).all()


def test_an_evaluation_counts_what_was_not_thrown() -> None:
    found = evaluate("analytic", "PnTConveyor-v0", 64, level=LEVEL)
    throws = found["throws"]
    picked, dropped = ([throw[name] for throw in throws] for name in ("picked", "dropped"))
    assert 0 < sum(picked) < 64
    assert sum(dropped) > 0
    assert found["pick_rate"] == pytest.approx(sum(picked) / 64)
    assert found["drop_rate"] == pytest.approx(sum(dropped) / sum(picked))
    assert found["failed_unpicked"] == pytest.approx(1.0 - sum(picked) / 64)
    assert found["failed_dropped"] == pytest.approx(sum(dropped) / 64)
    assert found["unmeasured"] == 64 - sum(picked) + sum(dropped)
    for throw in throws:
        is_thrown = throw["picked"] and not throw["dropped"]
        for name in ("landing_error_m", "landing_along_m", "landing_across_m"):
            assert (throw[name] is not None) == is_thrown
        assert is_thrown or not throw["success"]
    failures = sum(found[name] for name in found if name.startswith("failed_"))
    assert failures == pytest.approx(1.0 - found["success_rate"])
    json.dumps(found, allow_nan=False)


def test_training_that_begins_with_failed_picks_is_told_without_a_warning(tmp_path: Path) -> None:
    shown: list[tuple[float, ...]] = []
    callback = ProgressCallback(tmp_path / "progress.csv", 0, Stop(), ThrowWindow(), lambda *told: shown.append(told))
    none = {"is_success": False, "landing_error": np.nan}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for infos in ([none, none], [none, {"is_success": True, "landing_error": 0.02}]):
            callback.locals = {"rewards": np.array([0.1, 0.3]), "infos": infos}
            callback._on_step()
    (_, _, success, error), (*_, later, known) = shown
    assert (success, later) == (0.0, 0.25)
    assert np.isnan(error)
    assert known == pytest.approx(0.02)
