"""The reproduction of Leveziel et al.: circle, moves, closing of the gripper, the robot alone, and tables."""

import numpy as np
import pytest
from scipy.optimize import fsolve

from papers.leveziel import cases as leveziel_cases
from papers.leveziel import circle as leveziel_circle
from papers.leveziel import closing as leveziel_closing
from papers.leveziel import formulas as leveziel_formulas
from papers.leveziel import moves as leveziel_moves
from papers.leveziel.cases import poses_at
from papers.leveziel.motion import joint_deviation
from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper.references import motor_references
from tests.tools.leveziel import ALL, HOME, L, allowed, angles_of, findings, row


def test_the_share_of_the_circle() -> None:
    axis = 0.0005 * (np.arange(-400, 400) + 0.5)
    x, y = np.meshgrid(axis, axis)
    for height in (-0.2, -0.24):
        poses = poses_at(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)]), HOME)
        inside = allowed(poses)
        found = leveziel_circle.shares(height, HOME, 0.001)
        assert found.area == pytest.approx(np.pi * 0.08**2 / (inside.sum() * 0.0005**2), rel=2e-3)
        nearest = np.hypot(*poses[~inside, :2].T).min()
        assert found.inscribed == pytest.approx(nearest, abs=0.001)
    assert (
        leveziel_circle.shares(-0.24, HOME, 0.001).inscribed
        < 0.08
        < leveziel_circle.shares(-0.235, HOME, 0.001).inscribed + 0.001
    )


def test_the_circle_covers_almost_80_percent_only_where_it_just_fits() -> None:
    found = row("circle", "circle/area")
    assert found.details["share"] == pytest.approx(38.0, abs=0.5)
    assert found.details["share_240"] == pytest.approx(79.6, abs=1.0)
    assert found.details["inscribed_240_m"] < 0.08
    largest = row("circle", "circle/largest-area").details
    assert [share for _, share in largest["by_angle"].values()] == sorted(s for _, s in largest["by_angle"].values())
    assert 75.0 < largest["by_angle"]["-30"][1] < 80.0
    assert max(largest["all_angles"].values()) < 75.0


def test_the_circle_keeps_the_platform_angle_in_the_model() -> None:
    assert row("circle", "circle/theta").reproduced < 0.1
    assert row("circle", "circle/theta").details["radius_error_m"] < 2e-4
    assert 0.5 < row("circle", "circle/time-of-a-turn").reproduced < 1.5


def closed_at(q: Floats, guess: Floats) -> Floats:
    """Pose that the motor angles hold, by a general solver on the printed closure in mm."""

    def gaps(p: Floats) -> Floats:
        pose = np.array([[1e-3 * p[0], 1e-3 * p[1], 1e-3 * p[2], p[3]]])
        return 1e3 * (leveziel_formulas.forearm_lengths(pose, q[None])[0] - 1e-3 * L)

    return np.asarray(fsolve(gaps, guess, xtol=1e-13))


@pytest.mark.parametrize("name", ["z", "y", "x"])
def test_joint_linear_moves_turn_the_halves(name: str) -> None:
    found = row("moves", f"moves/joint-linear-{name}")
    assert found.verdict == "differs"
    for degrees, turned in found.details["by_theta"].items():
        theta = np.deg2rad(float(degrees))
        first, last = (poses_at(np.array([place]), theta) for place in leveziel_moves.MOVES[name])
        q_first, q_last = angles_of(first)[0], angles_of(last)[0]
        changes = []
        for share in np.linspace(0.0, 1.0, 33):
            guess = np.append(1e3 * (first + share * (last - first))[0, :3], theta)
            pose = closed_at(q_first + share * (q_last - q_first), guess)
            changes.append(np.rad2deg(pose[3] - theta))
        assert turned == pytest.approx(max(changes, key=abs), abs=0.01)
        assert 1.2 < abs(turned) < 3.5


def test_the_model_moves_as_the_closed_form_says() -> None:
    assert abs(row("moves", "simulated/cartesian").reproduced) < 0.1
    assert row("moves", "moves/cartesian").reproduced == 0.0
    found = row("moves", "simulated/joint-linear")
    assert found.details["gap"] < 0.1
    assert row("moves", "simulated/cartesian").details["torque"] < 3.0
    assert set(found.details["by_move"]) == set(findings("moves").data["leveziel_moves"])


