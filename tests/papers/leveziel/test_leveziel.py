"""The reproduction of Leveziel et al.: workspace, indices and formulas against independent calculations."""

import numpy as np
import pytest
from scipy.optimize import brentq

from papers.leveziel import indices as leveziel_indices
from papers.leveziel import workspace as leveziel_workspace
from papers.leveziel.cases import arm_positions, is_reachable, lowest_pose, poses_at, random_poses, reduced
from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper import PROTOTYPE, inverse_kinematics, jacobian_q, jacobian_x, kappa, tau
from tests.tools.leveziel import ALL, HOME, PIXEL, STEP, K, L, R, V, W, allowed, angles_of, findings, row
from tests.tools.reproduced import assert_plain


@pytest.mark.parametrize("name", ALL)
def test_rows_and_data_are_plain_json_and_figures_are_drawings(name: str) -> None:
    found = findings(name)
    assert_plain(found, "leveziel")
    for r in found.rows:
        assert r.note, r.quantity
    assert found.grids
    assert all(grid.rows and len(line) == len(grid.header) for grid in found.grids for line in grid.rows)
    for file, drawing in found.figures.items():
        assert file.startswith("leveziel_")
        assert drawing.count("<path") > 10


def test_quantities_differ_between_parts() -> None:
    quantities = [r.quantity for name in ALL for r in findings(name).rows]
    assert len(set(quantities)) == len(quantities)


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "quantity"), [("kappa", "fig-5/smallest-kappa"), ("singular_angle", "video/first-singular-angle")]
)
def test_a_wrong_index_shows_in_the_verdict(monkeypatch: pytest.MonkeyPatch, name: str, quantity: str) -> None:
    before, right = row("workspace", quantity), getattr(leveziel_workspace, name)
    monkeypatch.setattr(leveziel_workspace, name, lambda at: 0.8 * right(at))
    after = {r.quantity: r for r in leveziel_workspace.workspace_findings(STEP, PIXEL).rows}[before.quantity]
    assert (before.verdict, after.verdict) == ("reproduced", "differs")


def test_only_what_the_paper_states_under_its_own_conditions_is_judged() -> None:
    ours = {
        "circle": ["circle/largest-area", "circle/radius"],
        "closing": ["closing/servo-limited", "closing/servo-limited-factory-gain"],
        "moves": ["moves/joint-linear-anywhere"],
        "indices": ["statement/transmission-ratios-scaled"],
        "formulas": [f"speed/{name}" for name in ("inverse-kinematics", "forward-kinematics", "scan")],
    }
    for part, quantities in ours.items():
        assert {row(part, quantity).verdict for quantity in quantities} == {"ours"}
    assert row("circle", "circle/area").verdict == "not reproducible"
    assert "searched" in row("circle", "circle/largest-area").note
    assert "the machine that made this" in row("formulas", "speed/inverse-kinematics").note


def test_the_reduced_workspace_is_that_of_the_printed_equations() -> None:
    axis = STEP * np.arange(-40, 41)
    grid = np.stack(np.meshgrid(axis, axis, STEP * np.arange(-40, 1), indexing="ij"), axis=-1).reshape(-1, 3)
    inside = grid[allowed(poses_at(grid, HOME))]
    found = row("workspace", "workspace/positions")
    assert found.published == 51_624.0
    assert found.reproduced == len(inside)
    assert row("workspace", "workspace/volume").reproduced == pytest.approx(len(inside) * STEP**3, rel=1e-12)
    extent = row("workspace", "workspace/extent").details["extent"]
    np.testing.assert_allclose(extent, [inside.min(axis=0), inside.max(axis=0)], atol=1e-12)


def kappa_of(poses: Floats) -> Floats:
    """Eq. 9 by the singular values of the first three rows of J_x^-1 J_q."""
    singular = np.linalg.svd(np.linalg.solve(jacobian_x(poses), jacobian_q(poses))[:, :3], compute_uv=False)
    return singular[:, -1] / singular[:, 0]


