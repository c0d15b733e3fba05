import hashlib
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pnt_gym.arrays import take
from pnt_gym.planning import GRAVITY, JerkTrajectory, MotionLimits, min_time_scurve
from pnt_gym.planning.motion.transfer import Band, Transfers, fast_transfer
from tests.tools.commands import environment
from tests.tools.planning import units


def cases(count, seed=1):
    """Ways of the conveyor cell, from and to most of the speed limit, at 15 to 45 % of the T3KR's performance."""
    rng = np.random.default_rng(seed)
    limits = MotionLimits.t3kr(rng.uniform(15.0, 45.0, count))
    way = rng.uniform((-0.5, -0.8, -0.15), (0.5, 0.8, 0.15), (count, 3))
    most = limits.arrays(count)[0]
    before, after = (units(rng, count) * (most * rng.uniform(0.5, 0.998, count))[:, None] for _ in range(2))
    drift = rng.uniform(-0.3, 0.3, (count, 3)) * [1.0, 1.0, 0.0]
    return way, before, after, limits, drift


def path_of(moves: Transfers, before):
    return JerkTrajectory.concatenate(np.zeros_like(before), [moves.segments], before)


def assert_within(path: JerkTrajectory, limits: MotionLimits):
    """Compare the norms with the limits on a 10 kHz sampling."""
    count = len(path.start)
    times = np.arange(0.0, float(path.duration.max()), 1e-4)
    read = path.sample(times)
    values = (read.velocity, read.acceleration, path.jerk(times))
    for value, most in zip(values, limits.arrays(count), strict=True):
        assert (np.linalg.norm(value, axis=2).max(axis=1) <= most * (1.0 + 1e-6)).all()


def test_ends_and_limits_hold_exactly():
    way, before, after, limits, _ = cases(150)
    moves = fast_transfer(way, before, after, limits)
    assert moves.feasible.all()
    path = path_of(moves, before)
    np.testing.assert_allclose(path.duration, moves.duration, rtol=1e-12)
    np.testing.assert_allclose(path.end, way, rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.knots.velocity[:, -1], after, rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.knots.acceleration[:, -1], 0.0, atol=1e-9)
    assert_within(path, limits)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    way=st.tuples(*[st.floats(-0.6, 0.6)] * 3),
    headings=st.tuples(*[st.floats(-3.14, 3.14)] * 2),
    slopes=st.tuples(*[st.floats(-1.5, 1.5)] * 2),
    shares=st.tuples(*[st.floats(0.2, 0.998)] * 2),
    limits=st.tuples(st.floats(0.3, 4.0), st.floats(8.0, 80.0), st.floats(200.0, 2500.0)),
)
def test_whatever_is_called_a_motion_is_one(way, headings, slopes, shares, limits):
    """Any limits, any ends: a row that holds a motion keeps to both, one that does not is NaN and still."""
    speeds = [
        share * limits[0] * np.array([[np.cos(h) * np.cos(s), np.sin(h) * np.cos(s), np.sin(s)]])
        for h, s, share in zip(headings, slopes, shares, strict=True)
    ]
    bounds = MotionLimits(*limits)
    moves = fast_transfer(np.array([way]), *speeds, bounds)
    if not moves.feasible[0]:
        assert np.isnan(moves.duration[0])
        assert not moves.segments.durations.any()
        return
    path = path_of(moves, speeds[0])
    np.testing.assert_allclose(path.end[0], way, rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.knots.velocity[0, -1], speeds[1][0], rtol=0, atol=1e-9)
    assert_within(path, bounds)


BEST = (
    0.48319, 0.46692, 0.27257, 0.41804, 0.48029, 0.30402, 0.59691, 0.40971, 0.32841, 0.42341, 0.56185, 0.47359, 0.58561,
    0.40538, 0.51585,
)  # fmt: skip
"""Durations of the fastest motions of `cases(15, seed=7)` from a moving start to rest [s], found as one optimum each by
a nonlinear programme with the interior-point solver IPOPT."""


def test_close_to_the_fastest_motion_from_a_moving_start():
    way, before, _, limits, _ = cases(len(BEST), seed=7)
    moves = fast_transfer(way, before, np.zeros_like(way), limits)
    assert moves.feasible.all()
    ratio = moves.duration / BEST
    assert ratio.min() > 0.99
    assert ratio.max() < 1.06
    assert np.median(ratio) < 1.03


def test_rest_to_rest_on_a_line_is_nearly_the_s_curve():
    rng = np.random.default_rng(11)
    count = 60
    limits = MotionLimits.t3kr(rng.uniform(15.0, 45.0, count))
    still = np.zeros((count, 3))
    for distance, most in ((0.02, 1.05), (0.3, 1.12), (1.0, 1.06)):
        way = distance * units(rng, count)
        moves = fast_transfer(way, still, still, limits)
        assert moves.feasible.all()
        ratio = moves.duration / min_time_scurve(np.full(count, distance), limits).duration
        assert ratio.min() >= 1.0
        assert ratio.max() <= most
        assert np.mean(ratio) <= 1.05


def test_a_moving_end_is_met_where_it_is_then():
    way, before, after, limits, drift = cases(100, seed=3)
    moves = fast_transfer(way, before, after, limits, drift=drift)
    good = moves.feasible
    assert good.mean() >= 0.98
    path = take(path_of(moves, before), good)
    np.testing.assert_allclose(path.end, (way + drift * moves.duration[:, None])[good], rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.knots.velocity[:, -1], after[good], rtol=0, atol=1e-9)
    assert_within(path, take(limits, good))


