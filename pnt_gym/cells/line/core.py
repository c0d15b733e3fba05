"""The batched simulation behind line environments: choices in; observations, rewards and infos out."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import replace
from typing import Any, Final, final

import numpy as np
from gymnasium.spaces import Box, Discrete
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.cell import MOST_CELLS, MOST_THREADS, Generators, whole_number
from pnt_gym.cells.base.core import Step, restoring
from pnt_gym.cells.base.features import CLIP
from pnt_gym.cells.base.request import ANYTHING, Request
from pnt_gym.cells.line.cell import LineCell, Taken
from pnt_gym.cells.line.config import MOST_ROBOTS, LineConfig
from pnt_gym.cells.line.observation import ENTRIES, Glance, encoded
from pnt_gym.cells.line.outcome import told
from pnt_gym.cells.line.state import CHOICES, Shift
from pnt_gym.cells.line.throws import Release, ThrownThrows
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
        threads: threads of the physics; results do not depend on their number.

    Raises:
        ConfigError: the count or the number of threads is out of range, or the level describes no possible line.
    """

    correction = None
    terminates = False

    def __init__(self, config: LineConfig, count: int, threads: int = 1) -> None:
        whole_number("num_envs", count, MOST_CELLS)
        whole_number("threads", threads, MOST_THREADS)
        self.cell = LineCell(config, count, threads)
        self.config, self.count, self.item_names = config, count, config.cell.items
        self.action_mode, self.dwell = MODE, config.cell.motion.dwell
        self.observation_space = Box(-CLIP, CLIP, (ENTRIES,), np.float32)
        self.action_space = Discrete(CHOICES)

    def use(self, release: Release) -> None:
        """Correct throws by a policy of `PnTRelease-v0`.

        Raises:
            ConfigError: the line's throws are not simulated.
        """
        if not isinstance(self.cell.throws, ThrownThrows):
            raise ConfigError(
                f"level {self.config.name!r} goes by a table of throws, which no release corrects; set `throws` to "
                "'flight' or 'full'"
            )
        self.cell.throws.release = release

    def reset(self, rows: Ints, generators: Generators, seeded: Bools | bool, request: Request = ANYTHING) -> None:
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
            raise ConfigError(f"options ask for {next(iter(request))}; what comes along a line cannot be asked for")
        self.cell.reset(rows, generators)

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming decisions (N, D)."""
        return encoded(self._glance(self.cell.state), self.cell.state.choices)

    def observe_as(self, robot: int) -> NDArray[np.float32]:
        """Observations of one robot (N, D), without choices where another robot decides."""
        state = self.cell.state
        own = state.robot == robot
        choices = replace(state.choices, real=state.choices.real & own[:, None])
        return encoded(self._glance(replace(state, robot=np.full_like(state.robot, robot))), choices)

    def kinds(self) -> dict[str, NDArray[Any]]:
        """`action_mask`, the real choices (N, CHOICES), and `robot`, the deciding robot (N,)."""
        state = self.cell.state
        return {"action_mask": state.choices.real.copy(), "robot": state.robot.copy()}

    def hidden(self) -> dict[str, Floats]:
        """Hidden quantities of the coming decisions by the names of the cell's `hidden`, (N,) each."""
        truth = self.cell.truth()
        return {one.name: np.array(one.value(truth), dtype=np.float64) for one in self.cell.hidden}

    def masks(self) -> Bools:
        """Mask of the real choices (N, CHOICES)."""
        return self.cell.state.choices.real.copy()

    def step(self, actions: object, waiting: Bools | None = None) -> Step:
        """Carry out one decision in every line.

        Args:
            actions: index of the choice (N,).
            waiting: lines that only fill the batch (N,): the step restores their states, and their results mean
                nothing; None for no such line.

        Raises:
            ActionError: the actions are not whole numbers from 0 to `CHOICES` - 1.
        """
        with nullcontext() if waiting is None else restoring(self.cell, waiting):
            taken = self.cell.take(_choices(actions, self.count))
            reward = taken.value - self.config.price_of_time * taken.elapsed
            ended = self.cell.over
            shifts = self._shifts(ended)
            info = {**_told(taken), **self._measured(taken), **shifts, **self.kinds()}
            return Step(self.observe(), reward, ended, info, dict.fromkeys(shifts, ended))

    def view(self) -> LineView:
        """View of the line, which records the robots' cycles from now on.

        Raises:
            ConfigError: there are several lines.
        """
        return LineView(self.cell)

    def _measured(self, taken: Taken) -> dict[str, NDArray[Any]]:
        """Infos that only simulated throws have."""
        if not isinstance(self.cell.throws, ThrownThrows):
            return {}
        return {"landing_error": taken.made.landing_error, "energy": taken.made.energy}

    def _shifts(self, ended: Bools) -> Mapping[str, NDArray[Any]]:
        """Figures of the shifts that are over, NaN for the other lines; empty while no shift is over."""
        rows = np.flatnonzero(ended)
        if rows.size == 0:
            return {}
        found: dict[str, NDArray[Any]] = {}
        for name, values in told(self.config, self.cell.state, self.cell.stream, rows).items():
            found[name] = np.full((self.count, *values.shape[1:]), np.nan)
            found[name][rows] = values
        return found

    def _glance(self, state: Shift) -> Glance:
        cell = self.cell
        rows = np.arange(self.count)
        busy = np.zeros((self.count, MOST_ROBOTS))
        busy[:, : state.free.shape[1]] = np.maximum(state.expected - state.clock[:, None], 0.0)
        return Glance(
            gone=np.minimum(state.clock / self.config.duration, 1.0),
            robot=state.robot,
            hand=state.hand[rows, state.robot],
            coming=cell.chooser.coming(state, cell.stream),
            busy=busy,
            possible=state.choices.real.sum(axis=1).astype(np.float64),
        )


def _told(taken: Taken) -> dict[str, NDArray[Any]]:
    """Infos of decisions, (N,) each."""
    made, context = taken.made, taken.context
    return {
        "dt": taken.elapsed,
        "by": taken.robot,
        "invalid_action": ~taken.valid,
        "object": np.where(taken.valid, taken.index, -1),
        "item": context.objects.measured.kind.copy(),
        "true_kind": context.objects.kind.copy(),
        "bin": context.bin.copy(),
        "percent": context.objects.percent.copy(),
        "value": taken.value,
        "picked": made.picked,
        "is_success": made.is_success,
        "sorted": made.sorted,
        "ended_in": made.ended_in,
        "start": taken.start,
        "cycle_time": taken.end - taken.start,
        "wait_time": np.where(taken.valid, taken.wait, 0.0),
    }


def _choices(actions: object, count: int) -> Ints:
    """Actions as whole numbers (N,)."""
    try:
        given: NDArray[Any] = np.asarray(actions)
    except ValueError:  # rows of different lengths
        said = one_sentence(repr(actions), 80)
        raise ActionError(f"action is {said}; it must be whole numbers of shape ({count},)") from None
    if given.shape != (count,):
        raise ActionError(f"action has shape {given.shape}; this environment needs ({count},)")
    if given.dtype.kind not in "iu" or np.ma.isMA(actions) or ((given < 0) | (given >= CHOICES)).any():
        said = one_sentence(repr(actions), 80)
        raise ActionError(f"action is {said}; it must be a whole number from 0 to {CHOICES - 1}")
    return given.astype(np.int64)
