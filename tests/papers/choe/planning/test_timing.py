import importlib

import numpy as np
import pytest

from papers.choe.planning.casadi_module import load_casadi
from papers.choe.planning.curves import Line
from papers.choe.planning.plane import PlanePath, SpacePath, lame_path, line_ellipse_line, rectangle
from papers.choe.planning.timing import TimedPath, time_path
from pnt_gym.errors import PntGymError
from pnt_gym.planning import HandPath, MotionLimits, min_time_scurve
from pnt_gym.planning.paths import EllipsePath
from tests.tools.nightly import with_nightly

LIMITS = MotionLimits(1.8, 36.0, 900.0)
LEVEL = EllipsePath.with_top(0.41, 0.0, 0.05)


def timed(path: PlanePath, joints="strict", limits=LIMITS, intervals=120) -> TimedPath:
    place = np.array([0.0, path.end[0], path.end[1]])
    return time_path(SpacePath.between(path, np.zeros(3), place), limits, joints=joints, intervals=intervals)


@pytest.fixture(scope="module")
def lame():
    return timed(lame_path(0.82, 0.05, 0.05, (0.1, 0.05)), intervals=240)


@pytest.fixture(scope="module")
def relaxed():
    return timed(line_ellipse_line(LEVEL, 0.05, 0.05), "relaxed", intervals=240)


@pytest.fixture(scope="module")
def strict():
    return timed(line_ellipse_line(LEVEL, 0.05, 0.05))


@pytest.fixture(scope="module")
def falling():
    """Different heights, a sharp ellipse and other limits."""
    ellipse = EllipsePath.with_top(0.15, -0.02, 0.03)
    return timed(line_ellipse_line(ellipse, 0.03, 0.06), "relaxed", MotionLimits(1.0, 10.0, 100.0))


def norms(motion, times):
    read = motion.sample(times)
    return [np.linalg.norm(x[0], axis=1) for x in (read.velocity, read.acceleration, motion.jerk(times))]


def limits_of(name):
    return (1.0, 10.0, 100.0) if name == "falling" else (1.8, 36.0, 900.0)


@pytest.mark.parametrize("name", with_nightly(["lame", "relaxed", "strict", "falling"], ["lame", "falling"]))
def test_limits_hold_at_10_khz(name, request):
    motion = request.getfixturevalue(name)
    times = np.arange(0.0, float(motion.duration[0]), 1e-4)
    for values, most in zip(norms(motion, times), limits_of(name), strict=True):
        assert values.max() <= most * (1.0 + 1e-6)
    # And what can be reached is reached.
    assert max(r[0] for r in motion.peak_ratios(MotionLimits(*limits_of(name)))) >= 0.99999


@pytest.mark.parametrize("name", with_nightly(["lame", "relaxed", "strict", "falling"], ["lame", "falling"]))
def test_samples_are_each_others_derivatives_on_the_path(name, request):
    motion = request.getfixturevalue(name)
    knots = motion.knot_times
    middle = 0.5 * (knots[1:] + knots[:-1])[np.diff(knots) > 1e-4]
    step = 1e-6
    before, here, after = (motion.sample(t) for t in (middle - step, middle, middle + step))
    for order in range(2):
        slope = (after[order] - before[order]) / (2 * step)
        np.testing.assert_allclose(here[order + 1], slope, rtol=0, atol=1e-5 * (1.0 + np.abs(slope).max()))
    slope = (after.acceleration - before.acceleration) / (2 * step)
    np.testing.assert_allclose(motion.jerk(middle), slope, rtol=0, atol=1e-4 * np.abs(slope).max())
    plane = motion.path.path.points(20_001)
    on = motion.path.positions(plane)
    for point in here.position[0, ::20]:
        assert np.linalg.norm(on - point, axis=1).min() < 3e-5


@pytest.mark.parametrize("name", ["lame", "strict"])
def test_acceleration_is_continuous_where_it_must_be(name, request):
    motion = request.getfixturevalue(name)
    gap = 1e-8
    before, after = motion.sample(motion.knot_times[1:-1] - gap), motion.sample(motion.knot_times[1:-1] + gap)
    assert np.abs(after.position - before.position).max() < 1e-7
    assert np.abs(after.velocity - before.velocity).max() < 1e-5
    assert np.abs(after.acceleration - before.acceleration).max() < 1e-3


def test_relaxed_joints_let_the_normal_acceleration_step_and_nothing_else(relaxed):
    border = np.searchsorted(relaxed.progress.s, relaxed.path.path.borders[1] - 1e-9)
    time = relaxed.knot_times[border]
    before, after = relaxed.sample(np.array([time - 1e-8])), relaxed.sample(np.array([time + 1e-8]))
    step = (after.acceleration - before.acceleration)[0, 0]
    speed = np.linalg.norm(before.velocity)
    assert speed == pytest.approx(0.468, abs=3e-3)
    # Across the vertical line, towards the place, by v^2 / rho = v^2 l / w^2.
    np.testing.assert_allclose(step, [0.0, speed**2 * 0.41 / 0.05**2, 0.0], atol=1e-3)
    assert np.abs(after.velocity - before.velocity).max() < 1e-5


