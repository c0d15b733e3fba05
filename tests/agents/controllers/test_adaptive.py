"""Controllers of a cell that drifts: they go by what is observed alone, and by one static policy."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from agents.controllers import Learner, adaptive, load_state, make_controller, save_state
from agents.controllers.adaptive import STATIC, begins_shift, has_feedback, ideal_offsets, without_feedback
from agents.controllers.filters import landing_noise
from agents.controllers.protocol import Observation, Outcome
from agents.controllers.regression import Mlp
from agents.controllers.trackers import drift_effects
from agents.ground.cli import UsageError
from agents.ground.environments import core_of, make_vector
from agents.judging import trials
from agents.judging.loop import observed, practise, throw_held_out
from agents.judging.throw_record import summary
from pnt_gym.cells.conveyor.observation import SHIFT_TABLE
from tests.agents.controllers.test_trackers import network, throws
from tests.tools.drifting import QUICK

NAMES = ("static", "ema", "kalman", "recursive_ridge", "in_context", "oracle_drift")
ROWS = 4
LEVEL = {"base": "day", "picks_per_shift": 6, **QUICK}


@pytest.fixture(scope="module")
def env() -> Iterator[Any]:
    made = gym.make_vec("PnTAdapt-v0", num_envs=ROWS, level=LEVEL)
    yield made
    made.close()


@pytest.fixture(scope="module")
def knowledge(env: Any) -> dict[str, np.ndarray]:
    """A static policy that says something, of all the kinds that there are."""
    random, regressor = np.random.default_rng(0), Mlp(8, 40)
    regressor.fit(throws(200), random.normal([0.03, 0.0], [0.01, 0.005], (200, 2)), 0)
    state = {f"{STATIC}_{name}": np.asarray(value) for name, value in regressor.state().items()}
    return {**state, "kinds": np.array(env.unwrapped.core.item_names)}


def controller_of(name: str, env: Any, knowledge: dict[str, np.ndarray]) -> Any:
    made = make_controller(name, env)
    made.restore({**knowledge, **(network() if name == "in_context" else {})})
    return made


def first_seen(env: Any, seed: int) -> Observation:
    features, info = env.reset(seed=seed)
    return observed(features, info["kind"])


def thrown(controller: Any, env: Any, steps: int, seed: int) -> list[tuple[Observation, np.ndarray, dict[str, Any]]]:
    """What a controller saw, did, and what came of it."""
    features, info = env.reset(seed=seed)
    found = []
    for _ in range(steps):
        seen = observed(features, info["kind"])
        action = controller.act(seen)
        features, _, _, _, info = env.step(action)
        found.append((seen, action, info))
    return found


def test_what_is_told_is_what_would_have_been_right(env: Any) -> None:
    features, info = env.reset(seed=0)
    first = observed(features, info["kind"])
    assert begins_shift(first).all()
    assert not ideal_offsets(first)[1].any()
    action = np.random.default_rng(0).uniform(-0.3, 0.3, (ROWS, 2)).astype(np.float32)
    features, _, _, _, info = env.step(action)
    second = observed(features, info["kind"])
    right, known = ideal_offsets(second)
    asked = action * env.unwrapped.core.correction.scale
    error = np.stack([info["seen_along"], info["seen_across"]], axis=1)
    rows = known & ~info["residual_clipped"]
    assert rows.any()
    np.testing.assert_allclose(right[rows], (asked - error)[rows], atol=1e-6)
    np.testing.assert_array_equal(known, np.isfinite(error).all(axis=1))
    assert not begins_shift(second).any()
    np.testing.assert_array_equal(without_feedback(second).features, features[:, :26])


@pytest.mark.parametrize("name", NAMES)
def test_the_shipped_ones_act_at_once(name: str, env: Any) -> None:
    controller = make_controller(name, env)
    assert isinstance(controller, Learner)
    assert controller.name == name
    for _, action, _ in thrown(controller, env, 3, 1):
        assert action.shape == (ROWS, 2)
        assert action.dtype == np.float32
        assert (np.abs(action) <= 1.0).all()


@pytest.mark.parametrize("name", NAMES)
def test_they_refuse_a_cell_that_tells_nothing(name: str) -> None:
    for env_id in ("PnTConveyor-v0", "PnTRelease-v0", "GripperToss-v0"):
        other = gym.make_vec(env_id, num_envs=2)
        with pytest.raises(UsageError) as caught:
            make_controller(name, other)
        said = f"controller {name!r} needs observations of the previous landing; use --env PnTAdapt-v0"
        assert str(caught.value) == said
        other.close()


def test_static_is_its_network(env: Any, knowledge: dict[str, np.ndarray]) -> None:
    controller, regressor = controller_of("static", env, knowledge), Mlp(8)
    regressor.restore(
        {name.removeprefix(f"{STATIC}_"): v for name, v in knowledge.items() if name.startswith(f"{STATIC}_")}
    )
    scale = env.unwrapped.core.correction.scale
    for seen, action, _ in thrown(controller, env, 8, 2):
        shift = np.clip(regressor.predict(seen.features[:, :26].astype(np.float64)), -scale, scale)
        np.testing.assert_allclose(action, shift / scale, atol=1e-6)
        assert action.any()


@pytest.mark.parametrize("name", ["ema", "kalman", "recursive_ridge", "in_context"])
def test_they_act_on_the_observation_alone(name: str, env: Any, knowledge: dict[str, np.ndarray]) -> None:
    """Whatever else they are told of a throw, and without the cells that gave it."""
    first, other = (controller_of(name, env, knowledge) for _ in range(2))
    static, moved = controller_of("static", env, knowledge), False
    found, count = thrown(first, env, 8, 3), np.zeros(ROWS)
    env.reset(seed=77)
    for seen, action, info in found:
        np.testing.assert_array_equal(other.act(seen), action)
        unknown = np.full((ROWS, 2), 0.1), count > 0, count, info["residual_clipped"], count
        other.learn(Outcome(seen, action, *unknown))
        moved |= not np.array_equal(static.act(seen), action)
    assert moved


@pytest.mark.parametrize("name", ["ema", "kalman", "recursive_ridge", "in_context"])
def test_a_shift_that_begins_forgets_the_one_before(name: str, env: Any, knowledge: dict[str, np.ndarray]) -> None:
    used, fresh = controller_of(name, env, knowledge), controller_of(name, env, knowledge)
    found = thrown(used, env, 9, 4)  # across the end of the shift, by itself
    again = [fresh.act(seen) for seen, *_ in found[6:]]
    assert begins_shift(found[6][0]).all()
    for (_, action, _), other in zip(found[6:], again, strict=True):
        np.testing.assert_allclose(action, other, atol=1e-7)
    seen = first_seen(env, 5)
    np.testing.assert_allclose(used.act(seen), controller_of(name, env, knowledge).act(seen), atol=1e-7)


@pytest.mark.parametrize("name", ["ema", "kalman", "recursive_ridge", "in_context"])
def test_a_row_goes_by_its_own_shift(name: str, env: Any, knowledge: dict[str, np.ndarray]) -> None:
    found = thrown(controller_of(name, env, knowledge), env, 5, 6)
    for row in (0, ROWS - 1):
        alone = controller_of(name, env, knowledge)
        for seen, action, _ in found:
            one = Observation(seen.features[[row]], seen.kind[[row]])
            np.testing.assert_allclose(alone.act(one)[0], action[row], atol=1e-6)


def test_a_landing_that_was_not_seen_teaches_nothing(env: Any, knowledge: dict[str, np.ndarray]) -> None:
    blind = [*SHIFT_TABLE.decode(np.zeros(34))].index("last_seen")
    controller, static = (controller_of(name, env, knowledge) for name in ("kalman", "static"))
    for seen, *_ in thrown(controller_of("kalman", env, knowledge), env, 4, 7):
        features = seen.features.copy()
        features[:, blind] = 0.0
        dark = Observation(features, seen.kind)
        np.testing.assert_allclose(controller.act(dark), static.act(dark), atol=1e-7)


def test_a_kind_that_was_never_learned_has_corrections_of_its_own(env: Any, knowledge: dict[str, np.ndarray]) -> None:
    """And tells nothing of the shift: what it does is its own."""
    names = env.unwrapped.core.item_names
    found = thrown(controller_of("kalman", env, knowledge), env, 5, 8)
    strange = {**knowledge, "kinds": knowledge["kinds"][:0]}
    controller, static = controller_of("kalman", env, strange), controller_of("static", env, knowledge)
    known = {kind for seen, *_ in found for kind in seen.kind}
    for seen, *_ in found:
        controller.act(seen)
    features = found[-1][0].features
    for kind in range(len(names)):
        seen = Observation(features[[0] * ROWS], np.full(ROWS, kind))
        last, plain = controller.act(seen), static.act(seen)
        if kind not in known:
            np.testing.assert_allclose(last, plain, atol=1e-7)
    learned = controller.act(found[-1][0])
    assert not np.allclose(learned, static.act(found[-1][0]), atol=1e-4)


def test_the_oracle_takes_back_what_the_drift_does(env: Any, knowledge: dict[str, np.ndarray]) -> None:
    oracle, static = (controller_of(name, env, knowledge) for name in ("oracle_drift", "static"))
    core = env.unwrapped.core
    for seed in (9, 10):
        features, info = env.reset(seed=seed)
        seen, drift = observed(features, info["kind"]), core.context.drift
        state = np.concatenate([drift.delay[:, None], drift.camera, drift.encoder[:, None]], axis=1)
        effect = np.einsum("nij,nj->ni", drift_effects(features[:, :26], core.config.belt.camera_x), state)
        taken = (static.act(seen) - oracle.act(seen)) * core.correction.scale
        inside = np.abs(oracle.act(seen)) < 1.0
        assert inside.mean() > 0.7
        np.testing.assert_allclose(taken[inside], effect[inside], atol=1e-6)
        assert np.abs(effect).max() > 0.003


# What they keep.


@pytest.mark.parametrize("name", NAMES)
def test_what_was_learned_survives_a_file(
    name: str, env: Any, knowledge: dict[str, np.ndarray], tmp_path: Path
) -> None:
    first, second = controller_of(name, env, knowledge), make_controller(name, env)
    save_state(first, tmp_path / "state.npz")
    load_state(second, tmp_path / "state.npz")
    assert first.state().keys() == second.state().keys()
    found = thrown(first, env, 4, 11) if name != "oracle_drift" else []
    for seen, action, _ in found:
        np.testing.assert_array_equal(second.act(seen), action)
    second.reset(0)  # back to what ships
    shipped = make_controller(name, env).state()
    assert all(np.array_equal(shipped[key], value) for key, value in second.state().items())


def test_what_goes_by_the_static_policy_takes_over_its_file(
    env: Any, knowledge: dict[str, np.ndarray], tmp_path: Path
) -> None:
    static = controller_of("static", env, knowledge)
    save_state(static, tmp_path / "static.npz")
    seen = first_seen(env, 12)
    for name in ("ema", "kalman", "recursive_ridge"):
        other = make_controller(name, env)
        load_state(other, tmp_path / "static.npz")
        np.testing.assert_array_equal(other.act(seen), static.act(seen))  # nothing is known of the shift yet
        save_state(other, tmp_path / "back.npz")
        load_state(make_controller("static", env), tmp_path / "back.npz")
    with pytest.raises(UsageError, match="was saved by 'static', not by 'in_context'"):
        load_state(make_controller("in_context", env), tmp_path / "static.npz")
    with pytest.raises(UsageError, match="was saved by 'static', not by 'ridge'"):
        load_state(make_controller("ridge", env), tmp_path / "static.npz")
    save_state(controller_of("in_context", env, knowledge), tmp_path / "in_context.npz")
    for name in ("static", "ema", "kalman", "recursive_ridge", "oracle_drift"):
        other = make_controller(name, env)
        load_state(other, tmp_path / "in_context.npz")
        np.testing.assert_array_equal(
            other._static.predict(without_feedback(seen)), static._static.predict(without_feedback(seen))
        )


def test_a_network_that_has_not_studied_does_as_the_static_policy(
    env: Any, knowledge: dict[str, np.ndarray], tmp_path: Path
) -> None:
    controller = make_controller("in_context", env)
    controller.restore(knowledge)
    static = controller_of("static", env, knowledge)
    save_state(controller, tmp_path / "state.npz")
    load_state(controller, tmp_path / "state.npz")
    for seen, action, _ in thrown(controller, env, 3, 13):
        np.testing.assert_array_equal(static.act(seen), action)


def test_nothing_learned_at_all_is_the_planners_throw(env: Any) -> None:
    for name in ("static", "kalman", "in_context"):
        controller = make_controller(name, env)
        controller.restore({})
        assert not controller.act(first_seen(env, 14)).any()


@pytest.mark.parametrize("name", ["static", "in_context"])
def test_practice_is_the_static_policys_and_what_it_leaves_is_studied(
    name: str, env: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(adaptive, "STEPS", 60)
    options = {"size": 4, "batches": 2} if name == "in_context" else {}
    controller, shipped = make_controller(name, env, **options), make_controller(name, env).state()
    assert isinstance(controller, Learner)
    practise(controller, env, 96, 0)
    state = controller.state()
    assert any(not np.array_equal(state[key], shipped.get(key)) for key in state if key.startswith(f"{STATIC}_"))
    assert ("memory_in_weight" in state) == (name == "in_context")
    assert set(state["kinds"]) <= set(env.unwrapped.core.item_names)
    seen = first_seen(env, 15)
    action = controller.act(seen)
    assert action.any()
    np.testing.assert_array_equal(action, controller.act(seen))  # and no exploration


def test_kalman_knows_the_noise_of_the_camera_over_the_bins_from_the_level() -> None:
    level = {"base": "day", "feedback": {"noise": 0.02}}
    with closing(make_vector("PnTAdapt-v0", level, 2, threads=1)) as env:
        controller = make_controller("kalman", env)
    np.testing.assert_array_equal(controller._tracker._filters._noise, landing_noise(0.02))


@pytest.mark.nightly
def test_practice_forgets_what_was_shipped_and_pays(env: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(adaptive, "STEPS", 300)
    planner = summary(throw_held_out(make_controller("analytic", env), env, 96, 0))["landing_error_mean_m"]
    controller = make_controller("static", env)
    practise(controller, env, 160, 0)
    assert summary(throw_held_out(controller, env, 96, 0))["landing_error_mean_m"] < 0.8 * planner


@pytest.mark.parametrize("mode", ["release_point", "release_xyz", "virtual_goal"])
def test_whole_shifts_are_counted_whatever_an_action_means(mode: str) -> None:
    with closing(make_vector("PnTAdapt-v0", LEVEL, 2, 1, mode)) as env:
        assert has_feedback(core_of(env))
        assert trials.of(env).count() == 12
    with closing(make_vector("PnTConveyor-v0", "waste", 2, 1, mode)) as env:
        assert not has_feedback(core_of(env))
        assert trials.of(env).count() == 200
