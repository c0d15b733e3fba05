"""Reading a flight: where it passes nearest to a goal, where it ends, and what the camera sees of it."""

from dataclasses import replace

import numpy as np
import pytest

from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.hidden import expected_hidden
from pnt_gym.cells.one_joint.measure import CONTACT_TIME, MIN_FRAMES, estimated_state, film
from pnt_gym.cells.one_joint.pallets import SORTING
from pnt_gym.cells.one_joint.plant import LATEST_FLIGHT, MARGIN, OneJointPlant
from tests.tools.thrower import EXAMPLE, RELEASES, WEIGHTS, G, closed_form, coming, fly, state_at_goal, throws

IDEAL = OneJointConfig.load("ideal")


@pytest.fixture(scope="module")
def flights():
    return fly(IDEAL, throws(RELEASES))


@pytest.fixture(scope="module")
def caught():
    """A block thrown into the second pallet at 0.5 ms, where contacts are finer."""
    config = OneJointConfig.load("ideal", task="sort", timestep=0.0005)
    u = np.array([[0.71076469, 9.3998815, 0.25716435, 0.25860198]])
    plant, plan = OneJointPlant(config, 1), throws(u)
    return plant.fly(coming(plan, expected_hidden(1, config)), plan)


def brute_force(u, goal, weights):
    """The nearest of many states of a drag-free flight."""
    time = np.linspace(0.0, 1.15 * u[3] + 0.11, 300_000)
    pose = closed_form(u[None], time[None])[0]
    states = np.concatenate([pose, (u[1] * pose[0, 0] - G * time)[:, None]], axis=1)
    return states[(((states - goal) * weights) ** 2).sum(axis=1).argmin()]


@pytest.mark.parametrize("weights", [(1.0, 1.0, 0.1, 0.1), (1.0, 1.0, 0.0, 0.0), (1.0, 1.0, 1.0, 0.3)])
def test_the_nearest_state_is_that_of_a_fine_search(flights, weights):
    rng = np.random.default_rng(0)
    goal = state_at_goal(RELEASES) + rng.normal(size=(len(RELEASES), 4)) * [0.03, 0.03, 0.2, 0.2]
    found = flights.nearest(goal, np.array(weights))
    for row, u in enumerate(RELEASES):
        wanted = brute_force(u, goal[row], np.array(weights))
        assert (np.abs(found[row] - wanted) < [0.0006, 0.0006, 0.002, 0.003]).all(), row


def test_the_nearest_state_does_not_depend_on_what_lies_before_the_release(flights):
    goal = state_at_goal(RELEASES)
    held = ~flights.after_release
    spoilt = replace(flights, pose=np.where(held[..., None], goal[:, None, :3], flights.pose))
    np.testing.assert_array_equal(spoilt.nearest(goal, WEIGHTS), flights.nearest(goal, WEIGHTS))


def test_a_flight_that_nothing_stops_is_free_to_its_end(flights):
    np.testing.assert_array_equal(flights.free, flights.after_release)
    assert not flights.touches().any()


def test_a_flight_into_a_pallet_is_free_until_it_touches(caught):
    assert caught.touches()[0].tolist() == [False, True, False]
    free = np.flatnonzero(caught.free[0])
    assert caught.after_release[0].sum() > free.size > 100
    np.testing.assert_array_equal(np.diff(free), 1)
    fall = np.diff(caught.velocity[0, free, 1]) / caught.step
    np.testing.assert_allclose(fall[1:], -9.81, atol=1e-6)
    hit = (caught.velocity[0, free[-1] + 1, 1] - caught.velocity[0, free[-1], 1]) / caught.step
    assert abs(hit + 9.81) > 1.0


def test_a_flight_that_ends_at_a_pallet_is_carried_on_to_its_goal(caught):
    goal = SORTING[1].state[None]
    assert (np.abs(caught.nearest(goal, WEIGHTS) - goal) < [5e-4, 5e-4, 2e-3, 5e-3]).all()
    resting = caught.final_pose[0, 0]
    assert np.hypot(*(resting[:2] - goal[0, :2])) > 1e-4


