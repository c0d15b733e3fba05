"""Motions in machine code are those of the S-curves in NumPy, to the last bit."""

import numpy as np
import pytest

from pnt_gym.arrays import concatenate_records
from pnt_gym.cells.conveyor.movers.straight import straight_back
from pnt_gym.cells.conveyor.sections import FollowThrough
from pnt_gym.planning import plan_release_batch
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.riding import MOST_SHARE, Fading
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.scurve import accelerate, brake, brake_distance, coast, rest_to_rest
from tests.tools.throws import same_bits, straight_mover

COUNT = 500


def random_limits(seed):
    """Limits of any scale, so that strokes of every form occur."""
    random = np.random.default_rng(seed)
    scale = np.exp(random.uniform(-2.0, 2.0, (3, COUNT)))
    return random, LimitRows(*(np.array([3.0, 50.0, 1500.0])[:, None] * scale))


def assert_same(segments, expected):
    assert same_bits(segments.durations, expected.durations)
    np.testing.assert_array_equal(segments.jerks, expected.jerks)


@pytest.mark.parametrize("share", [None, 0.8])
def test_throws_run_up_coast_and_brake(share):
    random, limits = random_limits(1)
    pick = random.uniform(-0.3, 0.0, (COUNT, 3))
    release = plan_release_batch(pick, pick + random.uniform([0.2, 0.3, -0.2], [0.8, 1.5, 0.2], (COUNT, 3)), limits)
    mover = straight_mover(FollowThrough(window=0.07, gravity_share=share))
    motion = mover.throw(pick, release, limits, np.full(COUNT, np.inf))
    slow = mover.braking_limits(release, limits)
    ahead = accelerate(release.direction, release.distance, limits)
    stop = brake(release.direction, release.speed, slow)
    assert_same(motion.segments, concatenate_records([ahead, coast(np.full(COUNT, 0.07)), stop], axis=1))
    assert same_bits(motion.release_time, ahead.durations.sum(axis=1))
    assert same_bits(motion.stop_time, motion.release_time + 0.07 + stop.durations.sum(axis=1))
    way = release.distance + (0.07 * release.speed + brake_distance(release.speed, slow))
    assert same_bits(motion.stop, pick + release.direction * way[:, None])


@pytest.mark.parametrize("clearance", [0.002, 0.05, 0.4])
def test_returns_go_straight_wait_and_come_down(clearance):
    random, limits = random_limits(2)
    stop, pick = random.uniform(-0.5, 0.5, (2, COUNT, 3))
    wait = np.where(random.random(COUNT) < 0.5, 0.0, random.random(COUNT))
    above, down = pick + np.array([0.0, 0.0, clearance]), np.tile([0.0, 0.0, -clearance], (COUNT, 1))
    stop[:5] = above[:5]  # no way at all
    moves = [rest_to_rest(above - stop, limits), coast(wait), rest_to_rest(down, limits)]
    assert_same(straight_back(stop, pick, wait, limits, clearance), concatenate_records(moves, axis=1))


def test_a_fading_is_two_equal_ramps_and_leaves_what_it_does_not_take():
    _, limits = random_limits(3)
    fading = Fading.for_limits(limits, COUNT, 0.4)
    half, jerk = 0.5 * fading.time, 4.0 * 0.4 / fading.time**2
    along = np.array([1.0, 0.0, 0.0])
    for sign, segments in ((-1.0, fading.fade_out()), (1.0, fading.fade_in(np.full(COUNT, 0.3)))):
        ramps = np.stack([sign * jerk, -sign * jerk], axis=1)[:, :, None] * along
        parts = [Segments(np.stack([half, half], axis=1), ramps)]
        assert_same(segments, concatenate_records([coast(np.full(COUNT, 0.3))] * (sign > 0) + parts, axis=1))
    left, peak = fading.planning_limits(limits), 2.0 * 0.4 / fading.time
    assert same_bits(left.velocity, limits.velocity)
    assert same_bits(left.acceleration, np.maximum(limits.acceleration - peak, (1 - MOST_SHARE) * limits.acceleration))
    assert same_bits(left.jerk, np.maximum(limits.jerk - 2.0 * peak / fading.time, (1 - MOST_SHARE) * limits.jerk))


def test_delayed_motions_wait_first():
    _, limits = random_limits(4)
    motion, wait = rest_to_rest(np.ones((COUNT, 3)), limits), np.linspace(0.0, 1.0, COUNT)
    assert_same(motion.delay(wait), concatenate_records([coast(wait), motion], axis=1))
