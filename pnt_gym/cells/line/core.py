"""The batched simulation behind line environments: choices in; observations, rewards and infos out."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any, Final, final

import numpy as np
from gymnasium.spaces import Box, Discrete
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.cell import MOST_CELLS, MOST_THREADS, Generators, check_whole_number
from pnt_gym.cells.base.core import EPISODE_SUCCESS, Step, restore_rows
from pnt_gym.cells.base.features import CLIP
from pnt_gym.cells.base.request import NO_REQUEST, Request
from pnt_gym.cells.line.cell import Decisions, LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.observation import ENTRIES, fill_observations
from pnt_gym.cells.line.outcome import shift_figures
from pnt_gym.cells.line.rows import CHOICES
from pnt_gym.cells.line.throws import Release, SimulatedThrows
from pnt_gym.cells.line.view import LineView
from pnt_gym.errors import ActionError, ConfigError, one_sentence

MODE: Final = "choice"
"""Name of the only action mode."""


@final
class LineCore:
    """N lines; row i is environment i.

    Args:
        config: level of the line.
        count: number of lines N.
        threads: threads of the physics and of the search for choices; results do not depend on their number.

    Raises:
        ConfigError: the count or the number of threads is out of range, or the level describes no possible line.
    """

    correction = None
    terminates = False

    def __init__(self, config: LineConfig, count: int, threads: int = 1) -> None:
        check_whole_number("num_envs", count, MOST_CELLS)
        check_whole_number("threads", threads, MOST_THREADS)
        self.cell = LineCell(config, count, threads)
        self.config, self.count, self.item_names = config, count, config.cell.items
        self.action_mode, self.dwell = MODE, config.cell.motion.dwell
        self.observation_space = Box(-CLIP, CLIP, (ENTRIES,), np.float32)
        self.action_space = Discrete(CHOICES)
        self._decisions, self._successes = np.zeros((2, count), dtype=np.int64)
        self.last: Decisions | None = None
        """The latest decisions, with all results of their throws; None before the first step."""

    def use(self, release: Release) -> None:
        """Correct throws by a policy of `PnTRelease-v0`.

        Raises:
            ConfigError: the line's throws are not simulated.
        """
        if not isinstance(self.cell.throws, SimulatedThrows):
            raise ConfigError(
                f"level {self.config.name!r} takes the results of throws from a table, so no release can be corrected; "
                "set `throws` to 'flight' or 'full'"
            )
        self.cell.throws.release = release

    def reset(self, rows: Ints, generators: Generators, seeded: Bools | bool, request: Request = NO_REQUEST) -> None:
        """Begin shifts in some lines.

        Args:
            rows: indices of the lines.
            generators: one generator for each row; the row keeps drawing from its generator.
            seeded: rows with a new generator; makes no difference here.
            request: must be empty; a stream takes no requests.

        Raises:
            ConfigError: the request is not empty.
        """
        if request:
            raise ConfigError(f"options ask for {next(iter(request))}; a line takes no requests for objects or bins")
        self._decisions[rows] = self._successes[rows] = 0
        self.cell.reset(rows, generators)

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming decisions (N, D)."""
        return self.observe_as(self.cell.state.robot)

    def observe_as(self, robot: int | Ints) -> NDArray[np.float32]:
        """Observations (N, D) of one robot, or of one in each line (N,), without choices where another decides."""
        cell, robots, lines = self.cell, np.full(self.count, robot), np.arange(self.count)
        observations = np.empty((self.count, ENTRIES), dtype=np.float32)
        fill_observations(cell.chooser.tables, cell.state, cell.stream.riders, robots, lines, observations)
        return observations

    def kinds(self) -> dict[str, NDArray[Any]]:
        """`action_mask`, the real choices (N, CHOICES), and `robot`, the deciding robot (N,)."""
        state = self.cell.state
        return {"action_mask": state.choices["real"].copy(), "robot": state.robot.copy()}

    def hidden(self) -> dict[str, Floats]:
        """Hidden quantities of the coming decisions by the names of the cell's `hidden`, (N,) each."""
        truth = self.cell.truth()
        return {quantity.name: np.array(quantity.value(truth), dtype=np.float64) for quantity in self.cell.hidden}

    def masks(self) -> Bools:
        """Mask of the real choices (N, CHOICES)."""
        return self.cell.state.choices["real"].copy()

    def step(self, actions: object, waiting: Bools | None = None) -> Step:
        """Carry out one decision in every line.

        Args:
            actions: index of the choice (N,).
            waiting: lines that only fill the batch (N,): the step restores their states, and their results mean
                nothing; None for no such line.

        Raises:
            ActionError: the actions are not whole numbers from 0 to `CHOICES` - 1.
        """
        with nullcontext() if waiting is None else restore_rows(self.cell, waiting):
            self.last = decisions = self.cell.take(_check(actions, self.count))
            reward = decisions.value - self.config.price_of_time * decisions.elapsed
            ended = self.cell.over
            shift_info = self._shift_info(ended)
            results, attempt = decisions.results, decisions.attempt
            # The decisions that succeeded, of those in the shifts that are over.
            counts = np.ones_like(ended) if waiting is None else ~waiting
            self._decisions += counts
            self._successes += results["is_success"] & counts
            if ended.any():
                success = self._successes / np.maximum(self._decisions, 1)
                shift_info[EPISODE_SUCCESS] = np.where(ended, success, np.nan)
            simulated = ("landing_error", "energy") if isinstance(self.cell.throws, SimulatedThrows) else ()
            info = {
                "dt": decisions.elapsed,
                "by": decisions.robot,
                "invalid_action": ~decisions.valid,
                "object": np.where(decisions.valid, decisions.index, -1),
                "item": attempt.item,
                "true_kind": attempt.true_kind,
                "bin": attempt.bin,
                "percent": attempt.percent,
                "value": decisions.value,
                "picked": results["picked"],
                "is_success": results["is_success"],
                "sorted": results["sorted"],
                "ended_in": results["ended_in"],
                "start": decisions.start,
                "cycle_time": decisions.end - decisions.start,
                "wait_time": np.where(decisions.valid, attempt.chosen["wait"], 0.0),
                **{name: results[name] for name in simulated},
                **shift_info,
                **self.kinds(),
            }
            return Step(decisions.observation, reward, ended, info, dict.fromkeys(shift_info, ended))

    def view(self) -> LineView:
        """View of the line, which records the robots' cycles from now on.

        Raises:
            ConfigError: there are several lines.
        """
        return LineView(self.cell)

    def _shift_info(self, ended: Bools) -> dict[str, NDArray[Any]]:
        """Figures of the shifts that are over, NaN for the other lines; empty while no shift is over."""
        rows = np.flatnonzero(ended)
        if rows.size == 0:
            return {}
        figures: dict[str, NDArray[Any]] = {}
        cell = self.cell
        for name, values in shift_figures(self.config, cell.chooser.tables, cell.state, cell.stream, rows).items():
            figures[name] = np.full((self.count, *values.shape[1:]), np.nan)
            figures[name][rows] = values
        return figures


def _check(actions: object, count: int) -> Ints:
    """Actions as whole numbers (N,)."""
    try:
        choices: NDArray[Any] = np.asarray(actions)
    except ValueError:  # rows of different lengths
        text = one_sentence(repr(actions), 80)
        raise ActionError(f"action is {text}; it must be whole numbers of shape ({count},)") from None
    if choices.shape != (count,):
        raise ActionError(f"action has shape {choices.shape}; this environment needs ({count},)")
    if choices.dtype.kind not in "iu" or np.ma.isMA(actions) or ((choices < 0) | (choices >= CHOICES)).any():
        text = one_sentence(repr(actions), 80)
        raise ActionError(f"action is {text}; it must be a whole number from 0 to {CHOICES - 1}")
    return choices.astype(np.int64)
