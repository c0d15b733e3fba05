"""Controllers of a line by scores: a tuned index, or the policy of a training run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.observation import CHOICE_TABLE, ENTRIES, LINE_TABLE
from pnt_gym.cells.line.rows import CHOICES

from ..controllers.protocol import Controller, Observation
from ..ground.cli import UsageError
from ..learning.runs import RunFolder
from .rules import HALF, first_of

Scores = Callable[[NDArray[np.float32]], NDArray[np.floating]]
"""Function from observations (N, ENTRIES) to scores of choices (N, CHOICES)."""
REAL: Final = slice(len(LINE_TABLE) + CHOICE_TABLE.names.index("real"), ENTRIES, len(CHOICE_TABLE))
"""Entries of an observation that say whether each choice exists."""


def choice_mask(observations: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Whether each choice exists (N, CHOICES)."""
    return observations[:, REAL] > HALF


@final
class ScoreController(Controller):
    """Takes the choice of the largest score.

    Args:
        name: name in tables.
        scores: function that scores choices.
    """

    def __init__(self, name: str, scores: Scores) -> None:
        self.name, self.scores = name, scores

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """The best choice of each line (N,)."""
        features = observation.features
        worth: Floats = np.where(choice_mask(features), self.scores(features), -np.inf)
        return first_of(worth)


def run_scores(folder: Path, checkpoint: Path | None = None) -> ScoreController:
    """Controller of a run folder's policy for lines, or of one of its checkpoints.

    Raises:
        UsageError: the folder or its policy is missing or damaged, or belongs to another environment.
    """
    run = RunFolder(folder)
    policy = run.load_policy(checkpoint)
    if policy.sizes != (ENTRIES, CHOICES) or getattr(policy, "output", "scores") != "scores":
        inputs, outputs = policy.sizes
        raise UsageError(
            f"the policy of {str(folder)!r} has {inputs} inputs and {outputs} outputs; a line needs {ENTRIES} inputs "
            f"and {CHOICES} outputs"
        )
    return ScoreController(run.arguments["algo"], policy)
