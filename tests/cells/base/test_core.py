"""Any core makes an environment: a cell on paper, thrown at by the facades, shown by a view of its own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import imageio.v3 as iio
import numpy as np
import pytest

from pnt_gym.cells.base.action import ActionMode, Modes, by_name
from pnt_gym.cells.base.cell import Cell
from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.base.core import COMMON_INFO, Core, Episodes
from pnt_gym.cells.base.view import record_video
from pnt_gym.envs.base import ThrowEnv, scalars
from pnt_gym.envs.vector import vector_form
from pnt_gym.errors import ConfigError


class PaperView:
    """Frames that tell how many throws have been seen."""

    def __init__(self, cell: PaperCell) -> None:
        self.cell, self.closed, self.shown = cell, 0, 0

    def frame(self, row: int = 0) -> np.ndarray:
        return np.full((16, 16, 3), row, dtype=np.uint8)

    def last_throw(self, fps: int = 30) -> list[np.ndarray]:
        return [np.full((16, 16, 3), 60 * self.cell.throws, dtype=np.uint8)] * (fps // 10)

    def render(self, mode: str) -> Any:
        return self.frame() if mode == "rgb_array" else self.last_throw()

    def show(self) -> None:
        self.shown += 1

    def close(self) -> None:
        self.closed += 1


class PaperConfig(LevelConfig):
    folder: ClassVar[str] = "paper"

    reach: float = 0.9


@dataclass(frozen=True)
class PaperContext:
    """Points to be hit (N, 3)."""

    point: np.ndarray
    kind: np.ndarray


@dataclass(frozen=True)
class PaperPlans:
    """Where to (N, 3), and whether the arm gets there (N,)."""

    place: np.ndarray
    feasible: np.ndarray


@dataclass(frozen=True)
class PaperVerdict:
    is_success: np.ndarray
    landing_error: np.ndarray
    cycle_time: np.ndarray


class PaperPlanner:
    def __init__(self, config: PaperConfig) -> None:
        self._reach = config.reach

    def plan(self, context: PaperContext, residual: np.ndarray) -> PaperPlans:
        assert len(context.point) == len(residual)
        return PaperPlans(residual, (np.abs(residual) <= self._reach).all(axis=1))


class PaperCell(Cell[PaperConfig, PaperContext, PaperPlans, PaperVerdict]):
    """Draws a point per episode, or two for a pair of throws; the reward is the distance of the action to it."""

    modes: ClassVar[Modes] = by_name(
        ActionMode("push", ("x", "y", "z"), lambda config: np.ones(3), PaperPlanner.plan),
        ActionMode("nudge", ("x", "y", "z"), lambda config: np.full(3, 0.1), PaperPlanner.plan, ("miss",)),
    )
    reward_terms: ClassVar[tuple[str, ...]] = ("near", "hit")
    features = 3
    item_names = ("stone",)

    def __init__(self, count: int, throws: int, early: bool = False) -> None:
        super().__init__(PaperConfig(), count, 1)
        self.planner = PaperPlanner(self.config)
        self.episode, self.terminates = throws, throws == 1
        self.throws, self._early = 0, early
        self.context = PaperContext(np.zeros((count, 3)), np.zeros(count, dtype=np.int64))

    def first(self, rows: np.ndarray) -> PaperContext:
        point = np.array([self.generators[row].uniform(-1, 1, 3) for row in rows])
        return PaperContext(point, np.zeros(len(rows), dtype=np.int64))

    def observe(self) -> np.ndarray:
        return self.context.point.astype(np.float32)

    def throw(self, plans: PaperPlans) -> PaperVerdict:
        verdict = self.preview(plans)
        self.throws += 1
        self.context = self.first(np.arange(self.count))
        return verdict

    def preview(self, plans: PaperPlans, jitter: bool = False) -> PaperVerdict:
        assert plans.feasible.all()
        miss = np.linalg.norm(plans.place - self.context.point, axis=1)
        return PaperVerdict(miss < 0.5, miss, np.full(self.count, 2.0))

    def reward(self, outcome: PaperVerdict) -> Mapping[str, np.ndarray]:
        return {"near": -outcome.landing_error, "hit": 0.5 * outcome.is_success}

    def info(self, outcome: PaperVerdict, throws: PaperContext) -> dict[str, np.ndarray]:
        return {"point_x": throws.point[:, 0].copy()}

    def ends_early(self, outcome: PaperVerdict, throws: PaperContext) -> np.ndarray | None:
        return outcome.is_success if self._early else None

    def view(self) -> PaperView:
        return PaperView(self)


class PaperEnv(ThrowEnv):
    @classmethod
    def make_cell(cls, level: object, count: int, threads: int) -> PaperCell:
        return PaperCell(count, 1)


PaperVectorEnv = vector_form(PaperEnv)


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
    core = Core(PaperCell(1, 1))
    view = core.view()
    path = record_video(view, (core.step(np.zeros((1, 3))) for _ in range(2)), tmp_path / "paper.mp4", fps=20)
    frames = list(iio.imiter(path, plugin="FFMPEG"))
    assert len(frames) == 4  # two a throw
    assert [round(float(f.mean()), -1) for f in frames] == pytest.approx([60, 60, 120, 120], abs=10)
    assert view.closed == 1


def test_an_episode_ends_with_its_last_throw_or_earlier() -> None:
    episodes = Episodes(3, 2, drawn=True)
    assert episodes.begin(np.arange(3), seeded=True).tolist() == [0, 1, 2]
    assert episodes.count_throws(early=np.array([False, True, False])).tolist() == [False, True, False]
    # The throw that the cell has drawn already is kept; one that was broken off before its end is drawn anew.
    assert episodes.begin(np.array([1, 2]), seeded=False).tolist() == [1]
    assert episodes.count_throws().tolist() == [True, False, False]
    assert episodes.begin(np.array([0]), seeded=False).size == 0
    assert episodes.begin(np.array([0]), seeded=True).tolist() == [0]


def test_the_default_mode_is_the_cells_first() -> None:
    core = Core(PaperCell(2, 1))
    assert core.action_mode == "push"
    assert core.action_sizes == {"push": 3, "nudge": 3}
    assert core.shift_modes == ("nudge",)
    assert core.correction is None


def test_a_step_tells_what_every_cell_does_the_rewards_terms_and_what_the_cell_adds() -> None:
    core = Core(PaperCell(2, 1))
    core.reset(np.arange(2), [np.random.default_rng(i) for i in range(2)], seeded=True)
    thrown = core.context
    step = core.step(np.zeros((2, 3)))
    assert set(step.info) == {*COMMON_INFO, "reward_near", "reward_hit", "point_x"}
    np.testing.assert_array_equal(step.reward, step.info["reward_near"] + step.info["reward_hit"])
    np.testing.assert_array_equal(step.info["point_x"], thrown.point[:, 0])
    np.testing.assert_array_equal(step.info["landing_error"], np.linalg.norm(thrown.point, axis=1))
    assert scalars(step.info, 1) == {name: values[1].item() for name, values in step.info.items()}


def test_a_cell_may_end_an_episode_early() -> None:
    cell = PaperCell(2, 3, early=True)
    core = Core(cell)
    core.reset(np.arange(2), [np.random.default_rng(i) for i in range(2)], seeded=True)
    cell.context = PaperContext(np.array([[0.1, 0.0, 0.0], [0.9, 0.9, 0.9]]), cell.context.kind)
    assert core.step(np.zeros((2, 3))).ended.tolist() == [True, False]


def test_a_cell_that_cannot_be_drawn_says_so() -> None:
    cell = PaperCell(1, 1)
    with pytest.raises(ConfigError, match="PaperCell has no pictures"):
        Cell.view(cell)
