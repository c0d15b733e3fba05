"""Every key of every level: a value of another type, below or above its range, an unknown or a missing key is refused.

The cases come from the types of the levels' sections, so that a new key has its cases with its first line.
"""

import re
from typing import Final

import pytest

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.errors import ConfigError
from tests.tools.wrong import FAMILIES, keys, lacks

NO_SIMULATED_TIME: Final = {"reward.time_scale", "patience", "arm.time_step", "duration", "down.0.start", "down.0.end"}
"""Times of what is not simulated throw by throw."""
CHECKED_ELSEWHERE: Final = re.compile(r"drift\.(?!steps)\w+\.\w+|grasp\.stages|picks_per_shift")
"""Numbers whose section says their bounds by itself, and a number that may be as large as one likes."""


@pytest.mark.parametrize("family", FAMILIES)
def test_every_number_of_a_level_has_bounds(family: type[LevelConfig]) -> None:
    numbers = {case.name for case in keys(family) if case.value == "zzz"}
    assert len(numbers) > 50
    for how in ("below", "above"):
        free = numbers - {case.name for case in keys(family) if case.how == how}
        assert [name for name in free if not CHECKED_ELSEWHERE.fullmatch(name)] == []


@pytest.mark.parametrize("family", FAMILIES)
def test_no_part_of_a_throw_takes_more_than_seconds(family: type[LevelConfig]) -> None:
    above = {case.name: case.value for case in keys(family) if case.how == "above" and case.unit == "s"}
    assert len(above) > 4
    assert {name for name, value in above.items() if value > 11.0} <= NO_SIMULATED_TIME


@pytest.mark.parametrize("family", FAMILIES)
def test_a_value_that_a_key_cannot_have_is_refused_by_name(family: type[LevelConfig]) -> None:
    assert {case.how for case in keys(family)} == {"type", "below", "above", "unknown"}
    for case in (*keys(family), *lacks(family)):
        with pytest.raises(ConfigError) as caught:
            family.load(case.level())
        head, *problems = str(caught.value).split("\n")
        assert case.name in str(caught.value), case
        assert head.startswith("config"), case
        assert all(problem.startswith("- ") for problem in problems), case
        assert max(map(len, (head, *problems))) <= 502, case
        assert caught.value.__suppress_context__, case  # no traceback of pydantic's before the sentence
