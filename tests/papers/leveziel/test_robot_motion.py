"""Motions of the 4-DoF gripper robot under its motors' limits."""

import numpy as np
import pytest

from papers.leveziel.motion import Profile, circle, closing_time, joint_deviation, joint_move, line
from papers.leveziel.scan import scan_workspace
from pnt_gym.robots.gripper import (
    MOTOR_SPEED,
    JointLimits,
    PoseError,
    forward_kinematics,
    inverse_kinematics,
    travel_time,
)
from tests.tools.gripper import DOWN, UP, pose

MOVES = [
    lambda **options: line(DOWN, UP, **options),
    lambda **options: line(pose(20, -30, -190, -30), pose(-30, 40, -230, -60), **options),
    lambda **options: joint_move(DOWN, pose(0, 70, -200, -55), **options),
    circle,
]
PROFILES = [Profile(), Profile("trapezoid", 0.5), Profile("s-curve", 0.3)]


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("profile", PROFILES)
def test_a_motion_uses_its_limits_and_no_more(move, profile):
    free = move(profile=profile)
    assert np.abs(free.speed).max() == pytest.approx(MOTOR_SPEED, rel=1e-12)
    peak = np.abs(free.acceleration).max()
    gentle = move(profile=profile, limits=JointLimits(acceleration=peak / 9.0))
    assert gentle.duration == pytest.approx(3.0 * free.duration, rel=1e-12)
    assert np.abs(gentle.acceleration).max() == pytest.approx(peak / 9.0, rel=1e-12)
    assert np.abs(gentle.speed).max() < MOTOR_SPEED
    slow = move(profile=profile, limits=JointLimits(speed=MOTOR_SPEED / 2.0))
    assert slow.duration == pytest.approx(2.0 * free.duration, rel=1e-12)


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("profile", PROFILES)
def test_samples_belong_together(move, profile):
    """Angles hold the poses; speed and acceleration are their derivatives by central differences."""
    motion = move(profile=profile, samples=2001)
    np.testing.assert_allclose(forward_kinematics(motion.q, start=motion.pose), motion.pose, atol=1e-12)
    step = motion.time[1]
    speed = (motion.q[2:] - motion.q[:-2]) / (2.0 * step)
    np.testing.assert_allclose(speed, motion.speed[1:-1], atol=1e-3 * MOTOR_SPEED)
    change = (motion.speed[2:] - motion.speed[:-2]) / (2.0 * step)
    apart = np.abs(change - motion.acceleration[1:-1]).max(axis=1) / np.abs(motion.acceleration).max()
    # A trapezoid's acceleration jumps at the two ends of the plateau, where differences see half of it.
    assert np.sort(apart)[-5] < 0.01


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("profile", PROFILES)
def test_a_motion_runs_from_rest_to_rest(move, profile):
    motion = move(profile=profile)
    assert motion.time[0] == 0.0 and motion.time[-1] == motion.duration > 0.0
    np.testing.assert_allclose(np.diff(motion.time), motion.time[1], rtol=1e-9)
    assert np.abs(motion.speed[[0, -1]]).max() < 1e-9


def test_a_line_is_straight_and_keeps_theta():
    motion = line(pose(-50, 20, -190, -52), pose(40, -30, -230, -52))
    assert np.ptp(motion.pose[:, 3]) == 0.0
    way = motion.pose[-1, :3] - motion.pose[0, :3]
    offset = motion.pose[:, :3] - motion.pose[0, :3]
    assert np.abs(np.cross(offset, way)).max() < 1e-15
    assert (np.diff(offset @ way) > 0.0).all()
    np.testing.assert_allclose(motion.pose[[0, -1]], [pose(-50, 20, -190, -52), pose(40, -30, -230, -52)], atol=1e-15)


@pytest.mark.parametrize("degrees", [-60.0, -45.0, -30.0])
def test_the_circle_of_the_experiments(degrees):
    motion = circle((0.0, 0.0, -0.22), np.deg2rad(degrees))
    np.testing.assert_allclose(np.hypot(*motion.pose[:, :2].T), 0.080, rtol=1e-12)
    assert np.ptp(motion.pose[:, 2:], axis=0).max() == 0.0
    turned = np.unwrap(np.arctan2(motion.pose[:, 1], motion.pose[:, 0]))
    assert turned[-1] - turned[0] == pytest.approx(2.0 * np.pi, rel=1e-12)
    assert np.abs(motion.speed).max() == pytest.approx(MOTOR_SPEED)


def test_joint_moves_are_synchronised_and_reach_both_ends():
    motion = joint_move(DOWN, UP)
    np.testing.assert_allclose(motion.pose[[0, -1]], [DOWN, UP], atol=1e-12)
    share = (motion.q - motion.q[0]) / (motion.q[-1] - motion.q[0])
    assert np.ptp(share, axis=1).max() < 1e-12
    travel = np.abs(inverse_kinematics(UP) - inverse_kinematics(DOWN)).max()
    # A trapezoid with ramps of a quarter takes 4/3 of the time at constant speed.
    assert motion.duration == pytest.approx(travel / MOTOR_SPEED * 4.0 / 3.0, rel=1e-12)


