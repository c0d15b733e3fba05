import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.arrays import take
from pnt_gym.errors import PlanningError
from pnt_gym.planning import EllipticWorkspace, MotionLimits
from pnt_gym.planning.motion.limits import LimitRows

SPACE = EllipticWorkspace(z_min=-1.0, z_max=-0.5)


def test_percent_scales_all_three_limits():
    limits = MotionLimits.t3kr(percent=30)
    assert (limits.velocity, limits.acceleration, limits.jerk) == (1.8, 36.0, 900.0)
    assert MotionLimits.t3kr() == MotionLimits(6.0, 120.0, 3000.0)


def test_percent_array_gives_limits_per_throw():
    limits = MotionLimits.t3kr(np.array([15.0, 30.0, 100.0]))
    assert limits.count == 3
    np.testing.assert_allclose(limits.acceleration, [18.0, 36.0, 120.0], rtol=1e-15)
    assert take(limits, 1) == MotionLimits.t3kr(30)
    assert take(limits, np.s_[1:]).count == 2
    assert take(limits, np.array([True, False, True])) == MotionLimits.t3kr(np.array([15.0, 100.0]))


@pytest.mark.parametrize("percent", [0.0, -1.0, 100.5, np.nan])
def test_percent_out_of_range_names_the_value(percent):
    with pytest.raises(ValueError, match=r"\(0, 100\]") as error:
        MotionLimits.t3kr(np.array([30.0, percent]))
    assert str(percent) in str(error.value)


@pytest.mark.parametrize("field", ["velocity", "acceleration", "jerk"])
@pytest.mark.parametrize("value", [0.0, -2.0, np.nan, np.inf])
def test_bad_limit_names_field_and_value(field, value):
    good = {"velocity": 1.0, "acceleration": 10.0, "jerk": 100.0}
    for bad in (value, np.array([1.0, value])):
        with pytest.raises(ValueError, match=field) as error:
            MotionLimits(**{**good, field: bad})
        assert str(value) in str(error.value)


def test_rows_are_as_many_as_the_throws():
    with pytest.raises(PlanningError, match="the limits hold 2 throws but 3 are planned"):
        LimitRows.t3kr(np.array([30.0, 40.0])).arrays(3)


def test_lengths_must_agree():
    with pytest.raises(ValueError, match="one length"):
        MotionLimits(np.ones(2), np.ones(3), 1.0)
    with pytest.raises(ValueError, match="2 throws but 5"):
        MotionLimits(np.ones(2), 1.0, 1.0).arrays(5)
    with pytest.raises(ValueError, match="shape"):
        MotionLimits(np.ones((2, 2)), 1.0, 1.0)


def test_arrays_are_copied_and_read_only():
    source = np.array([1.0, 2.0])
    limits = MotionLimits(source, 1.0, 1.0)
    source[0] = -5.0
    np.testing.assert_array_equal(limits.velocity, [1.0, 2.0])
    with pytest.raises(ValueError, match="read-only"):
        limits.velocity[0] = 3.0


def test_numbers_need_one_set_of_limits():
    assert MotionLimits(1.0, 2.0, 3.0).numbers() == (1.0, 2.0, 3.0)
    with pytest.raises(ValueError, match="take a row"):
        MotionLimits(np.ones(3), 2.0, 3.0).numbers()


def test_default_ellipse_and_heights():
    points = np.array([[0.0, 0.0, -0.7], [0.45, 0.0, -0.7], [0.46, 0.0, -0.7], [0.0, 0.81, -0.7], [0.0, 0.0, -0.4]])
    np.testing.assert_array_equal(SPACE.contains(points), [True, True, False, False, False])
    assert SPACE.contains(np.zeros((2, 4, 3))).shape == (2, 4)


@given(st.floats(-0.6, 0.6), st.floats(-1.0, 1.0), st.floats(-1.1, -0.4))
def test_margin_is_a_safe_distance(x, y, z):
    point = np.array([x, y, z])
    margin = float(SPACE.margin(point))
    inside = (x / 0.45) ** 2 + (y / 0.80) ** 2 <= 1.0 and -1.0 <= z <= -0.5
    assert (margin >= 0.0) == inside or abs(margin) < 1e-12
    if margin > 0.0:
        turn = np.linspace(0.0, 2.0 * np.pi, 2000)
        border = np.hypot(0.45 * np.cos(turn) - x, 0.80 * np.sin(turn) - y).min()
        assert margin <= min(border, z + 1.0, -0.5 - z) + 1e-12


@given(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9), st.floats(0.0, 6.283))
def test_line_bounds_are_where_the_line_crosses_the_border(x, y, turn):
    start, cosine, sine = np.array([[x, y, -0.8]]), np.array([np.cos(turn)]), np.array([np.sin(turn)])
    near, far, low, high = (float(b[0]) for b in SPACE.line_bounds(start, cosine, sine))
    along = np.linspace(0.0, 2.5, 400)
    line = start + along[:, None] * np.array([cosine[0], sine[0], 0.0])
    sure = np.abs(SPACE.margin(line)) > 1e-6
    np.testing.assert_array_equal(SPACE.contains(line)[sure], ((along >= near) & (along <= far))[sure])
    assert (low, high) == pytest.approx((-0.2, 0.3))


@pytest.mark.parametrize(
    "options", [{"semi_x": 0.0}, {"semi_y": np.nan}, {"z_min": 1.0, "z_max": 0.0}, {"z_min": np.nan}]
)
def test_bad_shapes_are_refused(options):
    with pytest.raises(ValueError, match=next(iter(options))):
        EllipticWorkspace(**options)
