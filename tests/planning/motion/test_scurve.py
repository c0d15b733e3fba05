import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.planning import MotionLimits, min_time_scurve, speed_at
from tests.tools.planning import printed_algorithm, travel_time

positive = st.floats(1e-3, 1e3)


def log_uniform(rng, low, high, count):
    return 10.0 ** rng.uniform(np.log10(low), np.log10(high), count)


def random_strokes(count, seed):
    rng = np.random.default_rng(seed)
    limits = [log_uniform(rng, *span, count) for span in ((1e-2, 1e2), (1e-1, 1e3), (1e-1, 1e5))]
    return log_uniform(rng, 1e-4, 1e2, count), MotionLimits(*limits)


def test_durations_agree_with_ruckig():
    distance, limits = random_strokes(20_000, seed=11)
    rows = zip(distance, limits.velocity, limits.acceleration, limits.jerk, strict=True)
    expected = [travel_time(*row) for row in rows]
    np.testing.assert_allclose(min_time_scurve(distance, limits).duration, expected, rtol=1e-12)


def test_peaks_agree_with_the_printed_algorithm_in_every_branch():
    distance, limits = random_strokes(3000, seed=12)
    curve = min_time_scurve(distance, limits)
    rows = zip(distance, limits.velocity, limits.acceleration, limits.jerk, strict=True)
    expected = np.array([printed_algorithm(*row) for row in rows])
    # The printed line 12 cancels; the tolerance is its, not ours.
    np.testing.assert_allclose(curve.velocity, expected[:, 0], rtol=1e-6)
    np.testing.assert_allclose(curve.acceleration, expected[:, 1], rtol=1e-12)
    saturated_v, saturated_a = curve.velocity == limits.velocity, curve.acceleration == limits.acceleration
    for branch in (saturated_v & saturated_a, saturated_v & ~saturated_a, ~saturated_v & saturated_a):
        assert branch.sum() > 100
    assert (~saturated_v & ~saturated_a).sum() > 100


def test_long_plateau_branch_has_no_cancellation():
    # A tiny stroke with a jerk so high that the plateau is everything: V = sqrt(P A) to first order.
    curve = min_time_scurve(1e-6, MotionLimits(10.0, 1e-3, 1e6))
    assert curve.velocity == pytest.approx(np.sqrt(1e-9), rel=1e-6)
    assert curve.durations.sum() == pytest.approx(curve.duration, rel=1e-14)


@given(positive, positive, positive, positive)
def test_profile_keeps_limits_and_closes(distance, velocity, acceleration, jerk):
    curve = min_time_scurve(distance, MotionLimits(velocity, acceleration, jerk))
    assert curve.velocity <= velocity * (1 + 1e-12)
    assert curve.acceleration <= acceleration * (1 + 1e-12)
    assert (curve.durations >= 0.0).all()
    assert curve.durations.sum() == pytest.approx(curve.duration, rel=1e-12)
    time = np.linspace(-0.1, 1.1, 601) * curve.duration
    position, speed, slope = curve.sample(time)
    assert position[0] == 0.0
    assert position[-1] == distance
    assert (np.diff(position) >= -1e-12 * distance).all()
    assert speed.min() >= -1e-12 * velocity
    assert speed.max() <= velocity * (1 + 1e-12)
    assert np.abs(slope).max() <= acceleration * (1 + 1e-12)
    assert curve.jerk <= jerk
    middle, top, flat = curve.sample(0.5 * curve.duration)
    assert middle == pytest.approx(0.5 * distance, rel=1e-12)
    assert top == pytest.approx(curve.velocity, rel=1e-12)
    assert abs(flat) <= 1e-14 * jerk * curve.duration


def test_zero_stroke_takes_no_time():
    curve = min_time_scurve(0.0, MotionLimits.t3kr(50))
    assert curve.duration == 0.0
    assert curve.velocity == 0.0
    assert [float(x) for x in curve.sample(0.3)] == [0.0, 0.0, 0.0]
    mixed = min_time_scurve(np.array([0.0, 0.5]), MotionLimits.t3kr(50))
    assert mixed.duration[0] == 0.0
    assert mixed.duration[1] > 0.0


@given(st.floats(1e-12, 1e6), st.floats(1e-6, 1e6))
def test_speed_at_is_the_speed_in_mid_stroke(distance, velocity):
    limits = MotionLimits(velocity, 50.0, 900.0)
    curve = min_time_scurve(2.0 * distance, limits)
    position, speed, _ = curve.sample(0.5 * curve.duration)
    assert position == pytest.approx(distance, rel=1e-9)
    assert speed == pytest.approx(speed_at(distance, limits), rel=1e-9)


def test_shapes_follow_the_inputs():
    limits = MotionLimits.t3kr(np.array([20.0, 40.0, 60.0]))
    batch = min_time_scurve(np.array([0.1, 0.2, 0.3]), limits)
    assert batch.durations.shape == (3, 7)
    assert batch.sample(0.05)[0].shape == (3,)
    assert batch.sample(np.zeros(5))[0].shape == (3, 5)
    assert batch.sample(np.zeros((3, 5)))[1].shape == (3, 5)
    with pytest.raises(ValueError, match="times must have shape"):
        batch.sample(np.zeros((2, 5)))
    single = min_time_scurve(0.2, MotionLimits.t3kr(40))
    assert isinstance(single.duration, float)
    assert single.duration == batch.duration[1]
    assert single.sample(np.zeros((4, 2)))[0].shape == (4, 2)
    assert min_time_scurve(0.2, limits).duration.shape == (3,)
    np.testing.assert_array_equal(batch.sample(np.array([0.05]))[0][1], single.sample(np.array([0.05]))[0])


@pytest.mark.parametrize("value", [-1e-9, np.nan, np.inf])
def test_bad_distance_is_refused_with_its_value(value):
    limits = MotionLimits.t3kr(30)
    for bad in (value, np.array([0.1, value])):
        with pytest.raises(ValueError, match="distance") as error:
            min_time_scurve(bad, limits)
        assert str(value) in str(error.value)
    with pytest.raises(ValueError, match="shape"):
        min_time_scurve(np.ones((2, 2)), limits)
