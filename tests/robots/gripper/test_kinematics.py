"""Closure, inverse and forward kinematics and Jacobians of the 4-DoF gripper robot."""

import numpy as np
import pytest

from pnt_gym.robots.gripper import (
    PROTOTYPE,
    PoseError,
    check_pose,
    closure_excess,
    forward_kinematics,
    inverse_jacobian,
    inverse_kinematics,
    jacobian,
    jacobian_q,
    jacobian_x,
    singularity,
)

K, R, L, U, V, W = 0.0825, 0.080, 0.223, 0.040, 0.0135, 0.0265
HOME = np.array([0.0, 0.0, -0.2, -np.pi / 4])
OUTWARD = np.array([1.0, 1.0, -1.0, -1.0])


def paper_angles(q):
    """The paper's q, all counted from +x or +y, from outward ones."""
    return np.where(OUTWARD > 0, q, np.pi - q)


def excess_of_points(pose, q):
    """Half of |A_i B_i|^2 - l^2 from the paper's points, for its angles q; complex arguments too."""
    x, y, z, t = np.moveaxis(np.asarray(pose), -1, 0)
    zero, side = np.zeros_like(x), V + W * np.cos(t)
    lift = z + W * np.sin(t)
    a = [(x + U, y, z), (x, y + side, lift), (x - U, y, z), (x, y - side, lift)]
    c, s = R * np.cos(q), R * np.sin(q)
    b = [
        (c[..., 0] + K, zero, s[..., 0]),
        (zero, c[..., 1] + K, s[..., 1]),
        (c[..., 2] - K, zero, s[..., 2]),
        (zero, c[..., 3] - K, s[..., 3]),
    ]
    squares = [sum((p - e) ** 2 for p, e in zip(ai, bi, strict=True)) for ai, bi in zip(a, b, strict=True)]
    return 0.5 * (np.stack(squares, axis=-1) - L**2)


def derivative(function, at):
    """Columns of the derivative by complex steps: exact to rounding."""
    return np.stack([function(at + 1e-40j * e).imag / 1e-40 for e in np.eye(4)], axis=-1)


def random_poses(count, seed=0, theta=(-60.0, -30.0)):
    """Random poses within the reduced workspace, uniform in position and angle."""
    low, high = np.deg2rad(theta)
    poses = np.random.default_rng(seed).uniform(
        [-0.16, -0.15, -0.28, low], [0.16, 0.15, -0.12, high], (8 * count + 100, 4)
    )
    inside = np.isfinite(inverse_kinematics(poses, strokes=True)).all(axis=1)
    assert inside.sum() >= count
    return poses[inside][:count]


POSES = random_poses(2000)


@pytest.mark.parametrize("branch", [1, -1, [1, -1, -1, 1]])
def test_forearms_keep_their_length_in_every_branch(branch):
    poses = np.random.default_rng(1).uniform([-0.2, -0.2, -0.3, -1.5], [0.2, 0.2, -0.02, 1.5], (20_000, 4))
    q = inverse_kinematics(poses, branch=branch)
    good = np.isfinite(q[:, 0])
    assert 2000 < good.sum() < 18_000
    assert (np.isnan(q).any(axis=1) == np.isnan(q).all(axis=1)).all()
    assert np.abs(excess_of_points(poses[good], paper_angles(q[good]))).max() < 1e-15


def test_closure_excess_is_that_of_the_papers_points():
    q = np.random.default_rng(2).uniform(-1.5, 1.5, POSES.shape)
    np.testing.assert_allclose(closure_excess(POSES, q), excess_of_points(POSES, paper_angles(q)), atol=1e-16)


def test_out_of_reach_is_where_the_papers_condition_fails():
    """Eq. 7 with D, E, F expanded from the closure equations, arm by arm."""
    poses = np.random.default_rng(3).uniform([-0.3, -0.3, -0.35, -1.5], [0.3, 0.3, 0.0, 1.5], (50_000, 4))
    x, y, z, t = poses.T
    lift, side = z + W * np.sin(t), V + W * np.cos(t) - K
    arms = [(x + U - K, y, z), (y + side, x, lift), (U - K - x, y, z), (side - y, x, lift)]
    reached = np.ones(len(poses), dtype=bool)
    for out, along, up in arms:
        d, e, f = 2 * R * up, 2 * R * out, out**2 + along**2 + up**2 + R**2 - L**2
        reached &= d**2 + e**2 >= f**2
    assert 0.02 < reached.mean() < 0.5
    assert (np.isfinite(inverse_kinematics(poses)).all(axis=1) == reached).all()


def test_working_branch_has_the_elbows_outward():
    out, inward = inverse_kinematics(POSES), inverse_kinematics(POSES, branch=-1)
    both = np.isfinite(inward[:, 0])
    assert both.any()
    assert (np.cos(out[both]) > np.cos(inward[both])).all()