def test_kappa_of_the_sections_and_its_shares() -> None:
    poses = reduced(STEP).poses
    values = kappa_of(poses)
    assert row("workspace", "fig-5/smallest-kappa").reproduced == pytest.approx(values.min(), rel=1e-6)
    assert row("workspace", "fig-5/over-0.5").reproduced == pytest.approx(100.0 * (values > 0.5).mean())
    assert row("workspace", "fig-5/over-0.5").reproduced == pytest.approx(76.0, abs=1.0)
    cut = leveziel_workspace.section("y-z", HOME, 0.01)
    i, j = np.argwhere(cut.reduced)[10]
    pose = np.array([[0.0, cut.across[i], cut.up[j], HOME]])
    assert cut.kappa[i, j] == pytest.approx(float(kappa_of(pose)[0]), rel=1e-6)
    assert (cut.full | ~cut.reduced).all()
    assert cut.full.sum() > 1.5 * cut.reduced.sum()


def test_three_motor_angles_give_the_position_that_holds_them() -> None:
    rng = np.random.default_rng(0)
    angles = rng.uniform(*PROTOTYPE.stroke, (200, 3))
    poses = poses_at(arm_positions(angles, HOME), HOME)
    poses, angles = poses[np.isfinite(poses[:, 0])], angles[np.isfinite(poses[:, 0])]
    q = angles_of(poses)
    reached = np.isfinite(q).all(axis=1)
    assert reached.sum() > 100
    # Where an elbow would have to point inward the position has other outward angles.
    same = np.abs(q[reached, :3] - angles[reached]).max(axis=1) < 1e-9
    assert same.mean() > 0.8
    assert is_reachable(poses)[reached][same].sum() > 50


def test_the_smallest_kappa_is_in_the_tip_between_the_ends_of_the_strokes() -> None:
    found = row("workspace", "fig-5/smallest-kappa-anywhere")
    assert found.reproduced == pytest.approx(0.2962, abs=1e-4)
    assert found.verdict == "differs"
    q = np.rad2deg(inverse_kinematics(found.details["position"]))
    assert np.sort(q)[1:] == pytest.approx([45.0, 45.0, 45.0], abs=1e-3)
    samples = random_poses(20_000, seed=3)
    samples[:, 3] = HOME
    assert kappa(samples[is_reachable(samples)]).min() > found.reproduced


def test_the_search_finds_the_ends_of_what_it_measures() -> None:
    pose, height = lowest_pose(lambda poses: poses[:, 2], HOME)
    assert height == pytest.approx(float(reduced(0.004).positions[:, 2].min()), abs=0.004)
    assert pose[2] == height
    assert allowed(pose[None]).all()


def test_the_centre_is_singular_where_each_half_is_in_line_with_its_forearm() -> None:
    def bent(degrees: float) -> float:
        """Sine of the angle between half and forearm at x = y = 0, z = -200 mm."""
        theta = np.deg2rad(degrees)
        q = angles_of(np.array([[0.0, 0.0, -0.2, theta]]))[0, 1]
        out, up = V + W * np.cos(theta) - K - R * np.cos(q), -200.0 + W * np.sin(theta) - R * np.sin(q)
        return (up * np.cos(theta) - out * np.sin(theta)) / L

    assert row("workspace", "video/singular-centre").reproduced == pytest.approx(brentq(bent, 20.0, 80.0), abs=1e-9)
    assert brentq(bent, 20.0, 80.0) == pytest.approx(53.33, abs=0.01)


def test_singular_poses_appear_in_the_reduced_workspace_near_45_degrees() -> None:
    first = row("workspace", "video/first-singular-angle")
    assert first.tolerance == 5.0
    assert 40.5 < first.details["anywhere"] <= first.reproduced < 42.0
    pose = np.array([first.details["position"]])
    assert allowed(pose).all()
    assert abs(np.linalg.det(jacobian_x(pose))[0]) < 1e-6 * np.linalg.det(jacobian_x(PROTOTYPE.home[None]))[0]
    assert row("workspace", "video/kappa-at-45-deg").reproduced < 1e-2
    assert min(row("workspace", "video/kappa-at-45-deg").details["smallest_at_negative_angles"].values()) > 0.28


def tau_of(poses: Floats) -> Floats:
    return 1.0 / np.linalg.norm(np.linalg.solve(jacobian_x(poses), jacobian_q(poses))[:, 3], axis=1)


