"""Any thread draws an environment, one after the other or at the same time, and any thread closes it."""

import threading
from concurrent.futures import ThreadPoolExecutor

import gymnasium as gym
import mujoco
import numpy as np
import pytest

from pnt_gym.cells.base import canvas
from pnt_gym.errors import ConfigError
from tests.tools.throws import LINE

pytestmark = [pytest.mark.usefixtures("opengl"), pytest.mark.filterwarnings("error")]


def drawn(env_id):
    """An environment that has been reset."""
    env = gym.make(env_id, render_mode="rgb_array", width=160, height=96)
    env.reset(seed=0)
    return env


def elsewhere(work):
    """What work gives in a thread of its own, which ends with it."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(work).result()


@pytest.mark.parametrize("env_id", ["PnTRelease-v0", *LINE])
def test_each_thread_draws_the_same_picture_and_another_closes(env_id):
    env = drawn(env_id)
    first = env.render()
    assert first.std() > 20.0
    np.testing.assert_array_equal(elsewhere(env.render), first)
    np.testing.assert_array_equal(env.render(), first)
    elsewhere(env.close)


def test_a_thread_draws_what_it_made_while_another_one_draws():
    env, begun = drawn("PnTRelease-v0"), threading.Barrier(2)
    first = env.render()

    def pictures(make):
        begun.wait()
        other = make()
        return [other.render() for _ in range(2)]

    with ThreadPoolExecutor(2) as pool:
        frames = pool.map(pictures, (lambda: env, lambda: drawn("PnTRelease-v0")))
    assert all((frame == first).all() for several in frames for frame in several)


def test_threads_draw_one_environment_at_the_same_time():
    env = drawn("PnTRelease-v0")
    with ThreadPoolExecutor(3) as pool:
        frames = [*pool.map(lambda _: env.render(), range(6))]
    assert all((frame == frames[0]).all() for frame in frames)


def test_a_vector_environment_is_drawn_in_another_thread():
    env = gym.make_vec("PnTRelease-v0", num_envs=2, render_mode="rgb_array", width=160, height=96)
    env.reset(seed=0)
    np.testing.assert_array_equal(env.render(), elsewhere(env.render))
    elsewhere(env.close)


def test_a_library_that_is_bound_to_a_thread_is_refused_in_another_one(monkeypatch):
    """As Apple's, whose context another thread would wait for without end."""
    env = drawn("PnTRelease-v0")
    env.render()
    monkeypatch.setattr(canvas, "_BOUND", (mujoco.GLContext.__module__,))
    for work in (env.render, env.close):
        with pytest.raises(ConfigError, match="only in the thread that asked for the first one"):
            elsewhere(work)
    env.close()
