"""Robots of other sizes, and what a level says of the conveyor cell: a YAML file, or one sentence why not."""

from collections.abc import Mapping

import numpy as np
import pytest

from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.observation import TABLE, decode, feature_table
from pnt_gym.cells.gripper.robot import Robot
from pnt_gym.envs.gripper import GripperTossEnv
from pnt_gym.errors import ConfigError
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD
from pnt_gym.robots.gripper.geometry import PROTOTYPE
from tests.tools.gripper import made

BELT = GripperConfig.load("belt").model_dump(exclude_unset=True)
SLOW_SERVO = {"servo": {"speed": 1.0}}


def varied(**changes):
    """The level `belt` as its file has it, with some sections' values replaced."""
    data = {key: BELT[key] for key in ("name", "robot", "conveyor", "items", "grip", "motion", "action", "observation")}
    data["tray"] = {"x": 0.90, "settle": 0.35}
    for name, values in changes.items():
        data[name] = {**data.get(name, {}), **values} if isinstance(values, Mapping) else values
    return data


def test_the_default_robot_is_the_prototype():
    assert Robot().parts() == (PROTOTYPE, PROTOTYPE_BUILD)
    assert Robot().size == 1.0


def test_the_belts_robot_is_the_industrial_one_with_softer_and_narrower_claws():
    config = GripperConfig.load("belt")
    dimensions, build = config.robot.parts()
    # Of that size is the industrial robot whose proportions the paper takes.
    same = PROTOTYPE_BUILD.with_scale(4.1, build.servo)
    assert dimensions == PROTOTYPE.with_scale(4.1)
    assert build.moving_mass == same.moving_mass
    assert build.claws.length == same.claws.length
    assert build.claws.stiffness < same.claws.stiffness
    assert build.claws.width < same.claws.width


def test_parts_are_named_one_by_one():
    dimensions, build = Robot(
        scale=2.0,
        dimensions={"l": 0.5, "stroke": [-1.4, 0.7]},
        masses={"arm_mass": 0.2},
        claws={"pad": [0.05, 0.004, 0.03]},
    ).parts()
    assert (dimensions.l, dimensions.r, dimensions.stroke) == (0.5, 2.0 * PROTOTYPE.r, (-1.4, 0.7))
    assert (build.arm_mass, build.rod_mass) == (0.2, 4.0 * PROTOTYPE_BUILD.rod_mass)
    assert build.claws.pad == (0.05, 0.004, 0.03)