def test_strict_joints_stop_where_the_curvature_jumps(strict):
    line, arc = min_time_scurve(0.05, LIMITS).duration, LEVEL.arc((0.41, 0.0))
    alone = timed(PlanePath((arc,)))
    assert strict.duration[0] == pytest.approx(2.0 * line + alone.duration[0], rel=1e-9)
    for time in (line, strict.duration[0] - line):
        state = strict.sample(np.array([time]))
        assert np.abs(state.velocity).max() < 1e-6
        assert np.abs(state.acceleration).max() < 1e-3


def test_durations_of_the_comparison(lame, relaxed, strict):
    assert lame.duration[0] == pytest.approx(0.721, abs=1e-3)
    assert relaxed.duration[0] == pytest.approx(0.706, abs=1e-3)
    assert strict.duration[0] == pytest.approx(0.8165, abs=1e-3)


def test_a_straight_line_cut_in_two_takes_the_time_of_the_closed_form():
    curve = min_time_scurve(0.82, LIMITS)
    pieces = timed(PlanePath((Line((0.0, 0.0), (0.5, 0.0)), Line((0.5, 0.0), (0.82, 0.0)))), intervals=240)
    assert curve.duration <= pieces.duration[0] <= curve.duration * (1.0 + 1e-4)
    times = np.linspace(0.0, curve.duration, 200)
    np.testing.assert_allclose(pieces.sample(times).position[0, :, 1], curve.sample(times)[0], rtol=0, atol=2e-4)
    whole = timed(PlanePath((Line((0.0, 0.0), (0.82, 0.0)),)))
    assert whole.duration[0] == pytest.approx(curve.duration, rel=1e-12)


def test_a_rectangle_is_three_strokes_without_casadi(monkeypatch):
    monkeypatch.setattr("papers.choe.planning.quickest.load_casadi", lambda: pytest.fail("casadi is not needed"))
    motion = timed(rectangle(0.82, 0.1, 0.1))
    strokes = [min_time_scurve(x, LIMITS).duration for x in (0.1, 0.82, 0.1)]
    assert motion.duration[0] == pytest.approx(sum(strokes), rel=1e-12)
    assert max(r[0] for r in motion.peak_ratios(LIMITS)) <= 1.0 + 1e-9


def test_without_casadi_the_error_says_what_to_install(monkeypatch):
    real = importlib.import_module

    def missing(name, *rest):
        if name == "casadi":
            raise ImportError(name)
        return real(name, *rest)

    load_casadi.cache_clear()
    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(PntGymError, match=r"need casadi; install it with: pip install 'pnt_gym\[optimal\]'"):
        load_casadi()
    load_casadi.cache_clear()


@pytest.mark.nightly
def test_a_shorter_way_and_looser_limits_are_quicker(lame):
    shorter = timed(lame_path(0.7, 0.05, 0.05, (0.1, 0.05)), intervals=60)
    assert shorter.duration[0] < lame.duration[0]
    looser = timed(lame_path(0.7, 0.05, 0.05, (0.1, 0.05)), limits=LIMITS.with_scale(2.0), intervals=60)
    assert looser.duration[0] < shorter.duration[0]


@pytest.mark.nightly
def test_scaled_limits_scale_the_time_exactly():
    path = lame_path(0.4, 0.03, 0.06, (0.1, 0.05), 4.0)
    once = timed(path, intervals=60)
    # Twice the time: half the speed, a quarter of the acceleration, an eighth of the jerk.
    twice = timed(path, limits=MotionLimits(0.9, 9.0, 112.5), intervals=60)
    assert twice.duration[0] == pytest.approx(2.0 * once.duration[0], rel=2e-4)
    slowed = once.slower(2.0).peak_ratios(LIMITS)
    for ratio, before, power in zip(slowed, once.peak_ratios(LIMITS), (2, 4, 8), strict=True):
        assert ratio[0] == pytest.approx(before[0] / power, rel=1e-6)


def test_rest_outside_and_shapes(lame):
    path: HandPath = lame
    end = float(path.duration[0])
    assert path.duration.shape == (1,)
    outside = path.sample(np.array([-0.1, 0.0, end, end + 0.1]))
    np.testing.assert_allclose(outside.position[0, :2], 0.0, atol=1e-12)
    np.testing.assert_allclose(outside.position[0, 2:], [[0.0, 0.82, 0.0]] * 2, atol=1e-9)
    assert np.abs(outside.velocity).max() < 1e-6
    assert not np.asarray(path.jerk(np.array([-0.1, end + 0.1]))).any()
    times = np.linspace(0.0, end, 7)
    for one, other in zip(path.sample(times), path.sample(times[None]), strict=True):
        np.testing.assert_array_equal(one, other)
        assert one.shape == (1, 7, 3)
    assert path.jerk(times).shape == (1, 7, 3)
    with pytest.raises(ValueError, match="times"):
        path.sample(np.zeros((2, 3)))


def test_bad_requests_are_refused():
    path = SpacePath.between(rectangle(0.3, 0.1, 0.1), (0.0, 0.0, 0.0), (0.3, 0.0, 0.0))
    with pytest.raises(ValueError, match="joints"):
        time_path(path, LIMITS, joints="loose")
    with pytest.raises(ValueError, match="intervals"):
        time_path(path, LIMITS, intervals=3)
    with pytest.raises(ValueError, match="one set"):
        time_path(path, MotionLimits.t3kr(np.array([10.0, 20.0])))
