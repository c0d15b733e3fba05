"""Curves and paths of several curves: by differences, by quadrature, and where their pieces join."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from papers.choe.planning.curves import LameCorner, Line, MeasuredCurve
from papers.choe.planning.plane import Joint, PlanePath, SpacePath, lame_path, line_ellipse_line, rectangle
from pnt_gym.planning.paths import EllipseArc, EllipsePath

EXAMPLE = EllipsePath.paper(half_width=0.15, half_rise=0.025)


def test_curvature_radius_agrees_with_the_curve():
    curve = MeasuredCurve(EXAMPLE.arc())
    s = np.linspace(0.0, curve.length, 50)
    points = curve.at(s)
    local = points.position @ np.array([[np.cos(EXAMPLE.angle), -np.sin(EXAMPLE.angle)], [np.sin(EXAMPLE.angle), 0.0]])
    local[:, 1] = points.position @ [-np.sin(EXAMPLE.angle), np.cos(EXAMPLE.angle)]
    theta = np.arctan2(local[:, 1] / EXAMPLE.semi_minor, local[:, 0] / EXAMPLE.semi_major)
    np.testing.assert_allclose(-1.0 / points.curvature, EXAMPLE.radius_of_curvature(theta), rtol=1e-9)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: rectangle(0.0, 0.1, 0.1), "width"),
        (lambda: rectangle(0.1, -0.1, 0.1), "lift"),
        (lambda: line_ellipse_line(EXAMPLE, 0.1, np.nan), "drop"),
        (lambda: lame_path(0.1, 0.1, 0.1, (0.06, 0.01)), "fit"),
        (lambda: lame_path(0.1, 0.1, 0.1, (0.05, 0.0)), "height"),
        (lambda: lame_path(0.1, 0.1, 0.1, (0.05, 0.01), 2.5), "exponent"),
        (lambda: PlanePath(()), "piece"),
        (lambda: PlanePath((Line((0.0, 0.0), (0.0, 0.0)),)), "length"),
        (lambda: PlanePath((Line((0.0, 0.0), (0.0, 1.0)), Line((0.0, 1.1), (0.0, 2.0)))), "meet"),
    ],
)
def test_bad_paths_are_refused(make, word):
    with pytest.raises(ValueError, match=word):
        make()


CURVES = [
    Line((0.1, 0.2), (0.4, -0.1)),
    EXAMPLE.arc((0.2, 0.1)),
    EllipseArc((0.0, 0.0), (-0.1, 0.02), (0.0, 0.05), 0.3, 2.0),
    LameCorner((0.1, 0.0), (-0.1, 0.0), (0.0, 0.05), 3.0),
    LameCorner((0.1, 0.0), (0.0, 0.05), (0.2, 0.0), 4.5),
]


@pytest.mark.parametrize("curve", CURVES)
def test_derivatives_agree_with_differences(curve):
    u, step = np.linspace(0.05, 0.95, 31), 1e-5
    before, here, after = (curve.derivatives(x) for x in (u - step, u, u + step))
    for order in range(3):
        slope = (after[order] - before[order]) / (2.0 * step)
        scale = np.abs(here[order + 1]).max() + 1e-6
        np.testing.assert_allclose(here[order + 1], slope, rtol=0, atol=1e-7 * scale)


@pytest.mark.parametrize("curve", CURVES)
def test_arc_length_and_curvature_agree_with_differences(curve):
    measured = MeasuredCurve(curve)
    whole = quad(lambda u: np.linalg.norm(curve.derivatives(np.array([u])).first), 0.0, 1.0, epsabs=1e-13)[0]
    assert measured.length == pytest.approx(whole, rel=1e-9)
    s, step = np.linspace(0.01, 0.99, 41) * measured.length, 1e-6 * measured.length
    before, here, after = (measured.at(x) for x in (s - step, s, s + step))
    np.testing.assert_allclose(here.tangent, (after.position - before.position) / (2 * step), rtol=0, atol=1e-7)
    turn = np.unwrap(np.arctan2(after.tangent[:, 1], after.tangent[:, 0]))
    turn -= np.unwrap(np.arctan2(before.tangent[:, 1], before.tangent[:, 0]))
    scale = np.abs(here.curvature).max() + 1.0
    np.testing.assert_allclose(here.curvature, turn / (2 * step), rtol=0, atol=1e-6 * scale)
    slope = (after.curvature - before.curvature) / (2 * step)
    np.testing.assert_allclose(here.slope, slope, rtol=0, atol=1e-5 * (np.abs(slope).max() + 1.0))


@settings(deadline=None)
@given(st.floats(3.0, 8.0), st.floats(0.01, 0.3), st.floats(0.01, 0.3))
def test_a_lame_corner_lies_on_its_curve_and_is_straight_at_its_ends(exponent, width, height):
    curve = LameCorner((0.0, 0.0), (-width, 0.0), (0.0, height), exponent)
    points = curve.derivatives(np.linspace(0.0, 1.0, 101)).position
    on = np.abs(points[:, 0] / width) ** exponent + np.abs(points[:, 1] / height) ** exponent
    np.testing.assert_allclose(on, 1.0, rtol=1e-12)
    measured = MeasuredCurve(curve)
    ends = measured.at(np.array([0.0, measured.length]))
    np.testing.assert_allclose(ends.curvature, 0.0, atol=1e-9 / min(width, height))
    np.testing.assert_allclose(ends.tangent, [[0.0, 1.0], [1.0, 0.0]], atol=1e-12)


def test_how_the_pieces_of_each_path_join():
    assert rectangle(0.8, 0.1, 0.05).joints == (Joint.CORNER, Joint.CORNER)
    assert line_ellipse_line(EXAMPLE, 0.05, 0.05).joints == (Joint.TANGENT, Joint.TANGENT)
    assert lame_path(0.8, 0.05, 0.05, (0.1, 0.05)).joints == (Joint.CURVED,) * 4
    assert lame_path(0.8, 0.05, 0.05, (0.1, 0.05), 2.0).joints == (Joint.TANGENT,) * 4
    assert len(lame_path(0.8, 0.0, 0.0, (0.4, 0.05)).pieces) == 2


@settings(max_examples=15, deadline=None)
@given(st.floats(0.05, 1.0), st.floats(0.0, 0.2), st.floats(0.0, 0.2), st.floats(0.01, 0.2))
def test_ends_lengths_and_tops_of_pick_and_place_paths(width, lift, drop, height):
    paths = [
        lame_path(width, lift, drop, (0.3 * width, height)),
        line_ellipse_line(EllipsePath.with_top(0.5 * width, 0.0, height), lift, drop),
        rectangle(width, lift + height, drop + height),
    ]
    for path in paths:
        np.testing.assert_allclose(path.start, [0.0, 0.0], atol=2e-9)
        np.testing.assert_allclose(path.end, [width, lift - drop], atol=2e-9)
        assert path.top == pytest.approx(lift + height, rel=1e-6)
        walked = np.linalg.norm(np.diff(path.points(1001), axis=0), axis=1).sum()
        assert path.length == pytest.approx(walked, rel=1e-3)
    assert paths[2].length == pytest.approx(width + lift + drop + 2 * height)
    assert paths[2].length > paths[0].length > paths[1].length


def test_a_path_between_two_points_in_space():
    path = lame_path(0.5, 0.1, 0.2, (0.1, 0.05))
    pick, place = np.array([0.1, -0.2, -0.8]), np.array([0.4, 0.2, -0.9])
    space = SpacePath.between(path, pick, place)
    points = space.positions(path.points(11))
    np.testing.assert_allclose(points[[0, -1]], [pick, place], atol=1e-9)
    np.testing.assert_allclose(np.cross(points - pick, place - pick)[:, 2], 0.0, atol=1e-12)
    for bad in ((0.4, 0.2, -0.8), (0.1, -0.2, -0.9), (np.nan, 0.0, 0.0)):
        with pytest.raises(ValueError, match=r"apart|straight above|finite"):
            SpacePath.between(path, pick, bad)
