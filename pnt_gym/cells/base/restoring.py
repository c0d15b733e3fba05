"""Steps that some rows of a batch take only because all rows take them."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, Protocol

import numpy as np

from pnt_gym.arrays import Bools, replaced, take


class Drawing(Protocol):
    """A cell of N rows, each of which draws from a generator of its own."""

    context: Any
    """The coming throws (N,)."""
    generators: list[np.random.Generator]


@contextmanager
def restoring(cell: Drawing, waiting: Bools) -> Generator[None]:
    """At the end of the block, give rows that wait the coming throws and the random numbers of its begin.

    Args:
        cell: steps in the block.
        waiting: these rows (N,).
    """
    context, generators = cell.context, [cell.generators[row] for row in np.flatnonzero(waiting)]
    states = [generator.bit_generator.state for generator in generators]
    yield
    cell.context = replaced(cell.context, waiting, take(context, waiting))
    for generator, state in zip(generators, states, strict=True):
        generator.bit_generator.state = state
