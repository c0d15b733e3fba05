"""Levels and config files: the shipped ones work, and a wrong one is refused in one sentence."""

import numpy as np
import pytest
import yaml
from throw_tools import item, make_core

from pnt_gym.cells.items import CATALOGUE, HELD_OUT_ITEMS, PAPER_ITEMS, SEEN_ITEMS
from pnt_gym.config import CellConfig, level_names, load
from pnt_gym.errors import ConfigError

LEVELS = ("fast", "ideal", "nominal", "tight", "unseen", "waste")
BIN = {"name": "box", "x": 0.3, "y": 0.4}
SMALLEST = {"bins": {"fixed": [BIN]}}


def test_the_shipped_levels_are_the_documented_ones():
    assert level_names() == LEVELS


@pytest.mark.parametrize("name", LEVELS)
def test_every_shipped_level_loads_and_carries_its_name(name):
    config = load(name)
    assert isinstance(config, CellConfig)
    assert config.name == name
    assert config.mismatch == (0.0 if name == "ideal" else 1.0)


def test_levels_use_the_items_they_are_meant_for():
    assert load("nominal").items == load("ideal").items == PAPER_ITEMS
    assert set(load("waste").items) == set(load("tight").items) == set(SEEN_ITEMS)
    assert set(load("unseen").items) == set(HELD_OUT_ITEMS)
    assert not set(load("waste").items) & set(load("unseen").items)


def test_unseen_and_tight_differ_from_waste_in_one_respect_each():
    waste = load("waste").model_dump(exclude={"name"})
    unseen = load("unseen").model_dump(exclude={"name"})
    tight = load("tight").model_dump(exclude={"name"})
    assert {key for key in waste if waste[key] != unseen[key]} == {"items"}
    assert {key for key in waste if waste[key] != tight[key]} == {"bins"}
    assert load("tight").bins.random.side[1] < load("waste").bins.random.side[0]


