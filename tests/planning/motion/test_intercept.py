import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pnt_gym.arrays import take
from pnt_gym.planning import InterceptReason, MotionLimits, plan_intercept
from tests.tools.planning import travel_time

CLEARANCE = 0.05
WINDOW = (-0.4, 0.4)


def arrival(start, place, limits):
    above = place + np.array([0.0, 0.0, CLEARANCE])
    return sum(travel_time(way, *limits.numbers()) for way in (float(np.linalg.norm(above - start)), CLEARANCE))


def scene(count, seed):
    rng = np.random.default_rng(seed)
    start = np.stack([rng.uniform(-0.4, 0.4, count), rng.uniform(-0.6, 0.6, count), rng.uniform(-0.84, -0.5, count)], 1)
    place = np.stack([rng.uniform(-1.5, 0.5, count), rng.uniform(-0.5, 0.5, count), np.full(count, -0.85)], axis=1)
    return start, place, MotionLimits.t3kr(rng.uniform(10.0, 100.0, count))


@pytest.mark.parametrize("speed", [0.05, 0.3, 0.8, 2.0])
def test_hand_and_object_arrive_together(speed):
    start, place, limits = scene(200, seed=61)
    belt = np.array([speed, 0.0, 0.0])
    meeting = plan_intercept(start, place, belt, limits, clearance=CLEARANCE, window=WINDOW)
    assert meeting.feasible.sum() > 40
    for k in np.flatnonzero(meeting.feasible):
        np.testing.assert_allclose(meeting.position[k], place[k] + meeting.time[k] * belt, rtol=0, atol=1e-12)
        needed = arrival(start[k], meeting.position[k], take(limits, int(k)))
        assert needed + meeting.wait[k] == pytest.approx(meeting.time[k], abs=1e-10)
        assert WINDOW[0] - 1e-9 <= meeting.position[k, 0] <= WINDOW[1] + 1e-9
        if meeting.wait[k] > 0.0:
            assert meeting.position[k, 0] == pytest.approx(max(WINDOW[0], place[k, 0]), abs=1e-9)
    np.testing.assert_allclose(meeting.travel + meeting.descent + meeting.wait, meeting.time, rtol=0, atol=1e-12)


@pytest.mark.parametrize("speed", [0.1, 0.6, 1.5])
def test_no_earlier_meeting_and_none_where_it_says_none(speed):
    start, place, limits = scene(60, seed=62)
    belt = np.array([speed, 0.0, 0.0])
    meeting = plan_intercept(start, place, belt, limits, clearance=CLEARANCE, window=WINDOW)
    for k in range(60):
        row = take(limits, k)
        enter, leave = ((edge - place[k, 0]) / speed for edge in WINDOW)
        last = meeting.time[k] - 1e-6 if meeting.feasible[k] else leave
        times = np.linspace(max(enter, 0.0), last, 150) if last > max(enter, 0.0) else []
        for time in times:
            assert arrival(start[k], place[k] + time * belt, row) > time - 1e-9


def test_object_at_rest_is_met_after_the_travel_time():
    limits = MotionLimits.t3kr(40)
    start, place = np.array([[0.0, 0.0, -0.7]]), np.array([[0.2, 0.1, -0.85]])
    meeting = plan_intercept(start, place, np.zeros(3), limits, clearance=CLEARANCE, window=WINDOW)
    assert meeting.time[0] == pytest.approx(arrival(start[0], place[0], limits), rel=1e-12)
    assert meeting.wait[0] == 0.0
    np.testing.assert_array_equal(meeting.position, place)


def test_hand_waits_for_an_object_that_has_not_come_yet():
    limits = MotionLimits.t3kr(40)
    start, place = np.array([[-0.3, 0.0, -0.7]]), np.array([[-1.4, 0.0, -0.85]])
    meeting = plan_intercept(start, place, (0.2, 0.0, 0.0), limits, clearance=CLEARANCE, window=WINDOW)
    assert meeting.time[0] == pytest.approx(5.0, rel=1e-12)
    assert meeting.wait[0] == pytest.approx(5.0 - arrival(start[0], meeting.position[0], limits), rel=1e-9)
    later = plan_intercept(start, place, (0.2, 0.0, 0.0), limits, clearance=CLEARANCE, window=WINDOW, times=(6.0, 30.0))
    assert later.time[0] == pytest.approx(6.0)
    assert later.wait[0] > 0.0


