"""Motions in machine code: where they pass, and what a fading leaves."""

import numpy as np
import pytest

from pnt_gym.arrays import concatenate_records
from pnt_gym.cells.conveyor.sections import FollowThrough
from pnt_gym.planning import JerkTrajectory, plan_release_batch
from pnt_gym.planning.motion.kernel import fade, go_back, grow
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.scurve import coast, rest_to_rest
from pnt_gym.planning.motion.strokes import MOST_SHARE
from tests.tools.throws import same_bits, straight_mover

COUNT = 500


def random_limits(seed):
    """Limits of any scale, so that strokes of every form occur."""
    random = np.random.default_rng(seed)
    scale = np.exp(random.uniform(-2.0, 2.0, (3, COUNT)))
    return random, LimitRows(*(np.array([3.0, 50.0, 1500.0])[:, None] * scale))


@pytest.mark.parametrize("share", [None, 0.8])
def test_throws_run_up_coast_and_brake(share):
    random, limits = random_limits(1)
    pick = random.uniform(-0.3, 0.0, (COUNT, 3))
    release = plan_release_batch(pick, pick + random.uniform([0.2, 0.3, -0.2], [0.8, 1.5, 0.2], (COUNT, 3)), limits)
    mover = straight_mover(FollowThrough(window=0.07, gravity_share=share))
    motion = mover.throw(pick, release, limits, np.full(COUNT, np.inf))
    np.testing.assert_allclose(motion.release_time, release.time, rtol=1e-9)
    np.testing.assert_allclose(motion.path.duration, motion.stop_time, rtol=1e-12)
    for time in (motion.release_time, motion.release_time + 0.07):
        seen = motion.path.sample(time[:, None])
        way = release.position + (time - motion.release_time)[:, None] * release.velocity
        np.testing.assert_allclose(seen.position[:, 0], way, atol=1e-9)
        np.testing.assert_allclose(seen.velocity[:, 0], release.velocity, atol=1e-9)
    np.testing.assert_allclose(motion.path.end, motion.stop, atol=1e-9)
    ratios = motion.path.peak_ratios(limits)
    assert max(ratio.max() for ratio in ratios) <= 1.0 + 1e-9
    assert ratios.jerk.min() >= 1.0 - 1e-12


@pytest.mark.parametrize("clearance", [0.002, 0.05, 0.4])
def test_returns_go_straight_wait_and_come_down(clearance):
    random, limits = random_limits(2)
    stop, pick = random.uniform(-0.5, 0.5, (2, COUNT, 3))
    wait = np.where(random.random(COUNT) < 0.5, 0.0, random.random(COUNT))
    above = pick + np.array([0.0, 0.0, clearance])
    stop[:5] = above[:5]  # no way at all
    path = JerkTrajectory.concatenate(stop, [go_back(stop, pick, wait, limits, clearance)])
    arrival, descent = path.knot_times[:, 7], path.knot_times[:, 8]
    np.testing.assert_allclose(descent - arrival, wait, atol=1e-12)
    for time, place in ((arrival, above), (descent, above), (path.duration, pick)):
        seen = path.sample(time[:, None])
        np.testing.assert_allclose(seen.position[:, 0], place, atol=1e-9)
        np.testing.assert_allclose(seen.velocity[:, 0], 0.0, atol=1e-9)
    assert (arrival[:5] == 0.0).all()
    assert max(ratio.max() for ratio in path.peak_ratios(limits)) <= 1.0 + 1e-9


def test_a_fading_is_two_equal_ramps_and_leaves_what_it_does_not_take():
    _, limits = random_limits(3)
    fading = fade(limits, 0.4, 0.0)
    start, speed = np.zeros((COUNT, 3)), np.array([0.4, 0.0, 0.0])
    out = JerkTrajectory.concatenate(start, [grow(fading.time, -0.4, 2)], start + speed)
    np.testing.assert_allclose(out.end, fading.lead, atol=1e-12)
    np.testing.assert_allclose(out.knots.velocity[:, -1], 0.0, atol=1e-12)
    grown = JerkTrajectory.concatenate(start, [grow(fading.time, 0.4, 2)])
    np.testing.assert_allclose(grown.duration, fading.time, rtol=1e-12)
    np.testing.assert_allclose(grown.knots.velocity[:, -1], start + speed, atol=1e-12)
    left, peak = fading.left, 2.0 * 0.4 / fading.time
    assert same_bits(left.velocity, limits.velocity)
    for part, limit, taken in (
        (left.acceleration, limits.acceleration, peak),
        (left.jerk, limits.jerk, 2.0 * peak / fading.time),
    ):
        np.testing.assert_allclose(part, np.maximum(limit - taken, (1 - MOST_SHARE) * limit), rtol=1e-12)


def test_delayed_motions_wait_first():
    _, limits = random_limits(4)
    motion, wait = rest_to_rest(np.ones((COUNT, 3)), limits), np.linspace(0.0, 1.0, COUNT)
    delayed, expected = motion.delay(wait), concatenate_records([coast(wait), motion], axis=1)
    assert same_bits(delayed.durations, expected.durations)
    np.testing.assert_array_equal(delayed.jerks, expected.jerks)
