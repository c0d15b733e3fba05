"""The environments as Gymnasium sees them: its own checker, episodes, rewards and infos."""

import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils import env_checker
from gymnasium.utils.env_checker import check_env, data_equivalence
from stable_baselines3.common.env_checker import check_env as check_for_sb3

import pnt_gym
from pnt_gym.cells.base.core import COMMON_INFO
from pnt_gym.cells.conveyor.action import FIXED_THROW
from pnt_gym.cells.conveyor.observation import decode
from tests.tools.nightly import with_nightly
from tests.tools.throws import FEATURES, GRASP, LINE, MODES, THROWS, vary, zeros

SHORT = vary("nominal", picks_per_shift=4)
SHIFTS = ("PnTConveyor-v0", "PnTAdapt-v0")
CASES = [(env_id, mode) for env_id in pnt_gym.ENV_IDS for mode in MODES[env_id]]
FAMILIES = ("PnTRelease-v0", "OneJointThrow-v0", "GripperToss-v0")
"""An environment of every robot, whose modes are those of the robot's other environments."""
CHECKED = with_nightly(CASES, [case for case in CASES if case[0] in FAMILIES or case[1] == next(iter(MODES[case[0]]))])


def equivalent(first, second, exact=False):
    """As Gymnasium's checker sees it, which takes NaN, the landing that no camera saw, for another value than NaN."""
    both_nan = isinstance(first, float) and isinstance(second, float) and np.isnan([first, second]).all()
    return both_nan or data_equivalence(first, second, exact)


@pytest.mark.parametrize(("env_id", "mode"), CHECKED)
def test_gymnasiums_checker_has_nothing_to_say(env_id, mode, opengl, monkeypatch):
    monkeypatch.setattr(env_checker, "data_equivalence", equivalent)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):  # a window would open where there is one
        monkeypatch.delenv(name, raising=False)
    env = gym.make(env_id, action_mode=mode, width=64, height=48)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped, skip_render_check=mode != next(iter(MODES[env_id])))
    env.close()


@pytest.mark.parametrize(("env_id", "mode"), CHECKED)
def test_stable_baselines_checker_has_nothing_to_say(env_id, mode):
    env = gym.make(env_id, action_mode=mode)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_for_sb3(env, warn=True)
    env.close()


@pytest.mark.parametrize(("env_id", "mode"), CASES)
def test_spaces(env_id, mode):
    env = gym.make(env_id, action_mode=mode)
    vector = gym.spaces.Box(-5.0, 5.0, (FEATURES[env_id],), np.float32)
    image = gym.spaces.Box(0, 255, (5, 48, 48), np.uint8)
    assert env.observation_space == (gym.spaces.Dict(image=image, vector=vector) if env_id in GRASP else vector)
    choices, numbers = gym.spaces.Discrete(16), gym.spaces.Box(-1.0, 1.0, (MODES[env_id][mode],), np.float32)
    assert env.action_space == (choices if env_id in LINE else numbers)
    env.close()


@pytest.mark.parametrize("env_id", SHIFTS)
def test_a_shift_is_truncated_after_its_picks_and_never_terminated(env_id):
    env = gym.make(env_id, level=SHORT)
    env.reset(seed=0)
    ends = [env.step(np.zeros(2, dtype=np.float32))[2:4] for _ in range(4)]
    assert ends == [(False, False)] * 3 + [(False, True)]
    env.reset()
    assert env.step(np.zeros(2, dtype=np.float32))[2:4] == (False, False)
    assert gym.make(env_id).unwrapped.core.config.picks_per_shift == 50


SINGLE = ("PnTRelease-v0", "OneJointThrow-v0", "OneJointSort-v0", "GripperToss-v0")


@pytest.mark.parametrize("env_id", SINGLE)
def test_a_single_throw_is_terminated_and_its_observation_is_that_of_the_next_episode(env_id):
    env = gym.make(env_id)
    first, _ = env.reset(seed=1)
    after, _, terminated, truncated, _ = env.step(zeros(env_id))
    assert (terminated, truncated) == (True, False)
    following, _ = env.reset()
    assert np.array_equal(after, following)
    if env_id != "OneJointSort-v0":  # there the same pallet may come twice
        assert not np.array_equal(after, first)


def test_a_reset_without_a_throw_draws_a_new_pick():
    env = gym.make("PnTRelease-v0")
    first, _ = env.reset(seed=1)
    second, _ = env.reset()
    assert not np.array_equal(first, second)


@pytest.mark.parametrize("env_id", SHIFTS)
def test_returned_observations_are_the_callers_own(env_id):
    """An observation that is changed by the caller, or kept, does not change with the environment."""
    env = gym.make(env_id)
    first, _ = env.reset(seed=0)
    kept = first.copy()
    second, *_ = env.step(np.zeros(2, dtype=np.float32))
    assert np.array_equal(first, kept)
    second[:] = 0.0
    third, *_ = env.step(np.zeros(2, dtype=np.float32))
    assert not np.array_equal(third, second)