def test_reasons():
    limits = MotionLimits.t3kr(20)
    start = np.tile([0.0, 0.0, -0.7], (5, 1))
    place = np.array([[0.5, 0, -0.85], [0.39, 0, -0.85], [-0.6, 0, -0.85], [-40, 0, -0.85], [0, 0, -0.85]], dtype=float)
    belt = np.array([[0.5, 0, 0], [0.5, 0, 0], [-0.5, 0, 0], [0.5, 0, 0], [0.5, 0, 0]], dtype=float)
    meeting = plan_intercept(start, place, belt, limits, clearance=CLEARANCE, window=WINDOW)
    kinds = InterceptReason
    expected = [kinds.PASSED, kinds.TOO_LATE, kinds.PASSED, kinds.NEVER_ENTERS, kinds.FEASIBLE]
    assert meeting.reason.tolist() == expected
    assert np.isnan(meeting.time[:4]).all()
    assert np.isnan(meeting.position[:4]).all()
    assert np.isfinite(meeting.time[4])
    still = plan_intercept(start[:1], place[:1], np.zeros(3), limits, clearance=CLEARANCE, window=WINDOW)
    assert still.reason[0] == kinds.NEVER_ENTERS
    assert all(len(kind.sentence) > 10 for kind in kinds)


def test_belt_may_run_in_any_direction():
    start, place, limits = scene(100, seed=63)
    forward = plan_intercept(start, place, (0.3, 0.0, 0.0), limits, clearance=CLEARANCE, window=WINDOW)
    mirror = np.array([-1.0, 1.0, 1.0])
    backward = plan_intercept(
        start * mirror, place * mirror, (-0.3, 0.0, 0.0), limits, clearance=CLEARANCE, window=WINDOW
    )
    np.testing.assert_allclose(backward.time, forward.time, rtol=1e-12)
    swap = [1, 0, 2]
    turned = plan_intercept(
        start[:, swap], place[:, swap], (0.0, 0.3, 0.0), limits, clearance=CLEARANCE, window=WINDOW, axis=1
    )
    np.testing.assert_allclose(turned.time, forward.time, rtol=1e-12)


def test_object_faster_than_the_hand_is_met_while_it_comes_closer():
    limits = MotionLimits(0.5, 20.0, 800.0)
    start = np.array([[0.0, 0.0, -0.75]])
    coming, going = np.array([[-2.0, 0.05, -0.85]]), np.array([[0.5, 0.05, -0.85]])
    met = plan_intercept(start, coming, (1.0, 0.0, 0.0), limits, clearance=CLEARANCE)
    lost = plan_intercept(start, going, (1.0, 0.0, 0.0), limits, clearance=CLEARANCE)
    assert met.feasible[0]
    assert arrival(start[0], met.position[0], limits) == pytest.approx(met.time[0], abs=1e-10)
    assert lost.reason[0] == InterceptReason.TOO_LATE


# The example is a short stroke whose time lies above the extension of the long strokes' straight line.
@given(st.floats(1e-4, 3.0), st.floats(0.0, 0.95), st.floats(1.0, 100.0), st.floats(-3.0, 3.0))
@example(0.36, 0.02, 86.0, 0.0)
def test_a_slower_object_is_always_caught(distance, share, percent, turn):
    limits = MotionLimits.t3kr(percent)
    speed = share * limits.velocity
    belt = speed * np.array([np.cos(turn), np.sin(turn), 0.0])
    meeting = plan_intercept(
        np.zeros((1, 3)), np.array([[distance, 0.0, -0.1]]), belt, limits, clearance=0.02, times=(0.0, 1e5)
    )
    assert meeting.feasible[0]
    assert meeting.wait[0] == 0.0


def test_bad_inputs_are_named():
    limits, one = MotionLimits.t3kr(20), np.zeros((1, 3))
    good = {"clearance": 0.05, "window": (-1.0, 1.0)}
    for bad, word in (
        ({"clearance": -0.1}, "clearance"),
        ({"clearance": np.nan}, "clearance"),
        ({"window": (1.0, -1.0)}, "window"),
        ({"window": (np.nan, 1.0)}, "window"),
        ({"times": (0.0, 0.0)}, r"times\[1\]"),
        ({"times": (np.inf, 30.0)}, r"times\[0\]"),
        ({"times": 6.0}, "times must be two times"),
    ):
        with pytest.raises(ValueError, match=word):
            plan_intercept(one, one, np.zeros(3), limits, **{**good, **bad})
    with pytest.raises(ValueError, match="belt_velocity"):
        plan_intercept(one, one, np.full(3, np.nan), limits, **good)
    with pytest.raises(ValueError, match="one row each"):
        plan_intercept(one, np.zeros((2, 3)), np.zeros(3), limits, **good)
