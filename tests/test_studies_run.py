"""The studies that ship run: the first case of every part is measured, with few throws and little practice."""

from typing import Any, Final

import pytest

from agents.benchmark.study import measurement
from agents.results import study
from agents.results.study import STUDIES, Amount, Case

FEW: Final = 64
"""Throws of a case."""
SHIFTS: Final = {
    "adaptation", "cells", "ceilings", "dispatch", "fit", "fit_full", "fit_use", "headroom", "line", "robots",
}  # fmt: skip
"""Studies of work shifts, cells, twins and searches, which are longer: a case has two of them."""
MORE: Final = {"grasping": 2000}
"""Throws of studies that need some of each kind."""
LITTLE: Final = {
    "practice": 400, "trials": 1, "collected": 400, "objects": 400, "comparisons": 100, "tries": 400, "most": 2000,
    "rows": 2,
}  # fmt: skip
"""What settings ask for at most."""
LONG: Final = {"grasp_shift"}
"""Studies that practise for minutes; tests/test_shift_learners.py has their parts."""
PLANS = [plan for plan in map(study.read, sorted(STUDIES.glob("*.yaml"))) if not plan.needs_data]
FIRST = {f"{plan.study}-{part}": plan.cases(part)[0] for plan in PLANS if plan.study not in LONG for part in plan.parts}
"""The first case of each part; studies of measured data have tests of their own."""


def little(name: str, value: Any) -> Any:
    """A setting that asks for less, also inside of other settings."""
    if isinstance(value, dict):
        return {key: little(key, part) for key, part in value.items()}
    return min(value, LITTLE[name]) if name in LITTLE and isinstance(value, int) else value


def few(name: str, amount: Amount) -> Amount:
    """Few throws, or work shifts, of a part."""
    plan = name.partition("-")[0]
    return amount._replace(throws=min(amount.throws, 2 if plan in SHIFTS else MORE.get(plan, FEW)))


@pytest.mark.nightly
@pytest.mark.filterwarnings("ignore")  # few throws may have no throw of a kind
@pytest.mark.parametrize("name", FIRST)
def test_the_first_case_of_a_part_is_measured(name: str) -> None:
    case: Case = FIRST[name]
    figures = measurement(case.measure)(little("", case.settings), few(name, case.amount))
    rows = [figures] if isinstance(figures, dict) else list(figures)
    assert rows
    assert all(rows)
