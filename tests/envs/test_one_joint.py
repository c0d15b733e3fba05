"""The one-joint tasks: what an action does, when an episode is over, and what counts as a success."""

import gymnasium as gym
import numpy as np

from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.observation import FEATURES, decode
from pnt_gym.cells.one_joint.tasks import PUSHED
from tests.tools.throws import zeros

PAPER = np.array([0.0, 0.4, np.deg2rad(150.0), 0.0])


def vector(env_id, count, level="ideal", **options):
    env = gym.make_vec(env_id, num_envs=count, level=level, **options)
    env.reset(seed=3)
    return env


def test_a_virtual_goal_moves_each_error_one_to_one():
    env = vector("OneJointThrow-v0", 8, level="ideal")
    core = env.unwrapped.core
    actions = 0.05 * np.concatenate([np.eye(4), -np.eye(4)])
    *_, info = env.step(actions)
    free = ~info["residual_clipped"]
    assert free.sum() >= 6
    errors = np.stack([info[name] for name in core.correction.errors], axis=-1)
    # Where a flight passes the old goal nearest is not where it meets the new one; the angle and the speed differ.
    near = np.abs(errors - actions * core.correction.scale) <= np.array([0.012, 0.012, 0.15, 0.1])
    assert near[free].mean() > 0.9


def test_the_release_state_is_moved_by_raw_amounts():
    env = vector("OneJointThrow-v0", 3, level="paper", action_mode="release_state")
    core = env.unwrapped.core
    assert core.correction is None
    before = core.context.plans.u.copy()
    plans, clipped = core.plan(-0.1 * np.eye(3))
    assert not clipped.any()
    moved = plans.u[:, :3] - before[:, :3]
    np.testing.assert_allclose(moved, -0.1 * np.diag(core.config.action.release_scale()), atol=1e-12)


def test_an_assembly_goes_on_after_its_first_part_and_is_over_after_the_second():
    env = gym.make("OneJointAssembly-v0", level="ideal")
    observation, info = env.reset(seed=0)
    assert info["kind"] == 0
    observation, _, terminated, truncated, info = env.step(zeros("OneJointAssembly-v0"))
    assert (terminated, truncated, info["is_success"], info["is_complete"]) == (False, False, True, False)
    assert info["kind"] == 1
    assert decode(observation)["is_second"] == 1.0
    _, _, terminated, truncated, info = env.step(zeros("OneJointAssembly-v0"))
    assert (terminated, truncated, info["is_success"], info["is_complete"]) == (True, False, True, True)
    assert info["kind"] == 0


def test_an_assembly_whose_first_part_is_missed_is_over():
    env = gym.make("OneJointAssembly-v0", level="late")
    env.reset(seed=0)
    _, _, terminated, _, info = env.step(zeros("OneJointAssembly-v0"))
    assert terminated
    assert not info["is_success"]
    assert info["kind"] == 0


def test_the_paper_level_has_the_papers_goal():
    env = gym.make("OneJointThrow-v0", level="paper")
    observation, _ = env.reset(seed=0)
    seen = decode(observation)
    goal = np.array([seen[f"goal_{name}"] for name in ("x", "y", "phi", "dy")])
    np.testing.assert_allclose(goal, PAPER, atol=1e-6)
    # Angle, speed and radius at the release, and the flight time, from an independent solution of Eq. 11.
    state = [seen[name] for name in ("release_angle", "release_speed", "radius", "flight_time")]
    np.testing.assert_allclose(state, [np.deg2rad(20.835), 9.3190, 0.27858, 0.24191], rtol=2e-4)


def test_nothing_hidden_is_seen():
    """The observation is the same whatever the mismatch is."""
    seen = []
    for level in ("ideal", "nominal", "late"):
        env = gym.make("OneJointThrow-v0", level=OneJointConfig.load(level, goals=OneJointConfig.load("paper").goals))
        seen.append(env.reset(seed=5)[0])
    assert len(seen[0]) == len(FEATURES)
    assert np.array_equal(seen[0], seen[1])
    assert np.array_equal(seen[0], seen[2])


def test_a_pushed_block_is_thrown_at_goals_that_it_can_reach():
    def names(env_id, level):
        return gym.make(env_id, level=level).unwrapped.core.item_names

    assert names("OneJointThrow-v0", "contact") == tuple(goal.name for goal in PUSHED)
    assert names("OneJointThrow-v0", {"release": "contact", "goals": {"region": {}}}) == ("goal",)
    for env_id in ("OneJointSort-v0", "OneJointAssembly-v0"):
        assert names(env_id, "contact") == names(env_id, "nominal")
