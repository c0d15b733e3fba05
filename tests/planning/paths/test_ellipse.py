"""The ellipse of the hand's path: its published example, and shape and length of any other."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ellipe

from pnt_gym.errors import PlanningError
from pnt_gym.planning.paths import EllipsePath, half_circumference
from pnt_gym.planning.paths.ellipse import MOST_NODES

EXAMPLE = EllipsePath.paper(half_width=0.15, half_rise=0.025)
widths = st.floats(0.05, 1.0)
shares = st.floats(-0.99, 0.99)
tops = st.floats(0.02, 1.0)


def test_published_example_to_all_printed_digits():
    assert np.degrees(EXAMPLE.angle) == pytest.approx(10.0, abs=1e-9)
    assert round(EXAMPLE.semi_major, 5) == 0.15219
    assert round(EXAMPLE.semi_minor, 5) == 0.03511
    assert round(EXAMPLE.approximate_length, 5) == 0.32058
    assert [round(x, 5) for x in EXAMPLE.top] == [0.08617, 0.04352]
    assert round(EXAMPLE.height, 5) == 0.06852
    # The printed values with their labels the right way round.
    assert round(float(np.degrees(EXAMPLE.theta_t1)), 3) == 177.671
    assert round(float(np.degrees(EXAMPLE.theta_t2)), 3) == -2.329


def test_exact_length_of_the_example_by_two_other_ways():
    a, b = EXAMPLE.semi_major, EXAMPLE.semi_minor
    assert EXAMPLE.length == pytest.approx(2.0 * a * ellipe(1.0 - (b / a) ** 2), rel=1e-14)
    thetas = np.linspace(EXAMPLE.theta_t1, EXAMPLE.theta_t2, 200_001)
    chords = np.linalg.norm(np.diff(EXAMPLE.point(thetas), axis=0), axis=1)
    assert EXAMPLE.length == pytest.approx(chords.sum(), rel=1e-9)
    assert EXAMPLE.length == pytest.approx(0.323730, abs=5e-7)


@given(st.floats(1e-6, 1.0))
def test_half_circumference_is_the_elliptic_integral(ratio):
    for major, minor in ((2.0, 2.0 * ratio), (2.0 * ratio, 2.0)):
        assert half_circumference(major, minor) == pytest.approx(4.0 * ellipe(1.0 - ratio**2), rel=1e-13)


@given(widths, shares, tops)
def test_an_ellipse_by_its_top_is_vertical_at_both_ends_and_has_that_top(width, share, top):
    e = EllipsePath.with_top(width, share * top, top)
    ends = e.point([e.theta_t1, e.theta_t2])
    np.testing.assert_allclose(ends, [[-width, -share * top], [width, share * top]], rtol=0, atol=1e-12)
    theta = np.linspace(e.theta_t1, e.theta_t2, 20_001)
    points = e.point(theta)
    assert points[:, 1].max() == pytest.approx(top, rel=1e-6)
    assert points[np.argmax(points[:, 1]), 0] == pytest.approx(e.top[0], abs=2e-3 * (width + top))
    np.testing.assert_allclose(np.abs(points[:, 0]).max(), width, rtol=1e-12)
    assert e.semi_major >= e.semi_minor > 0.0
    # A third point fixes a centred ellipse with two vertical tangents: both forms are the same curve.
    arc = e.arc().derivatives(np.linspace(0.0, 1.0, 9)).position
    cos, sin = np.cos(e.angle), np.sin(e.angle)
    x, y = arc[:, 0] * cos + arc[:, 1] * sin, arc[:, 1] * cos - arc[:, 0] * sin
    np.testing.assert_allclose((x / e.semi_major) ** 2 + (y / e.semi_minor) ** 2, 1.0, rtol=1e-7)
    # Monotone in x: the upper half and nothing else.
    assert (np.diff(points[:, 0]) >= -1e-12).all()


@given(widths, st.floats(0.01, 5.0), st.floats(0.001, 0.999))
def test_angle_and_top_are_two_names_of_one_ellipse(width, slope, share):
    rise = slope * width
    critical = np.arctan(slope)
    angle = critical + share * (0.5 * np.pi - critical)
    e = EllipsePath.with_angle(width, rise, float(angle))
    again = EllipsePath.with_top(width, rise, e.top_height)
    assert again.angle == pytest.approx(angle, abs=1e-6)
    # Eqs. 21 and 23 as printed.
    sin2, cos, sin = np.sin(2 * angle), np.cos(angle), np.sin(angle)
    d, f = width * sin2 + 2 * rise * sin**2, width * sin2 - 2 * rise * cos**2
    big, small = (width * sin) ** 2 - (rise * cos) ** 2, (width * cos) ** 2 - (rise * sin) ** 2
    assert e.semi_major**2 == pytest.approx(d * big / f + small, rel=1e-5)
    assert e.semi_minor**2 == pytest.approx(big + f * small / d, rel=1e-5)
    mirrored = EllipsePath.with_angle(width, -rise, float(-angle))
    assert mirrored.length == pytest.approx(e.length, rel=1e-12)


def test_length_grows_with_the_angle_everywhere():
    angles = np.radians(np.linspace(9.463, 89.9, 400))
    lengths = [EllipsePath.with_angle(0.15, 0.025, float(a)).length for a in angles]
    assert (np.diff(lengths) > 0.0).all()
    assert lengths[0] == pytest.approx(2.0 * np.hypot(0.15, 0.025), rel=1e-3)


def test_node_list_of_the_example():
    printed = EXAMPLE.nodes(0.77, clip=False)
    assert len(printed.theta) == 80
    assert np.degrees(printed.theta[-1]) == pytest.approx(-2.530, abs=5e-4)
    assert printed.steps.min() == pytest.approx(0.219e-3, abs=5e-7)
    assert printed.steps.max() == pytest.approx(74.2e-3, abs=5e-5)
    steps = -np.diff(printed.theta)
    np.testing.assert_allclose(steps, 0.77 * EXAMPLE.radius_of_curvature(printed.theta[:-1]), rtol=1e-12)
    clipped = EXAMPLE.nodes(0.77)
    np.testing.assert_allclose(clipped.points[[0, -1]], [[-0.15, -0.025], [0.15, 0.025]], atol=1e-12)
    np.testing.assert_array_equal(clipped.theta[:-1], printed.theta[:-1])
    with pytest.raises(ValueError, match="rate"):
        EXAMPLE.nodes(0.0)
    with pytest.raises(ValueError, match="rate must be at least"):
        EXAMPLE.nodes(1e-9)


@pytest.mark.parametrize("rise", [0.0, -0.01, np.nan, np.inf])
def test_the_papers_rule_refuses_level_and_falling_paths(rise):
    with pytest.raises(ValueError, match="half_rise"):
        EllipsePath.paper(half_width=0.15, half_rise=rise)


@pytest.mark.parametrize("degrees", [1, 5, 10, 22, 45, 60, 88, 89, 89.5])
def test_the_papers_rule_refuses_whole_critical_angles(degrees):
    with pytest.raises(ValueError, match="critical angle"):
        EllipsePath.paper(half_width=0.15, half_rise=0.15 * np.tan(np.radians(degrees)))


@given(st.floats(0.01, 1.0), st.floats(0.001, 2.0))
def test_the_papers_rule_gives_an_ellipse_or_a_reason(width, rise):
    try:
        e = EllipsePath.paper(width, rise)
    except ValueError as error:
        critical = np.degrees(np.arctan(rise / width))
        assert critical > 89.0 or abs(critical - round(critical)) < 1e-6
        assert "critical angle" in str(error) or "top" in str(error)
        return
    assert np.degrees(e.angle) == pytest.approx(np.ceil(np.degrees(np.arctan(rise / width))), abs=1e-5)
    assert e.length > 2.0 * np.hypot(width, rise)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: EllipsePath.with_top(0.0, 0.0, 0.1), "half_width"),
        (lambda: EllipsePath.with_top(0.1, np.nan, 0.1), "half_rise"),
        (lambda: EllipsePath.with_top(0.1, 0.0, np.inf), "top"),
        (lambda: EllipsePath.with_top(0.1, 0.1, 0.1), "top"),
        (lambda: EllipsePath.with_top(0.1, -0.2, 0.1), "top"),
        (lambda: EllipsePath.with_angle(0.1, 0.0, 0.3), "with_top"),
        (lambda: EllipsePath.with_angle(0.1, 0.1, 0.5), "angle"),
        (lambda: EllipsePath.with_angle(0.1, 0.1, np.nan), "angle"),
        (lambda: EllipsePath.with_angle(0.1, 0.1, 0.5 * np.pi), "angle"),
        (lambda: half_circumference(1.0, 0.0), "semi_minor"),
    ],
)
def test_bad_ellipses_are_refused(make, word):
    with pytest.raises(ValueError, match=word):
        make()


SIZES = st.floats(1e-30, 1e30)


@settings(max_examples=50)
@given(width=SIZES, top=SIZES, share=st.floats(-0.999, 0.999), rate=st.floats(1e3, 1e9))
def test_ellipses_of_any_size_have_a_length_and_nodes_that_end(width, top, share, rate):
    """Half the circumference lies between the major axis and half the box around the ellipse."""
    e = EllipsePath.with_top(width, share * top, top)
    assert 2.0 * e.semi_major <= e.length * (1 + 1e-12) <= 2.0 * (e.semi_major + e.semi_minor) * (1 + 3e-12)
    slowest = np.pi / MOST_NODES * e.semi_major / e.semi_minor**2
    assert 2 <= len(e.nodes(slowest * rate).theta) <= MOST_NODES + 2


@pytest.mark.parametrize("size", [5e-324, 1e-300, 1e-31, 1.1e30, 1e155, 1.7e308])
def test_ellipses_whose_powers_no_number_holds_are_one_sentence(size):
    makes = (
        lambda: EllipsePath.with_top(size, 0.0, 0.1),
        lambda: EllipsePath.with_top(0.1, 0.0, size),
        lambda: EllipsePath.with_angle(size, 0.5 * size, 0.6),
        lambda: EllipsePath.with_angle(1.0, size, 1.5707963),
        lambda: EllipsePath.paper(size, 0.3 * size),
    )
    for make in makes:
        with pytest.raises(PlanningError, match=r"must be from 1e-30 to 1e\+30 m, got"):
            make().nodes(1e300)
    with pytest.raises(PlanningError, match=r"semi_minor must be from 1e-100 to 1e\+100 m"):
        half_circumference(1.0, max(size * 1e-80, 5e-324) if size < 1.0 else 1e101)
