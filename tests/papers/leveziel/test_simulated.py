"""The simulated half of the reproduction of Leveziel et al.: small versions of the cycle and the grasps."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from agents.reproduce.finding import Findings, Row
from papers.leveziel import cycle as leveziel_cycle
from papers.leveziel import cycle_run as leveziel_cycle_run
from papers.leveziel import grasps as leveziel_grasps
from papers.leveziel.cycle import ejector_power
from papers.leveziel.cycle_run import PHASES, Cycles, run_cycles
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.robots.gripper import MOTOR_SPEED, inverse_kinematics
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD
from tests.tools.nightly import with_nightly
from tests.tools.reproduced import assert_plain


@cache
def findings(name: str) -> Findings:
    """Small versions of the parts."""
    small = {
        "cycle": lambda: leveziel_cycle.cycle_findings(cycles=8),
        "grasps": lambda: leveziel_grasps.grasp_findings(grasps=24),
    }
    return small[name]()


@cache
def calm() -> Cycles:
    """A cycle at half of the motors' speed without anything unknown."""
    return run_cycles(1, mismatch=0.0, share=0.5)


def row(name: str, quantity: str) -> Row:
    return next(r for r in findings(name).rows if r.quantity == f"leveziel/{quantity}")


@pytest.mark.parametrize("name", with_nightly(["cycle", "grasps"], ["grasps"]))
def test_rows_and_data_are_plain_json_and_figures_are_drawings(name: str) -> None:
    found = findings(name)
    assert_plain(found, "leveziel")
    assert all(r.note for r in found.rows)


def test_the_figures_are_the_known_ones() -> None:
    drawn = [figure for name in ("cycle", "grasps") for figure in findings(name).figures]
    assert drawn == ["leveziel_cycle.svg", "leveziel_cycle_pictures.svg", "leveziel_grasps.svg"]


def test_the_commanded_cycle_keeps_the_motors_speed_and_comes_back() -> None:
    for share in (0.5, 1.0):
        cycles = calm() if share == 0.5 else run_cycles(1, mismatch=0.0, share=share)
        pose, step = cycles.course.pose, cycles.config.timestep
        for leg in ("lower", "lift", "across", "back"):
            speed = np.abs(np.diff(inverse_kinematics(pose[cycles.phase_steps(leg)]), axis=0)).max() / step
            assert 0.97 * share * MOTOR_SPEED < speed < 1.001 * share * MOTOR_SPEED
        assert list(cycles.course.ends) == list(PHASES)
        assert pose[-1] == pytest.approx(pose[0], abs=1e-9)
        at = [pose[cycles.phase_steps(name).stop, :3] for name in ("lower", "lift", "across")]
        assert at[1] - at[0] == pytest.approx([0.0, 0.0, 0.050], abs=1e-9)
        assert at[2] - at[1] == pytest.approx([0.0, 0.070, 0.0], abs=1e-9)


def test_a_slow_robot_follows_the_command() -> None:
    cycles = calm()
    moving = slice(0, cycles.phase_steps("back").stop)
    away = np.abs(cycles.platform[0, moving, :3] - cycles.course.pose[moving, :3])
    assert away.max() < 0.002
    # Only the squeezed object keeps the halves from going where they are told to go.
    empty = cycles.phase_steps("lower")
    assert np.abs(cycles.platform[0, empty, 3] - cycles.course.pose[empty, 3]).max() < np.deg2rad(0.5)
    touched = cycles.pads[0].any(axis=1)
    assert not touched[: cycles.phase_steps("lower").stop].any()
    assert touched[cycles.phase_steps("lift").start : cycles.phase_steps("stand").stop].all()
    assert not touched[cycles.phase_steps("back")].any()


def test_cycles_side_by_side_are_those_alone() -> None:
    three = run_cycles(3, mismatch=1.0, share=1.0)
    alone = run_cycles(1, mismatch=1.0, share=1.0)
    np.testing.assert_array_equal(three.cork[:1], alone.cork)
    assert (three.cork[0, -1] != three.cork[1, -1]).any()


