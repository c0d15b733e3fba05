"""What all cases of the fuzz share: how they draw, what is junk, and what is a find."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any, Final

import gymnasium as gym
import numpy as np

from pnt_gym.errors import PntGymError

Random = np.random.Generator
LONGEST: Final = 500
"""Characters of a sentence."""
JUNK: Final = (
    None, True, "", "x", "1.0", "nan", "a\nb", "x" * 300, [], {}, [1.0], [[1.0]], {"x": 1.0}, b"x", 1j, object(),
    float("nan"), float("inf"), -float("inf"), 0, 1, -1, 5, 0.5, 1e-300, 1e300, 10**400, -(10**12), 2.5e-9,
)  # fmt: skip


class Find(Exception):
    """What must not be."""


class Refused(Exception):
    """The right answer to what is wrong."""


@contextlib.contextmanager
def refusable(subject: str, *kinds: type[Exception]) -> Iterator[None]:
    """The block may be refused by an error of some kinds, in one sentence.

    Raises:
        Find: it is refused otherwise.
        Refused: it is refused well.
    """
    try:
        yield
    except (PntGymError, gym.error.Error, *kinds) as error:
        sentence = str(error)
        if isinstance(error.__cause__ or error.__context__, MemoryError):
            raise Find(f"{subject}: wants more memory than there is: {sentence}") from error
        head, *problems = sentence.split("\n")
        is_long = isinstance(error, PntGymError) and len(head) > LONGEST
        if not head or is_long or not all(problem.startswith("- ") for problem in problems):
            raise Find(f"{subject}: {type(error).__name__} is no sentence: {sentence!r}") from error
        raise Refused from error
    except (Refused, Find):
        raise
    except BaseException as error:
        raise Find(f"{subject}: {type(error).__name__}: {error}") from error


def finite(subject: str, *values: Any) -> None:
    """Make sure that observations and rewards are numbers."""
    parts = [part for value in values for part in (value.values() if isinstance(value, dict) else [value])]
    for value in parts:
        if not np.isfinite(np.asarray(value, dtype=np.float64)).all():
            raise Find(f"{subject}: {value} is no number")


def pick(random: Random, choices: Any) -> Any:
    """One element of a sequence, drawn at random."""
    chosen = list(choices)
    return chosen[int(random.integers(len(chosen)))]
