"""The core of the one-joint environments: N arms, one throw a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from pnt_gym.cells.features import CLIP
from pnt_gym.cells.pallet.cell import PalletCell
from pnt_gym.cells.pallet.config import PalletConfig, Reward, Task, load
from pnt_gym.cells.pallet.context import Context
from pnt_gym.cells.pallet.observation import FEATURES, observe
from pnt_gym.cells.pallet.outcome import Outcome
from pnt_gym.correction import limited_actions
from pnt_gym.envs.core import Episodes, Step, check_counts, check_mode
from pnt_gym.goal_residual import ACTION_SIZE, SHIFT_MODES, GoalMode, corrected_plans, goal_correction
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.planning.one_joint import ThrowPlans
from pnt_gym.render.pallet import PalletView

Level = str | Path | PalletConfig | Mapping[str, Any]
REWARD_TERMS: Final = ("position", "angle", "speed", "success")


@final
class OneJointCore:
    """N one-joint arms behind the environments: actions in, observations, rewards and infos out.

    Args:
        level: a shipped level's name, a YAML file, a mapping or a config; its `task` is replaced by the environment's.
        task: what is thrown where.
        action_mode: how an action is read.
        count: number of cells N.
        threads: worker threads of the physics; results do not depend on it.

    Raises:
        ConfigError: no such level, a level that describes no working cell, or an unknown action mode.
    """

    def __init__(self, level: Level, task: Task, action_mode: GoalMode, count: int, threads: int) -> None:
        check_mode(action_mode, ACTION_SIZE)
        check_counts(count, threads)
        self.config = load(level, task=task)
        self.action_mode: GoalMode = action_mode
        self.action_sizes: Mapping[str, int] = ACTION_SIZE
        self.shift_modes: Sequence[str] = SHIFT_MODES
        self.count = count
        self.terminates = True
        self.dwell = 0.0
        self.cell = PalletCell(self.config, count, threads)
        job = self.cell.job
        self.correction = goal_correction(self.config, job, action_mode)
        self.item_names = job.names
        self.observation_space = Box(-CLIP, CLIP, (len(FEATURES),), np.float32)
        self.action_space = Box(-1.0, 1.0, (ACTION_SIZE[action_mode],), np.float32)
        self._nominal = np.stack([target.state for target in job.targets])
        self._last = len(job.targets) - 1 if job.in_order else 0
        self._in_order = job.in_order
        self._episodes = Episodes(count, len(job.targets) if job.in_order else 1, drawn=True)

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
        """Observations of the coming throws (N, 14)."""
        return observe(self.context, self._nominal[self.context.kind])

    def kinds(self) -> dict[str, NDArray[Any]]:
        """Kinds of the coming throws: index into `item_names`, (N,)."""
        return {"kind": self.context.kind.copy()}

    def step(self, actions: object) -> Step:
        """Throw in every cell.

        Args:
            actions: (N, size) within [-1, 1]; values outside are clipped.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        kind = self.context.kind
        outcome = self.cell.throw(*self.plan(self._checked(actions)))
        terms = reward_terms(outcome, self.config.reward)
        # An assembly whose first part is not in place is over: there is nothing to put the second on.
        over = self._episodes.thrown(early=~outcome.is_success)
        done = outcome.is_success & (kind == self._last if self._in_order else True)
        info = _info(outcome, kind) | {"is_complete": done}
        info |= {f"reward_{name}": term for name, term in terms.items()} | self.kinds()
        return Step(self.observe(), sum(terms.values(), np.zeros(self.count)), over, info)

    def plan(self, actions: Floats) -> tuple[ThrowPlans, Bools]:
        """Plans that actions (N, size) ask for, made feasible, and which had to be shortened (N,)."""
        return corrected_plans(self.action_mode, actions, self.cell, self.config.action)

    def preview(self, actions: object, jitter: bool = False) -> Outcome:
        """What actions would do to the coming throws, hidden values included, without advancing.

        This is privileged: the oracle uses it, and figures do. Scatter and camera noise are left out unless `jitter`
        is set.
        """
        plans, _ = self.plan(self._checked(actions))
        return self.cell.preview(plans, jitter)

    def view(self) -> PalletView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return PalletView(self.cell)

    def _checked(self, actions: object) -> Floats:
        return limited_actions(actions, self.count, ACTION_SIZE[self.action_mode], self.action_mode)


def reward_terms(outcome: Outcome, weights: Reward) -> dict[str, Floats]:
    """Weighted reward terms by name, each (N,); before weighting every term lies in [0, 1]."""
    angle, speed = np.abs(outcome.true_error[:, 2]), np.abs(outcome.true_error[:, 3])
    return {
        "position": weights.position * np.maximum(1.0 - outcome.landing_error / weights.position_scale, 0.0),
        "angle": weights.angle * np.maximum(1.0 - np.rad2deg(angle) / weights.angle_scale_deg, 0.0),
        "speed": weights.speed * np.maximum(1.0 - speed / weights.speed_scale, 0.0),
        "success": weights.success * outcome.is_success.astype(np.float64),
    }


def _info(outcome: Outcome, kind: Ints) -> dict[str, NDArray[Any]]:
    never = np.zeros(len(kind), dtype=np.bool_)
    return {
        "is_success": outcome.is_success,
        "landing_error": outcome.landing_error,
        "landing_along": outcome.true_error[:, 0],
        "landing_across": outcome.true_error[:, 1],
        "angle_error": outcome.true_error[:, 2],
        "speed_error": outcome.true_error[:, 3],
        "error_x": outcome.error_x,
        "error_y": outcome.error_y,
        "error_phi": outcome.error_phi,
        "error_dy": outcome.error_dy,
        "cycle_time": outcome.cycle_time,
        "in_pallet": outcome.in_pallet,
        "touched_other": outcome.touched_other,
        "recontact": never,
        "rim": never.copy(),
        "residual_clipped": outcome.clipped,
        "peak_torque": outcome.peak_torque,
        "item": kind.copy(),
        "target_x": outcome.goal[:, 0].copy(),
        "target_y": outcome.goal[:, 1].copy(),
    }
