"""What a user gets wrong: one sentence that names the value, and an environment that still works afterwards."""

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from pnt_gym.envs.conveyor import PnTConveyorEnv, PnTConveyorVectorEnv
from pnt_gym.errors import ActionError, ConfigError
from tests.tools.throws import CONVEYOR, MODES, zeros


def sentence(caught, *parts):
    text = str(caught.value)
    assert isinstance(caught.value, ValueError)
    assert "\n" not in text
    for part in parts:
        assert part in text
    return text


BAD_ACTIONS = [
    np.array([np.nan, 0.0]), np.array([0.0, np.inf]), np.array([-np.inf, 0.0]), np.zeros(5), np.zeros((1, 2)), 0.5,
    np.zeros(0),
]  # fmt: skip


@pytest.mark.parametrize("action", BAD_ACTIONS, ids=repr)
@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_a_rejected_action_changes_nothing(env_id, action):
    hurt, unhurt = (gym.make(env_id).unwrapped for _ in range(2))
    hurt.reset(seed=1)
    unhurt.reset(seed=1)
    with pytest.raises(ActionError) as caught:
        hurt.step(action)
    sentence(caught, "action")
    a, b = hurt.step(zeros(env_id)), unhurt.step(zeros(env_id))
    assert np.array_equal(a[0], b[0])
    assert a[1:] == b[1:]


@pytest.mark.parametrize(
    "actions", [np.full((2, 2), np.nan), np.zeros((3, 2)), np.zeros(2), np.zeros((2, 3)), np.zeros((2, 2, 1))], ids=repr
)
def test_a_vector_environment_rejects_and_goes_on(actions):
    hurt, unhurt = (gym.make_vec("PnTConveyor-v0", num_envs=2) for _ in range(2))
    hurt.reset(seed=1)
    unhurt.reset(seed=1)
    with pytest.raises(ActionError) as caught:
        hurt.step(actions)
    sentence(caught, "action")
    a, b = hurt.step(np.zeros((2, 2))), unhurt.step(np.zeros((2, 2)))
    assert np.array_equal(a[0], b[0])
    assert np.array_equal(a[1], b[1])


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_unknown_settings(env_id):
    with pytest.raises(ConfigError) as caught:
        gym.make(env_id, level="nowhere")
    sentence(caught, "unknown level 'nowhere'", "nominal")
    with pytest.raises(ConfigError) as caught:
        gym.make(env_id, action_mode="telepathy")
    sentence(caught, "action_mode is 'telepathy'", *MODES[env_id])
    with pytest.raises(ConfigError) as caught:
        gym.make_vec(env_id, num_envs=2, action_mode="telepathy")
    sentence(caught, "action_mode is 'telepathy'")


@pytest.mark.parametrize("env_id", CONVEYOR)
def test_a_cell_that_cannot_be(env_id):
    with pytest.raises(ConfigError) as caught:
        gym.make(env_id, level={"bins": {"fixed": [{"name": "b", "x": 0.3, "y": -0.3}]}})
    sentence(caught, "bin 'b'", "lies on the belt")


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
@pytest.mark.parametrize("count", [0, -1])
def test_an_environment_needs_a_cell(env_id, count):
    with pytest.raises(ConfigError) as caught:
        gym.make_vec(env_id, num_envs=count)
    sentence(caught, str(count))


@pytest.mark.parametrize("threads", [0, -2])
def test_physics_needs_a_thread(threads):
    with pytest.raises(ConfigError) as caught:
        gym.make("PnTConveyor-v0", threads=threads)
    sentence(caught, "threads", str(threads))


def test_unknown_render_modes():
    with pytest.raises(ConfigError) as caught:
        PnTConveyorEnv(render_mode="hologram")
    sentence(caught, "render_mode is 'hologram'", "rgb_array", "rgb_array_list", "human")
    with pytest.raises(ConfigError) as caught:
        PnTConveyorVectorEnv(2, render_mode="human")
    sentence(caught, "render_mode is 'human'", "rgb_array")


def test_a_window_needs_a_display(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    env = gym.make("PnTConveyor-v0", render_mode="human").unwrapped
    with pytest.raises(ConfigError) as caught:
        env.reset(seed=0)
    sentence(caught, "needs a display", "rgb_array")
    env.close()


def test_a_list_of_seeds_of_another_length():
    env = gym.make_vec("PnTRelease-v0", num_envs=3)
    with pytest.raises(ValueError, match="seed has 2 entries; this environment has 3 cells"):
        env.reset(seed=[1, 2])


def test_a_step_before_the_first_reset_is_refused_by_gymnasium():
    with pytest.raises(gym.error.ResetNeeded):
        gym.make("PnTConveyor-v0").step(np.zeros(2, dtype=np.float32))


def test_unknown_arguments_are_named():
    with pytest.raises(TypeError, match="colour"):
        gym.make("PnTConveyor-v0", colour="red")