@pytest.mark.parametrize(
    ("level", "message"),
    [
        ({"items": []}, "items"),
        ({"table": {"pick_x": [0.0, -0.1]}}, "pick_x"),
        ({"tray": {"rim": -0.2}}, "below the claws"),
        ({"items": ["cork", "cork"]}, "differ"),
        ({"items": ["sofa"]}, r"unknown item 'sofa'; known are .* more"),
        ({"robot": {"scale": -1.0}}, "robot.scale is -1"),
        ({"robot": {"dimensions": {"q": 1.0}}}, "unknown dimension 'q'; known are k, r"),
        ({"robot": {"dimensions": {"l": 0.01}}}, "cannot bridge"),
        ({"robot": {"servo": {"torque": 1.0}}}, "robot.servo: unknown key 'torque'; known are stall_torque"),
        ({"robot": {"servo": {"kp": "much"}}}, "robot.servo.kp is 'much'; it must be a number"),
        ({"robot": {"servo": {"kp": -1.0}}}, "servo.kp is -1"),
        ({"robot": {"claws": {"pad": [0.1, 0.2]}}}, "three lengths"),
        ({"robot": {"masses": {"arm": 1.0}}}, "robot.masses: unknown key 'arm'; known are arm_mass"),
        (varied(conveyor={"level": "moon"}), "unknown level 'moon'"),
        (varied(conveyor={"origin": [0.0, 0.0]}), "conveyor.origin"),
        (varied(items=["ufo"]), "unknown item 'ufo'"),
        (varied(tray={"x": 0.1}), "stands in the table"),
    ],
)
def test_wrong_values_are_named_in_one_sentence(level, message):
    with pytest.raises(ConfigError, match=message) as caught:
        GripperConfig.load(level)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"robot": SLOW_SERVO}, "the motors are too slow for the throw"),
        ({"robot": {"dimensions": {"l": 0.150}}}, "reach"),
        ({"tray": {"x": 0.6}}, "reach"),
        ({"table": {"pick_x": [-0.2, 0.0]}}, "reach"),
        ({"table": {"speed": 1.2}}, "the motors are too slow to follow the belt"),
        ({"table": {"speed": 1.2, "travel_deg": 90.0}}, "the belt carries the object out of the robot's reach"),
        (varied(table={"speed": 6.0}), "the belt carries the object out"),
        (varied(tray={"x": 3.0}), "reach"),
        (varied(robot={"scale": 3.5}), "the robot does not reach the grip"),
        (varied(grip={"open_deg": -56.0}), "the paper_ball is 0.08 m wide; the claws open to 0.008858 m"),
        ({"grip": {"open_deg": 50.0}}, "grip.open_deg is 50 deg; the platform's halves turn from -60 to -30 deg"),
        ({"grip": {"open_deg": 60.0}, "robot": {"dimensions": {"theta": [-1.1, 1.2]}}}, "from 53.3 deg on the motors"),
        ({"grip": {"release_deg": 30.0}}, "opens the claws to -19.1 deg around the cork"),
        (varied(robot={"claws": {"width": 0.13}}), "the yoghurt_cup is 0.07 m wide; claws that squeeze by 4 deg"),
    ],
)  # fmt: skip
def test_what_the_robot_cannot_do_is_refused_in_one_sentence(data, message):
    with pytest.raises(ConfigError, match=message) as caught:
        GripperCell(GripperConfig.load(data), 1)
    assert "\n" not in str(caught.value)


def test_what_a_cell_says_itself_goes_before_the_conveyor_cell():
    data = varied(table={"speed": 0.1}, errors={"mass": 0.5}, conveyor={"level": "nominal"})
    config = GripperConfig.load({key: value for key, value in data.items() if key != "items"})
    assert (config.table.speed, config.errors.mass) == (0.1, 0.5)
    assert config.table.height == GripperConfig.load("belt").table.height
    assert config.items == ("paper", "metal_can", "plastic_package")
    GripperCell(config, 1)


def test_a_small_robot_picks_from_a_small_belt():
    belt = {"speed": 0.08, "travel_deg": 90.0, "camera": -0.2, "pick_y": [-0.03, 0.01]}
    cell = made("nominal", 24, mismatch=0.0, table=belt)
    outcome = cell.throw(cell.context.plans)
    assert outcome.is_success.all()
    assert outcome.landing_error.max() < 0.008


def test_a_cells_own_centres_and_scales_are_used_and_read_back():
    cell = made("belt", 12)
    table, context = feature_table(cell.config), cell.context
    values = decode(table.encode(context), table)
    np.testing.assert_allclose(values["place_x"], context.place[:, 0], atol=1e-6)
    np.testing.assert_allclose(values["width"], context.measured[:, 1], atol=1e-6)
    np.testing.assert_array_equal(feature_table(made("nominal", 12).config).encode(context), TABLE.encode(context))
    with pytest.raises(ConfigError, match="unknown feature 'colour'; known are place_x"):
        feature_table(GripperConfig.load({"observation": {"colour": [0.0, 1.0]}}))


def test_the_environments_manual_says_what_the_belts_numbers_are():
    action, reward = GripperConfig.load("belt").action, GripperConfig.load("belt").reward
    text = " ".join(str(GripperTossEnv.__doc__).split())
    assert f"with `belt` 1 stands for {action.along:g} m, {action.across:g} m and {action.opening:g} s" in text
    assert f"with `belt` {reward.landing_scale:g} m" in text
    assert f"{GripperConfig.load('belt').robot.scale:g} times the prototype" in text
