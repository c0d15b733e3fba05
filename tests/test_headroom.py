"""The optimum of the study `headroom`: it keeps limits and rules, and is not slower than the cell's planners."""

import numpy as np
import pytest

from agents.results.study import Amount
from benchmarks.studies import headroom
from benchmarks.studies.optimum import NoMotionFound, fastest_throw
from pnt_gym.errors import PlanningError
from pnt_gym.planning import EllipticWorkspace, MotionLimits
from pnt_gym.planning.free.rules import HandRules
from tests.tools.throw_check import check_throw

LIMITS = MotionLimits.t3kr(30)
RULES = HandRules(window=0.03, workspace=EllipticWorkspace())
PICK, TARGET, FOLLOWING, CEILING = [-0.2, -0.25, -0.85], [0.3, 0.4, -0.85], [-0.2, -0.35, -0.85], -0.75


def test_the_optimum_keeps_limits_and_rules_and_lands_on_its_target():
    found = fastest_throw(PICK, TARGET, FOLLOWING, LIMITS, ceiling=CEILING, rules=RULES)
    check = check_throw(found.path, np.array([found.release_time]), np.array([TARGET]), LIMITS, CEILING, RULES)
    assert check.keeps_rules(1e-6).tolist() == [True]
    np.testing.assert_allclose(found.path.end[0], FOLLOWING, atol=1e-6)
    assert found.position[2] <= CEILING + 1e-6
    assert sum(found.legs.values()) == pytest.approx(found.duration)


def test_planners_are_compared_on_the_same_picks_and_none_is_quicker_than_the_optimum(monkeypatch):
    seconds = iter([0.5, 0.4])
    monkeypatch.setattr(headroom, "_optimal_times", lambda context, *_: np.full(len(context.pick), next(seconds)))
    level = {"base": "nominal_plain", "limits": {"percent": [30]}}
    rows = {row["planner"]: row for row in headroom.headroom({"level": level}, Amount(6, 0))}
    assert list(rows) == [*headroom.PLANNERS, "optimum", "optimum, no window"]
    assert {row["picks"] for row in rows.values()} == {6}
    straight, flying, free = (rows[name]["seconds"]["value"] for name in headroom.PLANNERS)
    assert straight > flying > free > 0.0
    assert rows["straight"]["over_optimum"]["value"] == pytest.approx(straight / 0.5 - 1.0)
    assert rows["optimum, no window"]["over_optimum"]["value"] == pytest.approx(-0.2)


def test_impossible_throws_are_errors_in_a_sentence():
    with pytest.raises(PlanningError, match="below the ceiling"):
        fastest_throw(PICK, TARGET, FOLLOWING, LIMITS, ceiling=-0.9, rules=RULES)
    with pytest.raises(PlanningError, match="outside the workspace"):
        fastest_throw([2.0, 0.0, -0.85], TARGET, FOLLOWING, LIMITS, ceiling=CEILING, rules=RULES)
    with pytest.raises(NoMotionFound, match="no throw from"):
        fastest_throw(PICK, [9.0, 0.0, -0.85], FOLLOWING, LIMITS, ceiling=CEILING, rules=RULES)