def test_random_moves_stay_in_the_workspace_and_shorter_pieces_turn_less() -> None:
    first, last = leveziel_moves.random_moves(200)
    assert len(first) == 200
    assert allowed(first).all()
    assert allowed(last).all()
    ways = np.linalg.norm((last - first)[:, :3], axis=1)
    assert 0.05 <= ways.min() < ways.max() <= 0.10
    assert (first[:, 3] == last[:, 3]).all()
    assert np.isfinite(joint_deviation(first, last).theta).all()
    pieces = list(row("moves", "moves/joint-linear-in-pieces").details["by_pieces"].values())
    # The deviation falls with the square of the length.
    assert pieces[0] / pieces[1] == pytest.approx(4.0, abs=0.6)
    assert pieces[1] / pieces[2] == pytest.approx(4.0, abs=0.4)


def test_distances_from_a_line() -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.01, 0.003, 0.004], [0.02, 0.0, -0.002]])
    away = leveziel_moves.line_distance(points, np.zeros(3), np.array([0.03, 0.0, 0.0]))
    np.testing.assert_allclose(away, [0.0, 0.005, 0.002], atol=1e-15)


def test_closing_takes_as_long_as_the_servo_takes() -> None:
    poses = np.array([[0.0, 0.0, -0.2, np.deg2rad(-45.0)], [0.0, 0.0, -0.2, np.deg2rad(-60.0)]])
    travel = np.rad2deg(np.abs(np.diff(angles_of(poses), axis=0)).max())
    quickest = row("closing", "closing/speed-limited")
    assert quickest.reproduced == pytest.approx(travel / (70.0 * 6.0), rel=1e-3)
    assert row("closing", "closing/acceleration-for-60-ms").reproduced == pytest.approx(4.0 * travel / 0.06**2)
    stiff, factory = row("closing", "closing/servo-limited"), row("closing", "closing/servo-limited-factory-gain")
    assert quickest.reproduced < stiff.reproduced < factory.reproduced < 0.060
    assert stiff.details["smooth"] == pytest.approx(0.053, abs=0.003)
    assert all(0.045 < value < 0.075 for value in factory.details["armatures"].values())


def test_the_gripper_is_closed_when_it_first_comes_near() -> None:
    theta = np.deg2rad([-45.0, -55.0, -59.4, -59.6, -60.2, -59.0])
    assert leveziel_closing.arrival(theta) == pytest.approx(4 * leveziel_cases.STEP)
    assert np.isnan(leveziel_closing.arrival(theta[:3]))


def test_a_robot_that_is_told_to_stand_stands_with_closed_loops() -> None:
    start = poses_at(np.array([[0.0, 0.0, -0.2], [0.03, -0.04, -0.22]]), np.deg2rad(-50.0))
    told = np.repeat(start[:, None], 80, axis=1)
    done = leveziel_cases.follow(start, motor_references(told, leveziel_cases.STEP))
    assert done.pose.shape == done.q.shape == done.torque.shape == (2, 80, 4)
    np.testing.assert_allclose(done.pose[..., :3], told[..., :3], atol=1e-5)
    # Feed-forward leaves the small torque out that the halves' own weight asks for.
    np.testing.assert_allclose(done.pose[..., 3], told[..., 3], atol=np.deg2rad(0.05))
    lengths = leveziel_formulas.forearm_lengths(done.pose.reshape(-1, 4), done.q.reshape(-1, 4))
    np.testing.assert_allclose(lengths, 1e-3 * L, atol=2e-5)


def test_tables_hold_every_row() -> None:
    moves, *others = findings("moves").grids
    assert "a move turns" in moves.headline
    assert len(moves.rows) == 9
    assert moves.rows[0][:2] == ["50 mm in z", "-60 deg"]
    assert moves.rows[0][3] == "-3.45 deg"
    assert sum(len(grid.rows) for grid in others) + 3 == len(findings("moves").rows)


@pytest.mark.nightly
def test_every_row_of_a_part_stands_in_its_tables() -> None:
    for name in set(ALL) - {"moves"}:
        assert sum(len(grid.rows) for grid in findings(name).grids) == len(findings(name).rows)
