"""A video of an episode shows its throws from beginning to end, without Gymnasium's MoviePy."""

import sys

import gymnasium as gym
import imageio.v3 as iio
import numpy as np
import pytest

from pnt_gym.errors import ConfigError
from pnt_gym.wrappers import RecordVideo


class Counter(gym.Env):
    """Three steps an episode; a step has two frames, which are as bright as the number of frames before them."""

    metadata = {"render_modes": ["rgb_array_list"], "render_fps": 10}  # noqa: RUF012 - Gymnasium's own form
    render_mode = "rgb_array_list"

    def reset(self, *, seed=None, options=None):
        self.steps, self.count = 0, getattr(self, "count", 0)
        return 0, {}

    def step(self, action):
        self.steps += 1
        return 0, 0.0, self.steps == 3, False, {}

    def render(self):
        self.count += 2
        return [np.full((18, 34, 3), 10 * (self.count + part), np.uint8) for part in (-2, -1)]


def episodes(env, count):
    for _ in range(count):
        env.reset()
        while not env.step(0)[2]:
            pass
    env.close()


def brightness(video):
    return [frame.mean() / 10 for frame in iio.imiter(video)]


def test_a_recorded_episode_has_every_frame_of_its_throws(tmp_path):
    env = gym.make("OneJointThrow-v0", level="ideal", render_mode="rgb_array_list", width=160, height=90)
    film = RecordVideo(env, str(tmp_path / "videos"), episode_trigger=lambda episode: episode == 0)
    film.reset(seed=0)
    film.step(np.zeros(4))
    frames = list(film.recorded_frames)
    film.close()
    (video,) = tmp_path.glob("videos/*.mp4")
    assert np.abs(np.subtract(iio.imread(video), frames, dtype=float)).mean() < 5.0  # but for compression
    assert len(frames) > 10
    assert iio.immeta(video)["fps"] == env.metadata["render_fps"]


def test_an_episodes_video_has_its_frames_in_their_order(tmp_path):
    episodes(RecordVideo(Counter(), tmp_path, episode_trigger=lambda episode: episode == 1), 3)
    (video,) = tmp_path.iterdir()
    assert video.name == "rl-video-episode-1.mp4"
    assert brightness(video) == pytest.approx(range(8), abs=0.5)  # nothing was rendered in episode 0


def test_a_video_of_a_length_goes_on_over_episodes_and_ends_with_its_last_frame(tmp_path):
    episodes(RecordVideo(Counter(), tmp_path, step_trigger=lambda step: step == 2, video_length=5, name_prefix="a"), 3)
    (video,) = tmp_path.iterdir()
    assert video.name == "a-step-2.mp4"
    assert brightness(video) == pytest.approx(range(5), abs=0.5)


def test_cubes_are_recorded_unless_a_trigger_says_otherwise(tmp_path):
    episodes(RecordVideo(Counter(), tmp_path), 9)
    assert {path.stem for path in tmp_path.iterdir()} == {f"rl-video-episode-{n}" for n in (0, 1, 8)}


def test_what_cannot_be_recorded_is_one_sentence(tmp_path, monkeypatch):
    with pytest.raises(ConfigError, match="render_mode is None; a video needs 'rgb_array_list'"):
        RecordVideo(gym.make("PnTRelease-v0"), tmp_path)
    monkeypatch.setitem(sys.modules, "imageio.v3", None)
    with pytest.raises(ConfigError, match=r"video needs imageio with ffmpeg: pip install 'pnt_gym\[video\]'"):
        RecordVideo(Counter(), tmp_path)
