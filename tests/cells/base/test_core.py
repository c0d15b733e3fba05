"""What a core makes of any cell: episodes, modes, rewards and infos; and how an environment shows its throws."""

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.base.cell import Cell
from pnt_gym.cells.base.core import COMMON_INFO, Core, Episodes
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.conveyor.action import MODES
from pnt_gym.envs.base import scalars
from pnt_gym.errors import ConfigError
from tests.tools.throws import make_core


def test_a_window_is_shown_after_every_throw(monkeypatch):
    shown = []

    def show(view: ThrowView) -> None:
        shown.append(view)

    monkeypatch.setattr(ThrowView, "show", show)
    env = gym.make("PnTRelease-v0", render_mode="human").unwrapped
    env.reset(seed=0)
    env.step(np.zeros(2))
    assert len(shown) == 2


def test_an_episode_ends_with_its_last_throw_or_earlier() -> None:
    episodes, failed = Episodes(3, 2, drawn=True), np.zeros(3, dtype=np.bool_)
    assert episodes.begin(np.arange(3), seeded=True).tolist() == [0, 1, 2]
    assert episodes.count(failed, early=np.array([False, True, False]))[0].tolist() == [False, True, False]
    # The throw that the cell has drawn already is kept; one that was broken off before its end is drawn anew.
    assert episodes.begin(np.array([1, 2]), seeded=False).tolist() == [1]
    assert episodes.count(failed)[0].tolist() == [True, False, False]
    assert episodes.begin(np.array([0]), seeded=False).size == 0
    assert episodes.begin(np.array([0]), seeded=True).tolist() == [0]


def test_the_default_mode_is_the_cells_first():
    core = Core(make_core("ideal").cell)
    assert core.action_mode == next(iter(MODES))
    assert core.action_sizes == {name: len(mode.numbers) for name, mode in MODES.items()}


def test_a_step_tells_what_every_cell_does_and_the_rewards_terms():
    core = make_core("ideal", 2)
    step = core.step(np.zeros((2, 2)))
    terms = [f"reward_{name}" for name in core.cell.reward_terms]
    assert {*COMMON_INFO, *terms} <= step.info.keys()
    np.testing.assert_array_equal(step.reward, sum(step.info[name] for name in terms))
    assert scalars(step.info, 1) == {name: values[1].item() for name, values in step.info.items()}


def test_a_cell_that_cannot_be_drawn_says_so():
    with pytest.raises(ConfigError, match="ConveyorCell has no pictures"):
        Cell.view(make_core("ideal").cell)