def test_the_cork_is_carried_and_dropped() -> None:
    assert row("cycle", "cycle/rise").reproduced == pytest.approx(0.050, abs=0.001)
    assert row("cycle", "cycle/across").reproduced == pytest.approx(0.070, abs=0.003)
    assert row("cycle", "cycle/success").reproduced == 100.0
    assert row("cycle", "cycle/held").verdict == "reproduced"
    angle = row("cycle", "cycle/angle-change")
    assert angle.verdict == "ours"
    closed = row("cycle", "cycle/angle-change-in-closed-form")
    assert (closed.verdict, closed.reproduced) == ("differs", pytest.approx(4.0, abs=0.05))
    assert angle.details["joint_linear_deg"] == pytest.approx(4.0, abs=0.1)


def slippery(config: GripperConfig) -> GripperConfig:
    """The same cell for items on which pads find no hold."""
    items = [
        item.model_copy(update={"name": f"slippery_{item.name}", "pad_friction": 0.002}) for item in config.item_list()
    ]
    return config.model_copy(update={"items": tuple(item.name for item in items), "extra_items": tuple(items)})


@pytest.mark.nightly
def test_a_slippery_cork_is_not_carried(monkeypatch: pytest.MonkeyPatch) -> None:
    known = leveziel_cycle_run.cycle_config

    def config(mismatch: float) -> Any:
        return slippery(known(mismatch))

    monkeypatch.setattr(leveziel_cycle_run, "cycle_config", config)
    found = {r.quantity.rsplit("/", 1)[1]: r for r in leveziel_cycle.cycle_findings(cycles=2).rows}
    for name in ("held", "success"):
        assert found[name].reproduced == 0.0
    for name in ("held", "success", "rise", "across"):
        assert found[name].verdict == "differs"


def test_legs_take_the_speed_limited_times_and_more() -> None:
    lift, across = (row("cycle", f"cycle/{name}-time") for name in ("lift", "across"))
    assert lift.details["on_axis_s"] == pytest.approx(0.078, abs=5e-4)
    assert across.details["outwards_at_-200mm_s"] == pytest.approx(0.0784, abs=5e-4)
    for leg in (lift, across):
        # A trapezoid with ramps of a quarter of the time takes 4/3 of the time at full speed.
        assert leg.details["commanded_s"] > 1.2 * leg.reproduced
        assert leg.reproduced < leg.details["simulated_s"] < leg.details["commanded_s"] + 0.01


def test_objects_are_lifted_without_slip_but_turn_into_line_before() -> None:
    for name in ("cork", "cap", "block"):
        assert row("grasps", f"grasps/{name}").reproduced >= 98.0
        assert row("grasps", f"grasps/{name}").details["slip_max_m"] < 0.0005
    assert row("grasps", "grasps/cork-from-closed-grip").reproduced > 0.0005
    assert row("grasps", "grasps/cap-from-closed-grip").reproduced < 0.0005


def test_slippery_objects_count_as_not_held() -> None:
    cell = GripperCell(slippery(GripperConfig.load("drop")), 4)
    for kind in range(len(cell.item_names)):
        assert not leveziel_grasps.simulate_grasps(cell, kind).is_held.any()


def test_energy_of_a_cycle_is_stated_for_motors_and_for_suction() -> None:
    motors, suction = row("cycle", "cycle/motor-work"), row("cycle", "cycle/suction-work")
    assert (motors.verdict, suction.verdict) == ("ours", "ours")
    # Four motors at 70 rpm and at most their stall torque: an upper bound of their work in one cycle.
    seconds = row("cycle", "cycle/cycle-time").reproduced
    most = 4 * PROTOTYPE_BUILD.servo.stall_torque * PROTOTYPE_BUILD.servo.no_load_speed * seconds
    assert 0.0 < motors.reproduced < most
    # Air through a nozzle at the speed of sound: 27 normal litres a minute, compressed to six times its pressure.
    assert 60e3 * ejector_power() / 101_325.0 / np.log(601_325 / 101_325) == pytest.approx(27.0, rel=0.02)
    assert row("cycle", "cycle/picks-per-minute").reproduced == pytest.approx(60.0 / seconds)
