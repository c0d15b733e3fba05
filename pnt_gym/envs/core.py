"""What stands behind every environment: N cells that throw in step, actions in, observations and rewards out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Protocol, final

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from pnt_gym.correction import Correction
from pnt_gym.errors import ConfigError
from pnt_gym.levels import LevelConfig
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.render import View


@final
@dataclass(frozen=True)
class Step:
    """What one throw in every cell gave."""

    observation: NDArray[np.float32]
    """Of the next throws (N, D)."""
    reward: Floats
    """(N,)"""
    ended: Bools
    """Episodes that are over (N,)."""
    info: dict[str, NDArray[Any]]
    """Named results, (N,) each; every core has those of `COMMON_INFO`."""


COMMON_INFO: Final = (
    "is_success",
    "landing_error",
    "landing_along",
    "landing_across",
    "cycle_time",
    "recontact",
    "rim",
    "residual_clipped",
    "item",
    "target_x",
    "target_y",
    "kind",
)
"""What every core tells of a throw; the errors of its `Correction` come on top."""


class Cells(Protocol):
    """N cells whose coming throws can be drawn anew."""

    def reset(self, rows: Ints, generators: list[np.random.Generator], /) -> None:
        """Begin anew in some rows, each with its own generator."""
        ...


@final
class Episodes:
    """Counts the throws of N cells, and knows which of them need a new draw when their episode begins.

    Args:
        count: number of cells N.
        length: throws in an episode.
        drawn: whether the cell draws the next episode's first throw by itself after the last one of an episode.
    """

    def __init__(self, count: int, length: int, drawn: bool) -> None:
        self._length, self._drawn = length, drawn
        self._throws = np.zeros(count, dtype=np.int64)
        self._fresh = np.zeros(count, dtype=np.bool_)

    def begin(self, rows: Ints, seeded: bool) -> Ints:
        """Begin new episodes in some rows; returns the positions in `rows` of those that must be drawn anew."""
        self._throws[rows] = 0
        draw = np.full(len(rows), True) if seeded else ~self._fresh[rows]
        self._fresh[rows] = False
        return np.flatnonzero(draw)

    def restart(self, cell: Cells, rows: Ints, generators: list[np.random.Generator], seeded: bool) -> None:
        """Begin new episodes in some rows of `cell`; the arguments are those of `Core.reset`."""
        chosen = self.begin(rows, seeded)
        if chosen.size > 0:
            cell.reset(rows[chosen], [generators[i] for i in chosen])

    def thrown(self, early: Bools | None = None) -> Bools:
        """Count one throw in every cell; returns the episodes that are over (N,).

        Args:
            early: episodes that this throw ends before their length (N,); None for none.
        """
        self._throws += 1
        ended = self._throws >= self._length
        if early is not None:
            ended = ended | early
        self._fresh = ended & self._drawn
        return ended


class Core(Protocol):
    """N cells behind the environments.

    A new cell is one class of this form; environments, evaluation, training and benchmark need no more than it.
    """

    @property
    def config(self) -> LevelConfig:
        """The level in full."""
        ...

    @property
    def count(self) -> int:
        """Number of cells N."""
        ...

    @property
    def observation_space(self) -> Box[np.float32]:
        """Of one cell, (D,)."""
        ...

    @property
    def action_space(self) -> Box[np.float32]:
        """Of one cell, (A,) within [-1, 1]."""
        ...

    @property
    def action_mode(self) -> str:
        """How actions are read."""
        ...

    @property
    def action_sizes(self) -> Mapping[str, int]:
        """All action modes of this kind of cell, with the numbers in one action."""
        ...

    @property
    def shift_modes(self) -> Sequence[str]:
        """Those of the modes that have a correction."""
        ...

    @property
    def correction(self) -> Correction | None:
        """What an action means to a controller that learns from errors; None where that is not one to one."""
        ...

    @property
    def terminates(self) -> bool:
        """Whether an episode that is over terminates, its task being done or lost; others are truncated."""
        ...

    @property
    def item_names(self) -> Sequence[str]:
        """What `kind` and `item` of the info are indices into."""
        ...

    @property
    def dwell(self) -> float:
        """Part of the cycle time in which the hand holds still to grip [s]."""
        ...

    def reset(self, rows: Ints, generators: list[np.random.Generator], seeded: bool) -> None:
        """Begin new episodes in some rows.

        Args:
            rows: which cells.
            generators: one per row; the row keeps drawing from it.
            seeded: whether the generators are new; if not, a throw that is already drawn is kept.
        """
        ...

    def observe(self) -> NDArray[np.float32]:
        """Observations of the coming throws (N, D)."""
        ...

    def kinds(self) -> dict[str, NDArray[Any]]:
        """`kind`: what the cell's classifier says of the coming things to throw, index into `item_names`, (N,)."""
        ...

    def step(self, actions: object) -> Step:
        """Throw in every cell.

        Args:
            actions: (N, A) within [-1, 1]; values outside are clipped.

        Raises:
            ActionError: wrong shape, NaN or infinite values.
        """
        ...

    def preview(self, actions: object, jitter: bool = False) -> Any:
        """What actions would do to the coming throws, hidden values included, without advancing.

        Args:
            actions: (N, A).
            jitter: whether what is drawn anew in every throw takes part.

        Returns:
            An outcome with the errors of `correction` among its attributes, (N,) each.
        """
        ...

    def view(self) -> View:
        """Pictures of the cells; row 0 is recorded from now on."""
        ...


def check_counts(count: int, threads: int) -> None:
    """Make sure that there is a cell and a thread to simulate it.

    Raises:
        ConfigError: there is not.
    """
    for name, value in (("num_envs", count), ("threads", threads)):
        if value < 1:
            raise ConfigError(f"{name} is {value}; it must be at least 1")


def check_mode(mode: str, modes: Mapping[str, int]) -> None:
    """Make sure that an environment has an action mode.

    Raises:
        ConfigError: it does not.
    """
    if mode not in modes:
        raise ConfigError(f"action_mode is {mode!r}; it must be one of {', '.join(modes)}")


def scalars(info: dict[str, NDArray[Any]], row: int) -> dict[str, Any]:
    """One row of a step's info as plain Python values."""
    return {name: values[row].item() for name, values in info.items()}