def test_deviation_is_that_of_the_motion():
    start, end = pose(-20, 10, -180, -40), pose(30, 60, -220, -55)
    motion = joint_move(start, end, samples=1001)
    share = (motion.q[:, 0] - motion.q[0, 0]) / (motion.q[-1, 0] - motion.q[0, 0])
    turned = motion.pose[:, 3] - (start[3] + share * (end[3] - start[3]))
    got = joint_deviation(np.stack([start, end]), np.stack([end, start]), samples=1001)
    assert got.theta[0] == pytest.approx(turned[np.abs(turned).argmax()], rel=1e-4)
    np.testing.assert_allclose(got.theta[0], got.theta[1], rtol=1e-4)
    offset, way = motion.pose[:, :3] - start[:3], (end - start)[:3]
    apart = np.linalg.norm(np.cross(offset, way), axis=1) / np.linalg.norm(way)
    assert got.path[0] == pytest.approx(apart.max(), rel=1e-4)
    folding = joint_deviation(UP, pose(0, 0, -200, -60))
    assert folding.path < 1e-12


def test_closing_over_the_workspace_takes_11_to_42_milliseconds():
    seconds = closing_time(scan_workspace(0.005).positions)
    assert np.nanmin(seconds) == pytest.approx(11e-3, abs=5e-4)
    assert np.nanmax(seconds) == pytest.approx(42e-3, abs=5e-4)
    assert np.isnan(seconds).mean() < 1e-3


def test_travel_time_bounds_every_motion_along_the_line():
    assert travel_time(DOWN, UP) == pytest.approx(78e-3, abs=5e-4)
    assert travel_time(UP, DOWN) == pytest.approx(float(travel_time(DOWN, UP)), rel=1e-12)
    for profile in PROFILES:
        assert line(DOWN, UP, profile=profile).duration > travel_time(DOWN, UP)
    # Nearly all of the time at the limit of the worst motor: the bound by an independent integral of the rates.
    share = np.linspace(0.0, 1.0, 20_001)[:, None]
    q = inverse_kinematics(DOWN + share * (UP - DOWN))
    seconds = np.abs(np.diff(q, axis=0)).max(axis=1).sum() / MOTOR_SPEED
    assert travel_time(DOWN, UP) == pytest.approx(seconds, rel=1e-4)
    assert travel_time(DOWN, UP, speed=2.0 * MOTOR_SPEED) == pytest.approx(seconds / 2.0, rel=1e-4)


def test_what_leaves_the_reach_is_nan():
    assert closing_time(np.zeros((2, 0, 3))).shape == (2, 0)
    assert np.isnan(joint_deviation(UP, pose(0, 0, -400, -45)).theta)


def test_standing_still_takes_no_time():
    for motion in (line(UP, UP), joint_move(UP, UP)):
        assert motion.duration == 0.0
        assert (motion.speed == 0.0).all()


@pytest.mark.parametrize("profile", PROFILES)
def test_profiles_are_their_own_derivatives(profile):
    time = np.linspace(0.0, 1.0, 4001)
    progress, rate, bend = profile.sample(time)
    assert progress[0] == 0.0 and progress[-1] == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(np.gradient(progress, time)[1:-1], rate[1:-1], atol=2e-3)
    assert np.abs(rate - rate[::-1]).max() < 1e-9
    assert rate.max() == pytest.approx(1.0 / (1.0 - profile.ramp), rel=1e-9)
    assert np.sum(bend) * time[1] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: line(UP, pose(0, 0, -350, -45)), "arm 2 would stand at -85"),
        (lambda: line(pose(0, 0, -200, 40), pose(0, 0, -200, 60)), "singularity"),
        (lambda: joint_move(UP, pose(0, 120, -130, -45)), "arm"),
        (lambda: circle(radius=0.2), "arm"),
        (lambda: circle(radius=-0.1), "radius"),
        (lambda: circle([[0.0, 0.0, -0.2]]), "centre"),
        (lambda: line([UP], DOWN), "start"),
        (lambda: line(UP, DOWN, samples=2), "samples"),
        (lambda: joint_deviation(UP, [DOWN]), "one row each"),
        (lambda: joint_deviation(UP, DOWN, samples=2), "samples"),
        (lambda: Profile("cubic"), "cubic"),
        (lambda: Profile(ramp=0.6), "ramp"),
    ],
)
def test_bad_arguments_are_refused(call, text):
    with pytest.raises(ValueError, match=text):
        call()


def test_errors_are_the_houses():
    with pytest.raises(PoseError):
        joint_move(UP, pose(0, 0, -500, -45))
