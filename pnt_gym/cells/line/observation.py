"""Observation of the robot that decides next: its line in a few numbers, and the features of each choice.

Nothing hidden enters: positions are those of the camera and the belt's encoder, values and items those of the camera,
times the planner's, chances those of the table of throws.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.features import CLIP, Feature, FeatureTable
from pnt_gym.cells.line import observation_kernel
from pnt_gym.cells.line.choosing import Chooser
from pnt_gym.cells.line.config import MOST_ROBOTS
from pnt_gym.cells.line.state import CHOICES, Choices, LineState
from pnt_gym.cells.line.stream import Stream

MIN_RATE: Final = 1e-6
"""Value per second below which choices count as equal."""


@final
@dataclass(frozen=True)
class LineSummary:
    """What N deciding robots know of their lines."""

    gone: Floats
    """Share of the shift that is over (N,)."""
    robot: Ints
    """Index of the deciding robot (N,)."""
    hand: Floats
    """Position at which the hand stands still (N, 3) [m]."""
    coming: Floats
    """Objects that the robot takes, between the camera and the end of its window (N,)."""
    busy: Floats
    """Time until each robot of the line is expected to be free (N, MOST_ROBOTS) [s]; 0 for robots that do not exist."""
    possible: Floats
    """Number of real choices (N,)."""


def log_rate(choices: Choices) -> Floats:
    """Logarithm of the expected value per second of a choice, S."""
    rate: Floats = choices.value * choices.chance / choices.cycle
    return np.log(np.maximum(rate, MIN_RATE))


def _one_hot(index: int) -> Feature:
    def is_turn(glance: LineSummary) -> Floats:
        return (glance.robot == index).astype(np.float64)

    return Feature(f"turn_{index}", "-", 0.5, 0.5, f"whether it is the turn of robot {index}, upstream first", is_turn)


def _until_free(index: int) -> Feature:
    def until(glance: LineSummary) -> Floats:
        return glance.busy[:, index]

    return Feature(f"busy_{index}", "s", 0.5, 0.5, f"until robot {index} is expected to be free", until)


LINE_TABLE: Final = FeatureTable(
    (
        Feature("gone", "-", 0.5, 0.5, "share of the shift that is over", lambda g: g.gone),
        *(_one_hot(index) for index in range(MOST_ROBOTS)),
        *(_until_free(index) for index in range(MOST_ROBOTS)),
        Feature("hand_x", "m", 0.0, 0.30, "where the hand stands, from the robot's base", lambda g: g.hand[:, 0]),
        Feature("hand_y", "m", 0.0, 0.30, "where the hand stands, from the robot's base", lambda g: g.hand[:, 1]),
        Feature("coming", "-", 8.0, 8.0, "objects in the camera's sight that the robot takes", lambda g: g.coming),
        Feature("possible", "-", 8.0, 8.0, "choices that exist", lambda g: g.possible),
    )
)
"""Features of the line; entries from 0 on."""
CHOICE_TABLE: Final = FeatureTable(
    (
        Feature("real", "-", 0.0, 1.0, "1; all entries of a choice that does not exist are 0", lambda c: c.real),
        Feature("pick_x", "m", 0.0, 0.30, "where the object is lifted", lambda c: c.pick[..., 0]),
        Feature("pick_y", "m", -0.33, 0.15, "where the object is lifted", lambda c: c.pick[..., 1]),
        Feature("lift", "s", 1.0, 0.6, "until the object is lifted", lambda c: c.lift),
        Feature("cycle", "s", 1.3, 0.6, "until the robot is free again", lambda c: c.cycle),
        Feature("wait", "s", 0.0, 0.5, "standstill above the belt until the object comes", lambda c: c.wait),
        Feature("slack", "s", 1.0, 1.0, "how much later the object could be lifted", lambda c: c.leave - c.lift),
        Feature("value", "-", 1.0, 1.0, "of the object in its bin", lambda c: c.value),
        Feature("ln_rate", "ln 1/s", 0.0, 3.0, "value x chance / cycle, its logarithm", log_rate),
        Feature("chance", "-", 0.5, 0.5, "that the object ends in its bin, by the table of throws", lambda c: c.chance),
        Feature("percent", "%", 40.0, 10.0, "speed setting", lambda c: c.percent),
        Feature(
            "distance",
            "m",
            0.8,
            0.2,
            "horizontal distance from pick to bin",
            lambda c: np.hypot(c.away[..., 0], c.away[..., 1]),
        ),
        Feature("stop_x", "m", 0.0, 0.3, "where the hand stops after the throw", lambda c: c.stop[..., 0]),
        Feature("stop_y", "m", 0.1, 0.2, "where the hand stops after the throw", lambda c: c.stop[..., 1]),
        Feature(
            "crowd", "-", 2.0, 2.0, "objects within 0.25 m of this stop that the robot can take then", lambda c: c.crowd
        ),
        Feature("heirs", "-", 0.0, 1.0, "robots downstream that take this item", lambda c: c.heirs),
        Feature(
            "reaches", "s", 0.0, 3.0, "until the first of these robots can reach it; 0 for none", lambda c: c.reaches
        ),
        Feature("queue", "-", 0.0, 6.0, "objects ahead of it that this downstream robot takes", lambda c: c.queue),
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


def encode_observation(glance: LineSummary, choices: Choices) -> NDArray[np.float32]:
    """Observations (N, ENTRIES) of deciding robots, feature by feature; `write_observations` gives the same bits."""
    choice_features = CHOICE_TABLE.encode(choices)
    choice_features[~choices.real] = 0.0
    return np.concatenate([LINE_TABLE.encode(glance), choice_features.reshape(len(choice_features), -1)], axis=1)


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


def decoded(observation: NDArray[np.floating]) -> DecodedObservation:
    """Physical values of observations S + (ENTRIES,); clipped entries stay clipped."""
    head = len(LINE_TABLE)
    choice_features = observation[..., head:].reshape(*observation.shape[:-1], CHOICES, len(CHOICE_TABLE))
    return DecodedObservation(LINE_TABLE.decode(observation[..., :head]), CHOICE_TABLE.decode(choice_features))
