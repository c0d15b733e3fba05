import numpy as np
import pytest

from pnt_gym.planning import (
    JerkTrajectory,
    MotionLimits,
    accelerate,
    brake,
    brake_distance,
    coast,
    min_time_scurve,
    rest_to_rest,
    speed_at,
)
from pnt_gym.planning.motion.kernel import superpose
from pnt_gym.planning.motion.rows import Segments
from tests.tools.planning import units


def throw_and_return(count=16, seed=3):
    """Accelerate, hold the speed for 20 ms, brake, wait, go back to the start."""
    rng = np.random.default_rng(seed)
    limits = MotionLimits.t3kr(rng.uniform(15.0, 100.0, count))
    direction, distance = units(rng, count), rng.uniform(0.02, 0.8, count)
    speed = speed_at(distance, limits)
    way = distance + 0.02 * speed + brake_distance(speed, limits)
    parts = [
        accelerate(direction, distance, limits),
        coast(np.full(count, 0.02)),
        brake(direction, speed, limits),
        coast(np.full(count, 0.1)),
        rest_to_rest(-way[:, None] * direction, limits),
    ]
    start = rng.normal(size=(count, 3))
    return JerkTrajectory.concatenate(start, parts), limits, direction, distance, speed


def test_round_trip_comes_back_to_rest_at_the_start():
    path, _, _, _, _ = throw_and_return()
    np.testing.assert_allclose(path.end, path.start, rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.knots.velocity[:, -1], 0.0, atol=1e-12)
    np.testing.assert_allclose(path.knots.acceleration[:, -1], 0.0, atol=1e-10)


def test_speed_and_place_at_the_release():
    path, limits, direction, distance, speed = throw_and_return()
    release = path.knot_times[:, 4]
    np.testing.assert_allclose(release, 0.5 * min_time_scurve(2.0 * distance, limits).duration, rtol=1e-12)
    position, velocity, acceleration = (x[:, 0] for x in path.sample(release[:, None]))
    np.testing.assert_allclose(position, path.start + distance[:, None] * direction, rtol=0, atol=1e-13)
    np.testing.assert_allclose(velocity, speed[:, None] * direction, rtol=0, atol=1e-12)
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-10)


def test_limits_are_reached_and_kept():
    path, limits, _, _, _ = throw_and_return()
    ratios = path.peak_ratios(limits)
    for ratio in ratios:
        assert ratio.max() <= 1.0 + 1e-9
    np.testing.assert_allclose(ratios.jerk, 1.0, rtol=1e-12)
    doubled = path.peak_ratios(limits.with_scale(0.5))
    for once, twice in zip(ratios, doubled, strict=True):
        np.testing.assert_allclose(2.0 * once, twice, rtol=1e-12)


def test_samples_agree_with_small_steps():
    path, _, _, _, _ = throw_and_return(count=4)
    step = 1e-5
    time = np.arange(0.0, path.duration.max() + 0.01, step)
    _, velocity, acceleration = path.sample(time)
    position = path.sample(time).position
    walked = path.start[:, None] + np.cumsum(0.5 * step * (velocity[:, 1:] + velocity[:, :-1]), axis=1)
    np.testing.assert_allclose(position[:, 1:], walked, rtol=0, atol=1e-7)
    gained = np.cumsum(0.5 * step * (acceleration[:, 1:] + acceleration[:, :-1]), axis=1)
    np.testing.assert_allclose(velocity[:, 1:], gained, rtol=0, atol=1e-6)


def test_times_in_any_order_give_what_each_gives_alone():
    """At borders, outside, and where several segments without duration begin together."""
    rng = np.random.default_rng(5)
    durations = rng.random((6, 9)) * (rng.random((6, 9)) < 0.6)
    path = JerkTrajectory(rng.normal(size=(6, 3)), durations, rng.normal(size=(6, 9, 3)))
    times = rng.permuted(np.concatenate([path.knot_times, rng.uniform(-1.0, 10.0, (6, 40))], axis=1), axis=1)
    together, jerk = path.sample(times), path.jerk(times)
    for k in range(times.shape[1]):
        alone = path.sample(times[:, k : k + 1])
        for values, one in zip(together, alone, strict=True):
            np.testing.assert_array_equal(values[:, k], one[:, 0])
        np.testing.assert_array_equal(jerk[:, k], path.jerk(times[:, k : k + 1])[:, 0])
    np.testing.assert_allclose(path.sample(path.knot_times).velocity, path.knots.velocity, atol=1e-12)


def test_rest_to_rest_matches_the_scalar_curve():
    limits = MotionLimits.t3kr(35)
    move = np.array([[0.3, -0.4, 0.0]])
    path = JerkTrajectory.concatenate(np.zeros((1, 3)), [rest_to_rest(move, limits)])
    time = np.linspace(-0.05, 0.6, 400)
    curve = min_time_scurve(0.5, limits)
    for ours, reference in zip(path.sample(time), curve.sample(time), strict=True):
        np.testing.assert_allclose(ours[0], reference[:, None] * move / 0.5, rtol=0, atol=1e-11)


def test_a_move_of_nothing_takes_no_time_beside_others():
    moves = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    path = JerkTrajectory.concatenate(np.ones((2, 3)), [rest_to_rest(moves, MotionLimits.t3kr(35))])
    assert path.duration[0] == 0.0
    np.testing.assert_array_equal(path.sample(np.linspace(0.0, 0.3, 7)).position[0], 1.0)


