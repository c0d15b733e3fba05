"""What all cases of the fuzz share: how they draw, what is junk, and what is a find."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Final

import gymnasium as gym
import hypothesis
import numpy as np
from hypothesis import strategies as st

from pnt_gym.errors import PntGymError

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


class Draws:
    """What a case draws by hypothesis, which then looks for the simplest draws that lead to the same find."""

    def __init__(self, data: Any) -> None:
        self._draw: Callable[[Any], Any] = data.draw

    def pick(self, choices: Iterable[Any]) -> Any:
        """One of the choices; the first one is the simplest."""
        return self._draw(st.sampled_from(list(choices)))

    def integer(self, low: int, end: int | None = None) -> int:
        """A whole number from 0 to below ``low``, or from ``low`` to below ``end``."""
        low, end = (0, low) if end is None else (low, end)
        return self._draw(st.integers(low, end - 1))

    def number(self, low: float, high: float) -> float:
        """A number in a range."""
        return self._draw(st.floats(low, high))

    def chance(self, share: float) -> bool:
        """True in a share of the cases; False is simpler."""
        return self.integer(1000) >= 1000 - round(1000 * share)

    def generator(self) -> np.random.Generator:
        """A generator for arrays."""
        return np.random.default_rng(self.integer(2**32))


def find_simplest(case: Callable[[Draws], object], seed: int, count: int) -> str | None:
    """What is wrong with the simplest of a number of cases in which something is; None where nothing is.

    Args:
        case: raises a `Find`, or any other exception.
        seed: seed of the draws.
        count: number of cases.
    """
    rules = hypothesis.settings(
        max_examples=count,
        database=None,
        deadline=None,
        report_multiple_bugs=False,
        phases=(hypothesis.Phase.generate, hypothesis.Phase.shrink),
        suppress_health_check=list(hypothesis.HealthCheck),
        verbosity=hypothesis.Verbosity.quiet,
    )

    def attempt(data: Any) -> None:
        case(Draws(data))

    try:
        hypothesis.seed(seed)(rules(hypothesis.given(data=st.data())(attempt)))()
    except Find as find:
        return str(find)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None


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
    except (Exception, SystemExit) as error:
        raise Find(f"{subject}: {type(error).__name__}: {error}") from error


def finite(subject: str, *values: Any) -> None:
    """Make sure that observations and rewards are numbers."""
    parts = [part for value in values for part in (value.values() if isinstance(value, dict) else [value])]
    for value in parts:
        if not np.isfinite(np.asarray(value, dtype=np.float64)).all():
            raise Find(f"{subject}: {value} is no number")
