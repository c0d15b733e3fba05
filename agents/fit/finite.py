"""Numbers of a fit that are not finite, which end the fit with one sentence."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

import numpy as np

from pnt_gym.errors import PntGymError, one_sentence

from ..ground.cli import UsageError


@contextmanager
def finite_numbers() -> Generator[None]:
    """Context or decorator of a computation that NumPy and SciPy refuse where its numbers are not finite.

    Raises:
        UsageError: they do.
    """
    try:
        yield
    except PntGymError:
        raise
    except (ValueError, ArithmeticError) as error:  # of SciPy's search, and of NumPy's matrices, whose error is a kind
        raise _error(one_sentence(error, 120)) from error


def check_finite(*numbers: Any) -> None:
    """Make sure that the results of a fit are finite.

    Raises:
        UsageError: one is not.
    """
    if not all(np.isfinite(part).all() for part in numbers):
        raise _error("a result is not finite")


def _error(reason: str) -> UsageError:
    return UsageError(
        f"no fit follows from these throws and this level ({reason}); look for values of the log, of the level or of "
        "--prior that no cell has"
    )