def test_home_of_the_prototype_is_symmetric_with_room_to_both_sides():
    q = np.rad2deg(inverse_kinematics(HOME))
    assert q[0] == pytest.approx(q[2], abs=1e-12)
    assert q[1] == pytest.approx(q[3], abs=1e-12)
    assert (q > -85 + 45).all() and (q < 45 - 45).all()


def test_strokes_count_outward_and_upward():
    poses = np.random.default_rng(4).uniform([-0.2, -0.2, -0.3, -1.0], [0.2, 0.2, -0.05, -0.5], (20_000, 4))
    q, bounded = inverse_kinematics(poses), inverse_kinematics(poses, strokes=True)
    within = ((q >= np.deg2rad(-85)) & (q <= np.deg2rad(45))).all(axis=1)
    assert within.any() and (~within & np.isfinite(q[:, 0])).any()
    assert np.isnan(bounded[~within]).all()
    assert (bounded[within] == q[within]).all()
    # With the platform at x > 0, below arm 1, that arm is lifted and arm 3 lowered.
    tilted = inverse_kinematics([0.1, 0.0, -0.2, -np.pi / 4])
    assert tilted[0] > 0.2 and tilted[2] < -0.2


def test_round_trip_over_the_reduced_workspace():
    poses = random_poses(10_000, seed=5)
    back = forward_kinematics(inverse_kinematics(poses, strokes=True))
    assert np.abs(back - poses).max() < 1e-12


@pytest.mark.parametrize("theta", [(-90.0, -60.0), (-30.0, 0.0), (0.0, 40.0), (40.0, 55.0)])
def test_round_trip_at_other_angles_up_to_the_singularity(theta):
    poses = random_poses(3000, seed=6, theta=theta)
    held = singularity(poses).value > 1e-4
    assert held.mean() > 0.5
    back = forward_kinematics(inverse_kinematics(poses))
    assert np.abs(back - poses)[held].max() < 1e-9


def test_another_assembly_mode_is_never_returned():
    poses = random_poses(3000, seed=7, theta=(45.0, 80.0))
    value = singularity(poses).value
    lost = poses[value < 0.0]
    assert len(lost) > 500
    back = forward_kinematics(inverse_kinematics(lost))
    found = np.isfinite(back[:, 0])
    # The same angles may also hold a pose in the robot's own mode, but never the lost one itself.
    assert (np.abs(back - lost)[found].max(axis=1) > 1e-6).all()
    assert (singularity(back[found]).value > 0.0).all()
    # Not even when the search starts there.
    again = forward_kinematics(inverse_kinematics(lost), start=lost)
    assert (singularity(again[np.isfinite(again[:, 0])]).value > 0.0).all()


def test_a_start_far_off_does_not_lead_through_a_singularity():
    """Free Newton steps would end with the platform above the base."""
    poses = np.array(
        [[-0.1181605, 0.12828087, -0.1349891, 0.14359478], [-0.11887323, 0.12122112, -0.15984247, 0.7105894]]
    )
    start = np.array(
        [[0.09825311, -0.07081131, -0.15753455, 0.69651707], [0.07357672, -0.08523963, -0.15169112, 0.456298]]
    )
    q = inverse_kinematics(poses)
    found = forward_kinematics(q, start=start)
    assert (np.isnan(found) | np.isclose(found, poses)).all()
    np.testing.assert_allclose(forward_kinematics(q), poses, atol=1e-9)


def test_any_angles_give_a_pose_that_they_hold_or_nan():
    q = np.random.default_rng(8).uniform(*PROTOTYPE.stroke, (4000, 4))
    poses = forward_kinematics(q)
    found = np.isfinite(poses[:, 0])
    assert found.any() and (~found).any()
    assert (np.isnan(poses).any(axis=1) == ~found).all()
    assert np.abs(excess_of_points(poses[found], paper_angles(q[found]))).max() < 1e-14
    assert (np.linalg.det(jacobian_x_at(poses[found], q[found])) > 0).all()


def jacobian_x_at(poses, q):
    angles = paper_angles(q)
    return derivative(lambda p: excess_of_points(p, angles), poses)


def test_warm_start_gives_the_same_pose():
    q = inverse_kinematics(POSES)
    near = POSES + np.random.default_rng(9).uniform(-5e-3, 5e-3, POSES.shape)
    np.testing.assert_allclose(forward_kinematics(q, start=near), POSES, atol=1e-12)
    np.testing.assert_allclose(forward_kinematics(q[:3], start=near[0]), POSES[:3], atol=1e-12)


