"""Any core makes an environment: a cell on paper, thrown at by the facades, shown by a view of its own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest
from gymnasium.spaces import Box
from throw_tools import same_bits

from pnt_gym.correction import limited_actions
from pnt_gym.envs.base import ThrowEnv, ThrowVectorEnv
from pnt_gym.envs.core import Episodes, Step, check_counts, check_mode
from pnt_gym.errors import ConfigError
from pnt_gym.render import record_video

SIZES = {"push": 3}


class PaperView:
    """Frames that tell how many throws have been seen."""

    def __init__(self, core: PaperCore) -> None:
        self.core, self.closed, self.shown = core, 0, 0

    def frame(self, row: int = 0) -> np.ndarray:
        return np.full((16, 16, 3), row, dtype=np.uint8)

    def last_throw(self, fps: int = 30) -> list[np.ndarray]:
        return [np.full((16, 16, 3), 60 * self.core.throws, dtype=np.uint8)] * (fps // 10)

    def render(self, mode: str) -> Any:
        return self.frame() if mode == "rgb_array" else self.last_throw()

    def show(self) -> None:
        self.shown += 1

    def close(self) -> None:
        self.closed += 1


class PaperCore:
    """Draws a point per episode, or two for a pair of throws; the reward is the distance of the action to it."""

    config = SimpleNamespace(name="paper", model_dump=lambda **_: {})
    action_mode = "push"
    action_sizes = SIZES
    shift_modes = ()
    correction = None
    item_names = ("stone",)
    dwell = 0.0
    observation_space = Box(-1.0, 1.0, (3,), np.float32)
    action_space = Box(-1.0, 1.0, (3,), np.float32)

    def __init__(self, count: int, throws: int) -> None:
        check_counts(count, 1)
        check_mode("push", SIZES)
        self.count, self.terminates, self.throws = count, throws == 1, 0
        self._episodes = Episodes(count, throws, drawn=False)
        self._generators = [np.random.default_rng(0) for _ in range(count)]
        self._point = np.zeros((count, 3))

    def reset(self, rows: np.ndarray, generators: list[np.random.Generator], seeded: bool) -> None:
        for position in self._episodes.begin(rows, seeded):
            self._generators[rows[position]] = generators[position]
            self._draw(rows[position])

    def observe(self) -> np.ndarray:
        return self._point.astype(np.float32)

    def kinds(self) -> dict[str, np.ndarray]:
        return {"kind": np.zeros(self.count, dtype=np.int64)}

    def step(self, actions: object) -> Step:
        miss = np.linalg.norm(limited_actions(actions, self.count, 3, "push") - self._point, axis=1)
        self.throws += 1
        for row in range(self.count):
            self._draw(row)
        return Step(self.observe(), -miss, self._episodes.thrown(), {"landing_error": miss, **self.kinds()})

    def preview(self, actions: object, jitter: bool = False) -> Any:
        return SimpleNamespace()

    def view(self) -> PaperView:
        return PaperView(self)

    def _draw(self, row: int) -> None:
        self._point[row] = self._generators[row].uniform(-1, 1, 3)


class PaperEnv(ThrowEnv):
    def __init__(self, throws: int = 1, render_mode: str | None = None) -> None:
        super().__init__(PaperCore(1, throws), render_mode)


class PaperVectorEnv(ThrowVectorEnv):
    def __init__(self, num_envs: int, throws: int = 1, render_mode: str | None = None) -> None:
        super().__init__(PaperCore(num_envs, throws), render_mode)


@pytest.mark.parametrize("throws", [1, 2])
def test_an_episode_of_one_throw_terminates_and_a_longer_one_is_truncated(throws: int) -> None:
    env = PaperEnv(throws)
    for _ in range(2):
        env.reset(seed=0)
        ends = [env.step(np.zeros(3))[2:4] for _ in range(throws)]
        assert ends == [(False, False)] * (throws - 1) + [(throws == 1, throws > 1)]


@pytest.mark.parametrize("throws", [1, 2])
def test_a_row_of_the_vector_is_the_single_environment(throws: int) -> None:
    vector = PaperVectorEnv(3, throws)
    actions = np.random.default_rng(0).uniform(-1, 1, (4, 3, 3))
    first, _ = vector.reset(seed=5)
    steps = [vector.step(a) for a in actions]
    for row in range(3):
        env = PaperEnv(throws)
        observation, _ = env.reset(seed=5 + row)
        assert same_bits(observation, first[row])
        for k, (after, reward, over, cut, info) in enumerate(steps):
            observation, alone, *end, told = env.step(actions[k, row])
            assert (alone, end) == (reward[row], [over[row], cut[row]])
            assert told["landing_error"] == info["landing_error"][row]
            if any(end):
                assert same_bits(info["final_obs"][row], observation)
                observation, _ = env.reset()
            assert same_bits(observation, after[row])


def test_spaces_come_from_the_core() -> None:
    env = PaperVectorEnv(2)
    assert env.num_envs == 2
    assert env.single_action_space == PaperCore.action_space
    assert env.observation_space.shape == (2, 3)


def test_pictures_come_from_the_cores_view() -> None:
    env = PaperEnv(render_mode="rgb_array_list")
    env.reset(seed=0)
    env.step(np.zeros(3))
    assert [int(frame.mean()) for frame in env.render()] == [60, 60, 60]
    view = env._view
    env.close()
    env.close()
    assert view.closed == 1
    vector = PaperVectorEnv(2, render_mode="rgb_array")
    vector.reset(seed=0)
    assert [int(frame.mean()) for frame in vector.render()] == [0, 1]


def test_a_window_is_shown_after_every_throw() -> None:
    env = PaperEnv(render_mode="human")
    env.reset(seed=0)
    env.step(np.zeros(3))
    assert env._view.shown == 2


def test_any_view_can_be_filmed(tmp_path) -> None:
    core = PaperCore(1, 1)
    view = core.view()
    path = record_video(view, (core.step(np.zeros((1, 3))) for _ in range(2)), tmp_path / "paper.mp4", fps=20)
    frames = list(iio.imiter(path, plugin="FFMPEG"))
    assert len(frames) == 4  # two a throw
    assert [round(float(f.mean()), -1) for f in frames] == pytest.approx([60, 60, 120, 120], abs=10)
    assert view.closed == 1


def test_an_episode_ends_with_its_last_throw_or_earlier() -> None:
    episodes = Episodes(3, 2, drawn=True)
    assert episodes.begin(np.arange(3), seeded=True).tolist() == [0, 1, 2]
    assert episodes.thrown(early=np.array([False, True, False])).tolist() == [False, True, False]
    # The throw that the cell has drawn already is kept; one that was broken off before its end is drawn anew.
    assert episodes.begin(np.array([1, 2]), seeded=False).tolist() == [1]
    assert episodes.thrown().tolist() == [True, False, False]
    assert episodes.begin(np.array([0]), seeded=False).size == 0
    assert episodes.begin(np.array([0]), seeded=True).tolist() == [0]


@pytest.mark.parametrize(("count", "threads", "said"), [(0, 1, "num_envs is 0"), (1, -1, "threads is -1")])
def test_counts_below_one_are_named(count: int, threads: int, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        check_counts(count, threads)


def test_an_unknown_action_mode_is_answered_with_the_environments_own() -> None:
    with pytest.raises(ConfigError, match=r"action_mode is 'pull'; it must be one of push, shove"):
        check_mode("pull", {"push": 3, "shove": 2})
    check_mode("push", SIZES)
