"""What scores the choices at a line, as numbers: the log of the ATC index, and what is added to it.

A scorer is one small network for all choices alike. It sees the entries of one choice and those of the line, and what
it says is added to the log of that choice's ATC index; the choice of the greatest score is taken. So a network that
says nothing *is* the rule, and one without hidden layers is an index whose weights can be written down.

A file of it is a NumPy archive of numbers and one name:

    weight_0, bias_0, weight_1, ...   full layers, weights (outputs, inputs), float32; of the first the inputs are the
                                      entries of `CHOICE_TABLE`, then those of `LINE_TABLE`, as observations have them
    activation                        after every layer but the last, see `agents.policies.actor`
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
from pnt_gym.cells.line.state import CHOICES
from pnt_gym.errors import one_sentence
from pnt_gym.reading import arrays_of

from ..ground.cli import UsageError
from .actor import ACTIVATIONS, Layers, layers_of, named, through

NAMES: Final = CHOICE_TABLE.names
"""Of a choice's entries."""
INPUTS: Final = len(CHOICE_TABLE) + len(LINE_TABLE)
"""Entries that a scorer sees of one choice."""


def inputs(observations: NDArray[np.floating]) -> Floats:
    """What a scorer sees of each choice, (N, CHOICES, INPUTS), in observations (N, ENTRIES)."""
    rows, head = len(observations), len(LINE_TABLE)
    each = np.asarray(observations[:, head:], dtype=np.float64).reshape(rows, CHOICES, -1)
    line = np.broadcast_to(observations[:, None, :head], (rows, CHOICES, head))
    return np.concatenate([each, line], axis=-1)


def rule(patience: float) -> tuple[Floats, float]:
    """Weights (INPUTS,) and constant by which inputs make the log of the ATC index, with a patience [s].

    It is value x chance / cycle, logarithmic, less slack / patience, and observations are linear in both.
    """
    zero, one = (CHOICE_TABLE.decode(np.full(len(CHOICE_TABLE), value)) for value in (0.0, 1.0))
    weight, constant = np.zeros(INPUTS), 0.0
    for name, factor in (("ln_rate", 1.0), ("slack", -1.0 / patience)):
        weight[NAMES.index(name)] = factor * (one[name] - zero[name])
        constant += float(factor * zero[name])
    return weight, constant


PARTS: Final = re.compile(r"(?:weight|bias)_\d{1,3}|activation|patience")
"""Names of the arrays in a file."""


@final
@dataclass(frozen=True)
class Scorer:
    """Scores of choices; its file holds what its attributes say."""

    layers: Layers
    patience: float
    activation: str = "Tanh"

    @classmethod
    def linear(cls, patience: float = 1.0, weights: Mapping[str, float] | None = None) -> Self:
        """An index whose log is that of ATC and a weighted sum of a choice's entries.

        Args:
            patience: of ATC [s].
            weights: by the names of `CHOICE_TABLE`, of entries as observations have them; others count nothing.

        Raises:
            UsageError: a weight of no entry.
        """
        weight = np.zeros((1, INPUTS), dtype=np.float32)
        for name, value in (weights or {}).items():
            if name not in NAMES:
                raise UsageError(f"an index weighs {one_sentence(name, 40)!r}; entries are {', '.join(NAMES)}")
            weight[0, NAMES.index(name)] = value
        return cls(((weight, np.zeros(1, dtype=np.float32)),), patience)

    def __call__(self, observations: NDArray[np.floating]) -> Floats:
        """Scores (N, CHOICES) for observations (N, ENTRIES); those of choices that are not there mean nothing."""
        seen, (weight, constant) = inputs(observations), rule(self.patience)
        return seen @ weight + constant + through(self.layers, self.activation, seen)[..., 0]

    @property
    def sizes(self) -> tuple[int, int]:
        """Numbers in an observation, and choices."""
        return ENTRIES, CHOICES

    @property
    def numbers(self) -> dict[str, NDArray[Any]]:
        """All but the name of its activation, by their names in a file."""
        return {**named(self.layers), "patience": np.array(self.patience)}

    def save(self, file: Path) -> None:
        """Write it to a file."""
        with file.open("wb") as place:  # given a name, numpy would append a suffix
            np.savez(place, **self.numbers, activation=np.array(self.activation))

    @classmethod
    def load(cls, file: Path) -> Self:
        """Read it; nothing in the file is run.

        Raises:
            UsageError: it is missing or damaged, or holds something else.
        """
        if not file.is_file():
            raise UsageError(f"scorer {str(file)!r} does not exist")
        try:
            found = arrays_of(file, PARTS)
            scorer = cls(layers_of(found), float(found["patience"]), str(found["activation"]))
            _check(scorer)
        except Exception as error:
            # There is no telling what a torn or foreign file upsets.
            raise UsageError(f"{str(file)!r} is damaged: {file.name} is truncated or scores no choices") from error
        return scorer


def _check(scorer: Scorer) -> None:
    """Make sure that the parts fit together."""
    first, last = scorer.layers[0][0], scorer.layers[-1][0]
    fits = (first.shape[1], len(last)) == (INPUTS, 1) and scorer.activation in ACTIVATIONS
    if not (fits and np.isfinite(scorer.patience) and scorer.patience > 0.0):
        raise ValueError("parts that do not fit together")