def test_no_motion_is_shorter_than_asked_for():
    way, before, after, limits, _ = cases(64, seed=4)
    free = fast_transfer(way, before, after, limits)
    shortest = free.duration * 1.3
    held = fast_transfer(way, before, after, limits, shortest=shortest)
    assert held.feasible.mean() > 0.95
    good = held.feasible
    assert (held.duration[good] >= shortest[good]).all()
    path = path_of(held, before)
    np.testing.assert_allclose(path.end[good], way[good], rtol=0, atol=1e-9)
    assert_within(path, limits)


def test_heights_stay_in_their_band_at_the_borders():
    rng = np.random.default_rng(6)
    count = 64
    limits = MotionLimits.t3kr(40)
    way = rng.uniform((-0.3, -0.7, -0.05), (0.3, -0.4, 0.0), (count, 3))
    before = np.column_stack(
        [rng.uniform(-0.5, 0.5, count), rng.uniform(1.2, 1.6, count), rng.uniform(0.8, 1.6, count)]
    )
    after = np.tile([0.0, 0.0, -1.0], (count, 1))
    free = path_of(fast_transfer(way, before, after, limits), before).knots.position[..., 2]
    low, high = way[:, 2], np.full(count, 0.12)
    moves = fast_transfer(way, before, after, limits, band=Band.level(low, high))
    assert moves.feasible.mean() > 0.95
    good = moves.feasible
    height = path_of(moves, before).knots.position[..., 2][good]
    assert (free.max(axis=1) > 0.12).any()
    assert (height <= 0.12 + 1e-5).all()
    assert (height >= low[good, None] - 1e-5).all()
    assert_within(path_of(moves, before), limits)


def test_the_hand_stays_above_the_object_it_let_go_and_then_behind_it():
    rng = np.random.default_rng(8)
    count, fall, clear, late = 64, 0.5 * GRAVITY, 0.1, 0.09
    limits = MotionLimits.t3kr(45)
    way = rng.uniform((-0.5, -0.2, -0.3), (-0.3, 0.2, -0.2), (count, 3))
    before = rng.uniform((0.8, 0.0, -0.2), (1.2, 0.0, 0.4), (count, 3))
    after = np.tile([0.0, 0.0, -1.0], (count, 1))
    never = np.full(count, np.inf)
    above, behind = [], []
    for radius in (0.0, clear):
        band = Band(-never, never, *(np.full(count, x) for x in (fall, radius, late)))
        moves = fast_transfer(way, before, after, limits, band=band)
        assert moves.feasible.mean() > 0.95
        path = take(path_of(moves, before), moves.feasible)
        since = path.knot_times
        away = path.knots.position - since[..., None] * before[moves.feasible, None]
        above.append(np.where(since < late, away[..., 2] + 0.5 * fall * since**2, np.inf).min())
        behind.append(np.where(since >= late, -away[..., 0], np.inf).min())
        assert_within(path, limits)
    assert above[0] < -1e-3
    assert above[1] >= -1e-5
    assert behind[1] >= clear - 1e-5


def test_row_does_not_depend_on_its_batch():
    count = 70
    way, before, after, limits, drift = cases(count, seed=9)
    before = before * [1.0, 0.0, 1.0]
    band = Band(*(np.full(count, x) for x in (-0.3, 0.3, 5.0, 0.05, 0.1)))

    def plan(rows):
        part = Band(*(value[rows] for value in band))
        ends = (way[rows], before[rows], after[rows], take(limits, rows))
        return fast_transfer(*ends, drift=drift[rows], band=part)

    whole = plan(np.arange(count))
    assert whole.feasible.any()
    shuffled = np.random.default_rng(5).permutation(count)
    for rows in [shuffled, np.arange(33), np.arange(64), np.array([3, 3, 3]), *np.arange(0, count, 7)[:, None]]:
        part, expected = plan(rows), take(whole, rows)
        for name, values in vars(part).items():
            np.testing.assert_array_equal(values, getattr(expected, name), name)


def fingerprint():
    moves = fast_transfer(*cases(70, seed=9)[:4])
    return hashlib.sha256(moves.duration.tobytes() + moves.jerks.tobytes()).hexdigest()


def test_one_thread_gives_the_bits_of_two():
    """Tests run with one thread (`tests/conftest.py`); another process has two."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    code = "from tests.planning.motion.test_transfer import fingerprint; print(fingerprint())"
    two = {**environment(), **dict.fromkeys(names, "2")}
    found = subprocess.run([sys.executable, "-c", code], env=two, capture_output=True, text=True, check=True)
    assert found.stdout.strip() == fingerprint()


def test_a_way_that_cannot_be_gone_is_no_motion():
    """A band with no room for the start's upward speed; the other row is not disturbed."""
    way = np.array([[0.3, 0.0, 0.0], [0.3, 0.0, 0.0]])
    before, after = np.array([[0.0, 0.0, 2.0], [0.0, 0.0, 0.5]]), np.zeros((2, 3))
    band = Band.level(np.full(2, -0.001), np.full(2, 0.02))
    moves = fast_transfer(way, before, after, MotionLimits.t3kr(40), band=band)
    assert moves.feasible.tolist() == [False, True]
    assert np.isnan(moves.duration[0])
    path = path_of(moves, before * moves.feasible[:, None])
    np.testing.assert_array_equal(path.end[0], 0.0)


@pytest.mark.parametrize("count", [1, 2])
def test_limits_for_another_number_of_rows_are_refused(count):
    with pytest.raises(ValueError, match="limits hold 3 throws"):
        fast_transfer(*[np.zeros((count, 3))] * 3, MotionLimits.t3kr([30.0, 30.0, 30.0]))
