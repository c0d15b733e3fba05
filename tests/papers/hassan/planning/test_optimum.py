from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from papers.common.fastest import NoMotionFound, fastest_motion
from papers.hassan.planning.optimum import FreeThrow, fastest_throw
from papers.hassan.planning.throw_check import check_throw
from pnt_gym.constants import GRAVITY
from pnt_gym.errors import PntGymError
from pnt_gym.planning import EllipticWorkspace, JerkTrajectory, MotionLimits, accelerate, plan_release
from pnt_gym.planning.free.rules import HandRules
from tests.tools.nightly import with_nightly

# Picks, targets, tolerance and ceiling of Hassan et al. 2022, section V (Table I).
PICKS = ((-0.2, -0.25, -0.85), (-0.2, -0.35, -0.85), (-0.3, -0.35, -0.85))
INSIDE, OUTSIDE = (0.3, 0.4, -0.85), (0.45, 0.65, -0.85)
CEILING, TOLERANCE = -0.75, 0.005
SPACE = EllipticWorkspace()
RULES = HandRules(workspace=SPACE)
CELLS = {"in 15": (0, INSIDE, 15.0), "in 40": (1, INSIDE, 40.0), "out 45": (2, OUTSIDE, 45.0)}
SOME_DAILY = with_nightly(CELLS, ["in 40"])


def throw(name, rules=RULES, ceiling=CEILING) -> FreeThrow:
    number, target, percent = CELLS[name]
    following = PICKS[(number + 1) % 3]
    limits = MotionLimits.t3kr(percent)
    return fastest_throw(PICKS[number], target, following, limits, ceiling=ceiling, tolerance=TOLERANCE, rules=rules)


@cache
def known(name) -> FreeThrow:
    return throw(name)


def aimed(name):
    """The point that is aimed at: short of the target by the tolerance along the longer axis (Eqs. 16-17)."""
    number, target, _ = CELLS[name]
    gap = np.array(target) - PICKS[number]
    return np.array(target) - TOLERANCE / np.abs(gap[:2]).max() * gap


def judged(path: JerkTrajectory, release_time, name, rules=RULES, ceiling=CEILING):
    limits = MotionLimits.t3kr(CELLS[name][2])
    return check_throw(path, np.array([release_time]), aimed(name)[None], limits, ceiling, rules)


@pytest.mark.parametrize("name", SOME_DAILY)
def test_every_limit_and_rule_holds_at_10_khz(name):
    found = known(name)
    check = judged(found.path, found.release_time, name)
    assert check.keeps_rules().tolist() == [True], check
    # A time-optimal motion uses what it is given.
    assert max(check.velocity[0], check.acceleration[0], check.jerk[0]) > 1.0 - 1e-6


@pytest.mark.parametrize("name", SOME_DAILY)
def test_what_is_told_is_what_the_path_does(name):
    found = known(name)
    number, _, _ = CELLS[name]
    assert found.duration == pytest.approx(sum(found.legs.values()), rel=1e-12)
    assert set(found.legs) == {"throw", "window", "clearing", "return", "approach"}
    assert found.legs["throw"] == pytest.approx(found.release_time, rel=1e-12)
    read = found.path.sample(np.array([0.0, found.release_time, found.duration]))
    np.testing.assert_array_equal(read.position[0, 0], PICKS[number])
    np.testing.assert_allclose(read.position[0, 1], found.position, rtol=0, atol=1e-12)
    np.testing.assert_allclose(read.velocity[0, 1], found.velocity, rtol=0, atol=1e-11)
    np.testing.assert_allclose(read.position[0, 2], PICKS[(number + 1) % 3], rtol=0, atol=1e-8)
    np.testing.assert_allclose(read.velocity[0, 2], 0.0, atol=1e-7)
    np.testing.assert_allclose(read.acceleration[0], 0.0, atol=1e-5)
    t = found.flight_time
    landing = found.position + t * found.velocity - [0.0, 0.0, 0.5 * GRAVITY * t * t]
    np.testing.assert_allclose(landing, aimed(name), rtol=0, atol=1e-8)


@pytest.mark.parametrize("name", SOME_DAILY)
def test_the_last_way_is_straight_down_and_nothing_before_is_lower(name):
    found = known(name)
    following = np.array(PICKS[(CELLS[name][0] + 1) % 3])
    times = np.linspace(0.0, found.duration, 8001)
    place = found.path.sample(times).position[0]
    last = times >= found.duration - found.legs["approach"]
    np.testing.assert_allclose(place[last, :2] - following[:2], 0.0, atol=1e-8)
    assert place[last, 2].max() == pytest.approx(following[2] + RULES.approach, abs=1e-3)
    before = (times > found.release_time) & ~last
    assert place[before, 2].min() >= following[2] + RULES.approach - 1e-7
    assert place[:, 2].min() >= following[2] - 1e-8


@pytest.mark.parametrize("name", with_nightly(("in 40", "out 45"), ["in 40"]))
def test_never_slower_than_the_straight_throw_with_the_fastest_return(name):
    number, target, percent = CELLS[name]
    limits = MotionLimits.t3kr(percent)
    plan = plan_release(PICKS[number], target, limits, ceiling=CEILING, tolerance=TOLERANCE)
    following = PICKS[(number + 1) % 3]
    back = fastest_motion(
        plan.position,
        following,
        limits,
        drop=RULES.approach,
        start_velocity=plan.velocity,
        floor=following[2] + RULES.approach,
        roof=CEILING + RULES.hand_cap,
        workspace=SPACE,
    )
    assert known(name).duration < plan.time + float(back.duration[0])
    # The two fit together to one motion that lands, within the limits.
    out = accelerate(plan.direction[None], np.array([plan.distance]), limits)
    path = JerkTrajectory(
        np.array([PICKS[number]]),
        np.concatenate([out.durations, back.durations], axis=1),
        np.concatenate([out.jerks, back.jerks], axis=1),
    )
    check = judged(path, plan.time, name)
    assert check.landing[0] < 1e-9
    assert max(check.velocity[0], check.acceleration[0], check.jerk[0]) <= 1.0 + 1e-6


