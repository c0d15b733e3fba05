"""A video of an episode shows its throws from beginning to end."""

from __future__ import annotations

import gymnasium as gym
import imageio.v3 as iio
import numpy as np

from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.one_joint.view import DOTS, camera
from pnt_gym.wrappers import RecordVideo


def test_a_recorded_episode_has_every_frame_of_its_throws(tmp_path, monkeypatch):
    env = gym.make("OneJointThrow-v0", level="ideal", render_mode="rgb_array_list")
    env.unwrapped._view = ThrowView(env.unwrapped.core.cell, camera(), DOTS, size=(360, 640))
    drawn, render = [], env.unwrapped.render
    monkeypatch.setattr(env.unwrapped, "render", lambda: drawn.append(render()) or drawn[-1])
    film = RecordVideo(env, str(tmp_path / "videos"), episode_trigger=lambda episode: episode == 0)
    film.reset(seed=0)
    film.step(np.zeros(4))
    frames = drawn[-1]
    film.close()
    (video,) = tmp_path.glob("videos/*.mp4")
    filmed = list(iio.imiter(video))
    assert len(frames) > 10
    assert len(frames) - 1 <= len(filmed) <= len(frames)  # MoviePy's clock may round the last one away
    assert (
        np.abs(np.subtract(filmed, frames[: len(filmed)], dtype=float)).mean() < 5.0
    )  # but for compression the same pictures
    assert iio.immeta(video)["fps"] == env.metadata["render_fps"]
