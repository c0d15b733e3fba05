import numpy as np

from pnt_gym.cells.base.catalogue import CATALOGUE
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.scene import tray_panels


def test_the_nominal_level_has_the_defaults():
    assert set(GripperConfig.level_names()) == {"belt", "drop", "ideal", "late", "nominal", "patient"}
    assert GripperConfig.load("nominal").model_dump(exclude={"name"}) == GripperConfig().model_dump(exclude={"name"})


def test_an_own_item_is_tossed_like_those_of_the_catalogue():
    own = CATALOGUE["rubber_block"].model_dump() | {"name": "brick", "mass": 0.02}
    config = GripperConfig.load({"items": ["cork", "brick"], "extra_items": [own]})
    assert [item.mass for item in config.item_list()] == [CATALOGUE["cork"].mass, 0.02]
    assert GripperCell(config, 1).item_names == ("cork", "brick")


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
