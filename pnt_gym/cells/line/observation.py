"""Observation of the robot that decides next: its line in a few numbers, and the features of each choice.

Nothing hidden enters: positions are those of the camera and the belt's encoder, values and items those of the camera,
times the planner's, chances those of the table of throws.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pnt_gym.arrays import Floats, Ints, tuples
from pnt_gym.cells.base.features import EntryTable, scaled
from pnt_gym.cells.line import observe
from pnt_gym.cells.line.rows import CHOICES, LineState, Rider, Tables
from pnt_gym.rows import Quadruple, Row, Rows2

MIN_RATE: Final = 1e-6
"""Value per second below which choices count as equal."""


@final
class LineFeatures(Row):
    """What a robot sees of its line."""

    gone: float = scaled("-", 0.5, 0.5, "share of the shift that is over")
    turn: Quadruple = scaled("-", 0.5, 0.5, "whether it is the turn of robot {k}, upstream first")
    busy: Quadruple = scaled("s", 0.5, 0.5, "until robot {k} is expected to be free")
    hand_x: float = scaled("m", 0.0, 0.30, "where the hand stands, from the robot's base")
    hand_y: float = scaled("m", 0.0, 0.30, "where the hand stands, from the robot's base")
    coming: float = scaled("-", 8.0, 8.0, "objects in the camera's sight that the robot takes")
    possible: float = scaled("-", 8.0, 8.0, "choices that exist")


@final
class ChoiceFeatures(Row):
    """What a robot sees of one choice."""

    real: float = scaled("-", 0.0, 1.0, "1; all entries of a choice that does not exist are 0")
    pick_x: float = scaled("m", 0.0, 0.30, "where the object is lifted")
    pick_y: float = scaled("m", -0.33, 0.15, "where the object is lifted")
    lift: float = scaled("s", 1.0, 0.6, "until the object is lifted")
    cycle: float = scaled("s", 1.3, 0.6, "until the robot is free again")
    wait: float = scaled("s", 0.0, 0.5, "standstill above the belt until the object comes")
    slack: float = scaled("s", 1.0, 1.0, "how much later the object could be lifted")
    value: float = scaled("-", 1.0, 1.0, "of the object in its bin")
    ln_rate: float = scaled("ln 1/s", 0.0, 3.0, "value x chance / cycle, its logarithm")
    chance: float = scaled("-", 0.5, 0.5, "that the object ends in its bin, by the table of throws")
    percent: float = scaled("%", 40.0, 10.0, "speed setting")
    distance: float = scaled("m", 0.8, 0.2, "horizontal distance from pick to bin")
    stop_x: float = scaled("m", 0.0, 0.3, "where the hand stops after the throw")
    stop_y: float = scaled("m", 0.1, 0.2, "where the hand stops after the throw")
    crowd: float = scaled("-", 2.0, 2.0, "objects within 0.25 m of this stop that the robot can take then")
    heirs: float = scaled("-", 0.0, 1.0, "robots downstream that take this item")
    reaches: float = scaled("s", 0.0, 3.0, "until the first of these robots can reach it; 0 for none")
    queue: float = scaled("-", 0.0, 6.0, "objects ahead of it that this downstream robot takes")


LINE_TABLE: Final = EntryTable.of(LineFeatures)
"""Features of the line; entries from 0 on."""
CHOICE_TABLE: Final = EntryTable.of(ChoiceFeatures)
"""Features of one choice; the entries of all choices follow the entries of the line."""


@final
class LineTables:
    """Both feature tables, for the manual."""

    def __len__(self) -> int:
        return ENTRIES

    def markdown(self) -> str:
        """Markdown of the line's entries and of each choice's entries."""
        head, choice_entries = len(LINE_TABLE), len(CHOICE_TABLE)
        sentence = (
            f"Choice k, from 0 to {CHOICES - 1}, has the {choice_entries} entries from {head} + {choice_entries} k on:"
        )
        return f"{LINE_TABLE.markdown()}\n\n{sentence}\n\n{CHOICE_TABLE.markdown()}"


ENTRIES: Final = len(LINE_TABLE) + CHOICES * len(CHOICE_TABLE)


def fill_observations(
    tables: Tables,
    state: LineState,
    riders: Rows2[Rider],
    robots: Ints,
    lines: Ints,
    rows: NDArray[np.float32],
) -> None:
    """Write observations of robots (N,) into rows (N, ENTRIES), for some lines (K,).

    A robot gets no choices where another robot decides.
    """
    scalings = LINE_TABLE.scaling, CHOICE_TABLE.scaling
    observe.fill_observations(tables, state, riders, robots, lines, *scalings, rows)


@final
@dataclass(frozen=True)
class DecodedObservation:
    """Observations in physical values."""

    line: dict[str, Floats]
    """Features by the names of `LINE_TABLE`, S each."""
    choices: dict[str, Floats]
    """Features by the names of `CHOICE_TABLE`, S + (CHOICES,) each."""


def decoded(observation: ArrayLike) -> DecodedObservation:
    """Physical values of observations S + (ENTRIES,); clipped entries stay clipped.

    Raises:
        ValueError: the observations have another number of entries.
    """
    entries, head = tuples(observation, "observation", ENTRIES), len(LINE_TABLE)
    choice_features = entries[..., head:].reshape(*entries.shape[:-1], CHOICES, len(CHOICE_TABLE))
    return DecodedObservation(LINE_TABLE.decode(entries[..., :head]), CHOICE_TABLE.decode(choice_features))
