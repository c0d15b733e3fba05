from dataclasses import replace

import numpy as np
import pytest

from papers.hassan.planning.throw_check import check_throw, least_gap, miss
from pnt_gym.constants import GRAVITY
from pnt_gym.planning import EllipticWorkspace, JerkTrajectory, MotionLimits, accelerate, brake, coast, rest_to_rest
from pnt_gym.planning.free.rules import HandRules
from pnt_gym.planning.motion.ballistics import landing_point
from pnt_gym.planning.motion.scurve import brake_distance

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


def test_the_numbers_are_ratios_and_distances():
    check = GOOD.check(
        MotionLimits(4.0, 20.0, 500.0),
        replace(RULES, workspace=EllipticWorkspace(z_max=-0.80), hand_cap=0.0),
        ceiling=-0.90,
        targets=GOOD.target + np.array([0.03, -0.04, 0.0]),
    )
    peak = GOOD.path.peak_ratios(MotionLimits(4.0, 20.0, 500.0), samples=401)
    for ours, known in zip(check[:3], peak, strict=True):
        assert ours[0] == pytest.approx(known[0], rel=1e-4)
    top = GOOD.path.sample(np.linspace(0.0, 2.0, 20001)).position[0, :, 2].max()
    assert check.height[0] == pytest.approx(top + 0.90, abs=1e-7)
    assert check.outside[0] == pytest.approx(top + 0.80, abs=1e-7)
    assert check.landing[0] == pytest.approx(0.05, rel=1e-12)


def test_without_a_workspace_nothing_is_outside():
    assert GOOD.check(rules=replace(RULES, workspace=None)).outside[0] == -np.inf


def test_the_object_may_land_within_the_given_distance():
    check = GOOD.check(targets=GOOD.target + np.array([0.003, 0.0, 0.0]))
    assert not check.keeps_rules()[0]
    assert check.keeps_rules(landing=0.0031)[0]
    assert not check.keeps_rules(landing=0.0029)[0]


def test_rows_are_judged_one_by_one():
    rows = np.arange(3)
    many = JerkTrajectory(
        np.repeat(GOOD.path.start, 3, axis=0),
        np.repeat(GOOD.path.durations, 3, axis=0),
        np.repeat(GOOD.path.jerks, 3, axis=0),
    )
    limits = MotionLimits(2.0, 40.0, np.array([1000.0, 900.0, 1000.0]))
    ceiling = GOOD.ceiling - np.array([0.0, 0.0, 0.01])
    check = check_throw(many, GOOD.time[rows * 0], GOOD.target[rows * 0], limits, ceiling, RULES)
    assert check.keeps_rules().tolist() == [True, False, False]
    for name, value in GOOD.check()._asdict().items():
        assert getattr(check, name)[0] == value[0], name


def gap_by_loop(position, since, start, velocity, rules):
    """The rule read aloud, sample by sample."""
    least = np.inf
    for point, t in zip(position, since, strict=True):
        if t < 0.0:
            continue
        thing = start + t * velocity - np.array([0.0, 0.0, 0.5 * GRAVITY * t * t])
        if t > 0.0 and np.hypot(*(point - thing)[:2]) >= rules.clear_distance:
            break
        least = min(least, point[2] - thing[2] - rules.margin * 0.5 * GRAVITY * t * t)
    return least


@pytest.mark.parametrize(("margin", "clear"), [(0.0, 0.05), (0.3, 0.12), (0.9, 0.02), (0.5, 0.0), (0.2, 9.0)])
def test_the_gap_agrees_with_a_loop(margin, clear):
    rng = np.random.default_rng(2)
    count, samples = 12, 60
    rules = HandRules(margin=margin, clear_distance=clear)
    since = np.sort(rng.uniform(-0.05, 0.3, (count, samples)), axis=1)
    start, velocity = rng.normal(size=(count, 3)), rng.normal(size=(count, 3))
    wander = np.cumsum(rng.normal(scale=0.01, size=(count, samples, 3)), axis=1)
    position = start[:, None] + since[..., None] * velocity[:, None] + wander
    ours = least_gap(position, since, start, velocity, rules)
    loop = [gap_by_loop(*row, rules) for row in zip(position, since, start, velocity, strict=True)]
    np.testing.assert_allclose(ours, loop, rtol=0, atol=1e-12)


def test_a_hand_that_comes_back_is_clear_once_and_for_all():
    start, velocity = np.zeros((1, 3)), np.zeros((1, 3))
    since = np.array([[0.0, 0.1, 0.2, 0.3]])
    position = np.array([[[0.0, 0, 0], [0.1, 0, 0], [0.2, 0, -5.0], [0.0, 0, -5.0]]])
    assert least_gap(position, since, start, velocity, HandRules(clear_distance=0.1))[0] == 0.0
    assert least_gap(position, since, start, velocity, HandRules(clear_distance=0.15))[0] == 0.0
    assert least_gap(position, since, start, velocity, HandRules(clear_distance=0.25))[0] < -4.0


def test_the_miss_is_measured_where_the_object_comes_down():
    rng = np.random.default_rng(4)
    start, velocity = rng.normal(size=(50, 3)), rng.normal(size=(50, 3), scale=2.0)
    velocity[:, 2] = np.abs(velocity[:, 2])
    level = start[:, 2] + rng.uniform(-1.0, 0.3, 50)
    place = landing_point(start, velocity, level)
    known = np.isfinite(place).all(axis=1)
    assert known.sum() > 30
    off = rng.normal(size=(50, 3), scale=0.1) * [1.0, 1.0, 0.0]
    targets = np.where(known[:, None], place, 0.0) + off
    targets[:, 2] = level
    ours = miss(start, velocity, targets)
    np.testing.assert_allclose(ours[known], np.hypot(off[known, 0], off[known, 1]), rtol=0, atol=1e-12)
    assert np.isinf(ours[~known]).all()
    assert (~known).any()


def test_what_falls_from_below_the_target_never_comes_down_on_it():
    start = np.array([[0.0, 0.0, -0.1], [0.0, 0.0, -0.1], [0.0, 0.0, 0.1]])
    velocity = np.array([[1.0, 0.0, -3.0], [1.0, 0.0, 3.0], [1.0, 0.0, -3.0]])
    # Each would be above the origin at the time that solves its flight, the first one in the past.
    root = np.sqrt(9.0 + 2.0 * GRAVITY * start[:, 2])
    start[:, 0] = -(velocity[:, 2] + root) / GRAVITY
    assert start[0, 0] > 0.0
    np.testing.assert_allclose(miss(start, velocity, np.zeros((3, 3))), [np.inf, 0.0, 0.0], rtol=0, atol=1e-12)


def test_an_approach_of_no_height_is_refused():
    with pytest.raises(ValueError, match=r"approach must be finite and above 0 \[m\], got 0"):
        HandRules(approach=0.0)


@pytest.mark.parametrize("name", ["approach", "window", "clear_distance", "hand_cap", "margin"])
@pytest.mark.parametrize("value", [-0.01, np.nan, np.inf])
def test_bad_rules_are_refused(name, value):
    if name == "hand_cap" and value == np.inf:
        assert HandRules(hand_cap=np.inf).hand_cap == np.inf
        return
    with pytest.raises(ValueError, match=f"{name} must") as caught:
        HandRules(**{name: value})
    assert str(value) in str(caught.value)


def test_a_margin_of_one_is_refused():
    with pytest.raises(ValueError, match=r"margin must lie in \[0, 1\), got 1.0"):
        HandRules(margin=1.0)
