"""Honesty of the thrower's physics: without mismatch the plan comes true, and each effect does what is known of it."""

import numpy as np
import pytest

from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.hidden import draw_hidden, expected_hidden
from pnt_gym.cells.one_joint.plant import OneJointPlant
from pnt_gym.planning.one_joint.parameters import Block
from tests.tools.thrower import (
    EXAMPLE,
    NO_ERRORS,
    RELEASES,
    WEIGHTS,
    alone,
    closed_form,
    coming,
    fly,
    miss,
    state_at_goal,
    throws,
)

IDEAL = OneJointConfig.load("ideal")
BLOCK = Block(**IDEAL.block.model_dump())
G = 9.81


@pytest.fixture(scope="module")
def ideal():
    return fly(IDEAL, throws(RELEASES))


def at_release(flight, values):
    return values[np.arange(len(values)), flight.clock.release_step]


def test_the_flight_is_the_closed_form(ideal):
    time = ideal.time - ideal.release_time[:, None]
    counts = ideal.after_release & (time <= RELEASES[:, 3:])
    error = np.where(counts[..., None], ideal.pose - closed_form(RELEASES, time), 0.0)
    assert np.abs(error[..., :2]).max() < 0.0005
    assert np.abs(error[..., 2]).max() < np.deg2rad(0.01)


@pytest.mark.parametrize(("step", "share"), [(0.0005, 0.4), (0.001, 1.0), (0.002, 4.0)])
def test_the_state_at_the_goal_is_that_of_eq_11(step, share):
    """To 0.5 mm, 0.1 deg and 5 mm/s at 1 ms; the error is of second order in the step."""
    goal = state_at_goal(RELEASES)
    error = np.abs(fly(OneJointConfig.load("ideal", timestep=step), throws(RELEASES)).nearest(goal, WEIGHTS) - goal)
    assert error[:, :2].max() < 0.0005 * max(share, 0.2)
    assert error[:, 2].max() < np.deg2rad(0.1) * share
    assert error[:, 3].max() < 0.005 * share


def test_the_arm_is_where_and_as_fast_as_planned_at_the_release(ideal):
    np.testing.assert_allclose(ideal.release_angle, RELEASES[:, 0], atol=np.deg2rad(0.002))
    np.testing.assert_allclose(ideal.release_speed, RELEASES[:, 1], rtol=1e-5)


def test_the_part_leaves_with_the_velocity_of_its_place_on_the_arm(ideal):
    x, y = closed_form(RELEASES, np.zeros((len(RELEASES), 1)))[:, 0, :2].T
    velocity = at_release(ideal, ideal.velocity)
    np.testing.assert_allclose(velocity[:, 0], -RELEASES[:, 1] * y, atol=0.002)
    np.testing.assert_allclose(velocity[:, 1], RELEASES[:, 1] * x, atol=0.002)
    np.testing.assert_allclose(velocity[:, 2], RELEASES[:, 1], rtol=1e-5)


def test_energy_and_momentum_are_kept_in_flight(ideal):
    rate = ideal.velocity + 0.5 * ideal.step * np.array([0.0, -G, 0.0])
    energy = 0.5 * (rate[..., 0] ** 2 + rate[..., 1] ** 2) + G * ideal.pose[..., 1]
    for values, tolerance in ((energy, 1e-5), (ideal.velocity[..., 0], 1e-9), (ideal.velocity[..., 2], 1e-9)):
        start = values[np.arange(len(values)), ideal.clock.release_step + 1]
        drift = np.where(ideal.after_release, values - start[:, None], 0.0)
        drift[np.arange(len(values)), ideal.clock.release_step] = 0.0
        assert np.abs(drift).max() < tolerance


def test_the_motors_work_is_the_energy_that_arm_and_part_have_gained(ideal):
    """Kinetic energy of arm and block and the block's height at the release, against the torque's work."""
    arm = IDEAL.arm.arm()
    r2 = RELEASES[:, 2] ** 2
    kinetic = 0.5 * RELEASES[:, 1] ** 2 * (arm.inertia + BLOCK.inertia + BLOCK.mass * r2)
    height = closed_form(RELEASES, np.zeros((len(RELEASES), 1)))[:, 0, 1] - ideal.pose[:, 0, 1]
    before = np.arange(ideal.torque.shape[1]) <= ideal.clock.release_step[:, None]
    work = np.where(before, ideal.torque * ideal.arm_speed * ideal.step, 0.0).sum(axis=1)
    np.testing.assert_allclose(work, kinetic + BLOCK.mass * G * height, rtol=0.02)


def test_torque_stays_within_the_motors_limit(ideal):
    assert ideal.peak_torque.min() > 3.0
    assert fly(OneJointConfig.load("nominal"), throws(RELEASES)).peak_torque.max() <= IDEAL.arm.torque


@pytest.mark.parametrize(("delay", "low", "high"), [(0.005, 0.045, 0.062), (0.010, 0.090, 0.118)])
def test_a_delay_while_the_arm_brakes_lowers_the_flight_and_the_spin(delay, low, high):
    """At 194 rad/s2: 58 mm and 13 deg at 5 ms, 112 mm and 26 deg at 10 ms; the arm here brakes at 175."""
    error = miss(alone(delay=delay))[0]
    assert -high < error[1] < -low
    assert np.deg2rad(-3.2e3 * delay) < error[2] < np.deg2rad(-2.2e3 * delay)


def test_a_larger_radius_throws_higher():
    """3 mm: 7.4 mm higher and 26 mm/s faster at the same time (paper's goal); nearest to the goal, the former."""
    error = miss(alone(radius=0.003))[0]
    assert error[1] == pytest.approx(0.0074, abs=0.0006)
    assert abs(error[0]) < 0.003


