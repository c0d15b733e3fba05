"""Values that learn from rewards alone: what they choose, what picks teach them, and what they keep in a file."""

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest

from agents.controllers import make_controller, save_state
from agents.controllers.fitted_q import FittedQ, _scaled, _Tries
from agents.grasping.features import place_features
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector
from agents.judging.loop import observed, practise, throw_held_out
from pnt_gym.cells.grasp.observation import TABLE
from tests.tools.throws import same_bits

LEVEL: dict[str, Any] = {"base": "grasp", "fidelity": "flight"}
ROWS = 32


@pytest.fixture(scope="module")
def env() -> Iterator[Any]:
    with closing(make_vector("PnTGrasp-v0", LEVEL, ROWS, 1)) as cells:
        yield cells


def rate(controller: Any, env: Any) -> float:
    throws = throw_held_out(controller, env, 96, 3)
    return float(throws.sorted.sum() / throws.cycle_time.sum())


def test_what_ships_sorts_faster_than_the_middle(env: Any) -> None:
    assert rate(make_controller("fitted_q", env), env) > 1.05 * rate(make_controller("centre", env), env)


def test_a_short_practice_learns_from_rewards(env: Any, tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("torch")
    monkeypatch.setattr("agents.controllers.fitted_q.QUICK_STEPS", 75)
    monkeypatch.setattr("agents.controllers.fitted_q.STEPS", 200)
    controller = make_controller("fitted_q", env)
    controller.reset(0)
    practise(controller, env, 320, 0)
    assert rate(controller, env) > 0.85 * rate(make_controller("flattest", env), env)
    save_state(controller, tmp_path / "values.npz")
    other = make_controller("fitted_q", env, file=tmp_path / "values.npz")
    features, info = env.reset(seed=2)
    seen = observed(features, info["kind"])
    assert same_bits(other.act(seen), controller.act(seen))
    with pytest.raises(UsageError, match="does not exist"):
        make_controller("fitted_q", env, file=tmp_path / "none.npz")


def test_fields_of_picks_are_those_of_the_tries(env: Any) -> None:
    """Where a first try failed, its features are those of the place that failed; the last ones are of the last."""
    controller = make_controller("fitted_q", env)
    assert isinstance(controller, FittedQ)
    controller.begin_practice(10_000)
    features, info = env.reset(seed=1)
    for _ in range(12):
        seen = observed(features, info["kind"])
        action = controller.act(seen)
        features, _, _, _, info = env.step(action)
    tries = _Tries.of(observed(features, info["kind"]), env.core.config)
    values = TABLE.decode(features["vector"])
    assert tries.failed.any()
    assert not tries.failed.all()
    failed_before = np.hypot(values["failed_x"], values["failed_y"]) > 0.0
    assert same_bits(tries.failed, failed_before)
    table = place_features(features["image"], values["cup_radius"])
    rows = np.flatnonzero(tries.failed)
    there = tries.at(table, rows, tries.place[rows])
    assert (there[:, -1] == 1.0).all()  # at the place that failed
    assert (there[:, -2] == 1.0).all()
    far = tries.at(table, rows, tries.place[rows] + 0.05)
    assert (far[:, -1] < 0.01).all()
    assert (tries._replace(failed=np.zeros_like(tries.failed)).at(table, rows, tries.place[rows])[:, -2:] == 0.0).all()


def test_returns_are_scaled_to_shares() -> None:
    np.testing.assert_allclose(_scaled(np.array([-5.0, -1.2, -0.2, 0.8, 2.0])), [0.0, 0.0, 0.5, 1.0, 1.0])


@pytest.mark.parametrize(
    ("level", "words"),
    [
        ({"base": "grasp", "grasp": {"stages": 1, "tries": 1}}, "this level has `stages: 1`"),
        ("grasp_dense", "has groups of objects"),
    ],
)
def test_levels_on_which_it_cannot_learn_are_refused(level: Any, words: str) -> None:
    with closing(make_vector("PnTGrasp-v0", level, 2, 1)) as env, pytest.raises(UsageError, match=words):
        make_controller("fitted_q", env).begin_practice(10)  # type: ignore[attr-defined]
