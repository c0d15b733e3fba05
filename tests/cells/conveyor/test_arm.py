"""Arms in a cell: own ones without a change of the package, full physics against flights, limits, and bad sheets."""

import json
import shutil
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.ground.environments import core_of, make_vector
from agents.results.study import Amount
from benchmarks.studies import arms
from pnt_gym.cells.conveyor.arm import arm_problems
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.robot import RobotSheet
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError
from tests.tools.arms import changed, scara, six_axis
from tests.tools.commands import call_here
from tests.tools.nightly import with_nightly

COBOT: dict[str, Any] = {
    "base": "waste", "robot": "ur10e_class", "limits": {"percent": [100]}, "belt": {"lane_y": [-0.40, -0.20]},
    "bins": {"rim": -1.0, "random": {"x": [-0.35, 0.35], "y": [0.09, 0.18], "item_clearance": 0.06}},
    "motion": {"reserve": 0.05, "follow_through": {"window": 0.05}}, "action": {"along": 0.08, "across": 0.04},
}  # fmt: skip
"""A cell of the shipped arm: it tosses over a hand's breadth or two."""


@pytest.mark.parametrize("level", with_nightly(["cobot", "scara", "six"], ["scara"]))
def test_hands_keep_to_their_paths_and_joints_to_their_limits(level, tmp_path):
    """Random corrections to the full, 80 throws; the study `arm` has 10,000."""
    settings = COBOT if level == "cobot" else {"base": str({"scara": scara, "six": six_axis}[level](tmp_path))}
    found = arms.throws({"level": settings, "actions": 1.0}, Amount(80, 3))
    assert found["throws"] > 40
    assert found["apart_most_m"] < 0.001
    assert found["unlike_most"] < 0.01
    assert found["planned_beyond"] == found["too_fast"] == found["at_full_torque"] == 0
    assert found["planned_torque_most"] < 1.0
    assert 0.2 < found["planned_speed_most"] < 1.0


def test_flights_land_where_the_full_physics_do():
    landed = {}
    for fidelity in ("full", "flight"):
        with closing(make_vector("PnTRelease-v0", {**COBOT, "fidelity": fidelity}, 64, 1)) as env:
            env.reset(seed=1)
            landed[fidelity] = env.step(np.zeros(env.action_space.shape, dtype=np.float32))[4]
            assert core_of(env).config.robot.has_model
    off = [landed["full"][name] - landed["flight"][name] for name in ("landing_along", "landing_across")]
    apart = np.hypot(*off)
    assert np.nanquantile(apart, 0.95) < 0.005
    assert np.isfinite(apart).sum() > 40
    np.testing.assert_allclose(landed["full"]["energy"], landed["flight"]["energy"], rtol=0.05)


def test_singles_equal_a_batch(tmp_path):
    level = scara(tmp_path)
    with closing(make_vector("PnTRelease-v0", level, 3, 1)) as env:
        env.reset(seed=8)
        together = env.step(np.zeros((3, 2), dtype=np.float32))[4]
    for row in range(3):
        with closing(make_vector("PnTRelease-v0", level, 1, 1)) as env:
            env.reset(seed=8 + row)
            alone = env.step(np.zeros((1, 2), dtype=np.float32))[4]
        for name in ("landing_error", "cycle_time", "energy", "peak_torque"):
            np.testing.assert_array_equal(alone[name][0], together[name][row])


