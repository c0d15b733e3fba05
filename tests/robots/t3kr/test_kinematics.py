"""Geometry and closed-form kinematics of the T3KR-class robot."""

import numpy as np
import pytest

from pnt_gym.robots.t3kr.geometry import T3KR, T3krGeometry
from pnt_gym.robots.t3kr.kinematics import (
    closed_pose,
    closed_velocity,
    forward_kinematics,
    inverse_kinematics,
    jacobian,
)
from tests.tools.t3kr import WORKSPACE


def workspace_points():
    """Points all over the workspace, its boundary included."""
    radius, angle, z = np.meshgrid(
        np.linspace(0.0, 1.0, 9), np.linspace(0.0, 2 * np.pi, 33), np.linspace(-0.95, 0.0, 14), indexing="ij"
    )
    x, y = WORKSPACE.semi_x * radius * np.cos(angle), WORKSPACE.semi_y * radius * np.sin(angle)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3)


POINTS = workspace_points()


def elbows(q, geometry=T3KR):
    """Elbow positions (..., 4, 3), straight from the definition of the arm angle."""
    azimuth = np.deg2rad([75.0, 105.0, 255.0, 285.0])
    out = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(4)], axis=-1)
    pivots = np.array([[0.30, 0.15, 0.55], [-0.30, 0.15, 0.55], [-0.30, -0.15, 0.55], [0.30, -0.15, 0.55]])
    lift = np.sin(q)[..., None] * [0.0, 0.0, 1.0]
    return pivots + geometry.arm_length * (np.cos(q)[..., None] * out + lift)


def platform_joints(tcp):
    """Platform joints (..., 4, 3)."""
    corner = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * 0.10 / np.sqrt(2)
    return tcp[..., None, :] + np.column_stack([corner, np.full(4, 0.10)])


def test_whole_workspace_is_reachable_and_rods_have_their_length():
    q = inverse_kinematics(POINTS)
    assert np.isfinite(q).all()
    rods = np.linalg.norm(elbows(q) - platform_joints(POINTS), axis=-1)
    np.testing.assert_allclose(rods, 1.05, atol=1e-13)


def test_elbows_point_outward():
    q = inverse_kinematics(POINTS)
    higher = inverse_kinematics(POINTS) + 1e-3
    # Of the two closures, the outward one is left by lifting the arm only with a longer rod.
    rods = np.linalg.norm(elbows(higher) - platform_joints(POINTS), axis=-1)
    assert (rods > 1.05).all()
    assert np.rad2deg(q).min() > -100.0
    assert np.rad2deg(q).max() < 55.0


def test_round_trip_over_the_workspace():
    np.testing.assert_allclose(forward_kinematics(inverse_kinematics(POINTS)), POINTS, atol=1e-12)


def test_forward_kinematics_of_inconsistent_angles_is_the_best_fit():
    q = inverse_kinematics([0.1, -0.3, -0.6]) + np.array([1e-3, -2e-3, 1.5e-3, 0.5e-3])
    point = forward_kinematics(q)

    def misfit(tcp):
        return ((np.linalg.norm(elbows(q) - platform_joints(tcp), axis=-1) - 1.05) ** 2).sum()

    assert misfit(point) > 1e-9
    for shift in np.vstack([np.eye(3), -np.eye(3)]) * 1e-5:
        assert misfit(point + shift) > misfit(point)


def test_out_of_reach_is_nan_for_all_arms():
    points = np.array([[0.0, 0.0, -1.6], [2.0, 0.0, -0.5], [0.0, -1.9, -0.6], [0.0, 0.0, -0.6]])
    for values in (inverse_kinematics(points), jacobian(points).reshape(4, 12), closed_pose(points)):
        assert np.isnan(values[:3]).all()
        assert np.isfinite(values[3]).all()
    short_rods = T3krGeometry(arm_length=0.95, rod_length=0.90)
    assert np.isnan(forward_kinematics(np.zeros(4), short_rods)).all()


