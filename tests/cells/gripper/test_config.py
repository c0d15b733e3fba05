import numpy as np
import pytest

from pnt_gym.cells.base.catalogue import CATALOGUE
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.scene import tray_panels
from pnt_gym.errors import ConfigError


def test_shipped_levels_load_and_say_their_names():
    assert set(GripperConfig.level_names()) == {"belt", "drop", "ideal", "late", "nominal", "patient"}
    for name in GripperConfig.level_names():
        assert GripperConfig.load(name).name == name
    assert GripperConfig.load("nominal").model_dump(exclude={"name"}) == GripperConfig().model_dump(exclude={"name"})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"speed": 3}, "unknown key 'speed'"),
        ({"mismatch": -1.0}, "mismatch"),
        ({"timestep": 0.002}, "timestep"),
        ({"items": []}, "items"),
        ({"table": {"pick_x": [0.0, -0.1]}}, "pick_x"),
        ({"tray": {"rim": -0.2}}, "below the claws"),
        ({"items": ["cork", "cork"]}, "differ"),
        ({"items": ["sofa"]}, r"unknown item 'sofa'; known are .*rubber_block"),
    ],
)
def test_wrong_values_are_named(changes, message):
    with pytest.raises(ConfigError, match=message):
        GripperConfig.load(changes)


def test_an_own_item_is_tossed_like_those_of_the_catalogue():
    own = CATALOGUE["rubber_block"].model_dump() | {"name": "brick", "mass": 0.02}
    config = GripperConfig.load({"items": ["cork", "brick"], "extra_items": [own]})
    assert [item.mass for item in config.item_list()] == [CATALOGUE["cork"].mass, 0.02]
    assert GripperCell(config, 1).item_names == ("cork", "brick")


@pytest.mark.parametrize("changes", [{"tray": {"x": 0.6}}, {"table": {"pick_x": [-0.2, 0.0]}}])
def test_what_the_robot_cannot_reach_is_refused(changes):
    with pytest.raises(ConfigError, match="reach"):
        GripperCell(GripperConfig.load(changes), 1)


def test_the_walls_leave_exactly_the_openings():
    tray = GripperConfig.load().tray
    half, centre = tray_panels(tray, 3)
    low, high = centre - half, centre + half
    for x, y, z in tray.centres(3):
        rng = np.random.default_rng(1)
        inner = np.array([*tray.opening, tray.depth]) / 2.0
        point = np.array([x, y, z - tray.depth / 2.0]) + rng.uniform(-inner, inner, (200, 3))
        assert not ((point[:, None] > low) & (point[:, None] < high)).all(axis=2).any()
        for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1)):
            wall = np.array([x, y, z - tray.depth / 2.0])
            wall[axis] += sign * (inner[axis] + tray.wall / 2.0)
            assert ((wall >= low) & (wall <= high)).all(axis=1).any()
