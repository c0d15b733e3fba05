"""The core of the gripper robot's environment: N robots, one toss a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from pnt_gym.cells.features import CLIP
from pnt_gym.cells.tray.cell import Context, TrayCell
from pnt_gym.cells.tray.config import Reward, TrayConfig, load
from pnt_gym.cells.tray.motion import TossPlans
from pnt_gym.cells.tray.observation import FEATURES, feature_table, observe
from pnt_gym.cells.tray.outcome import Outcome
from pnt_gym.correction import limited_actions
from pnt_gym.envs.core import Episodes, Step, check_counts, check_mode
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.render.tray import TrayView
from pnt_gym.toss_residual import ACTION_SIZE, SHIFT_MODES, TossMode, corrected_plans, toss_correction

Level = str | Path | TrayConfig | Mapping[str, Any]
REWARD_TERMS: Final = ("landing", "success", "time")


@final
class GripperCore:
    """N gripper robots behind the environment: actions in, observations, rewards and infos out.

    Args:
        level: a shipped level's name, a YAML file, a mapping or a config.
        action_mode: how an action is read.
        count: number of cells N.
        threads: worker threads of the physics; results do not depend on it.

    Raises:
        ConfigError: no such level, a level that describes no working cell, or an unknown action mode.
    """

    def __init__(self, level: Level, action_mode: TossMode, count: int, threads: int) -> None:
        check_mode(action_mode, ACTION_SIZE)
        check_counts(count, threads)
        self.config = load(level)
        self.action_mode: TossMode = action_mode
        self.action_sizes: Mapping[str, int] = ACTION_SIZE
        self.shift_modes: Sequence[str] = SHIFT_MODES
        self.count = count
        self.terminates = True
        self.dwell = self.config.grip.closing + self.config.grip.hold
        self.cell = TrayCell(self.config, count, threads)
        self.correction = toss_correction(self.config, action_mode)
        self._features = feature_table(self.config)
        self.item_names = tuple(thing.name for thing in self.config.things)
        self.observation_space = Box(-CLIP, CLIP, (len(FEATURES),), np.float32)
        self.action_space = Box(-1.0, 1.0, (ACTION_SIZE[action_mode],), np.float32)
        self._episodes = Episodes(count, 1, drawn=True)

    @property
    def context(self) -> Context:
        """The coming throws."""
        return self.cell.context

    def reset(self, rows: Ints, generators: list[np.random.Generator], seeded: bool) -> None:
        """Begin new episodes in some rows.

        Args:
            rows: which cells.
            generators: one per row; the row keeps drawing from it.
            seeded: whether the generators are new; if not, a throw that is already drawn is kept.
        """
        self._episodes.restart(self.cell, rows, generators, seeded)

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming throws (N, 15)."""
        return observe(self.context, self._features)

    def kinds(self) -> dict[str, NDArray[Any]]:
        """Kinds of the objects to be thrown: index into `item_names`, (N,)."""
        return {"kind": self.context.kind.copy()}

    def step(self, actions: object) -> Step:
        """Throw in every cell.

        Args:
            actions: (N, size) within [-1, 1]; values outside are clipped.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        context = self.context
        outcome = self.cell.throw(*self.plan(self._checked(actions)))
        terms = reward_terms(outcome, self.config.reward)
        info = _info(outcome, context) | {f"reward_{name}": term for name, term in terms.items()} | self.kinds()
        return Step(self.observe(), sum(terms.values(), np.zeros(self.count)), self._episodes.thrown(), info)

    def plan(self, actions: Floats) -> tuple[TossPlans, Bools]:
        """Plans that actions (N, size) ask for, made feasible, and which had to be shortened (N,)."""
        return corrected_plans(actions, self.cell)

    def preview(self, actions: object, jitter: bool = False) -> Outcome:
        """What actions would do to the coming throws, hidden values included, without advancing.

        This is privileged: the oracle uses it, and figures do. The random part of the opening's delay is left out
        unless `jitter` is set.
        """
        plans, _ = self.plan(self._checked(actions))
        return self.cell.preview(plans, jitter)

    def view(self) -> TrayView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return TrayView(self.cell)

    def _checked(self, actions: object) -> Floats:
        return limited_actions(actions, self.count, ACTION_SIZE[self.action_mode], self.action_mode)


def reward_terms(outcome: Outcome, weights: Reward) -> dict[str, Floats]:
    """Weighted reward terms by name, each (N,); before weighting every term lies in [0, 1]."""
    landing = np.maximum(1.0 - np.nan_to_num(outcome.landing_error, nan=np.inf) / weights.landing_scale, 0.0)
    time = np.maximum(1.0 - outcome.cycle_time / weights.time_scale, 0.0)
    return {
        "landing": weights.landing * landing,
        "success": weights.success * outcome.is_success.astype(np.float64),
        "time": weights.time * time,
    }


def _info(outcome: Outcome, context: Context) -> dict[str, NDArray[Any]]:
    return {
        "is_success": outcome.is_success,
        "landing_error": outcome.landing_error,
        "landing_along": outcome.landing_along,
        "landing_across": outcome.landing_across,
        "release_delay": outcome.release_delay,
        "cycle_time": outcome.cycle_time,
        "in_opening": outcome.in_opening,
        "rim": outcome.rim,
        "picked": outcome.picked,
        "slip": outcome.slip,
        "recontact": outcome.recontact,
        "residual_clipped": outcome.clipped,
        "peak_torque": outcome.peak_torque,
        "item": context.kind.copy(),
        "target_x": context.target[:, 0].copy(),
        "target_y": context.target[:, 1].copy(),
    }
