"""Products of cases that take long: the daily run has some of them, the nightly run all."""

from collections.abc import Collection, Iterable
from typing import Any

import pytest


def with_nightly(cases: Iterable[Any], daily: Collection[Any]) -> list[Any]:
    """Cases for `parametrize`, tuples or single values, of which those that are not daily are marked as nightly."""
    values = list(cases)
    assert daily
    assert all(case in values for case in daily), "a daily case is none of the cases"
    return [
        pytest.param(*case if isinstance(case, tuple) else (case,), marks=[] if case in daily else pytest.mark.nightly)
        for case in values
    ]
