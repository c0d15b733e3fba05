"""Controllers against cells on paper with a known right answer."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.controllers import GRASPING_NAMES, NAMES, Learner, load_state, make_controller, save_state
from agents.controllers.goals import virtual_goal
from agents.controllers.protocol import ideal_offsets, to_action
from agents.controllers.regression import Ridge
from agents.controllers.trackers import later_release
from agents.ground.cli import UsageError
from agents.ground.environments import core_of, make_vector
from agents.judging.loop import practise, throw_held_out
from agents.judging.throw_record import summary
from pnt_gym.cells.conveyor.action import correction
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.observation import FEATURES
from pnt_gym.cells.one_joint.config import GoalRegion
from pnt_gym.cells.one_joint.observation import FEATURES as ARM_FEATURES
from pnt_gym.errors import PntGymError
from tests.tools.toy_cell import POSE, POSE_BIAS, PoseVectorEnv, ToyVectorEnv, observation_of, outcome_of

WASTE, NOMINAL = ConveyorConfig.load("waste"), ConveyorConfig.load("nominal")
ON_WASTE, ON_NOMINAL = correction(WASTE, "release_point"), correction(NOMINAL, "release_point")
LEARNERS = ("virtual_goal", "ridge", "mlp")


def encode(**values: float) -> np.ndarray:
    """One observation with the given physical values, all else at its centre."""
    row = [(values.get(f.name, f.centre) - f.centre) / f.scale for f in FEATURES]
    return np.array([row], dtype=np.float32)


def fall(height: float, speed: float, angle: float, step: float = 1e-6) -> float:
    """Distance of a drag-free throw, by integration until it is `height` lower."""
    x, z, vx, vz = 0.0, 0.0, speed * np.cos(angle), speed * np.sin(angle)
    while True:
        nz = z + vz * step - 0.5 * 9.81 * step**2
        if nz < -height and vz < 0:
            return x + vx * step * (z + height) / (z - nz)
        x, z, vz = x + vx * step, nz, vz - 9.81 * step


def flight_time(height: float, speed: float, angle: float) -> float:
    rise = speed * np.sin(angle)
    return (rise + np.sqrt(rise**2 + 2 * 9.81 * height)) / 9.81


@given(st.floats(0.03, 0.25), st.floats(1.2, 3.0), st.floats(0.05, 0.9), st.floats(0.0, 0.03))
@settings(max_examples=15, deadline=None)
def test_a_later_release_changes_the_landing_as_an_integrated_flight_does(
    height: float, speed: float, angle: float, delay: float
) -> None:
    plan = {
        "release_speed": np.array([speed]),
        "elevation": np.array([angle]),
        "flight_time": np.array([flight_time(height, speed, angle)]),
    }
    late = speed * delay
    far, near = (fall(height + up, speed, angle, 1e-5) for up in (late * np.sin(angle), 0.0))
    assert later_release(plan, delay)[0] == pytest.approx(late * np.cos(angle) + far - near, abs=5e-5)


def test_analytic_is_zero_in_every_action_mode() -> None:
    for mode, count in (("release_point", 2), ("release_xyz", 3)):
        env = ToyVectorEnv(3, action_mode=mode)
        action = make_controller("analytic", env).act(observation_of(env.reset(seed=0)[0]))
        assert action.shape == (3, count)
        assert action.dtype == np.float32
        assert not action.any()


@pytest.mark.parametrize("gain", [0.3, 0.5, 1.0, 1.5])
def test_virtual_goal_converges_on_a_constant_error(gain: float) -> None:
    controller = virtual_goal(ON_NOMINAL, gain)
    bias, seen = np.array([[0.07, -0.02]]), observation_of(encode())
    for _ in range(30):
        action = controller.act(seen)
        controller.learn(outcome_of(seen, action, bias + action * ON_NOMINAL.scale))
    assert controller.act(seen) * ON_NOMINAL.scale == pytest.approx(-bias, abs=1e-4)


def test_a_batch_of_throws_teaches_what_the_same_throws_one_by_one_do() -> None:
    errors = np.array([[0.05, 0.01], [0.03, -0.02], [0.08, 0.0]])
    together, apart = virtual_goal(ON_NOMINAL, 0.5), virtual_goal(ON_NOMINAL, 0.5)
    three, one = observation_of(np.repeat(encode(), 3, axis=0)), observation_of(encode())
    together.learn(outcome_of(three, np.zeros((3, 2)), errors))
    for error in errors:
        action = apart.act(one)
        apart.learn(outcome_of(one, action, error[None] + action * ON_NOMINAL.scale))
    assert together.act(one) == pytest.approx(apart.act(one), abs=1e-5)


@pytest.mark.parametrize("gain", [0.0, 2.0, -1.0, float("nan")])
def test_virtual_goal_refuses_a_gain_that_cannot_converge(gain: float) -> None:
    with pytest.raises(PntGymError, match="between 0 and 2"):
        virtual_goal(ON_NOMINAL, gain)


@pytest.mark.parametrize(("gain", "said"), [([0.1, 0.2, 0.3], "one number or 2"), ([0.5, 2.0], "between 0 and 2")])
def test_virtual_goal_refuses_a_diagonal_of_the_wrong_size_or_range(gain: list[float], said: str) -> None:
    with pytest.raises(PntGymError, match=said):
        virtual_goal(ON_NOMINAL, gain)


def test_a_diagonal_gain_moves_each_number_by_its_own_share() -> None:
    controller, seen = virtual_goal(ON_NOMINAL, [0.2, 1.0]), observation_of(encode())
    controller.learn(outcome_of(seen, controller.act(seen), np.array([[0.05, 0.01]])))
    assert controller.act(seen) * ON_NOMINAL.scale == pytest.approx(np.array([[-0.01, -0.01]]), abs=1e-6)


@pytest.mark.parametrize(("scatter", "gains"), [(0.0, (1.0,)), (0.05, (0.05, 0.1))])
def test_practice_chooses_a_large_gain_without_scatter_and_a_small_one_with_it(
    scatter: float, gains: tuple[float, ...]
) -> None:
    controller, seen, random = virtual_goal(ON_NOMINAL), observation_of(encode()), np.random.default_rng(1)
    for _ in range(300):
        action = controller.act(seen)
        error = np.array([[0.03, -0.02]]) + scatter * random.standard_normal((1, 2)) * np.array([1.0, 0.2])
        controller.learn(outcome_of(seen, action, error + action * ON_NOMINAL.scale))
    assert controller.state()["gain"] in gains
    again = virtual_goal(ON_NOMINAL)
    again.restore(controller.state())
    assert again.act(seen) == pytest.approx(controller.act(seen))
    assert again.state()["gain"] == controller.state()["gain"]


def test_learning_ends_below_the_threshold() -> None:
    near = np.array([[0.01, 0.0]])
    for threshold, expected in ((None, -0.5 * near), (0.02, 0.0 * near)):
        controller, seen = virtual_goal(ON_NOMINAL, 0.5, threshold), observation_of(encode())
        controller.learn(outcome_of(seen, controller.act(seen), near))
        assert controller.act(seen) * ON_NOMINAL.scale == pytest.approx(expected, abs=1e-6)
    controller.learn(outcome_of(seen, controller.act(seen), 10.0 * near))
    assert not controller.act(seen).any()
    with pytest.raises(PntGymError, match="threshold is 0"):
        virtual_goal(ON_NOMINAL, 0.5, 0.0)


def test_buckets_are_apart_and_a_new_place_begins_from_what_its_item_has_learned() -> None:
    controller, kind = virtual_goal(ON_NOMINAL, 0.5), np.array([2])
    here, there = (encode(target_x=b.x, target_y=b.y) for b in NOMINAL.bins.fixed)
    controller.learn(outcome_of(observation_of(here), np.zeros((1, 2)), np.array([[0.04, 0.0]])))
    assert controller.act(observation_of(there))[0, 0] * NOMINAL.action.along == pytest.approx(-0.02, abs=1e-6)
    controller.learn(outcome_of(observation_of(there), np.zeros((1, 2)), np.array([[-0.1, 0.0]])))
    for seen, expected in ((here, -0.02), (there, 0.04)):
        assert controller.act(observation_of(seen))[0, 0] * NOMINAL.action.along == pytest.approx(expected, abs=1e-6)
        assert not controller.act(observation_of(seen, kind)).any()


def test_buckets_are_bins_or_quarters() -> None:
    fixed = observation_of(np.concatenate([encode(target_x=b.x, target_y=b.y) for b in NOMINAL.bins.fixed]))
    assert [place for _, place in ON_NOMINAL.buckets(fixed.features, fixed.kind)] == ["inside", "outside"]
    corners = [(-0.4, 0.3), (0.4, 0.3), (-0.4, 0.7), (0.4, 0.7)]
    drawn = observation_of(np.concatenate([encode(target_x=x, target_y=y) for x, y in corners]))
    assert [p for _, p in ON_WASTE.buckets(drawn.features, drawn.kind)] == [
        "left-near",
        "right-near",
        "left-far",
        "right-far",
    ]


def test_goals_of_a_thrower_fall_into_quarters_of_their_region() -> None:
    env = make_vector("OneJointThrow-v0", num_envs=1)
    (x_low, x_high), (y_low, y_high) = GoalRegion().x, GoalRegion().y
    corners = [(x, y) for y in (y_low, y_high) for x in (x_low, x_high)]
    rows = [
        [({"goal_x": x, "goal_y": y}.get(f.name, f.centre) - f.centre) / f.scale for f in ARM_FEATURES]
        for x, y in corners
    ]
    buckets = core_of(env).correction.buckets(np.array(rows, dtype=np.float32), np.zeros(4, dtype=np.int64))
    env.close()
    assert [place for _, place in buckets] == ["left-low", "right-low", "left-high", "right-high"]


def test_clipped_and_unmeasured_throws_teach_nothing() -> None:
    seen = observation_of(np.repeat(encode(), 2, axis=0))
    outcome = outcome_of(seen, np.zeros((2, 2)), np.array([[0.1, 0.0], [np.nan, 0.0]]))
    outcome.clipped[0] = True
    controller = virtual_goal(ON_NOMINAL)
    controller.learn(outcome)
    assert not controller.act(seen).any()


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_shifts_and_actions_agree_inside_the_range(along: float, across: float) -> None:
    action = to_action(np.array([[along, across]]), ON_WASTE)
    assert (np.abs(action) <= 1.0).all()
    seen = observation_of(encode())
    back = ideal_offsets(outcome_of(seen, action, np.zeros((1, 2))), ON_WASTE)
    inside = np.clip([along, across], [-0.2, -0.06], [0.2, 0.06])
    assert back[0] == pytest.approx(inside, abs=1e-6)


def test_ridge_recovers_a_quadratic_law() -> None:
    random = np.random.default_rng(0)
    x = random.standard_normal((900, 26))
    truth = np.stack([0.02 + 0.03 * x[:, 0] - 0.01 * x[:, 1] * x[:, 2], 0.005 * x[:, 3] ** 2], axis=-1)
    model = Ridge()
    model.fit(x, truth + 0.001 * random.standard_normal(truth.shape), 0)
    fresh = random.standard_normal((500, 26))
    right = np.stack([0.02 + 0.03 * fresh[:, 0] - 0.01 * fresh[:, 1] * fresh[:, 2], 0.005 * fresh[:, 3] ** 2], axis=-1)
    assert np.abs(model.predict(fresh) - right).mean() < 0.001


def test_ridge_without_signal_predicts_the_mean() -> None:
    random = np.random.default_rng(1)
    x, y = random.standard_normal((60, 26)), 0.03 + 0.02 * random.standard_normal((60, 2))
    model = Ridge()
    model.fit(x, y, 0)
    off = model.predict(random.standard_normal((500, 26))) - 0.03
    assert np.sqrt((off**2).mean()) < 0.015  # a fit to the noise would be off by 0.02 and more


def test_ridge_learns_from_few_throws_what_a_table_cannot() -> None:
    env = ToyVectorEnv(8)
    error = {}
    for name in ("ridge", "virtual_goal"):
        controller = make_controller(name, env)
        practise(controller, env, 160, 0)
        error[name] = summary(throw_held_out(controller, env, 400, 0))["landing_error_mean_m"]
    assert error["ridge"] < 0.5 * error["virtual_goal"]


def test_exploration_ends_with_practice() -> None:
    env = ToyVectorEnv(8)
    controller = make_controller("ridge", env)
    assert isinstance(controller, Learner)
    seen = observation_of(env.reset(seed=0)[0])
    controller.begin_practice(100)
    assert not np.array_equal(controller.act(seen), controller.act(seen))
    controller.end_practice()
    assert np.array_equal(controller.act(seen), controller.act(seen))


@cache
def practised(name: str, cell: Any) -> Any:
    """A learner after forty throws of practice."""
    controller = make_controller(name, cell(8))
    practise(controller, cell(8), 40, 0)
    return controller


@pytest.mark.parametrize("name", LEARNERS)
@pytest.mark.parametrize("cell", [ToyVectorEnv, PoseVectorEnv])
def test_state_survives_a_file(name: str, cell: Any, tmp_path: Path) -> None:
    """Before practice, too."""
    env = cell(8)
    second = make_controller(name, env)
    features, info = env.reset(seed=5)
    seen = observation_of(features, info["kind"])
    for throws, first in ((0, make_controller(name, env)), (40, practised(name, cell))):
        save_state(first, tmp_path / "state")
        load_state(second, tmp_path / "state")
        assert first.act(seen).any() == (throws > 0)
        assert np.array_equal(first.act(seen), second.act(seen))
        assert first.state().keys() == second.state().keys()
        assert all(np.array_equal(value, second.state()[key]) for key, value in first.state().items())


@pytest.mark.parametrize("name", LEARNERS)
def test_state_serves_another_level(name: str, tmp_path: Path) -> None:
    env, elsewhere = ToyVectorEnv(8), make_controller(name, ToyVectorEnv(8, level="unseen"))
    save_state(practised(name, ToyVectorEnv), tmp_path / "state")
    load_state(elsewhere, tmp_path / "state")
    assert np.isfinite(elsewhere.act(observation_of(env.reset(seed=5)[0]))).all()


def test_a_table_saved_with_two_numbers_per_bucket_is_read(tmp_path: Path) -> None:
    """The form of the files on disk: names of the buckets, their shifts in metres, their counts."""
    buckets = np.array(["paper|inside", "paper|*"])
    shift, count = np.array([[-0.05, 0.012], [0.02, 0.0]]), np.array([4, 9])
    np.savez(tmp_path / "old.npz", controller=np.array("virtual_goal"), buckets=buckets, shift=shift, count=count)
    controller = virtual_goal(ON_NOMINAL)
    load_state(controller, tmp_path / "old.npz")
    places = {b.name: encode(target_x=b.x, target_y=b.y) for b in NOMINAL.bins.fixed}
    for place, expected in (("inside", shift[0]), ("outside", shift[1])):
        seen = observation_of(places[place])
        assert controller.act(seen)[0] * ON_NOMINAL.scale == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", LEARNERS)
def test_reset_forgets_everything(name: str) -> None:
    env = ToyVectorEnv(8)
    controller = make_controller(name, env)
    controller.restore(practised(name, ToyVectorEnv).state())
    features, info = env.reset(seed=5)
    seen = observation_of(features, info["kind"])
    assert controller.act(seen).any()
    controller.reset(0)
    assert not controller.act(seen).any()


@pytest.mark.parametrize("name", [n for n in NAMES if n not in ("analytic", "random", *GRASPING_NAMES)])
def test_controllers_of_shifts_say_that_xyz_is_not_theirs(name: str) -> None:
    with pytest.raises(UsageError, match="action of 2 numbers, not 3"):
        make_controller(name, ToyVectorEnv(2, action_mode="release_xyz"))


# A cell of another kind: four numbers, of which none is along or across a throw.


@pytest.mark.parametrize("name", [*LEARNERS, "oracle"])
def test_four_numbers_are_learned_as_two_are(name: str) -> None:
    env = PoseVectorEnv()
    base = throw_held_out(make_controller("analytic", env), env, 80, 0)
    np.testing.assert_allclose(base.error.mean(axis=0), POSE_BIAS, atol=0.02 * POSE.tolerance.max())
    controller = make_controller(name, env)
    practise(controller, env, 160, 0)
    left = throw_held_out(controller, env, 160, 0)
    assert left.error.shape == (160, 4)
    # What is left of the bias is small against the tolerance, in every coordinate.
    assert (np.abs(left.error.mean(axis=0)) < 0.2 * POSE.tolerance).all()
    assert base.is_success.mean() == 0.0
    assert left.is_success.mean() > 0.99


@pytest.mark.parametrize("name", LEARNERS)
def test_state_of_another_cell_is_refused(name: str, tmp_path: Path) -> None:
    for cell, other in ((ToyVectorEnv, PoseVectorEnv), (PoseVectorEnv, ToyVectorEnv)):
        save_state(practised(name, cell), tmp_path / "state.npz")
        with pytest.raises(UsageError, match=f"the saved state of '{name}'") as refused:
            load_state(make_controller(name, other(8)), tmp_path / "state.npz")
        assert "\n" not in str(refused.value)