def test_drag_slows_the_block_down():
    """Against the momentum that 0.5 rho C A v^2 takes at the mean speed and frontal area of the box."""
    still, blown = fly(alone(), throws(EXAMPLE)), fly(alone(drag=1.05), throws(EXAMPLE))
    row, last = 0, still.clock.release_step[0] + round(EXAMPLE[0, 3] / still.step)
    lost = still.velocity[row, last, :2] - blown.velocity[row, last, :2]
    speed = np.hypot(*still.velocity[row, still.clock.release_step[0] : last, :2].T).mean()
    for area, bound in ((0.03 * 0.03, np.greater), (0.03 * np.hypot(0.06, 0.03), np.less)):
        push = 0.5 * 1.2 * 1.05 * area * speed**2 / BLOCK.mass * EXAMPLE[0, 3]
        assert bound(np.hypot(*lost), 0.5 * push if bound is np.greater else push)
    assert lost @ still.velocity[row, last, :2] > 0.0


@pytest.mark.parametrize("error", [{"friction": 0.6}, {"inertia": 0.10}, {"viscous": 0.02}])
def test_the_controller_makes_up_for_most_of_what_the_joint_hides(error):
    """Feedback leaves less than 5 mm, but some."""
    free, hidden = fly(alone(), throws(EXAMPLE)), fly(alone(**error), throws(EXAMPLE))
    assert np.abs(hidden.torque - free.torque).max() > 0.05
    assert 1e-6 < np.abs(hidden.release_angle - free.release_angle).max() < np.deg2rad(0.2)
    assert np.abs(miss(alone(**error))[0, :2]).max() < 0.005


def test_the_mismatch_scales_the_errors_and_none_are_left_at_zero():
    generators = [np.random.default_rng(i) for i in range(4)]
    zero = draw_hidden(generators, IDEAL)
    assert not zero.radius.any()
    assert not zero.delay.any()
    assert not zero.noise.any()
    one, two = (
        draw_hidden([np.random.default_rng(i) for i in range(4)], OneJointConfig.load("nominal", mismatch=m))
        for m in (1.0, 2.0)
    )
    np.testing.assert_allclose(two.radius, 2.0 * one.radius, rtol=1e-12)
    np.testing.assert_allclose(two.noise, 2.0 * one.noise, rtol=1e-12)


def test_the_scatter_is_as_large_as_the_config_says():
    config = OneJointConfig.load("nominal")
    drawn = draw_hidden([np.random.default_rng(i) for i in range(2000)], config)
    assert drawn.radius.mean() == pytest.approx(config.errors.radius, abs=2e-5)
    assert drawn.radius.std() == pytest.approx(config.errors.placement, rel=0.08)
    assert drawn.delay.std() == pytest.approx(config.errors.timing, rel=0.08)
    assert drawn.noise[..., :2].std() == pytest.approx(config.camera.position, rel=0.01)
    assert np.rad2deg(drawn.noise[..., 2].std()) == pytest.approx(config.camera.angle_deg, rel=0.01)


@pytest.fixture(scope="module")
def by_contact():
    return fly(OneJointConfig.load("ideal", release="contact"), throws(RELEASES))


def test_the_outer_stopper_takes_spin_from_a_part_that_leaves_by_contact(by_contact):
    """Simulated elsewhere for the paper's goal: 3.6 to 4.8 rad/s at 175 rad/s2 and stoppers of 2 mm, within 11 ms."""
    rows, release = np.arange(len(RELEASES)), by_contact.clock.release_step
    after = by_contact.velocity[rows, release + round(0.020 / by_contact.step), 2]
    lost = RELEASES[:, 1] - after
    assert 3.0 < lost[0] < 6.0
    assert lost.min() > 2.0
    later = by_contact.velocity[rows, release + round(0.080 / by_contact.step), 2]
    np.testing.assert_allclose(later, after, rtol=1e-6)


def test_until_it_leaves_a_part_in_contact_stays_in_its_place(by_contact):
    held = np.arange(by_contact.pose.shape[1]) < by_contact.clock.release_step[:, None] - 1
    arm, (x, y, phi) = by_contact.arm_angle, np.moveaxis(by_contact.pose, -1, 0)
    along, across = x * np.cos(arm) + y * np.sin(arm), y * np.cos(arm) - x * np.sin(arm)
    radius = np.sqrt(RELEASES[:, 2:3] ** 2 - BLOCK.half_height**2)
    assert np.abs(np.where(held, along - radius, 0.0)).max() < 0.0005
    assert np.abs(np.where(held, across - BLOCK.half_height, 0.0)).max() < 0.0005
    assert np.abs(np.where(held, phi - arm, 0.0)).max() < np.deg2rad(0.5)


def test_a_recording_plays_the_throw_again():
    config = OneJointConfig.load("ideal")
    plant = OneJointPlant(config, 2)
    plant.record_row = 1
    plan = throws(RELEASES[:2])
    flight = plant.fly(coming(plan, expected_hidden(2, config)), plan)
    poses = [data.xpos[plant.recording.body].copy() for data, _ in plant.recording.play(config.timestep)]
    steps = len(poses) - 1
    np.testing.assert_array_equal(np.array(poses)[1:, [0, 2]], flight.pose[1, :steps, :2])
    np.testing.assert_allclose(plant.recording.plan[-1][[0, 2]], state_at_goal(RELEASES)[1, :2], atol=1e-9)


def test_without_errors_a_mismatch_of_one_is_the_ideal_world():
    assert fly(alone(), throws(RELEASES)).pose.tobytes() == fly(IDEAL, throws(RELEASES)).pose.tobytes()
    assert set(NO_ERRORS) == set(type(IDEAL.errors).model_fields)
