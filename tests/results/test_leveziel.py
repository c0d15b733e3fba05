"""Guards of committed numbers: what the rows of Leveziel et al. in results/reproduction.json reach."""

from __future__ import annotations

from typing import Any

import pytest

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT

ROWS: dict[str, dict[str, Any]] = {
    row["quantity"]: row
    for row in read_json(ROOT / "results" / "reproduction.json")["rows"]
    if row["paper"] == "leveziel"
}


def row(name: str) -> dict[str, Any]:
    return ROWS[f"leveziel/{name}"]


def value(name: str) -> Any:
    return row(name)["reproduced"]


def test_forward_kinematics_undoes_the_inverse_one() -> None:
    assert value("formula/round-trip") < 1e-9
    assert value("formula/wrong-assembly-mode") == 0.0
    assert "10,000 random poses" in row("formula/round-trip")["note"]


@pytest.mark.parametrize("name", ["J_x", "J_q", "inverse"])
def test_jacobians_are_finite_differences(name: str) -> None:
    assert value(f"formula/{name}") < 1e-7


def test_kappa_at_the_home_angle() -> None:
    assert value("fig-5/smallest-kappa") > 0.3
    assert value("fig-5/smallest-kappa-anywhere") == pytest.approx(0.299, abs=0.004)
    assert value("fig-5/over-0.5") == pytest.approx(76.0, abs=0.5)
    assert all(value(f"fig-5/over-0.5-in-{plane}") > 75.0 for plane in ("x-y", "x-z", "y-z"))


def test_singular_angles() -> None:
    assert 41.0 < value("fig-6/first-zero") < 42.0
    assert value("video/singular-centre") == pytest.approx(53.3, abs=0.05)
    assert value("video/kappa-at-45-deg") < 1e-3


def test_the_published_transmission_ratios_need_another_length_unit() -> None:
    assert row("inconsistency/transmission-ratios")["high"] == pytest.approx(3.88, abs=0.01)
    assert row("inconsistency/transmission-ratios-scaled")["high"] == pytest.approx(10.3, abs=0.05)
    assert value("fig-6/smallest-while-gripping") > 0.25


def test_moves_along_lines_keep_the_platform_angle_and_joint_linear_ones_do_not() -> None:
    assert value("simulated/cartesian") < 0.1
    assert value("simulated/joint-linear") == pytest.approx(value("moves/joint-linear-z"), abs=0.1)
    assert value("moves/joint-linear-z") == pytest.approx(-3.45, abs=0.01)
    assert value("circle/theta") < 0.1


def test_the_gripper_closes_within_the_published_time() -> None:
    times = [value(f"closing/{name}") for name in ("speed-limited", "servo-limited", "servo-limited-factory-gain")]
    assert times == sorted(times)
    assert times[0] == pytest.approx(0.0113, abs=1e-4)
    assert times[-1] < 0.060


def test_the_circle_is_far_from_80_percent_at_the_home_height() -> None:
    assert row("circle/area")["share"] == pytest.approx(38.0, abs=0.5)
    assert row("circle/area")["inscribed_240_m"] < 0.080


def test_a_million_poses_a_second_and_a_scan_within_ten_seconds() -> None:
    assert value("speed/inverse-kinematics") > 1e6
    assert value("speed/scan") < 10.0
    assert row("speed/scan")["poses"] == 101 * value("workspace/positions")