def test_a_file_holds_only_differences_from_the_defaults(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("belt: {speed: 0.4}\nbins: {fixed: [{name: box, x: 0.3, y: 0.4}]}\n")
    config = load(path)
    assert config.name == "mine"
    assert config.belt.speed == 0.4
    assert config.model_copy(update={"name": "custom", "belt": load(SMALLEST).belt}) == load(SMALLEST)


def test_a_config_and_a_mapping_are_taken_as_they_are():
    config = load("waste")
    assert load(config) == config
    assert load(SMALLEST) == load({**SMALLEST})
    assert load(config, mismatch=0.5).mismatch == 0.5
    assert load(config, mismatch=0.5).model_copy(update={"mismatch": 1.0}) == config


def test_a_config_cannot_be_changed_in_place():
    with pytest.raises(ValueError, match="frozen"):
        load("nominal").mismatch = 2.0


WRONG = {
    "unknown key": ({"colour": "red"}, "unknown key 'colour'"),
    "unknown key inside": ({"belt": {"sped": 0.2}}, "unknown key 'belt.sped'"),
    "negative mismatch": ({"mismatch": -0.1}, "mismatch is -0.1"),
    "percent 0": ({"limits": {"percent": [0]}}, "limits.percent.0 is 0"),
    "percent 101": ({"limits": {"percent": [40, 101]}}, "limits.percent.1 is 101"),
    "no percent": ({"limits": {"percent": []}}, "limits.percent"),
    "negative percent": ({"limits": {"percent": [-40]}}, "limits.percent.0 is -40"),
    "belt backwards": ({"belt": {"speed": -0.2}}, "belt.speed is -0.2"),
    "belt not a number": ({"belt": {"speed": float("nan")}}, "belt.speed is nan"),
    "range reversed": ({"belt": {"pick_x": [0.3, -0.3]}}, "belt.pick_x runs from 0.3 to -0.3"),
    "window off the belt": ({"belt": {"pick_x": [-0.3, 0.9]}}, "belt.pick_x .* leaves the belt"),
    "lane off the belt": ({"belt": {"lane_y": [-0.45, 0.0]}}, "belt.lane_y .* leaves the belt"),
    "no gaps": ({"belt": {"spacing": [0.0, 0.3]}}, "belt.spacing starts at 0.0"),
    "negative window": ({"motion": {"follow_through": {"window": -0.01}}}, "follow_through.window is -0.01"),
    "falls faster than g": ({"motion": {"follow_through": {"gravity_share": 1.5}}}, "gravity_share is 1.5"),
    "negative jitter": ({"suction": {"jitter": -1e-3}}, "suction.jitter is -0.001"),
    "step too long": ({"timestep": 0.01}, "timestep is 0.01"),
    "no picks": ({"picks_per_shift": 0}, "picks_per_shift is 0"),
    "unknown item": ({"items": ["sofa"]}, "unknown item 'sofa'"),
    "no items": ({"items": []}, "items is"),
    "bin on the belt": ({"bins": {"fixed": [{**BIN, "y": -0.3}]}}, "bin 'box' .* lies on the belt"),
    "wall on the belt": ({"bins": {"fixed": [{**BIN, "y": 0.0399}]}}, "bin 'box' .* lies on the belt"),
    "random on the belt": ({"bins": {"random": {"y": [-0.2, 0.5]}}}, "bins.random .* lies on the belt"),
    "overlap": ({"bins": {"fixed": [BIN, {**BIN, "name": "b", "x": 0.45}]}}, "bin 'b' overlaps bin 'box'"),
    "same name": ({"bins": {"fixed": [BIN, {**BIN, "x": -0.3}]}}, "names .* must differ"),
    "both kinds": ({"bins": {"fixed": [BIN], "random": {}}}, "`fixed` or a section `random`"),
    "neither kind": ({"bins": {}}, "`fixed` or a section `random`"),
    "no bins": ({"bins": None}, "bins is None"),
    "no room": ({"bins": {"fixed": [{**BIN, "size": [0.0, 0.2]}]}}, "bins.fixed.0.size.0 is 0"),
    "thin wall": ({"bins": {"fixed": [BIN], "wall": 0.001}}, "bins.wall is 0.001"),
    "bin for a stranger": ({"bins": {"fixed": [{**BIN, "accepts": ["sofa"]}]}}, "accepts 'sofa'"),
    "item without a bin": ({"bins": {"fixed": [{**BIN, "accepts": ["paper"]}]}}, "no bin accepts item 'metal_can'"),
    "item too heavy for its seal": ({"extra_items": [item("rock", mass=2.0)]}, "seal_force of 'rock'"),
    "item without a size": ({"extra_items": [item("thing", size=(0.1, 0.0, 0.1))]}, "extra_items.0.size.1 is 0"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_value_is_named_in_one_sentence(case):
    changes, message = WRONG[case]
    with pytest.raises(ConfigError, match=message) as caught:
        load({**SMALLEST, **changes})
    assert isinstance(caught.value, ValueError)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400
    assert caught.value.__suppress_context__  # no pydantic traceback in front of the sentence


def test_a_level_without_bins_says_that_the_key_is_missing():
    with pytest.raises(ConfigError, match="key 'bins' is missing"):
        load({})


def test_neighbouring_bins_may_share_a_wall():
    width = 0.22 + 0.010
    config = load({"bins": {"fixed": [BIN, {**BIN, "name": "next", "x": BIN["x"] + width}]}})
    assert len(config.bins.fixed) == 2


def test_unknown_levels_and_missing_files():
    with pytest.raises(ConfigError, match="unknown level 'nowhere'; shipped levels are fast, ideal, nominal"):
        load("nowhere")
    with pytest.raises(ConfigError, match=r"level file 'nowhere\.yaml' does not exist"):
        load("nowhere.yaml")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("bins: [1, 2\nbelt: {", "is not valid YAML"),
        ("- a\n- b\n", "must hold a mapping of settings, it holds list"),
        ("", "must hold a mapping of settings, it holds NoneType"),
        ("just text", "must hold a mapping of settings, it holds str"),
        ("1: 2\n", "unknown key '1'|key 'bins' is missing|1"),
    ],
)
def test_files_that_hold_no_level(tmp_path, text, message):
    path = tmp_path / "cell.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=message) as caught:
        load(path)
    assert "\n" not in str(caught.value)


def test_a_binary_file_is_no_level(tmp_path):
    path = tmp_path / "cell.yaml"
    path.write_bytes(bytes(range(256)))
    with pytest.raises(ConfigError, match="is not valid YAML"):
        load(path)


def test_a_directory_is_no_level(tmp_path):
    folder = tmp_path / "cell.yaml"
    folder.mkdir()
    with pytest.raises(ConfigError, match="does not exist"):
        load(folder)


def test_a_users_own_cell_throws(tmp_path):
    """Own belt, bins, limits and items from one file, through to a measured throw."""
    cell = {
        "mismatch": 0.0,
        "items": ["ball", "cork"],
        "extra_items": [{**item("ball"), "size": [0.06, 0.06, 0.06]}],
        "limits": {"percent": [35]},
        "belt": {"speed": 0.3},
        "bins": {
            "fixed": [
                {"name": "left", "x": -0.3, "y": 0.4, "size": [0.3, 0.3], "accepts": ["ball"]},
                {"name": "right", "x": 0.3, "y": 0.4, "size": [0.3, 0.3], "accepts": ["cork"]},
            ]
        },
    }
    path = tmp_path / "my_cell.yaml"
    path.write_text(yaml.safe_dump(cell))
    core = make_core(str(path), 6)
    assert core.config.name == "my_cell"
    info = core.step(np.zeros((6, 2))).info
    assert set(info["item"]) == {0, 1}
    np.testing.assert_array_equal(info["bin"], info["item"])
    np.testing.assert_array_equal(np.sign(info["target_x"]), np.where(info["item"] == 0, -1.0, 1.0))
    assert info["is_success"].all()
    assert info["landing_error"].max() < 0.01


def test_an_own_item_may_replace_one_of_the_catalogue():
    heavy = item("cork", mass=0.5)
    config = load({**SMALLEST, "items": ["cork"], "extra_items": [heavy]})
    assert config.item_list()[0].mass == 0.5
    assert CATALOGUE["cork"].mass < 0.01
