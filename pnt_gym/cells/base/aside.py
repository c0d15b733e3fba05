"""Random numbers beside a row's own: what a level switches on draws from them, and every other draw stays as it is."""

from __future__ import annotations

from enum import IntEnum
from typing import Any, Final, final

import numpy as np

APART: Final = 8192
"""Jumps between two purposes; requests look at fewer from where a generator is (`cells.base.request`)."""


@final
class Purpose(IntEnum):
    """What is drawn."""

    PICK = 1
    """Whether a cup seals."""
    CLASS = 2
    """As what an object is seen."""
    FILL = 3
    """How much lies in bins."""
    SHIFT = 4
    """What changes during a shift, and what is seen of it."""
    ARRIVAL = 5
    """Where objects lie on a line's belt, and what each is worth."""


def aside(generator: np.random.Generator, purpose: Purpose) -> np.random.Generator:
    """A generator far ahead in the sequence of a row's, which stays where it is.

    So it is a function of where the row's generator stands: a row gives the same alone and in a batch, and a copy of
    an environment needs nothing but that one.
    """
    bits: Any = generator.bit_generator
    return np.random.default_rng(bits.jumped(APART * purpose))
