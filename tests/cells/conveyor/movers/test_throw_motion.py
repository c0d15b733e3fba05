"""The hand's path through a pick keeps every limit, has no jump, and ends above and then at the next pick."""

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.sections import FollowThrough
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows, MotionLimits
from pnt_gym.planning.straight.release import plan_release_batch
from tests.tools.throws import is_feasible, make_core, straight_cycle, straight_motion, straight_mover

COUNT, CLEARANCE = 400, 0.05
FOLLOWS = (
    FollowThrough(window=0.080),
    FollowThrough(window=0.0),
    FollowThrough(window=0.030, gravity_share=0.9),
)


def random_throws(seed=0, count=COUNT):
    rng = np.random.default_rng(seed)
    pick = rng.uniform([-0.3, -0.45, -0.88], [0.3, -0.20, -0.80], (count, 3))
    target = rng.uniform([-0.5, 0.25, -0.85], [0.5, 0.75, -0.85], (count, 3))
    limits = LimitRows.t3kr(rng.choice([15.0, 30.0, 45.0, 100.0], count))
    release = plan_release_batch(pick, target, limits, ceiling=pick[:, 2] + 0.10)
    rows = np.flatnonzero(release.feasible)
    release = plan_release_batch(pick[rows], target[rows], take(limits, rows), ceiling=pick[rows, 2] + 0.10)
    wait = np.where(rng.random(rows.size) < 0.5, 0.0, rng.uniform(0, 0.5, rows.size))
    following = rng.uniform([-0.3, -0.45, -0.88], [0.3, -0.20, -0.80], (rows.size, 3))
    return pick[rows], release, take(limits, rows), wait, following


@pytest.fixture(scope="module", params=range(len(FOLLOWS)))
def cycle(request):
    follow = FOLLOWS[request.param]
    pick, release, limits, wait, following = random_throws(request.param)
    motion = straight_motion(pick, release, limits, follow)
    path = straight_cycle(motion, limits, wait, following, CLEARANCE)
    return follow, pick, release, limits, wait, following, motion, path


def test_norms_of_velocity_acceleration_and_jerk_stay_within_the_limits(cycle):
    _, _, _, limits, *_, path = cycle
    peaks = path.peak_ratios(limits)
    for ratio in peaks:
        assert ratio.max() <= 1.0 + 1e-9
    # The path is as fast as the limits allow somewhere: the check above is not one of a hand that stands still.
    assert peaks.jerk.min() > 1.0 - 1e-9


def test_release_and_stop_are_the_planned_ones(cycle):
    _, pick, release, *_, motion, path = cycle
    state = path.sample(motion.release_time[:, None])
    np.testing.assert_allclose(state.position[:, 0], release.position, atol=1e-9)
    np.testing.assert_allclose(state.velocity[:, 0], release.velocity, atol=1e-9)
    np.testing.assert_allclose(motion.release_time, release.time, atol=1e-9)
    np.testing.assert_array_equal(path.start, pick)
    state = path.sample(motion.stop_time[:, None])
    np.testing.assert_allclose(state.position[:, 0], motion.stop, atol=1e-9)
    np.testing.assert_allclose(state.velocity[:, 0], 0.0, atol=1e-9)
    way = motion.stop - pick
    np.testing.assert_allclose(np.cross(way, release.direction), 0.0, atol=1e-12)


def test_shaped_braking_keeps_the_hand_above_a_falling_object():
    """With a share of gravity below 1, the object falls away from the hand at every moment after the release."""
    pick, release, limits, wait, following = random_throws(5)
    gaps = []
    for share in (0.9, None):
        motion = straight_motion(pick, release, limits, FollowThrough(window=0.0, gravity_share=share))
        path = straight_cycle(motion, limits, wait, following, CLEARANCE)
        after = np.linspace(0.0, 1.0, 50) * (motion.stop_time - motion.release_time)[:, None]
        hand = path.sample(motion.release_time[:, None] + after).position[..., 2]
        fall = release.position[:, 2:] + release.velocity[:, 2:] * after - 0.5 * 9.81 * after**2
        gaps.append((hand - fall).min(axis=1))
    assert gaps[0].min() > -1e-9
    steep = release.angle > 0.4
    assert steep.any()
    assert (gaps[1] < 0.0)[steep].mean() > 0.5


def test_braking_is_never_harder_than_the_limits():
    pick, release, limits, *_ = random_throws(6)
    steep, full = release.angle > 0.01, limits.acceleration
    for share in (0.5, None):
        motion = straight_motion(pick, release, limits, FollowThrough(gravity_share=share))
        last = motion.segments.durations[:, 5:, None] * motion.segments.jerks[:, 5:]
        hardest = np.abs(np.cumsum(last, axis=1)).max(axis=1)
        assert (np.linalg.norm(hardest, axis=1) <= full * (1 + 1e-9)).all()
        falls_softly = hardest[:, 2] <= 0.5 * 9.81 * (1 + 1e-9)
        assert falls_softly[steep].all() if share else not falls_softly[steep].all()


def test_staying_inside_is_about_pick_release_and_stop():
    pick, release, limits, *_ = random_throws(7)
    follow = FollowThrough(window=0.08)
    workspace = EllipticWorkspace(0.45, 0.80, -0.95, 0.0)
    inside = straight_mover(follow, workspace).is_feasible(pick, release, limits)
    motion = straight_motion(pick, release, limits, follow)
    points = np.stack([pick, release.position, motion.stop], axis=1)
    ellipse = (points[..., 0] / 0.45) ** 2 + (points[..., 1] / 0.80) ** 2
    high = (points[..., 2] >= -0.95) & (points[..., 2] <= 0.0)
    np.testing.assert_array_equal(inside, ((ellipse <= 1.0) & high).all(axis=1))
    assert 0.05 < inside.mean() < 0.95


def test_a_throw_that_does_not_exist_does_not_stay_inside():
    core = make_core("nominal_plain", 3)
    pick = core.context.pick
    nowhere = plan_release_batch(pick, pick + np.array([0.0, 0.0, 0.1]), MotionLimits.t3kr(40.0))
    assert not nowhere.feasible.any()
    assert not is_feasible(core, nowhere).any()
    assert is_feasible(core, core.context.plan).all()
