"""Side generators of a row: effects that a level switches on draw from them, so that all other draws stay the same."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats

JUMPS_PER_PURPOSE: Final = 8192
"""Jumps of the bit generator between two purposes; requests jump fewer times (`cells.base.request`)."""


@final
class Purpose(IntEnum):
    """Purposes that have a separate side generator."""

    PICK = 1
    """Whether a cup seals."""
    CLASS = 2
    """The item that the classifier sees in an object."""
    FILL = 3
    """How much lies in bins."""
    SHIFT = 4
    """How a cell drifts during a shift of picks, and what the sensors measure of the drift."""
    ARRIVAL = 5
    """Where objects lie on a line's belt, and what each is worth."""


_JUMP: Final = 210306068529402873165736369884012333109
"""Steps of a jump of numpy's `PCG64`: its period times the golden ratio's fraction."""
_PERIOD: Final = 2**128


def side_generator(generator: np.random.Generator, purpose: Purpose) -> np.random.Generator:
    """A generator far ahead in the sequence of a row's generator, which does not advance.

    The side generator is a function of the state of the row's generator. So a row draws the same alone and in a batch,
    and a copy of an environment needs only the row's generator.
    """
    bits: Any = generator.bit_generator
    return np.random.default_rng(bits.jumped(JUMPS_PER_PURPOSE * purpose))


def draw_aside(generator: np.random.Generator, purpose: Purpose, draws: Floats) -> None:
    """Write the first uniform draws of a side generator; the row's generator, a `PCG64`, does not advance.

    The row's generator draws itself, far ahead, and comes back: a generator takes five times as long to make.
    """
    bits: Any = generator.bit_generator
    state = bits.state
    bits.advance(_JUMP * JUMPS_PER_PURPOSE * purpose % _PERIOD)
    generator.random(out=draws)
    bits.state = state
