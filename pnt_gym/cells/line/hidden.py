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
from pnt_gym.cells.line.state import CHOICES
from pnt_gym.cells.line.throws import Made


@final
@dataclass(frozen=True)
class Truth:
    """True properties of the choices of N robots, (N, CHOICES) each."""

    real: Bools
    """Whether each choice exists; other rows hold arbitrary values."""
    objects: Objects
    worth: Floats
    """Value of each object in a bin that takes the object."""
    made: Made | None
    """Results of each throw; None where only a simulation can tell."""
    value: Floats
    """Value that each choice would bring in; NaN where only a simulation can tell."""


def _each(name: str, unit: str, meaning: str, value: Callable[[Truth], NDArray[np.generic]]) -> tuple[Quantity, ...]:
    """A quantity of every choice, named by the choice's number; NaN where the choice does not exist."""

    def of(choice: int) -> Callable[[Truth], Floats]:
        return lambda truth: np.where(truth.real[:, choice], value(truth)[:, choice], np.nan)

    return tuple(Quantity(f"{name}_{choice}", unit, meaning, of(choice)) for choice in range(CHOICES))


def _made(truth: Truth) -> Made:
    """Results of the throws, by the table."""
    assert truth.made is not None
    return truth.made


OBJECTS: Final = (
    *_each("true_kind", "-", "what the object of choice K is, an index of `items`", lambda t: t.objects.kind),
    *_each("worth", "-", "what that object is worth in a bin that takes it", lambda t: t.worth),
)
"""Quantities of every line."""
BY_TABLE: Final = (
    *OBJECTS,
    *_each("picked", "-", "1 if the cup would seal", lambda t: _made(t).picked),
    *_each("is_success", "-", "1 if the object would lie in the bin of the choice", lambda t: _made(t).is_success),
    *_each("sorted", "-", "1 if it would, and that bin takes what the object is", lambda t: _made(t).sorted),
    *_each("value", "-", "what the choice would bring in before the shift is over", lambda t: t.value),
)
"""Quantities of a line with a table of throws, which gives the result of every choice."""
SIMULATED: Final = (
    *OBJECTS,
    *_each("mass", "kg", "true mass of the object of choice K", lambda t: t.objects.mass),
    *_each("height", "m", "true height of that object", lambda t: t.objects.size[..., 2]),
    *_each("seal", "N", "true vacuum force F0 on that object before the release", lambda t: t.objects.seal),
    *_each("delay", "s", "release of that object later than commanded", lambda t: t.objects.delay),
)
"""Quantities of a line with simulated throws: the properties that decide about them. Results are unknown, because only
the chosen throw is simulated."""
