"""Scorer of the choices on a line, as arrays of numbers: the log of the ATC index plus the output of a network.

A scorer applies one small network to each choice. The network's inputs are the entries of the choice and those of the
line. Its output is added to the log of the choice's ATC index, and the choice with the greatest score is taken. So a
network with zero output *is* the rule, and a network without hidden layers is an index whose weights can be written
down.

A scorer's file is a NumPy archive of numbers and one name:

    weight_0, bias_0, weight_1, ...   full layers, weights (outputs, inputs), float32; of the first the inputs are the
                                      entries of `CHOICE_TABLE`, then those of `LINE_TABLE`, as observations have them
    activation                        after every layer but the last, see `agents.policies.networks`
    patience                          of the ATC index [s]
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.observation import CHOICE_TABLE, ENTRIES, LINE_TABLE
from pnt_gym.cells.line.rows import CHOICES
from pnt_gym.reading import arrays_of

from ..ground.archives import save_arrays
from ..ground.cli import UsageError, check_known
from . import networks
from .networks import ACTIVATIONS, LAYER, Dense, Layers

NAMES: Final = CHOICE_TABLE.names
"""Names of a choice's entries."""
INPUTS: Final = len(CHOICE_TABLE) + len(LINE_TABLE)
"""Number of a scorer's inputs for one choice."""


def inputs(observations: NDArray[np.floating]) -> Floats:
    """Inputs of a scorer for each choice (N, CHOICES, INPUTS), from observations (N, ENTRIES)."""
    entries, head = np.asarray(observations, dtype=np.float64), len(LINE_TABLE)
    choices = entries[:, head:].reshape(len(entries), CHOICES, -1)
    line = np.broadcast_to(entries[:, None, :head], (len(entries), CHOICES, head))
    return np.concatenate([choices, line], axis=-1)


def rule(patience: float) -> tuple[Floats, float]:
    """Weights (INPUTS,) and constant of the log of the ATC index as a linear function of inputs; patience in [s].

    Apparent tardiness cost (Vepsalainen and Morton 1987): log(index) = log(value x chance / cycle) - slack / patience.
    The inputs `ln_rate` and `slack` are linear in the two terms.
    """
    origin, unit = (CHOICE_TABLE.decode(np.full(len(CHOICE_TABLE), value)) for value in (0.0, 1.0))
    weight, constant = np.zeros(INPUTS), 0.0
    for name, factor in (("ln_rate", 1.0), ("slack", -1.0 / patience)):
        weight[NAMES.index(name)] = factor * (unit[name] - origin[name])
        constant += float(factor * origin[name])
    return weight, constant


PARTS: Final = re.compile(rf"{LAYER}|activation|patience")
"""Names of the arrays in a scorer's file."""


@final
@dataclass(frozen=True)
class Scorer:
    """Scorer of choices; its file holds its attributes."""

    layers: Layers
    patience: float
    activation: str = "Tanh"

    @classmethod
    def linear(cls, patience: float = 1.0, weights: Mapping[str, float] | None = None) -> Self:
        """An index whose log is the log of the ATC index plus a weighted sum of a choice's entries.

        Args:
            patience: patience of the ATC index [s].
            weights: weights by the names of `CHOICE_TABLE`, for entries as in observations; other entries have weight
                0.

        Raises:
            UsageError: a weight has a name that is no entry.
        """
        weight = np.zeros((1, INPUTS), dtype=np.float32)
        for name, value in (weights or {}).items():
            check_known("weight of an index", [name], NAMES)
            weight[0, NAMES.index(name)] = value
        return cls((Dense(weight, np.zeros(1, dtype=np.float32)),), patience)

    def __call__(self, observations: NDArray[np.floating]) -> Floats:
        """Scores (N, CHOICES) for observations (N, ENTRIES); scores of empty choices mean nothing."""
        choice_inputs, (weight, constant) = inputs(observations), rule(self.patience)
        return choice_inputs @ weight + constant + networks.run(self.layers, self.activation, choice_inputs)[..., 0]

    @property
    def sizes(self) -> tuple[int, int]:
        """Length of an observation, and number of choices."""
        return ENTRIES, CHOICES

    @property
    def numbers(self) -> dict[str, NDArray[Any]]:
        """Arrays of the scorer by their names in a file, without the name of the activation."""
        return {**networks.arrays(self.layers), "patience": np.array(self.patience)}

    def save(self, file: Path) -> None:
        """Write the scorer to a file."""
        save_arrays(file, {**self.numbers, "activation": self.activation})

    @classmethod
    def load(cls, file: Path) -> Self:
        """Read a scorer from a file; no code in the file is run.

        Raises:
            UsageError: the file is missing or damaged, or holds no scorer.
        """
        if not file.is_file():
            raise UsageError(f"scorer {str(file)!r} does not exist")
        try:
            arrays = arrays_of(file, PARTS)
            scorer = cls(networks.layers(arrays), float(arrays["patience"]), str(arrays["activation"]))
            _check(scorer)
        except Exception as error:
            # A truncated or foreign file may raise anything.
            raise UsageError(f"{str(file)!r} is damaged: {file.name} is truncated or scores no choices") from error
        return scorer


def _check(scorer: Scorer) -> None:
    """Make sure that the arrays and the activation of a scorer fit together."""
    first, last = scorer.layers[0].weight, scorer.layers[-1].weight
    fits = (first.shape[1], len(last)) == (INPUTS, 1) and scorer.activation in ACTIVATIONS
    if not (fits and np.isfinite(scorer.patience) and scorer.patience > 0.0):
        raise ValueError("parts that do not fit together")
