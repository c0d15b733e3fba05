"""The vector form gives what Gymnasium's own loop over single environments gives, masks of infos included."""

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from tests.tools.throws import CONVEYOR, LINE, same_bits, zeros
from tests.tools.vectors import LEVELS, N, actions, assert_same_steps, both

SEED = 21
RESETS = ("SameStep", "NextStep", "Disabled")
OF_RESETS = {"kind", "robot", "action_mask"}
"""What a reset tells, too."""


@pytest.fixture(scope="module", params=[(env_id, mode) for env_id in pnt_gym.ENV_IDS for mode in RESETS], ids="-".join)
def compared(request):
    """Steps that were equal."""
    env_id, mode = request.param
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
    assert any(of.any() for of in unpicked) == (env_id in (*CONVEYOR, *LINE))


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
