"""Hidden quantities of the choices on N lines, for the study of decisions after the fact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.features import Quantity
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.line.rows import CHOICES, Result, Rider
from pnt_gym.rows import Rows2


@final
@dataclass(frozen=True)
class Truth:
    """True properties of the choices of N robots, (N, CHOICES) each."""

    real: Bools
    """Whether each choice exists; other rows hold arbitrary values."""
    objects: Objects
    riders: Rows2[Rider]
    results: Rows2[Result]
    """Results of each throw; of no attempt where only a simulation can tell."""
    value: Floats
    """Value that each choice would bring in; NaN where only a simulation can tell."""


def _per_choice(
    name: str, unit: str, meaning: str, value: Callable[[Truth], NDArray[np.generic]]
) -> tuple[Quantity, ...]:
    """A quantity of every choice, named by the choice's number; NaN where the choice does not exist."""
    return tuple(
        Quantity(
            f"{name}_{choice}",
            unit,
            meaning,
            lambda truth, choice=choice: np.where(truth.real[:, choice], value(truth)[:, choice], np.nan),
        )
        for choice in range(CHOICES)
    )


OBJECTS: Final = (
    *_per_choice(
        "true_kind", "-", "true item of the object of choice K, an index of `items`", lambda t: t.riders["kind"]
    ),
    *_per_choice(
        "worth", "-", "value of the object of choice K in a bin that takes the object", lambda t: t.riders["worth"]
    ),
)
"""Quantities of every line."""
BY_TABLE: Final = (
    *OBJECTS,
    *_per_choice("picked", "-", "1 if the cup would seal on the object of choice K", lambda t: t.results["picked"]),
    *_per_choice(
        "is_success", "-", "1 if the object would lie in the bin of the choice", lambda t: t.results["is_success"]
    ),
    *_per_choice(
        "sorted", "-", "1 if is_success_K is 1 and the bin takes the true item", lambda t: t.results["sorted"]
    ),
    *_per_choice("value", "-", "value that the choice would add before the shift ends", lambda t: t.value),
)
"""Quantities of a line with a table of throws, which gives the result of every choice."""
SIMULATED: Final = (
    *OBJECTS,
    *_per_choice("mass", "kg", "true mass of the object of choice K", lambda t: t.objects.mass),
    *_per_choice("height", "m", "true height of the object of choice K", lambda t: t.riders["height"]),
    *_per_choice(
        "seal", "N", "true vacuum force F0 on the object of choice K before the release", lambda t: t.objects.seal
    ),
    *_per_choice(
        "delay", "s", "time from the commanded to the true release of the object of choice K", lambda t: t.objects.delay
    ),
)
"""Quantities of a line with simulated throws: the hidden properties on which results depend. Results are unknown,
because only the chosen throw is simulated."""
