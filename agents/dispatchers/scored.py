"""Controllers of a line that go by scores: a tuned index, an imitation, or what a training run has learned."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.observation import CHOICE_TABLE, ENTRIES, LINE_TABLE
from pnt_gym.cells.line.state import CHOICES

from ..controllers.protocol import Controller, Observation
from ..ground.cli import UsageError
from ..learning.runs import load_numbers, read_arguments
from ..policies.scorer import Scorer
from .rules import HALF, first_of

Scores = Callable[[NDArray[np.float32]], NDArray[np.floating]]
"""Of choices (N, CHOICES), from observations (N, ENTRIES)."""
REAL: Final = slice(len(LINE_TABLE) + CHOICE_TABLE.names.index("real"), ENTRIES, len(CHOICE_TABLE))
"""The entries of an observation that tell which choices there are."""


def there(observations: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Which choices there are (N, CHOICES)."""
    return observations[:, REAL] > HALF


@final
class Scored(Controller):
    """Takes the choice of the greatest score.

    Args:
        name: in tables.
        scores: of choices.
    """

    def __init__(self, name: str, scores: Scores) -> None:
        self.name, self.scores = name, scores

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """The best choice of each line (N,)."""
        seen = observation.features
        worth: Floats = np.where(there(seen), self.scores(seen), -np.inf)
        return first_of(worth)


def scorer_in(file: Path) -> Scored:
    """What a file of a scorer does.

    Raises:
        UsageError: it is missing or damaged.
    """
    return Scored(file.stem, Scorer.load(file))


def run_scores(folder: Path, checkpoint: Path | None = None) -> Scored:
    """What a run folder has learned at a line, or one of its checkpoints.

    Raises:
        UsageError: the folder or its policy is missing or damaged, or of another environment.
    """
    policy = load_numbers(folder, checkpoint)
    if policy.sizes != (ENTRIES, CHOICES) or getattr(policy, "output", "scores") != "scores":
        seen, given = policy.sizes
        raise UsageError(
            f"the policy of {str(folder)!r} takes {seen} entries and gives {given} numbers; a line has {ENTRIES} and "
            f"{CHOICES} choices"
        )
    return Scored(read_arguments(folder)["algo"], policy)
