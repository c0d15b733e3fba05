"""Index rules for a line: each choice has an index by what is seen of it, and the robot takes the greatest.

They know nothing but the observation. All but `price` look at a choice as if the robot were alone; that one lets what
robots downstream can take as well count for less.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.line.observation import Seen, decoded
from pnt_gym.planning.dispatch import Candidates, Rule, index

from ..controllers.protocol import Controller, Observation

HALF: Final = 0.5
"""Between the 0 and the 1 of entries that are one or the other."""


def real(seen: Seen) -> Bools:
    """Which choices there are (N, C)."""
    return seen.choices["real"] > HALF


def expected(seen: Seen) -> Floats:
    """Value times chance of each choice (N, C)."""
    return np.exp(seen.choices["ln_rate"]) * seen.choices["cycle"]


def candidates(seen: Seen, value: Floats) -> Candidates:
    """Choices as the rules of dispatching see them, with what each is worth (N, C)."""
    own = seen.choices
    return Candidates(value, own["cycle"], own["lift"], own["lift"] + own["slack"], real(seen))


def first_of(worth: Floats) -> NDArray[np.int64]:
    """The choice of the greatest worth in each line (N,); the first of like ones."""
    return worth.argmax(axis=1).astype(np.int64)


@final
class Index(Controller):
    """One of the rules of `pnt_gym.planning.dispatch`.

    Args:
        name: in tables.
        rule: the rule.
        patience: k of `atc` [s].
        share: of its value that a choice loses which a robot downstream can take too, from 0 to 1.
    """

    def __init__(self, name: str, rule: Rule, patience: float = 1.0, share: float = 0.0) -> None:
        self.name, self._rule = name, rule
        self.patience, self.share = patience, share

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """The best choice of each line (N,)."""
        return first_of(self.worth(decoded(observation.features)))

    def worth(self, seen: Seen) -> Floats:
        """The index of each choice (N, C); minus infinity for what is not there."""
        value = expected(seen) * np.where(seen.choices["heirs"] > HALF, 1.0 - self.share, 1.0)
        return index(self._rule, candidates(seen, value), self.patience)


@final
class Anything(Controller):
    """Any choice that there is, each as likely."""

    name = "random"

    def __init__(self) -> None:
        self._generator = np.random.default_rng(0)

    def reset(self, seed: int) -> None:
        """Begin anew."""
        self._generator = np.random.default_rng(seed)

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """One of the choices of each line (N,)."""
        there = real(decoded(observation.features))
        return first_of(np.where(there, self._generator.random(there.shape), -1.0))