def test_nan_angles_give_nan_and_leave_the_rest_alone():
    q = inverse_kinematics(POSES[:4])
    q[1, 2] = np.nan
    back = forward_kinematics(q)
    assert np.isnan(back[1]).all()
    np.testing.assert_allclose(back[[0, 2, 3]], POSES[[0, 2, 3]], atol=1e-12)
    assert np.isnan(forward_kinematics(inverse_kinematics([0.0, 0.0, -0.5, -0.8]))).all()


@pytest.mark.parametrize("branch", [1, [1, -1, 1, 1]])
def test_jx_and_jq_are_the_derivatives_of_the_closure(branch):
    q = inverse_kinematics(POSES, branch=branch)
    good = np.isfinite(q[:, 0])
    assert good.sum() > 100
    poses, angles = POSES[good], paper_angles(q[good])
    j_x = derivative(lambda p: excess_of_points(p, angles), poses)
    j_q = -derivative(lambda a: excess_of_points(poses, a), angles)
    np.testing.assert_allclose(jacobian_x(poses, branch=branch), j_x, atol=1e-15)
    # dq_outward = -dq for arms 3 and 4.
    np.testing.assert_allclose(jacobian_q(poses, branch=branch), j_q * OUTWARD, atol=1e-15)


def test_jacobian_and_its_inverse():
    forward, inverse = jacobian(POSES), inverse_jacobian(POSES)
    np.testing.assert_allclose(forward, np.linalg.solve(jacobian_x(POSES), jacobian_q(POSES)), atol=1e-13)
    np.testing.assert_allclose(forward @ inverse, np.broadcast_to(np.eye(4), forward.shape), atol=1e-11)


def test_jacobians_are_nan_out_of_reach():
    poses = np.array([[0.0, 0.0, -0.5, -0.8], HOME])
    for function in (jacobian_x, jacobian_q, jacobian, inverse_jacobian):
        values = function(poses)
        assert np.isnan(values[0]).all() and np.isfinite(values[1]).all()


@pytest.mark.parametrize("shape", [(), (1,), (5,), (2, 3), (0,)])
def test_shapes(shape):
    poses = np.broadcast_to(HOME, (*shape, 4))
    q = inverse_kinematics(poses)
    assert q.shape == (*shape, 4)
    assert forward_kinematics(q).shape == (*shape, 4)
    assert closure_excess(poses, q).shape == (*shape, 4)
    for function in (jacobian_x, jacobian_q, jacobian, inverse_jacobian):
        assert function(poses).shape == (*shape, 4, 4)


@pytest.mark.parametrize("count", [1, 3, 7, 8, 9, 33])
def test_a_pose_does_not_depend_on_its_batch(count):
    q = inverse_kinematics(POSES[:40])
    for function, values in ((inverse_kinematics, POSES[:40]), (forward_kinematics, q), (jacobian, POSES[:40])):
        whole = function(values)
        for start in range(0, 40 - count + 1):
            part = slice(start, start + count)
            assert (function(values[part]) == whole[part]).all()


def test_more_rows_than_one_piece():
    poses = np.tile(POSES, (3, 1))
    q = inverse_kinematics(poses)
    assert (q == np.tile(inverse_kinematics(POSES), (3, 1))).all()
    assert (forward_kinematics(q) == np.tile(forward_kinematics(q[:2000]), (3, 1))).all()


@pytest.mark.parametrize("function", [inverse_kinematics, jacobian, check_pose, singularity])
@pytest.mark.parametrize(
    ("pose", "text"),
    [
        ([0.0, 0.0, -0.2], r"\(3,\)"),
        (0.0, r"\(\)"),
        ([0.0, np.nan, -0.2, 0.0], "nan"),
        ([[0.0, 0.0, -0.2, 0.0], [0.0, 0.0, -np.inf, 0.0]], "inf"),
    ],
)
def test_what_is_no_pose_is_refused(function, pose, text):
    with pytest.raises(PoseError, match=text):
        function(pose)


def test_other_bad_arguments_are_refused():
    q = inverse_kinematics(HOME)
    for call, text in [
        (lambda: inverse_kinematics(HOME, branch=0), "branch"),
        (lambda: inverse_kinematics(HOME, branch=[1, 1]), "branch"),
        (lambda: forward_kinematics(q[:3]), "q must have shape"),
        (lambda: forward_kinematics([np.inf, 0, 0, 0]), "inf"),
        (lambda: forward_kinematics([q, q], start=[HOME]), "start"),
        (lambda: forward_kinematics(q, start=[0, 0, np.nan, 0]), "start"),
        (lambda: closure_excess(HOME, [q, q]), "one row each"),
    ]:
        with pytest.raises(PoseError, match=text):
            call()


def test_far_away_poses_are_out_of_reach_without_a_warning():
    assert np.isnan(inverse_kinematics([[1e200, 0, -0.2, 0], [0, 0, -1e308, 0]])).all()