def test_quickest_stop_is_the_mirrored_start():
    limits = MotionLimits.t3kr(60)
    distance = np.linspace(0.001, 1.0, 50)
    speed = speed_at(distance, limits)
    curve = min_time_scurve(2.0 * distance, limits)
    no_cruise = distance - 0.5 * curve.durations[:, 3] * speed
    np.testing.assert_allclose(brake_distance(speed, limits), no_cruise, rtol=1e-12)
    with pytest.raises(ValueError, match="speed"):
        brake_distance(np.array([-1.0]), limits)


@pytest.mark.parametrize(
    ("start", "durations", "jerks", "word"),
    [
        (np.zeros((2, 2)), np.ones((2, 1)), np.zeros((2, 1, 3)), "start"),
        (np.zeros((2, 3)), np.ones((3, 1)), np.zeros((2, 1, 3)), "durations"),
        (np.zeros((2, 3)), np.ones((2, 1)), np.zeros((2, 2, 3)), "jerks"),
        (np.zeros((1, 3)), -np.ones((1, 1)), np.zeros((1, 1, 3)), "negative"),
        (np.zeros((1, 3)), np.full((1, 1), np.nan), np.zeros((1, 1, 3)), "finite"),
        (np.full((1, 3), np.nan), np.ones((1, 1)), np.zeros((1, 1, 3)), "finite"),
    ],
)
def test_bad_paths_are_refused(start, durations, jerks, word):
    with pytest.raises(ValueError, match=word):
        JerkTrajectory(start, durations, jerks)


def test_bad_times_are_refused():
    path = JerkTrajectory(np.zeros((2, 3)), np.ones((2, 1)), np.zeros((2, 1, 3)))
    with pytest.raises(ValueError, match="times"):
        path.sample(np.zeros((3, 4)))


def random_segments(rng, count, columns):
    """Segments of which some have no duration."""
    durations = rng.uniform(0.0, 0.2, (count, columns)) * (rng.random((count, columns)) < 0.7)
    return Segments(durations, rng.normal(size=(count, columns, 3)))


def test_superposed_motions_are_those_of_arrays_to_the_last_bit():
    rng = np.random.default_rng(8)
    parts = [random_segments(rng, 60, columns) for columns in (4, 7)]
    parts[1].durations[:9, 1:5] = parts[0].durations[:9]
    parts[1].durations[:9, 0] = 0.0
    whole = superpose(*parts)
    ends = [np.cumsum(part.durations, axis=1) for part in parts]
    borders = np.sort(np.concatenate(ends, axis=1), axis=1)
    np.testing.assert_array_equal(whole.durations, np.diff(borders, axis=1, prepend=0.0))
    middle = borders - 0.5 * whole.durations
    index = [(middle[:, :, None] > end[:, None, :]).sum(axis=2)[..., None] for end in ends]
    jerks = [np.pad(part.jerks, ((0, 0), (0, 1), (0, 0))) for part in parts]
    expected = [np.take_along_axis(jerk, k, axis=1) for jerk, k in zip(jerks, index, strict=True)]
    np.testing.assert_array_equal(whole.jerks, expected[0] + expected[1])


def test_borders_are_those_of_arrays_to_the_last_bit():
    rng = np.random.default_rng(9)
    part, (start, velocity, acceleration) = random_segments(rng, 60, 6), rng.normal(size=(3, 60, 3))
    path = JerkTrajectory(start, part.durations, part.jerks, velocity, acceleration)

    def running_sum(first, increments):
        return np.cumsum(np.concatenate([first[:, None], increments], axis=1), axis=1)

    d, jerks = part.durations[:, :, None], part.jerks
    a = running_sum(acceleration, d * jerks)
    v = running_sum(velocity, d * (a[:, :-1] + 0.5 * d * jerks))
    p = running_sum(start, d * (v[:, :-1] + 0.5 * d * (a[:, :-1] + d * jerks / 3.0)))
    for border, expected in zip(path.knots, (p, v, a), strict=True):
        np.testing.assert_array_equal(border, expected)
    np.testing.assert_array_equal(path.knot_times[:, 1:], np.cumsum(part.durations, axis=1))
    np.testing.assert_array_equal(path.knot_times[:, 0], 0.0)


def test_times_of_all_paths_are_times_of_each():
    part = random_segments(np.random.default_rng(10), 12, 6)
    path, times = JerkTrajectory(np.zeros((12, 3)), part.durations, part.jerks), np.linspace(-0.1, 1.5, 70)
    for values, expected in zip(path.sample(times), path.sample(np.tile(times, (12, 1))), strict=True):
        np.testing.assert_array_equal(values, expected)
    np.testing.assert_array_equal(path.jerk(times), path.jerk(np.tile(times, (12, 1))))


def test_a_path_rests_outside_or_rides():
    start, belt = np.zeros((1, 3)), np.array([[0.5, 0.0, 0.0]])
    parts = [Segments(np.array([[0.2]]), np.array([[[0.0, 1.0, 0.0]]]))]
    rest, ride = (JerkTrajectory.concatenate(start, parts, belt, rides=rides) for rides in (False, True))
    inside = np.linspace(0.0, 0.2, 9)
    for a, b in zip(rest.sample(inside), ride.sample(inside), strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(rest.sample([-0.1]).position[0, 0], start[0])
    np.testing.assert_allclose(ride.sample([-0.1]).position[0, 0], [-0.05, 0.0, 0.0])
    end = rest.sample([0.2])
    np.testing.assert_allclose(ride.sample([0.3]).position, end.position + 0.1 * end.velocity)
    np.testing.assert_allclose(ride.sample([0.3]).velocity, end.velocity)
    assert not rest.sample([0.3]).velocity.any()
