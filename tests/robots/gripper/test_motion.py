"""The least time of a line, and what the motors can do."""

import numpy as np
import pytest

from pnt_gym.robots.gripper import JointLimits, travel_time
from tests.tools.gripper import DOWN, UP, pose


def test_pick_and_toss_takes_78_and_85_milliseconds():
    """The moves of the cork, 50 mm up and 70 mm aside, at the motors' largest speed."""
    top = pose(0, 0, -180, -45)
    assert travel_time(pose(0, 0, -230, -45), top) == pytest.approx(78e-3, abs=1e-3)
    assert travel_time(top, pose(0, 70, -180, -45)) == pytest.approx(85e-3, abs=1e-3)


def test_travel_time_is_nan_where_a_line_leaves_the_reach():
    lines = travel_time(np.stack([UP, UP]), np.stack([DOWN, pose(0, 0, -400, -45)]))
    assert np.isfinite(lines[0]) and np.isnan(lines[1])


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: travel_time(UP, [DOWN]), "one row each"),
        (lambda: travel_time(UP, DOWN, speed=0.0), "speed"),
        (lambda: JointLimits(speed=np.nan), "speed"),
        (lambda: JointLimits(acceleration=0.0), "acceleration"),
    ],
)
def test_bad_arguments_are_refused(call, text):
    with pytest.raises(ValueError, match=text):
        call()
