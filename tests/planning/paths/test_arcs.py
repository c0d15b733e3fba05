"""Arcs timed in a batch: on the ellipse, within all limits, a few percent above the optimum."""

import numpy as np
import pytest

from papers.choe.planning.plane import PlanePath, SpacePath
from papers.choe.planning.timing import time_path
from pnt_gym.errors import PlanningError
from pnt_gym.planning import JerkTrajectory, MotionLimits
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.paths import EllipsePath
from pnt_gym.planning.paths import arcs as module
from pnt_gym.planning.paths.arc_kernel import PIECES
from pnt_gym.planning.paths.arcs import arc_segments

COUNT = 200


def drawn(count=COUNT, seed=0):
    """Ways (N, 3), heights of the tops above the starts (N,), and limits of all kinds."""
    random = np.random.default_rng(seed)
    run, turn = random.uniform(0.05, 1.2, count), random.uniform(-np.pi, np.pi, count)
    rise = random.uniform(-0.15, 0.15, count)
    way = np.stack([run * np.cos(turn), run * np.sin(turn), rise], axis=1)
    top = np.maximum(rise, 0.0) + random.uniform(0.01, 0.20, count)
    percent = random.uniform(10.0, 100.0, count)
    limits = LimitRows.t3kr(percent)
    return way, top, limits._replace(acceleration=limits.acceleration * random.uniform(0.1, 1.0, count))


@pytest.fixture(scope="module")
def moved():
    way, top, limits = drawn()
    segments = arc_segments(way, top, limits)
    return way, top, limits, JerkTrajectory(np.zeros_like(way), segments.durations, segments.jerks)


def test_a_motion_starts_and_ends_at_rest_where_it_should(moved):
    way, _, _, path = moved
    np.testing.assert_allclose(path.end, way, rtol=0, atol=1e-9)
    np.testing.assert_allclose(path.knots.velocity[:, -1], 0.0, atol=1e-9)
    np.testing.assert_allclose(path.knots.acceleration[:, -1], 0.0, atol=1e-7)


def test_the_hand_stays_on_the_ellipse_and_reaches_its_top(moved):
    """By the implicit equation of the ellipse, which knows no angle and no time; its gradient makes it a distance."""
    way, top, _, path = moved
    times = path.duration[:, None] * np.linspace(0.0, 1.0, 1501)
    place = path.sample(times).position
    run = np.hypot(way[:, 0], way[:, 1])
    half, rise = run[:, None] / 2.0, way[:, 2, None] / 2.0
    chord = np.sqrt((top[:, None] - rise) ** 2 - rise**2)
    x = (place[..., 0] * way[:, 0, None] + place[..., 1] * way[:, 1, None]) / run[:, None] - half
    y = place[..., 2] - rise
    across = (y - rise * x / half) / chord
    value = (x / half) ** 2 + across**2 - 1.0
    gradient = 2.0 * np.hypot(x / half**2 - across * rise / (half * chord), across / chord)
    off = np.abs(value / gradient).max(axis=1)
    assert np.median(off) < 5e-6
    assert np.quantile(off, 0.9) < 50e-6
    assert off.max() < 500e-6  # far, flat and slow: the bend is over before the first pieces are
    aside = place[..., 0] * way[:, 1, None] - place[..., 1] * way[:, 0, None]
    assert np.abs(aside).max() < 1e-9
    np.testing.assert_allclose(place[..., 2].max(axis=1), top, rtol=0, atol=5e-4)


def test_limits_are_kept_by_finite_differences_and_one_is_reached(moved):
    _, _, limits, path = moved
    step = 2e-4
    times = np.arange(0.0, path.duration.max() + step, step)
    place = path.sample(times).position
    ratios = []
    for order, most in enumerate(limits, start=1):
        change = np.diff(place, n=order, axis=1) / step**order
        ratios.append(np.linalg.norm(change, axis=2).max(axis=1) / most)
    # Rounding of positions weighs in third differences.
    assert ratios[0].max() < 1.0 + 1e-6
    assert ratios[1].max() < 1.0 + 1e-6
    assert ratios[2].max() < 1.0 + 1e-4
    exact = np.array(path.peak_ratios(limits))
    assert exact.max() < 1.0 + 1e-6
    assert exact.max(axis=0).min() > 0.999


@pytest.mark.parametrize(
    ("percent", "half", "rise", "crest"),
    [(15, 0.40, 0.03, 0.025), (40, 0.40, 0.0, 0.05), (40, 0.35, -0.03, 0.025), (60, 0.30, 0.02, 0.03)],
)
def test_it_takes_a_few_percent_more_than_the_quickest_motion_and_never_less(percent, half, rise, crest):
    limits, top = MotionLimits.t3kr(percent), abs(rise) + crest
    way = np.array([2.0 * half, 0.0, 2.0 * rise])
    ellipse = EllipsePath.with_top(half, rise, top)
    path = SpacePath.between(PlanePath((ellipse.arc((half, rise)),)), np.zeros(3), way)
    least = float(time_path(path, limits, intervals=80).duration[0])
    segments = arc_segments(way[None], np.array([top + rise]), limits)
    ratio = float(segments.durations.sum()) / least
    assert 0.998 < ratio < 1.10


def test_both_files_count_the_pieces_alike():
    assert module.PIECES == PIECES


@pytest.mark.parametrize(
    ("way", "top", "told"),
    [((0.0, 0.0, 0.1), 0.2, "got 0.0 and"), ((0.3, 0.0, 0.1), 0.1, "0.0 m"), ((0.3, 0.0, -0.1), -0.05, "-0.05 m")],
)
def test_an_arc_without_width_or_height_is_told(way, top, told):
    with pytest.raises(PlanningError, match="an arc needs a width and a top above both its ends") as error:
        arc_segments(np.array([way]), np.array([top]), MotionLimits.t3kr(40))
    assert told in str(error.value)