@pytest.mark.parametrize("env_id", SHIFTS)
def test_the_info_is_of_plain_values_and_agrees_with_itself(env_id):
    env = gym.make(env_id, level="waste")
    _, first = env.reset(seed=3)
    kind = first["kind"]
    observation, *_ = env.reset(seed=3)
    picked = set()
    for _ in range(24):
        seen = decode(observation)
        observation, reward, _, _, info = env.step(np.zeros(2, dtype=np.float32))
        assert all(type(value) in (int, float, bool) for value in info.values())
        assert type(reward) is float
        assert info["item"] == kind
        kind = info["kind"]
        assert info["is_success"] == (info["in_opening"] and info["in_bin"])
        assert info["rim"] == (info["in_opening"] and not info["in_bin"])
        error = np.hypot(info["landing_along"], info["landing_across"])
        assert error == pytest.approx(info["landing_error"], nan_ok=True)
        assert np.isnan(error) == (not info["picked"])
        assert not (info["dropped"] and not info["picked"])
        assert not (info["is_success"] and (info["dropped"] or not info["picked"]))
        picked.add(info["picked"])
        assert info["target_x"] == pytest.approx(float(seen["target_x"]), abs=1e-5)
        assert info["target_y"] == pytest.approx(float(seen["target_y"]), abs=1e-5)
        assert info["cycle_time"] > info["wait_time"] >= 0.0
        assert 0.0 < info["peak_torque"] < 530.0
    assert picked == {True, False}


@pytest.mark.parametrize("env_id", THROWS)
def test_every_environment_tells_what_controllers_and_figures_need(env_id):
    env = gym.make_vec(env_id, num_envs=4)
    _, first = env.reset(seed=0)
    *_, info = env.step(np.zeros(env.action_space.shape, dtype=np.float32))
    core = env.unwrapped.core
    assert set(COMMON_INFO) | set(core.correction.errors) <= set(info)
    assert (first["kind"] < len(core.item_names)).all()
    assert core.action_mode in core.shift_modes
    assert set(core.shift_modes) <= set(core.action_sizes)
    assert core.action_sizes[core.action_mode] == core.correction.count == env.single_action_space.shape[0]
    for values in (core.correction.scale, core.correction.exploration, core.correction.tolerance):
        assert values.shape == (core.correction.count,)
        assert (values > 0.0).all()
    env.reset(seed=0)
    seen = core.preview(np.zeros(env.action_space.shape), jitter=True)
    for name in core.correction.errors:
        np.testing.assert_allclose(getattr(seen, name), info[name], atol=1e-6)


def test_contexts_of_single_throws_do_not_depend_on_actions():
    """Throws of two policies on equal seeds are paired."""
    envs = [gym.make("PnTRelease-v0", level="waste") for _ in range(2)]
    observations = [env.reset(seed=5)[0] for env in envs]
    rewards = []
    for k in range(5):
        assert np.array_equal(*observations)
        actions = np.zeros(2, dtype=np.float32), np.full(2, (-1.0) ** k, dtype=np.float32)
        steps = [env.step(action) for env, action in zip(envs, actions, strict=True)]
        observations = [env.reset()[0] for env in envs]
        rewards.append([step[1] for step in steps])
    assert not np.array_equal(*np.array(rewards).T)


@pytest.mark.parametrize("env_id", SINGLE)
def test_the_zero_action_is_the_same_throw_in_every_mode_that_corrects_the_plan(env_id):
    errors = []
    for mode, size in MODES[env_id].items():
        if mode == FIXED_THROW:
            continue
        env = gym.make(env_id, action_mode=mode)
        env.reset(seed=2)
        errors.append(env.step(np.zeros(size, dtype=np.float32))[4]["landing_error"])
    assert np.isfinite(errors[0])
    np.testing.assert_allclose(errors, errors[0], atol=1e-6)


def test_closing_twice_is_safe():
    env = gym.make("PnTConveyor-v0", render_mode="rgb_array")
    env.reset(seed=0)
    env.close()
    env.close()
    vector = gym.make_vec("PnTConveyor-v0", num_envs=2)
    vector.reset(seed=0)
    vector.close()
    vector.close()


def test_an_environment_goes_on_after_close():
    """Closing frees the renderer; physics does not need it."""
    env = gym.make("PnTRelease-v0").unwrapped
    env.reset(seed=0)
    before = env.step(np.zeros(2))[1]
    env.close()
    env.reset(seed=0)
    assert env.step(np.zeros(2))[1] == before
