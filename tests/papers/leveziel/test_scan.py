"""kappa, tau, singularities and workspace of the 4-DoF gripper robot, and the paper's figures."""

import numpy as np
import pytest

from papers.leveziel.scan import scan_workspace, tau_hull
from pnt_gym.robots.gripper import (
    PROTOTYPE,
    Dimensions,
    conditioning,
    folding_speed,
    inverse_jacobian,
    inverse_kinematics,
    jacobian,
    jacobian_x,
    kappa,
    singular_angle,
    singularity,
    tau,
)

HOME = np.array([0.0, 0.0, -0.2, -np.pi / 4])


@pytest.fixture(scope="module")
def reduced():
    """The reduced workspace at -45 degrees, every 5 mm."""
    return scan_workspace(0.005)


def test_indices_are_equations_9_and_10_in_the_workspace_and_close_to_the_singularity(reduced):
    close = np.column_stack([np.tile([0.03, 0.02, -0.2], (200, 1)), np.linspace(0.5, 1.2, 200)])
    for poses, apart in ((reduced.poses, 0.0), (close, 1e-9)):
        forward = jacobian(poses)
        singular = np.linalg.svd(forward[:, :3], compute_uv=False)
        turned = np.linalg.norm(forward[:, 3], axis=1)
        np.testing.assert_allclose(kappa(poses), singular[:, -1] / singular[:, 0], rtol=1e-9, atol=apart)
        np.testing.assert_allclose(tau(poses), 1.0 / turned, rtol=1e-12, atol=1e-3 * apart)
        np.testing.assert_array_equal(conditioning(poses), (kappa(poses), tau(poses)))
    assert max(kappa(close).min(), tau(close).min()) < 0.01


def test_folding_speed_holds_the_platform_still(reduced):
    fold = folding_speed(reduced.poses)
    np.testing.assert_allclose(fold, 1.0 / np.linalg.norm(inverse_jacobian(reduced.poses)[..., 3], axis=1), rtol=1e-12)
    assert fold.min() == pytest.approx(0.85, abs=0.005)
    assert fold.max() == pytest.approx(2.56, abs=0.005)
    # Letting the platform drift never costs the motors more.
    assert (tau(reduced.poses) * fold <= 1.0 + 1e-12).all()


def test_the_scan_finds_what_the_inverse_kinematics_says(reduced):
    grid = 0.005 * np.stack(np.meshgrid(np.arange(-60, 61), np.arange(-60, 61), np.arange(-60, 1), indexing="ij"), -1)
    poses = np.append(grid.reshape(-1, 3), np.full((grid[..., 0].size, 1), -np.pi / 4), axis=1)
    for strokes, got in ((True, reduced), (False, scan_workspace(0.005, reduced=False))):
        want = poses[np.isfinite(inverse_kinematics(poses, strokes=strokes)[:, 0])]
        np.testing.assert_allclose(got.poses, want, atol=1e-15)


def test_singular_angles():
    assert np.rad2deg(singular_angle()) == pytest.approx(53.33, abs=0.005)
    assert np.rad2deg(singular_angle([0.0, 0.06, -0.2])) == pytest.approx(54.5, abs=0.05)
    positions = np.array([[0.05, -0.03, -0.19], [-0.08, 0.02, -0.21], [0.0, 0.0, -0.4]])
    angles = singular_angle(positions)
    assert np.isnan(angles[2])
    for shift, sign in ((-1e-7, 1.0), (1e-7, -1.0)):
        poses = np.column_stack([positions[:2], angles[:2] + shift])
        assert (np.sign(np.linalg.det(jacobian_x(poses))) == sign).all()
    assert singular_angle(np.zeros((0, 2, 3))).shape == (0, 2)


def test_singularity_is_the_determinant(reduced):
    got = singularity(reduced.poses)
    size = PROTOTYPE.l**4 * PROTOTYPE.w
    np.testing.assert_allclose(got.value, np.linalg.det(jacobian_x(reduced.poses)) / size, atol=1e-13)
    assert not got.mask.any()
    assert got.value[np.linalg.norm(reduced.positions - HOME[:3], axis=1) < 1e-9] == pytest.approx(0.989, abs=1e-3)
    assert singularity([0.0, 0.0, -0.2, np.deg2rad(54.0)]).mask
    assert np.isnan(singularity([0.0, 0.0, -0.5, 0.0]).value) and not singularity([0.0, 0.0, -0.5, 0.0]).mask


def test_tau_hull_bounds_the_curves(reduced):
    some = reduced.positions[::97]
    hull = tau_hull(some)
    assert hull.theta.shape == (101,) and hull.theta[0] == -np.pi / 2 and hull.theta[-1] == np.pi / 2
    for t in (0, 25, 50, 80, 100):
        poses = np.column_stack([some, np.full(len(some), hull.theta[t])])
        inside = np.isfinite(inverse_kinematics(poses, strokes=True)[:, 0])
        values = tau(poses[inside])
        assert (hull.low[t], hull.high[t], hull.count[t]) == (values.min(), values.max(), inside.sum())
    free = tau_hull(some, reduced=False)
    assert (free.count >= hull.count).all() and (free.count > hull.count).any()


def test_hull_of_nothing():
    hull = tau_hull(np.array([[0.0, 0.0, -0.5]]), [0.0, 1.0])
    assert np.isnan(hull.low).all() and np.isnan(hull.high).all() and (hull.count == 0).all()
    empty = scan_workspace(0.02, dimensions=Dimensions(stroke=(1.4, 1.5)))
    assert empty.positions.shape == (0, 3) and empty.volume == 0.0 and np.isnan(empty.extent).all()
    assert (tau_hull(empty.positions).count == 0).all()


def test_indices_are_nan_out_of_reach_and_keep_the_shape():
    poses = np.array([[[0.0, 0.0, -0.5, -0.8], HOME]])
    for values in (*conditioning(poses), kappa(poses), tau(poses), folding_speed(poses)):
        assert values.shape == (1, 2)
        assert np.isnan(values[0, 0]) and np.isfinite(values[0, 1])
    assert kappa(HOME).shape == () and conditioning(np.zeros((0, 4)))[0].shape == (0,)


def test_indices_do_not_depend_on_the_size_of_the_robot(reduced):
    for factor in (1e-3, 4.1, 1e3):
        size = [factor, factor, factor, 1.0]
        for big, small in zip(
            conditioning(reduced.poses[::50] * size, PROTOTYPE.with_scale(factor)),
            conditioning(reduced.poses[::50]),
            strict=True,
        ):
            np.testing.assert_allclose(big, small, rtol=1e-9)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: scan_workspace(0.0), "step"),
        (lambda: scan_workspace(np.nan), "step"),
        (lambda: scan_workspace(0.01, np.inf), "theta"),
        (lambda: tau_hull(np.zeros(3)), "positions"),
        (lambda: tau_hull(np.zeros((2, 4))), "positions"),
        (lambda: tau_hull(np.zeros((2, 3)), [[0.0]]), "theta"),
        (lambda: singular_angle([0.0, 0.0]), "position"),
    ],
)
def test_bad_arguments_are_refused(call, text):
    with pytest.raises(ValueError, match=text):
        call()
