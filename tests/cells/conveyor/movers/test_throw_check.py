"""The check of free throws sees each violation of limits and rules by itself."""

from dataclasses import replace

import numpy as np
import pytest

from pnt_gym.planning import EllipticWorkspace, JerkTrajectory, MotionLimits, accelerate, brake, coast, rest_to_rest
from pnt_gym.planning.free.rules import HandRules
from pnt_gym.planning.motion.ballistics import landing_point
from pnt_gym.planning.motion.scurve import brake_distance
from tests.tools.throw_check import check_throw

LIMITS = MotionLimits(2.0, 40.0, 1000.0)
PICK = np.array([[-0.1, -0.3, -0.85]])
AHEAD = np.array([[0.0, 0.8, 0.6]])
WAY = np.array([0.1])
RULES = HandRules(margin=0.3, clear_distance=0.05, hand_cap=0.15, workspace=EllipticWorkspace())


class Throw:
    """Along a line, a window, a stop on the line and straight back to the pick."""

    def __init__(self, window=0.04):
        start = accelerate(AHEAD, WAY, LIMITS)
        self.time = start.durations.sum(axis=1)
        state = JerkTrajectory.concatenate(PICK, [start]).knots
        self.position, self.velocity = state.position[:, -1], state.velocity[:, -1]
        speed = np.linalg.norm(self.velocity, axis=1)
        stop = (WAY + window * speed + brake_distance(speed, LIMITS))[:, None] * AHEAD
        parts = [start, coast(np.array([window])), brake(AHEAD, speed, LIMITS), rest_to_rest(-stop, LIMITS)]
        self.path = JerkTrajectory.concatenate(PICK, parts)
        self.ceiling = float(self.position[0, 2])
        self.target = landing_point(self.position, self.velocity, np.array([-0.85]))

    def check(self, limits=LIMITS, rules=RULES, **changes):
        given = {"targets": self.target, "ceiling": self.ceiling} | changes
        path = given.pop("path", self.path)
        return check_throw(path, self.time, given["targets"], limits, given["ceiling"], rules)


GOOD = Throw()


def violated(check):
    """What a check finds wrong, by name."""
    one = {name: value[0] for name, value in check._asdict().items()}
    wrong = {name for name in ("velocity", "acceleration", "jerk") if one[name] > 1.0 + 1e-6}
    wrong |= {name for name in ("height", "outside", "landing") if one[name] > 1e-6}
    return wrong | ({"gap"} if one["gap"] < -1e-6 else set())


def test_a_throw_that_keeps_everything_is_good():
    check = GOOD.check()
    assert violated(check) == set()
    assert check.keeps_rules().tolist() == [True]
    assert check.jerk[0] == pytest.approx(1.0, rel=1e-12)
    assert check.landing[0] < 1e-12
    assert check.height[0] == 0.0
    assert check.outside[0] < -0.1


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"limits": MotionLimits(1.9, 40.0, 1000.0)}, "velocity"),
        ({"limits": MotionLimits(2.0, 39.0, 1000.0)}, "acceleration"),
        ({"limits": MotionLimits(2.0, 40.0, 999.9)}, "jerk"),
        ({"rules": replace(RULES, clear_distance=0.5)}, "gap"),
        ({"path": Throw(window=0.0).path}, "gap"),
        ({"ceiling": GOOD.ceiling - 1e-5}, "height"),
        ({"rules": replace(RULES, hand_cap=0.05)}, "height"),
        ({"rules": replace(RULES, workspace=EllipticWorkspace(semi_x=0.09))}, "outside"),
        ({"rules": replace(RULES, workspace=EllipticWorkspace(z_max=-0.7))}, "outside"),
        ({"rules": replace(RULES, workspace=EllipticWorkspace(z_min=-0.84))}, "outside"),
        ({"targets": GOOD.target + np.array([2e-6, 0.0, 0.0])}, "landing"),
        ({"targets": GOOD.target + np.array([0.0, 0.0, 10.0])}, "landing"),
    ],
)
def test_each_violation_is_found_by_itself(changes, name):
    check = GOOD.check(**changes)
    assert violated(check) == {name}
    assert check.keeps_rules().tolist() == [False]