def test_a_window_is_kept_and_costs_its_time():
    found = throw("in 40", replace(RULES, window=0.02))
    assert judged(found.path, found.release_time, "in 40", replace(RULES, window=0.02)).keeps_rules()[0]
    inside = found.path.sample(found.release_time + np.linspace(1e-6, 0.02 - 1e-6, 9))
    np.testing.assert_allclose(inside.velocity[0] - found.velocity, 0.0, atol=1e-9)
    assert known("in 40").duration + 0.01 < found.duration < known("in 40").duration + 0.08


@pytest.mark.nightly
def test_a_lower_cap_costs_time():
    times = [known("in 40").duration]
    for cap in (0.03, 0.0):
        rules = replace(RULES, hand_cap=cap)
        found = throw("in 40", rules)
        assert judged(found.path, found.release_time, "in 40", rules).keeps_rules()[0]
        times.append(found.duration)
    assert times[0] * 1.1 < times[1] * 1.05 < times[2]


@pytest.mark.parametrize(("ceiling", "height"), with_nightly([(-0.82, -0.85), (-0.75, -0.72)], [(-0.75, -0.72)]))
def test_an_approach_that_begins_above_the_ceiling_forces_no_detour(ceiling, height):
    """A ceiling 3 cm above the pick, and a next pick 3 cm above the ceiling."""
    following, target = (*PICKS[1][:2], height), (0.3, 0.4, -0.85)
    found = fastest_throw(PICKS[0], target, following, MotionLimits.t3kr(40), ceiling=ceiling, rules=RULES)
    place = np.array([target])
    check = check_throw(found.path, np.array([found.release_time]), place, MotionLimits.t3kr(40), ceiling, RULES)
    assert check.keeps_rules().tolist() == [True], check
    assert found.duration < 1.5 * known("in 40").duration
    times = np.linspace(found.release_time, found.duration - found.legs["approach"], 4001)
    heights = found.path.sample(times).position[0, :, 2]
    assert heights.min() >= 0.5 * (PICKS[0][2] + ceiling) - 1e-7
    assert heights[-1] == pytest.approx(height + RULES.approach, abs=1e-7)


@pytest.mark.nightly
def test_the_same_task_gives_the_same_bits():
    once, again = known("in 15"), throw("in 15")
    np.testing.assert_array_equal(once.path.jerks, again.path.jerks)
    np.testing.assert_array_equal(once.path.durations, again.path.durations)
    assert once.flight_time == again.flight_time


def test_a_target_out_of_reach_is_told_in_one_sentence():
    target = (0.3, 0.4, 0.4)
    with pytest.raises(NoMotionFound, match=r"no throw from .* with a release below -0\.750 m .* 2\.4 m/s") as caught:
        fastest_throw(PICKS[0], target, PICKS[1], MotionLimits.t3kr(40), ceiling=CEILING, rules=RULES)
    assert isinstance(caught.value, PntGymError)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"ceiling": -0.9}, r"pick lies at z = -0\.85 m; it must lie below the ceiling at -0\.9 m"),
        ({"ceiling": -0.85}, r"pick lies at z = -0\.85 m; it must lie below the ceiling at -0\.85 m"),
        ({"ceiling": np.nan}, r"ceiling must be finite \[m\], got nan"),
        ({"ceiling": np.inf}, r"ceiling must be finite \[m\], got inf"),
        ({"next_pick": (-0.2, -0.35, -0.5)}, r"next_pick lies at z = -0\.5 m, above ceiling \+ hand_cap, .*: -0\.6 m"),
        ({"next_pick": (-0.2, -0.35, -0.62)}, r"next_pick \+ approach lies at z = -0\.57 m, above ceiling \+ hand_cap"),
        (
            {"rules": HandRules(workspace=EllipticWorkspace(z_max=-0.81))},
            r"next_pick \+ approach \[.*\] lies outside the workspace",
        ),
        ({"pick": (-0.46, 0.0, -0.85)}, r"pick \[-0\.46, 0\.0, -0\.85\] lies outside the workspace"),
        ({"next_pick": (0.0, 0.81, -0.85)}, r"next_pick \[0\.0, 0\.81, -0\.85\] lies outside the workspace"),
        ({"target": (-0.2, -0.246, -0.85)}, "lies within the tolerance of the pick"),
        ({"target": (-0.2, -0.25, -0.85), "tolerance": 0.0}, "lies within the tolerance of the pick"),
        ({"target": (np.nan, 0.0, 0.0)}, "target must be three finite numbers"),
        ({"pick": (0.0, 0.0)}, "pick must be three finite numbers"),
        ({"tolerance": -0.1}, "tolerance must not be negative"),
    ],
)
def test_bad_inputs_are_refused_in_one_sentence(changes, sentence):
    given = {"pick": PICKS[0], "target": INSIDE, "next_pick": PICKS[1], "limits": MotionLimits.t3kr(40)}
    given |= {"ceiling": CEILING, "tolerance": TOLERANCE, "rules": RULES} | changes
    with pytest.raises(ValueError, match=sentence) as caught:
        fastest_throw(**given)
    assert "\n" not in str(caught.value)
