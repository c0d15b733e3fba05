import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pnt_gym.planning import EllipticWorkspace

SPACE = EllipticWorkspace(z_min=-1.0, z_max=-0.5)


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