def test_the_hull_of_figure_6() -> None:
    data = findings("indices").data["leveziel_tau"]
    assert len(data["theta"]) == 101
    positions = reduced(STEP).positions
    for t in (10, 25, 60):
        poses = poses_at(positions, data["theta"][t])
        values = tau_of(poses[allowed(poses)])
        assert (data["low"][t], data["high"][t]) == (pytest.approx(values.min()), pytest.approx(values.max()))
        assert data["centre"][t] == pytest.approx(float(tau_of(np.array([[0.0, 0.0, -0.2, data["theta"][t]]]))[0]))
    first = row("indices", "fig-6/first-zero").reproduced
    for degrees, singular in ((first, True), (first - 1.8, False)):
        poses = poses_at(positions, float(np.deg2rad(degrees)))
        assert (np.linalg.det(jacobian_x(poses[allowed(poses)])) <= 0.0).any() == singular
    assert leveziel_indices.first_singular_angle(reduced().positions, np.deg2rad([39.6, 41.0, 42.0])) == np.deg2rad(
        41.0
    )
    assert row("indices", "fig-6/most-convenient-angle").reproduced == pytest.approx(-41.4, abs=1.9)
    assert row("indices", "fig-6/centre-at-home").reproduced == pytest.approx(0.3420, abs=5e-5)
    assert row("indices", "fig-6/smallest-at-home").reproduced == pytest.approx(tau_of(reduced(STEP).poses).min())


def test_transmission_ratios_come_out_only_with_the_length_of_a_half_in_centimetres() -> None:
    printed = row("indices", "statement/transmission-ratios").details
    scaled = row("indices", "statement/transmission-ratios-scaled").details
    assert (printed["low"], printed["high"]) == (pytest.approx(1.35, abs=0.01), pytest.approx(3.88, abs=0.01))
    assert scaled["low"] == pytest.approx(0.1 * W * printed["low"], rel=1e-12)
    assert scaled["high"] == pytest.approx(10.3, abs=0.05)
    judged = row("indices", "statement/transmission-ratios")
    assert (judged.published, judged.reproduced, judged.explained) == ("3.4 to 10.3", "1.4 to 3.9", "3.6 to 10.3")
    assert judged.verdict == "differs"
    poses = random_poses(5000, seed=2)
    ratios = 1.0 / tau(poses)
    assert printed["low"] <= ratios.min()
    assert ratios.max() <= printed["high"]
    drift = row("indices", "statement/tau-lets-the-platform-drift").details
    assert 0.8 < drift["low"] < drift["high"] < 2.6


def test_formulas_agree_with_the_printed_points_and_finite_differences() -> None:
    assert row("formulas", "formula/eqs-1-6").reproduced < 1e-12
    assert row("formulas", "formula/round-trip").reproduced < 1e-9
    assert row("formulas", "formula/wrong-assembly-mode").reproduced == 0.0
    for name in ("J_x", "J_q", "inverse"):
        assert row("formulas", f"formula/{name}").reproduced < 1e-7
    poses = random_poses(300, seed=5)
    np.testing.assert_allclose(inverse_kinematics(poses), angles_of(poses), atol=1e-12)


def test_conventions_are_shown_by_numbers() -> None:
    wrong = row("formulas", "statement/angles-of-arms-3-and-4")
    assert wrong.reproduced < 0.1 * 51_491
    outward = row("formulas", "statement/angles-of-arms-3-and-4/outward")
    assert (wrong.verdict, outward.verdict, outward.statement) == ("differs", "reproduced", wrong.quantity)
    assert row("formulas", "statement/sign-of-the-strokes").reproduced == pytest.approx(0.02, abs=0.005)
    condition = row("formulas", "statement/condition-7").details
    assert condition["over"] <= 1e-12
    assert condition["norm"] < 1e-12
    coplanar = row("formulas", "statement/coplanar-half-is-singular")
    assert coplanar.reproduced == pytest.approx(0.117, abs=1e-3)
    assert coplanar.details["coplanar_deg"] == pytest.approx(71.2, abs=0.05)
    assert coplanar.details["singular_deg"] == pytest.approx(54.5, abs=0.05)
    assert min(map(abs, coplanar.details["entries_m2"])) > 1e-4