@pytest.mark.parametrize("write", [scara, six_axis])
def test_an_arm_of_ones_own_costs_no_change_of_the_package(write, tmp_path):
    """From files in a folder, in full physics, by the command line; from another folder, too."""
    level = write(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    words = (
        "--level",
        f"../{level.name}",
        "--controller",
        "analytic",
        "--picks",
        "16",
        "--num-envs",
        "8",
        "--json",
        "out.json",
    )
    done = call_here("pnt_gym", "evaluate", *words, folder=tmp_path / "elsewhere")
    assert done.returncode == 0, done.stderr[-2000:]
    found = json.loads((tmp_path / "elsewhere" / "out.json").read_text())
    assert found["picks"] == 16
    assert found["landing_error_mean_m"] < 0.1


def test_arms_stand_on_lines(tmp_path):
    """The sheet of a robot of a line may have a model; the file's place counts from the line's file."""
    level = scara(tmp_path)
    robot = ConveyorConfig.load(level).robot.model_dump(mode="json", exclude_unset=True)
    robot["model"]["file"] = "my_arm.xml"
    line = tmp_path / "line.yaml"
    line.write_text(json.dumps({
        "base": "line3", "throws": "flight", "duration": 10.0,
        "robots": [{"name": "a", "x": 0.0, "robot": robot}, {"name": "b", "x": 1.6}],
    }))  # fmt: skip
    config = LineConfig.load(line)
    assert config.sheets()[0].model is not None
    before = config.digest()
    text = (tmp_path / "my_arm.xml").read_text()
    (tmp_path / "my_arm.xml").write_text(text.replace('mass="8"', 'mass="9"'))
    assert LineConfig.load(line).digest() != before


def test_two_arms_work_on_a_line_in_full_physics():
    cell = {key: COBOT[key] for key in ("base", "robot", "limits", "motion")}
    cell["belt"] = {**COBOT["belt"], "neighbours": "ghosts"}
    bins = [{"name": "all", "x": -0.1, "y": 0.12, "size": [0.24, 0.24]}]
    cell["bins"] = {"rim": -1.15, "random": None, "fixed": bins}
    robots = [{"name": "first", "x": 0.0}, {"name": "second", "x": 2.4}]
    line = {"name": "arms", "cell": cell, "robots": robots, "arrivals": {"rate": 1.0}, "duration": 5.0}
    seen: list[Any] = []
    for throws in ("full", "flight"):
        with closing(make_vector("PnTLine-v0", LineConfig.load({**line, "throws": throws}), 2, 1)) as env:
            env.reset(seed=0)
            steps = [env.step(np.zeros(2, dtype=np.int64))[4] for _ in range(3)]
            seen.append([(step["sorted"].tolist(), step["cycle_time"].tolist()) for step in steps])
    assert seen[0] == seen[1]
    assert any(any(sorted_) for sorted_, _ in seen[0])


def test_a_robot_of_a_line_rides_at_its_own_share_of_its_own_limits():
    """The shipped arm is slow: at the 40 % of the others it cannot ride with the belt, at its own 100 % it can."""
    robots: list[dict[str, Any]] = [{"name": "a", "x": 0.0}, {"name": "b", "x": 1.6, "robot": "ur10e_class"}]
    line = {"base": "line3", "throws": "flight", "robots": robots}
    with pytest.raises(ConfigError, match=r"robot 'b': belt\.speed is 0\.4 m/s; a hand at 40 %"):
        LineConfig.load(line)
    robots[1]["percent"] = [100]
    assert LineConfig.load(line).cells()[1].robot.name == "ur10e_class"


@pytest.mark.parametrize(
    ("robot", "said"),
    [
        ({"velocity": 9.0}, "robot.velocity is 9 m/s; joint 'lift' of 'mine' allows 2.8 m/s with the hand at"),
        ({"acceleration": 400.0}, "robot.acceleration is 400 m/s2 with a payload of 1 kg; joint 'shoulder' of"),
        ({"payload": 60.0}, "with a payload of 60 kg; joint 'lift' of 'mine' cannot hold it"),
        ({"payload": 0.01}, "carries at most 0.01 kg"),
        ({"reach": {"shape": "ring", "radius": 0.6, "hole": 0.1}}, "has a model and a reach of shape 'ring'"),
        ({"reach": {"shape": "circle", "radius": 1.5}}, "the arm of robot 'mine' does not get to"),
        ({"reach": {"shape": "circle", "radius": 0.2, "x": 9.0}}, "covers 0 %"),
        ({"model": {"base": [0.0, -9.0, 0.0]}}, "the arm finds no pose with a level and unturned hand at"),
        ({"model": {"home": [0.4, 2.0]}}, "robot.model.home has 2 values, and the arm has 4 joints"),
        ({"model": {"turn": [3.14159, 0.0, 0.0]}}, "the tool's z axis points 180 degrees from straight down"),
        ({"model": {"tool": "hand"}}, "unknown tool 'hand'"),
        ({"model": {"file": "gone.xml"}}, "robot 'mine': cannot read model 'gone.xml': No such file"),
        ({"model": {"speed": None}}, "the largest speed of joint 'shoulder', 'elbow', 'lift' and 'wrist' is missing"),
        ({"height": [-0.92, -0.10]}, "joint 'lift' would be"),
        ({"model": {"stem": -1.0}}, "robot.model.stem"),
    ],
)  # fmt: skip
def test_a_sheet_that_its_arm_cannot_keep_is_refused_in_a_sentence(robot, said, tmp_path):
    level = scara(tmp_path, **robot)
    with pytest.raises(ConfigError) as refused:
        ConveyorConfig.load(level)
    assert said in str(refused.value)
    done = call_here(
        "pnt_gym", "evaluate", "--level", str(level), "--controller", "analytic", "--json", "out.json", folder=tmp_path
    )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out.json").exists()


def test_a_changed_model_file_is_read_again(tmp_path):
    level = scara(tmp_path)
    ConveyorConfig.load(level)
    file = tmp_path / "my_arm.xml"
    file.write_text(file.read_text().replace('ctrlrange="-600 600"', 'ctrlrange="-6 6"'))
    with pytest.raises(ConfigError, match="joint 'shoulder' of 'mine' cannot hold it"):
        ConveyorConfig.load(level)


def test_a_reach_around_the_base_is_refused(tmp_path):
    """There the arm would have to turn back after a round, and is singular above its base."""
    level = scara(tmp_path, reach={"shape": "circle", "radius": 0.6}, model={"base": [0.1, 0.1, -0.35]})
    with pytest.raises(ConfigError, match="changes its posture within") as refused:
        ConveyorConfig.load(level)
    assert "robot.velocity is" in str(refused.value)


def test_the_shipped_sheet_is_kept_by_its_arm_and_not_much_below_what_that_allows(tmp_path):
    sheet = RobotSheet.model_validate("ur10e_class")
    assert not [*arm_problems(sheet)]
    for name in ("velocity", "acceleration"):
        faster = sheet.model_copy(update={name: 1.25 * getattr(sheet, name)})
        assert [problem for problem in arm_problems(faster) if f"robot.{name} is" in problem]
    shutil.copy(Path(str(sheet.model and sheet.model.file)), tmp_path / "again.xml")
    level = scara(tmp_path)
    changed(level, model={"file": "again.xml"})
    with pytest.raises(ConfigError, match=r"robot\.model\.speed has 4 values, and the arm has 6 joints"):
        ConveyorConfig.load(level)
