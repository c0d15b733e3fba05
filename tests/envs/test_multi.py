"""A line as a game of several agents."""

import warnings

import gymnasium as gym
import numpy as np
import pytest
from pettingzoo.test import api_test

import pnt_gym  # noqa: F401 - registers the environments
from pnt_gym.envs.multi import PnTLineAEC
from pnt_gym.errors import ActionError, ConfigError

SHORT = {"base": "skills3", "duration": 6.0}


def choice(info):
    there = np.flatnonzero(info["action_mask"])
    return int(there[0]) if there.size else 0


def test_pettingzoo_finds_nothing_wrong_with_it():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        api_test(PnTLineAEC(SHORT), num_cycles=20)


def test_its_agents_do_what_the_single_environment_does():
    game, env = PnTLineAEC(SHORT), gym.make("PnTLine-v0", level=SHORT)
    game.reset(seed=5)
    observation, told = env.reset(seed=5)
    over, gained = False, 0.0
    while not over:
        agent = game.agent_selection
        assert agent == f"robot_{told['robot']}"
        np.testing.assert_array_equal(game.observe(agent), observation)
        np.testing.assert_array_equal(game.infos[agent]["action_mask"], told["action_mask"])
        game.step(choice(game.infos[agent]))
        observation, reward, _, over, told = env.step(choice(told))
        assert game.rewards == dict.fromkeys(game.agents, pytest.approx(reward, abs=1e-12))
        gained += reward
    assert all(game.truncations.values())
    assert gained != 0.0


def test_who_is_not_at_its_turn_sees_the_line_and_no_choice():
    game = PnTLineAEC(SHORT)
    game.reset(seed=1)
    for name in game.agents:
        own = name == game.agent_selection
        assert game.infos[name]["action_mask"].any() == own
        assert game.observation_space(name).contains(game.observe(name))


@pytest.mark.parametrize("action", [None, 16, -1, 0.5])
def test_an_action_that_is_none_is_refused(action):
    game = PnTLineAEC(SHORT)
    game.reset(seed=1)
    with pytest.raises(ActionError, match="0 to 15"):
        game.step(action)


def test_a_level_that_describes_no_line_is_refused():
    with pytest.raises(ConfigError, match="windows that overlap"):
        PnTLineAEC({"base": "skills3", "robots": [{"name": "a", "x": 0.0}, {"name": "b", "x": 0.1}]})
