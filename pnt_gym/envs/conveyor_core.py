"""The core of the conveyor environments: N cells at moving belts, one throw a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from pnt_gym.cells.context import Context
from pnt_gym.cells.conveyor import ConveyorCell, Picks
from pnt_gym.cells.observation import CLIP, FEATURES, observe
from pnt_gym.cells.outcome import Outcome
from pnt_gym.config import CellConfig, Reward, load
from pnt_gym.correction import nearest_feasible
from pnt_gym.envs.core import Episodes, Step, check_counts, check_mode
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.planning.plan import ReleaseBatch
from pnt_gym.render import CellView
from pnt_gym.residual import ACTION_SIZE, SHIFT_MODES, ActionMode, check_actions, corrected_release, shift_correction

Level = str | Path | CellConfig | Mapping[str, Any]
REWARD_TERMS: Final = ("landing", "sorted", "time")


@final
class ConveyorCore:
    """N conveyor cells behind the environments: actions in, observations, rewards and infos out.

    Args:
        level: a shipped level's name, a YAML file, a mapping or a config.
        picks: "belt" for shifts on the moving belt, "independent" for one pick per episode.
        action_mode: how an action is read.
        count: number of cells N.
        threads: worker threads of the physics; results do not depend on it.

    Raises:
        ConfigError: no such level, a level that describes no working cell, or an unknown action mode.
    """

    def __init__(self, level: Level, picks: Picks, action_mode: ActionMode, count: int, threads: int) -> None:
        check_mode(action_mode, ACTION_SIZE)
        check_counts(count, threads)
        self.config = load(level)
        self.action_mode: ActionMode = action_mode
        self.action_sizes: Mapping[str, int] = ACTION_SIZE
        self.shift_modes: Sequence[str] = SHIFT_MODES
        self.correction = shift_correction(self.config, action_mode)
        self.count = count
        self.terminates = picks == "independent"
        self.item_names = self.config.items
        self.dwell = self.config.motion.dwell
        self.cell = ConveyorCell(self.config, count, picks, threads)
        self.observation_space = Box(-CLIP, CLIP, (len(FEATURES),), np.float32)
        self.action_space = Box(-1.0, 1.0, (ACTION_SIZE[action_mode],), np.float32)
        length = 1 if self.terminates else self.config.picks_per_shift
        self._episodes = Episodes(count, length, drawn=self.terminates)

    @property
    def context(self) -> Context:
        """The coming picks."""
        return self.cell.context

    def reset(self, rows: Ints, generators: list[np.random.Generator], seeded: bool) -> None:
        """Begin new episodes in some rows.

        Args:
            rows: which cells.
            generators: one per row; the row keeps drawing from it.
            seeded: whether the generators are new; if not, a pick that is already drawn is kept.
        """
        self._episodes.restart(self.cell, rows, generators, seeded)

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming picks (N, 26)."""
        return observe(self.context)

    def kinds(self) -> dict[str, NDArray[Any]]:
        """What the cell's classifier says of the objects under the cups: index into `config.items`, (N,)."""
        return {"kind": self.context.objects.kind.copy()}

    def step(self, actions: object) -> Step:
        """Throw in every cell.

        Args:
            actions: (N, size) within [-1, 1]; values outside are clipped.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        context = self.context
        release, clipped = self.plan(check_actions(actions, self.count, self.action_mode))
        outcome = self.cell.throw(release, clipped)
        terms = reward_terms(outcome, self.config.reward)
        info = _info(outcome, context) | {f"reward_{name}": term for name, term in terms.items()} | self.kinds()
        return Step(self.observe(), sum(terms.values(), np.zeros(self.count)), self._episodes.thrown(), info)

    def plan(self, actions: Floats) -> tuple[ReleaseBatch, Bools]:
        """Releases that actions (N, size) ask for, made feasible, and which had to be shortened (N,)."""
        context, config = self.context, self.config

        def corrected(part: Floats) -> ReleaseBatch:
            slack, mover = config.motion.ceiling_slack, self.cell.planner.mover
            return corrected_release(self.action_mode, part, context, config.action, slack, mover)

        return nearest_feasible(corrected, self.cell.is_feasible, actions)

    def preview(self, actions: object, jitter: bool = False) -> Outcome:
        """What actions would do to the coming picks, hidden values included, without advancing.

        This is privileged: the oracle uses it, and figures do. The random part of the release delay is left out
        unless `jitter` is set.
        """
        release, _ = self.plan(check_actions(actions, self.count, self.action_mode))
        return self.cell.preview(release, jitter)

    def view(self) -> CellView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return CellView(self.cell)


def reward_terms(outcome: Outcome, weights: Reward) -> dict[str, Floats]:
    """Weighted reward terms by name, each (N,); before weighting every term lies in [0, 1]."""
    landing = np.maximum(1.0 - outcome.landing_error / weights.landing_scale, 0.0)
    time = np.maximum(1.0 - outcome.cycle_time / weights.time_scale, 0.0)
    return {
        "landing": weights.landing * landing,
        "sorted": weights.sorted * outcome.sorted.astype(np.float64),
        "time": weights.time * time,
    }


def _info(outcome: Outcome, context: Context) -> dict[str, NDArray[Any]]:
    return {
        "is_success": outcome.sorted,
        "landing_error": outcome.landing_error,
        "landing_along": outcome.landing_along,
        "landing_across": outcome.landing_across,
        "cycle_time": outcome.cycle_time,
        "wait_time": outcome.wait_time,
        "in_opening": outcome.in_opening,
        "in_bin": outcome.in_bin,
        "rim": outcome.rim,
        "recontact": outcome.recontact,
        "residual_clipped": outcome.clipped,
        "peak_torque": outcome.peak_torque,
        "item": context.objects.kind.copy(),
        "bin": context.bin.copy(),
        "target_x": context.target[:, 0].copy(),
        "target_y": context.target[:, 1].copy(),
    }