def test_one_arm_out_of_reach_makes_the_pose_unreachable():
    reach = inverse_kinematics(np.random.default_rng(3).uniform(-2, 1, (4000, 3)))
    bad = np.isnan(reach)
    assert bad.any() and not bad.all()
    assert (bad.all(axis=1) == bad.any(axis=1)).all()


def test_the_ellipse_is_stricter_than_the_mechanism():
    corner = np.array([0.45, 0.65, -0.85])
    assert np.isfinite(inverse_kinematics(corner)).all()
    assert not WORKSPACE.contains(corner)


@pytest.mark.parametrize("shape", [(), (1,), (5,), (2, 3), (0,)])
def test_shapes(shape):
    points = np.broadcast_to([0.1, -0.2, -0.6], (*shape, 3))
    q = inverse_kinematics(points)
    assert q.shape == (*shape, 4)
    assert forward_kinematics(q).shape == (*shape, 3)
    assert jacobian(points).shape == (*shape, 4, 3)


@pytest.mark.parametrize("count", [1, 2, 3, 5, 7, 8, 9, 64])
def test_a_pose_does_not_depend_on_its_batch(count):
    points = np.random.default_rng(count).uniform([-0.3, -0.5, -0.9], [0.3, 0.5, 0.0], (64, 3))
    q = inverse_kinematics(points)
    for function, values in ((inverse_kinematics, points), (jacobian, points), (forward_kinematics, q)):
        whole = function(values)
        for start in range(0, 64 - count + 1):
            part = slice(start, start + count)
            assert (function(values[part]) == whole[part]).all()


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("arm_length", 0.0),
        ("rod_length", -1.05),
        ("rod_mass", np.nan),
        ("kp", np.inf),
        ("torque_limit", -530.0),
        ("arm_azimuth", 2.0),
        ("z_min", 0.5),
        ("arm_com", 0.9),
        ("arm_length", 0.2),
        ("colour", 1.0),
    ],
)
def test_impossible_geometry_is_refused_by_name(field, value):
    with pytest.raises(ValueError, match=field):
        T3krGeometry(**{field: value})


def test_another_geometry_is_used_throughout():
    other = T3krGeometry(arm_length=0.85, rod_length=1.10, attach_radius=0.12, arm_azimuth=1.0)
    points = POINTS[::7]
    q = inverse_kinematics(points, other)
    assert np.isfinite(q).all()
    assert np.abs(q - inverse_kinematics(points)).max() > 0.05
    np.testing.assert_allclose(forward_kinematics(q, other), points, atol=1e-12)


@pytest.mark.parametrize("rods", [1, 2])
def test_closed_velocities_are_the_derivative_of_closed_poses(rods):
    rng, step = np.random.default_rng(0), 1e-6
    points = POINTS[np.isfinite(closed_pose(POINTS)).all(axis=1)]
    velocity = rng.normal(size=points.shape)
    ahead, behind = (closed_pose(points + sign * step * velocity, rods) for sign in (1.0, -1.0))
    known = np.isfinite(ahead).all(axis=1) & np.isfinite(behind).all(axis=1)
    assert known.mean() > 0.9
    slope = ((ahead - behind) / (2.0 * step))[known]
    found = closed_velocity(points, velocity, rods)[known]
    chains = 4 * (1 + 2 * rods) + 3
    assert found.shape[1] == chains + (3 if rods == 2 else 0)
    np.testing.assert_allclose(found[:, :chains], slope[:, :chains], rtol=1e-5, atol=1e-6)
    # Neither does the platform turn.
    np.testing.assert_array_equal(found[:, chains:], 0.0)
    np.testing.assert_array_equal(slope[:, chains:], 0.0)


def test_a_pose_out_of_reach_has_no_velocity():
    found = closed_velocity([[0.0, 0.0, -0.7], [3.0, 0.0, -0.7]], [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1]).all()
