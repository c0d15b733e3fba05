"""Dimensions of the 4-DoF gripper robot, and which poses it says it can take."""

import subprocess
import sys

import numpy as np
import pytest

from papers.leveziel.scan import scan_workspace
from pnt_gym.robots.gripper import (
    PROTOTYPE,
    Dimensions,
    PoseError,
    check_pose,
    forward_kinematics,
    inverse_kinematics,
    jacobian,
)


def reduced_poses():
    return np.concatenate([scan_workspace(0.02, np.deg2rad(theta)).poses for theta in (-60.0, -45.0, -30.0)])


@pytest.mark.parametrize(
    ("pose", "text"),
    [
        ([0, 0, -0.4, -0.8], r"arm 1 is out of reach, 0.4023 m .* 0.143 to 0.303 m"),
        ([0.25, 0, -0.2, -0.8], "arm 2 is out of reach, 0.25 m beside"),
        ([0.0, 0.12, -0.13, -0.8], r"arm \d would stand at .* stroke is -85 to 45 deg"),
        ([0, 0, -0.2, np.deg2rad(55)], r"singularity.* below 53\.33 deg"),
        ([0, 0, -0.2, np.deg2rad(-20)], r"theta is -20\.00 deg; it must lie in -60 to -30 deg"),
        ([[0, 0, -0.2, -0.8], [0, 0, -0.2, -1.2]], r"row 1.*theta is -68\.75 deg"),
    ],
)
def test_check_pose_says_what_is_out(pose, text):
    with pytest.raises(PoseError, match=text):
        check_pose(pose)


def test_check_pose_accepts_what_the_robot_can_take():
    check_pose(reduced_poses())
    check_pose([0, 0, -0.2, np.deg2rad(52)], theta_limits=False)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"k": 0.0}, "k is 0"),
        ({"l": -0.2}, "l is -0.2"),
        ({"r": np.nan}, "r must be finite"),
        ({"w": "wide"}, "w must be a number"),
        ({"u": True}, "u must be a number"),
        ({"stroke": (1.0, -1.0)}, "stroke"),
        ({"stroke": 3.0}, "stroke must be two angles"),
        ({"theta": (-0.5, 2.0)}, "theta"),
        ({"theta": (-0.5, -0.2)}, "home_theta"),
        ({"home_z": 0.1}, "home_z"),
        ({"l": 0.1}, "cannot bridge"),
        ({"home_z": -0.4}, "cannot bridge"),
        ({"colour": "red"}, "unknown dimension 'colour'; .*home_theta"),
    ],
)
def test_impossible_dimensions_are_refused_by_name(changes, text):
    with pytest.raises(ValueError, match=text):
        Dimensions.from_mapping(changes)


def test_dimensions_from_a_mapping():
    other = Dimensions.from_mapping({"l": 0.25, "stroke": [-1.4, 0.7], "home_z": -0.22})
    assert (other.l, other.stroke, other.k) == (0.25, (-1.4, 0.7), PROTOTYPE.k)


def test_the_prototype_follows_the_papers_proportions():
    """Guidelines r, 2 (k - u) and l / 3 within 15 % of each other."""
    sizes = [PROTOTYPE.r, 2 * (PROTOTYPE.k - PROTOTYPE.u), PROTOTYPE.l / 3]
    assert max(sizes) / min(sizes) < 1.15


def test_a_scaled_robot_moves_alike():
    big = PROTOTYPE.with_scale(4.1)
    poses = reduced_poses()
    grown = poses * [4.1, 4.1, 4.1, 1.0]
    q = inverse_kinematics(grown, big)
    np.testing.assert_allclose(q, inverse_kinematics(poses), atol=1e-12)
    np.testing.assert_allclose(forward_kinematics(q, big), grown, atol=1e-11)
    np.testing.assert_allclose(jacobian(grown, big)[:, 3], jacobian(poses)[:, 3], atol=1e-12)
    with pytest.raises(ValueError, match="scale factor"):
        PROTOTYPE.with_scale(0.0)


def test_importing_the_robot_does_not_import_mujoco():
    code = "import sys, pnt_gym.robots.gripper; print('mujoco' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
