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
from pnt_gym.cells.base.features import CLIP, EntryTable, ObservationEntry
from pnt_gym.cells.line import observation_kernel
from pnt_gym.cells.line.choosing import Chooser
from pnt_gym.cells.line.config import MOST_ROBOTS
from pnt_gym.cells.line.state import CHOICES, LineState
from pnt_gym.cells.line.stream import Stream

MIN_RATE: Final = 1e-6
"""Value per second below which choices count as equal."""
_ROBOTS: Final = range(MOST_ROBOTS)

LINE_TABLE: Final = EntryTable(
    (
        ObservationEntry("gone", "-", 0.5, 0.5, "share of the shift that is over"),
        *(
            ObservationEntry(f"turn_{k}", "-", 0.5, 0.5, f"whether it is the turn of robot {k}, upstream first")
            for k in _ROBOTS
        ),
        *(ObservationEntry(f"busy_{k}", "s", 0.5, 0.5, f"until robot {k} is expected to be free") for k in _ROBOTS),
        ObservationEntry("hand_x", "m", 0.0, 0.30, "where the hand stands, from the robot's base"),
        ObservationEntry("hand_y", "m", 0.0, 0.30, "where the hand stands, from the robot's base"),
        ObservationEntry("coming", "-", 8.0, 8.0, "objects in the camera's sight that the robot takes"),
        ObservationEntry("possible", "-", 8.0, 8.0, "choices that exist"),
    )
)
"""Features of the line; entries from 0 on."""
CHOICE_TABLE: Final = EntryTable(
    (
        ObservationEntry("real", "-", 0.0, 1.0, "1; all entries of a choice that does not exist are 0"),
        ObservationEntry("pick_x", "m", 0.0, 0.30, "where the object is lifted"),
        ObservationEntry("pick_y", "m", -0.33, 0.15, "where the object is lifted"),
        ObservationEntry("lift", "s", 1.0, 0.6, "until the object is lifted"),
        ObservationEntry("cycle", "s", 1.3, 0.6, "until the robot is free again"),
        ObservationEntry("wait", "s", 0.0, 0.5, "standstill above the belt until the object comes"),
        ObservationEntry("slack", "s", 1.0, 1.0, "how much later the object could be lifted"),
        ObservationEntry("value", "-", 1.0, 1.0, "of the object in its bin"),
        ObservationEntry("ln_rate", "ln 1/s", 0.0, 3.0, "value x chance / cycle, its logarithm"),
        ObservationEntry("chance", "-", 0.5, 0.5, "that the object ends in its bin, by the table of throws"),
        ObservationEntry("percent", "%", 40.0, 10.0, "speed setting"),
        ObservationEntry("distance", "m", 0.8, 0.2, "horizontal distance from pick to bin"),
        ObservationEntry("stop_x", "m", 0.0, 0.3, "where the hand stops after the throw"),
        ObservationEntry("stop_y", "m", 0.1, 0.2, "where the hand stops after the throw"),
        ObservationEntry("crowd", "-", 2.0, 2.0, "objects within 0.25 m of this stop that the robot can take then"),
        ObservationEntry("heirs", "-", 0.0, 1.0, "robots downstream that take this item"),
        ObservationEntry("reaches", "s", 0.0, 3.0, "until the first of these robots can reach it; 0 for none"),
        ObservationEntry("queue", "-", 0.0, 6.0, "objects ahead of it that this downstream robot takes"),
    )
)
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


@final
class Observer:
    """Observes lines for robots.

    Args:
        chooser: chooser of the lines.
        duration: length of a work shift [s].
    """

    def __init__(self, chooser: Chooser, duration: float) -> None:
        self._numbers = chooser.numbers, chooser.can_take, chooser.bases, duration, CLIP, MIN_RATE

    def observe(self, state: LineState, stream: Stream, robot: Ints) -> NDArray[np.float32]:
        """Observations (N, ENTRIES) of robots (N,), without choices where another robot decides."""
        observations = empty_observations(len(robot))
        self.write(observations, state, stream, robot, np.arange(len(robot)))
        return observations

    def write(
        self, observations: NDArray[np.float32], state: LineState, stream: Stream, robot: Ints, lines: Ints
    ) -> None:
        """Write the rows of `observe` for some lines (K,)."""
        observation_kernel.write_observations(
            *self._numbers, lines, state.clock, robot, state.robot == robot, state.hand, state.expected,
            state.choices.real, state.choices.numbers, stream.x, state.books.read().since,
            stream.objects.measured.kind, LINE_TABLE.scaling, CHOICE_TABLE.scaling, observations,
        )  # fmt: skip


def empty_observations(count: int) -> NDArray[np.float32]:
    """Room for the observations of N robots (N, ENTRIES)."""
    return np.empty((count, ENTRIES), dtype=np.float32)


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
