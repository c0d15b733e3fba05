"""A hand that comes from a moving belt, or onto it, keeps its limits whatever it does besides."""

import numpy as np
import pytest

from pnt_gym.arrays import concatenate_records
from pnt_gym.planning.motion.kernel import fade, grow, superpose
from pnt_gym.planning.motion.limits import LimitRows, MotionLimits
from pnt_gym.planning.motion.riding import arrival_time, fastest_belt
from pnt_gym.planning.motion.scurve import accelerate, coast, rest_to_rest
from pnt_gym.planning.motion.trajectory import JerkTrajectory

COUNT = 2000


def random_limits(seed):
    """Of any scale, with A2 <= J V."""
    rng = np.random.default_rng(seed)
    velocity, acceleration = rng.uniform(0.5, 6.0, COUNT), np.exp(rng.uniform(np.log(2.0), np.log(120.0), COUNT))
    jerk = acceleration**2 / velocity * rng.uniform(1.0, 10.0, COUNT)
    return rng, LimitRows(velocity, acceleration, jerk)


def random_belt(seed):
    """A belt's speed for all, and limits of hands that can ride with it."""
    rng, limits = random_limits(seed)
    speed = (0.05, 0.25, 0.5, 0.8)[seed % 4]
    rows = fade(limits, speed, 0.0).is_possible
    assert rows.mean() > 0.2
    return rng, LimitRows(*(field[rows] for field in limits)), speed, int(rows.sum())


@pytest.mark.parametrize("seed", range(8))
def test_throws_from_the_belt_keep_limits_in_every_direction(seed):
    """Straight accelerations downstream are the worst of all motions; others are drawn beside them."""
    rng, limits, speed, count = random_belt(seed)
    fading = fade(limits, speed, 0.0)
    direction = rng.normal(size=(count, 3))
    direction[: count // 2] = [1.0, 0.0, 0.0]
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    distance = rng.uniform(0.001, 3.0, count)
    throw = accelerate(direction, distance, fading.left)
    belt = np.tile([speed, 0.0, 0.0], (count, 1))
    path = JerkTrajectory.concatenate(np.zeros((count, 3)), [superpose(throw, grow(fading.time, -speed, 2))], belt)
    peaks = path.peak_ratios(limits)
    for ratio in peaks:
        assert ratio.max() <= 1.0 + 1e-9
    # Downstream nothing is left over: acceleration begins against the fading, and comes to the limit after it.
    assert peaks.velocity.max() > 1.0 - 1e-9


@pytest.mark.parametrize("speed", [0.05, 0.25, 0.8])
@pytest.mark.parametrize("percents", [(40.0,), (30.0, 40.0, 45.0), (100.0,), (25.0, 60.0)])
def test_returns_onto_the_belt_keep_limits_with_and_without_a_descent(speed, percents):
    rng = np.random.default_rng(0)
    drop, count = 0.05, 300
    cell = LimitRows.t3kr(np.array(percents))
    if speed > fastest_belt(cell):
        pytest.skip("such a belt is refused")
    limits = MotionLimits.t3kr(rng.choice(percents, count))
    way = rng.uniform([-0.8, -1.0, -0.2], [0.8, 1.0, 0.2], (count, 3))
    way[:100] = [1.0, 0.0, 0.0] * rng.uniform(0.1, 1.5, (100, 1))
    down = np.tile([0.0, 0.0, -drop], (count, 1))
    for height, steps in ((0.0, [way]), (drop, [way, down])):
        growing = fade(limits.arrays(count), speed, arrival_time(cell, speed, height))
        parts = [coast(np.full(count, 0.3)), *(rest_to_rest(step, growing.left) for step in steps)]
        back = concatenate_records(parts, axis=1)
        begin = back.durations.sum(axis=1) - growing.time
        assert (begin > 0.0).all()
        growth = grow(growing.time, speed, 3)
        growth.durations[:, 0] = begin
        whole = superpose(back, growth)
        path = JerkTrajectory.concatenate(np.zeros((count, 3)), [whole])
        for ratio in path.peak_ratios(limits):
            assert ratio.max() <= 1.0 + 1e-9
        np.testing.assert_allclose(path.knots.velocity[:, -1], np.tile([speed, 0, 0], (count, 1)), atol=1e-9)
        ends = sum(steps) + growing.lead
        np.testing.assert_allclose(path.end, ends, atol=1e-9)


def test_a_known_descent_leaves_more_time():
    cell = LimitRows.t3kr(np.array([40.0]))
    assert arrival_time(cell, 0.25, 0.05) > 1.5 * arrival_time(cell, 0.25, 0.0)
    # A descent so high that hands come down at full speed is of no use.
    assert arrival_time(cell, 0.25, 3.0) == arrival_time(cell, 0.25, 0.0)


@pytest.mark.parametrize("percents", [(40.0,), (30.0, 40.0, 45.0), (100.0,), (10.0, 100.0)])
def test_the_fastest_belt_asks_for_the_whole_share_of_the_slowest_hand(percents):
    cell = LimitRows.t3kr(np.array(percents))
    speed = fastest_belt(cell)
    time = fade(cell, speed, 0.0).time.min()
    assert 2.0 * speed / time == pytest.approx(0.5 * cell.acceleration.min())