def test_a_flight_is_carried_on_beyond_the_simulation(flights):
    """A goal on the same parabola 80 ms later than simulated."""
    late = RELEASES.copy()
    late[:, 3] = LATEST_FLIGHT * RELEASES[:, 3] + MARGIN + 0.08
    goal = state_at_goal(late)
    assert (np.abs(flights.nearest(goal, WEIGHTS) - goal) < [5e-4, 5e-4, 2e-3, 5e-3]).all()


def test_frames_are_taken_from_the_release_to_the_planned_arrival(flights):
    frames = film(flights, RELEASES[:, 3], np.zeros((len(RELEASES), 450, 3)), IDEAL)
    seconds = frames.is_valid.sum(axis=1) / IDEAL.camera.rate
    np.testing.assert_allclose(seconds, RELEASES[:, 3], atol=0.0011)
    assert frames.time[frames.is_valid].min() > 0.0
    assert (frames.time.max(axis=1) <= RELEASES[:, 3]).all()
    assert not frames.pose[~frames.is_valid].any()


@pytest.mark.parametrize(("rate", "spacing"), [(1000.0, 0.001), (200.0, 0.005), (60.0, 0.017)])
def test_frames_come_at_the_cameras_rate(flights, rate, spacing):
    config = OneJointConfig.load("ideal", camera={"rate": rate})
    frames = film(flights, RELEASES[:, 3], np.zeros((len(RELEASES), 400, 3)), config)
    time = frames.time[0, frames.is_valid[0]]
    np.testing.assert_allclose(np.diff(time), spacing, rtol=1e-9)


def test_a_part_that_leaves_by_contact_is_watched_when_it_is_clear():
    config = OneJointConfig.load("ideal", release="contact")
    flight = fly(config, throws(EXAMPLE))
    frames = film(flight, EXAMPLE[:, 3], np.zeros((1, 400, 3)), config)
    assert frames.time[frames.is_valid].min() == pytest.approx(CONTACT_TIME, abs=0.001)
    spin = np.diff(frames.pose[0, frames.is_valid[0], 2])
    np.testing.assert_allclose(spin, spin[0], rtol=1e-6)


@pytest.mark.parametrize(("release", "rate"), [("contact", 1000.0), ("ideal", 50.0)])
def test_a_flight_planned_to_be_short_is_still_seen(release, rate):
    config, short = OneJointConfig.load("ideal", release=release, camera={"rate": rate}), EXAMPLE.copy()
    short[:, 3] = 0.005
    flight, noise = fly(config, throws(short)), np.zeros((1, 400, 3))
    assert film(flight, short[:, 3], noise, config).is_valid.sum() == MIN_FRAMES
    assert np.isfinite(estimated_state(flight, short[:, 3], state_at_goal(EXAMPLE), noise, config)).all()


def test_a_part_that_is_stopped_at_once_is_still_seen(flights):
    stopped = replace(flights, pushed=np.ones_like(flights.pushed))
    frames = film(stopped, RELEASES[:, 3], np.zeros((len(RELEASES), 400, 3)), IDEAL)
    assert (frames.is_valid.sum(axis=1) == MIN_FRAMES).all()
    noise, goal = np.zeros((len(RELEASES), 400, 3)), state_at_goal(RELEASES)
    assert np.isfinite(estimated_state(stopped, RELEASES[:, 3], goal, noise, IDEAL)).all()


def test_more_frames_make_a_better_estimate(flights):
    goal, rng = state_at_goal(RELEASES), np.random.default_rng(1)
    errors = []
    for frames in (20, 400):
        config = OneJointConfig.load("ideal", camera={"frames": frames})
        runs = []
        for _ in range(40):
            noise = rng.normal(size=(len(RELEASES), frames, 3)) * [0.0003, 0.0003, np.deg2rad(0.17)]
            runs.append(estimated_state(flights, RELEASES[:, 3], goal, noise, config) - goal)
        errors.append(np.sqrt((np.array(runs) ** 2).mean(axis=(0, 1))))
    assert (errors[1] < 0.5 * errors[0]).all()
    assert (errors[1] < [0.0005, 0.0005, np.deg2rad(0.2), 0.005]).all()
