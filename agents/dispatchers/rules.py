"""Rules for a line: each choice has an index or a score, and the robot takes the largest.

The rules use only the observation. All but `price` rate a choice as if the robot were alone; `price` discounts choices
that robots downstream can take too.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.observation import CHOICE_TABLE, ENTRIES, LINE_TABLE, DecodedObservation, decoded
from pnt_gym.cells.line.rows import CHOICES
from pnt_gym.planning.dispatch import Candidates, Rule, index

from ..controllers.protocol import Controller, Observation
from ..ground.cli import UsageError
from ..learning.runs import RunFolder

HALF: Final = 0.5
"""Threshold between the values 0 and 1 of binary entries."""


def candidates(observation: DecodedObservation, value: Floats) -> Candidates:
    """Choices as candidates of the dispatching rules, each with its value (N, C)."""
    choices = observation.choices
    return Candidates(
        value, choices["cycle"], choices["lift"], choices["lift"] + choices["slack"], observation.choices["real"] > HALF
    )


def best(worth: Floats) -> NDArray[np.int64]:
    """The choice of the largest worth in each line (N,); the first one of equals."""
    return worth.argmax(axis=1).astype(np.int64)


@final
class IndexRule(Controller):
    """One of the rules of `pnt_gym.planning.dispatch`.

    Args:
        name: name in tables.
        rule: name of the rule.
        patience: k of `atc` [s].
        share: share of its value that a choice loses if a robot downstream can take it too, from 0 to 1.
    """

    def __init__(self, name: str, rule: Rule, patience: float = 1.0, share: float = 0.0) -> None:
        self.name = name
        self._rule: Rule = rule
        self.patience, self.share = patience, share

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """The best choice of each line (N,)."""
        return best(self.worth(decoded(observation.features)))

    def worth(self, observation: DecodedObservation) -> Floats:
        """Index of each choice (N, C); minus infinity for choices that do not exist."""
        expected = np.exp(observation.choices["ln_rate"]) * observation.choices["cycle"]
        value = expected * np.where(observation.choices["heirs"] > HALF, 1.0 - self.share, 1.0)
        return index(self._rule, candidates(observation, value), self.patience)


@final
class RandomChoice(Controller):
    """Random choice among the real ones, with equal probabilities."""

    name = "random"

    def __init__(self) -> None:
        self._generator = np.random.default_rng(0)

    def reset(self, seed: int) -> None:
        """Reseed the generator."""
        self._generator = np.random.default_rng(seed)

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """A random choice in each line (N,)."""
        is_choice = decoded(observation.features).choices["real"] > HALF
        return best(np.where(is_choice, self._generator.random(is_choice.shape), -1.0))


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
        return best(worth)


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
