"""The vector form gives what Gymnasium's own loop over single environments gives, masks of infos included."""

import copy
import pickle
from itertools import product

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from pnt_gym.errors import ConfigError
from tests.tools.nightly import with_nightly
from tests.tools.throws import CONVEYOR, GRASP, LINE, same_bits, vary, zeros
from tests.tools.vectors import LEVELS, N, actions, assert_same_steps, both

SEED = 21
RESETS = ("SameStep", "NextStep", "Disabled")
OF_RESETS = {"kind", "robot", "action_mask"}
"""What a reset tells, too."""
LIMITS = {"PnTAdapt-v0": 2, "PnTRelease-v0": 1, "OneJointAssembly-v0": 1, "PnTLine-v0": 3}
"""Steps of an episode where a cell's own would be longer, or just as long."""
DAILY = {
    *(f"{env_id}-SameStep" for env_id in pnt_gym.ENV_IDS),
    *(f"PnTRelease-v0-{mode}" for mode in RESETS),
    "PnTConveyor-v0-NextStep",
}
"""All environments as they are by default, and the other forms of reset where an episode is a throw or several."""
LIMITED = {
    *(("PnTRelease-v0", mode) for mode in RESETS),
    *zip(("PnTAdapt-v0", "OneJointAssembly-v0", "PnTLine-v0"), RESETS, strict=True),
}
LONG = {**LEVELS, "PnTAdapt-v0": vary("drift_mix", picks_per_shift=4)}


@pytest.fixture(
    scope="module", params=with_nightly(["-".join(case) for case in product(pnt_gym.ENV_IDS, RESETS)], DAILY)
)
def compared(request):
    """Steps that were equal."""
    env_id, mode = request.param.rsplit("-", 1)
    return env_id, mode, assert_same_steps(*both(env_id, mode), actions(env_id), SEED)


def test_every_step_and_reset_is_that_of_gymnasiums_vectorizer(compared):
    _, _, steps = compared
    over = np.array([terminated | truncated for _, _, terminated, truncated, _ in steps])
    assert over.sum() >= 2 * N  # across several resets


def test_among_these_steps_are_picks_that_failed(compared):
    """So that what is compared here is compared of them too."""
    env_id, _, steps = compared
    told = [info.get("final_info", info) for *_, info in steps]
    unpicked = [~info["picked"][info["_picked"]] for info in told if "picked" in info]
    assert any(of.any() for of in unpicked) == (env_id in (*CONVEYOR, *LINE, *GRASP))


def test_results_stand_in_the_info_for_cells_that_begin_anew_in_the_same_step(compared):
    _, mode, steps = compared
    ends = [info for *_, info in steps if "final_info" in info]
    assert bool(ends) == (mode == "SameStep")
    for info in ends:
        results = {name for name in info["final_info"] if not name.startswith("_")} - OF_RESETS
        assert {"is_success", "cycle_time"} <= results
        assert all(same_bits(info[name], info["final_info"][name]) for name in results)
        assert not any((info[f"_{name}"] & info["_final_info"]).any() for name in results)


def test_a_cell_that_is_reset_in_the_next_step_has_no_results_of_it():
    """Every cell throws in a rollout; nothing is told of a throw that never was."""
    env = gym.make_vec("PnTRelease-v0", num_envs=2, autoreset_mode="NextStep")
    env.reset(seed=0)
    env.step(zeros("PnTRelease-v0", 2))
    env.reset(options={"reset_mask": np.array([True, False])})
    *_, info = env.step(zeros("PnTRelease-v0", 2))
    assert np.isnan(info["cycle_time"]).tolist() == [False, True] == (~info["_cycle_time"]).tolist()
    assert (info["is_success"][1], info["item"][1]) == (False, 0)


def test_after_a_reset_of_some_cells_masks_hold_for_these():
    env = gym.make_vec("PnTLine-v0", num_envs=N, level=LEVELS["PnTLine-v0"])
    env.reset(seed=0)
    mask = np.array([False, True, False])
    _, info = env.reset(options={"reset_mask": mask})
    assert info.keys() == {"robot", "action_mask", "_robot", "_action_mask"}
    assert same_bits(info["_action_mask"], mask)
    assert info["action_mask"].any(axis=1).all()  # choices stand there of every line


@pytest.mark.parametrize(("env_id", "mode"), with_nightly(product(LIMITS, RESETS), LIMITED))
def test_a_time_limit_is_that_of_gymnasiums_wrapper(env_id, mode):
    limit = LIMITS[env_id]
    envs = both(env_id, mode, level=LONG[env_id], max_episode_steps=limit)
    steps = assert_same_steps(*envs, actions(env_id, 3 * limit + 1), SEED)
    terminated, truncated = (np.array([step[k] for step in steps]) for k in (2, 3))
    assert truncated.sum() >= 2 * N
    assert (terminated & truncated).any() == (env_id == "PnTRelease-v0")


def test_a_time_limit_goes_on_in_a_copy():
    env = gym.make_vec("PnTLine-v0", num_envs=2, level="value", max_episode_steps=3)
    env.reset(seed=0)
    env.step(zeros("PnTLine-v0", 2))
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env.unwrapped))):
        assert [other.step(zeros("PnTLine-v0", 2))[3].all() for _ in range(3)] == [False, True, False]


@pytest.mark.parametrize("steps", [0, -1, True, 2.0, "5", float("nan"), [5]])
def test_no_number_of_steps_is_refused(steps):
    with pytest.raises(ConfigError, match=r"max_episode_steps is .*; it must be a whole number, at least 1, or None"):
        gym.make_vec("PnTLine-v0", num_envs=2, level="value", max_episode_steps=steps)


def test_a_specification_keeps_its_time_limit():
    env = gym.make_vec(gym.make("PnTLine-v0", level="value", max_episode_steps=2).spec, num_envs=2)
    again = gym.make_vec(env.spec)
    assert again.spec.kwargs["max_episode_steps"] == 2
    again.reset(seed=0)
    cuts = [again.step(zeros("PnTLine-v0", 2))[3].all() for _ in range(3)]
    assert cuts == [False, True, False]


def test_nothing_checks_a_vector_environment():
    gym.make_vec("PnTRelease-v0", num_envs=1, disable_env_checker=True).close()
    with pytest.raises(ConfigError, match="disable_env_checker is False; it must be True or None"):
        gym.make_vec("PnTRelease-v0", num_envs=1, disable_env_checker=False)
