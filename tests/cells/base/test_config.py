"""Levels of any kind of cell: differences from a base, by name, file, mapping or config, from the cell's own folder."""

from typing import ClassVar

import pytest
import yaml

from pnt_gym.cells.base import config as levels
from pnt_gym.cells.base.config import LevelConfig, Section, serialize_level
from pnt_gym.cells.base.merging import MergeRules
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.errors import ConfigError
from pnt_gym.reading import yaml_text

FAMILIES = (ConveyorConfig, OneJointConfig, GripperConfig)
SHIPPED = [(family, name) for family in FAMILIES for name in family.level_names()]


class Grill(Section):
    top: float = 0.0
    turns: int = 0


class Rack(Section):
    shelves: tuple[int, ...] = ()
    spit: Grill | None = None
    width: float = 0.4


class Oven(LevelConfig):
    folder: ClassVar[str] = "oven"
    rules: ClassVar[MergeRules] = MergeRules(alternatives={"rack": ("shelves", "spit")})

    heat: float = 200.0
    rack: Rack = Rack()
    grill: Grill = Grill()


class Fridge(LevelConfig):
    """A cell without shipped levels."""

    folder: ClassVar[str] = "fridge"

    cold: float = 4.0


SHELF = {
    "nominal": {"grill": {"top": 250.0}},
    "hot": {"heat": 300.0, "rack": {"shelves": [1, 3]}},
    "hotter": {"base": "hot", "heat": 320.0, "grill": {"turns": 2}},
    "chicken": {"base": "hotter", "rack": {"spit": {"turns": 9}}},
    "hen": {"base": "egg"},
    "egg": {"base": "hen"},
    "snake": {"base": "snake"},
}


@pytest.fixture(autouse=True)
def shelf(tmp_path, monkeypatch):
    """Shipped levels of the oven; the other cells keep theirs."""
    folder, real = tmp_path / "oven", levels.shipped_folder
    folder.mkdir()
    for name, data in SHELF.items():
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(data))
    monkeypatch.setattr(
        levels, "shipped_folder", lambda robot: tmp_path / robot if robot in ("oven", "fridge") else real(robot)
    )
    return folder


def test_every_cell_has_its_own_levels():
    assert Oven.level_names() == tuple(sorted(SHELF))
    assert Fridge.level_names() == ()
    assert Oven.load("hot").heat == 300.0
    assert Oven.load("nominal", heat=90.0).heat == 90.0
    assert Oven.file_of("hot").stem == "hot"
    for find in (Oven.load, Oven.file_of):
        with pytest.raises(ConfigError, match=r"unknown level 'cold'; known are chicken, egg, .*, or give a"):
            find("cold")


def test_a_level_is_its_differences_from_the_nominal_one():
    assert Oven.load("hot") == Oven(name="hot", heat=300.0, rack=Rack(shelves=(1, 3)), grill=Grill(top=250.0))
    assert Oven.load() == Oven.load("nominal") == Oven(name="nominal", grill=Grill(top=250.0))
    assert Oven.load({}) == Oven(grill=Grill(top=250.0))
    assert Oven.load({"mismatch": 0.5}) == Oven(mismatch=0.5, grill=Grill(top=250.0))


def test_a_family_without_shipped_levels_differs_from_its_defaults(tmp_path):
    assert Fridge.load({"cold": 1.0}) == Fridge(cold=1.0)
    path = tmp_path / "ice.yaml"
    path.write_text("cold: -18.0\n")
    assert Fridge.load(path) == Fridge(name="ice", cold=-18.0)


def test_a_base_is_followed_to_the_end_and_sections_are_merged_key_by_key():
    assert Oven.load("hotter") == Oven(
        name="hotter", heat=320.0, rack=Rack(shelves=(1, 3)), grill=Grill(top=250.0, turns=2)
    )
    assert Oven.load({"base": "hotter", "grill": {"turns": 5}}).grill == Grill(top=250.0, turns=5)


def test_keys_that_exclude_each_other_drop_those_of_the_base():
    assert Oven.load("chicken").rack == Rack(spit=Grill(turns=9))
    assert Oven.load({"base": "chicken", "rack": {"shelves": [4]}}).rack == Rack(shelves=(4,))
    # A key beside them excludes nothing, and who gives both has both.
    assert Oven.load({"base": "chicken", "rack": {"width": 0.3}}).rack == Rack(spit=Grill(turns=9), width=0.3)
    both = Oven.load({"base": "chicken", "rack": {"shelves": [4], "spit": {"top": 1.0}}}).rack
    assert both == Rack(shelves=(4,), spit=Grill(top=1.0, turns=9))


def test_a_section_given_as_an_object_is_complete():
    assert Oven.load({"base": "hotter", "grill": Grill(turns=1)}).grill == Grill(turns=1)


def test_a_base_may_be_a_file_beside_the_shipped_ones(tmp_path):
    first, second = tmp_path / "mine.yaml", tmp_path / "yours.yaml"
    first.write_text("base: hot\nmismatch: 0.25\n")
    second.write_text(yaml.safe_dump({"base": str(first), "heat": 310.0}))
    assert Oven.load(second) == Oven.load("hot", name="yours", mismatch=0.25, heat=310.0)
    assert Oven.load({"base": str(first)}) == Oven.load("hot", name="custom", mismatch=0.25)
    assert Oven.load({"base": first}) == Oven.load("hot", name="custom", mismatch=0.25)


def test_a_base_may_lie_beside_the_file_that_names_it(tmp_path):
    (tmp_path / "ours.yaml").write_text("mismatch: 0.25\n")
    (tmp_path / "mine.yaml").write_text("base: ours.yaml\nlimits: {percent: [30]}\n")
    config = ConveyorConfig.load(tmp_path / "mine.yaml")
    assert (config.name, config.mismatch, config.limits.percent) == ("mine", 0.25, (30.0,))


def test_a_users_file_that_is_called_nominal_differs_from_the_shipped_one(tmp_path):
    path = tmp_path / "nominal.yaml"
    path.write_text("heat: 20.0\n")
    assert Oven.load(path) == Oven(name="nominal", heat=20.0, grill=Grill(top=250.0))


@pytest.mark.parametrize(
    ("level", "said"),
    [
        ("hen", "levels are their own base: hen -> egg -> hen"),
        ("egg", "levels are their own base: egg -> hen -> egg"),
        ("snake", "levels are their own base: snake -> snake"),
        ({"base": "hen"}, "levels are their own base: hen -> egg -> hen"),
        ({"base": "cold"}, "unknown level 'cold'; known are"),
        ({"base": "cold.yaml"}, "level file 'cold.yaml' does not exist"),
        ({"base": 3}, "base is 3; it must be the name of a level or a YAML file"),
        ({"base": None}, "base is None; it must be"),
        ({"base": ["hot"]}, "it must be the name of a level or a YAML file"),
        ({"base": {"heat": 1.0}}, "it must be the name of a level or a YAML file"),
        ({"base": "hot", "haet": 1.0}, "unknown key 'haet'"),
        ({"base": "hot", "grill": 7}, "grill is 7"),
        ({"base": "hot", "name": ""}, "name is ''"),
    ],
)
def test_a_wrong_base_or_difference_is_named_in_one_sentence(level, said):
    with pytest.raises(ConfigError, match=said) as caught:
        Oven.load(level)
    assert "\n" not in str(caught.value)
    assert caught.value.__suppress_context__ or caught.value.__cause__ is None


def test_changes_replace_whole_values_of_the_level():
    assert Oven.load("hotter", grill={"turns": 1}).grill == Grill(turns=1)
    assert Oven.load("hotter", name="mine").name == "mine"
    assert Oven.load(Oven.load("hotter"), heat=1.0) == Oven.load("hotter", heat=1.0)


def test_a_file_a_mapping_and_a_config_are_read_alike(shelf):
    config = Oven.load("hot")
    assert Oven.load(shelf / "hot.yaml") == config
    assert Oven.load(str(shelf / "hot.yaml")) == config
    assert Oven.load({"name": "hot", **SHELF["hot"]}) == config
    assert Oven.load(config) == config


def test_a_level_is_not_changed_by_being_read():
    mine = {"base": "hot", "grill": {"turns": 3}}
    Oven.load(mine, heat=2.0)
    assert mine == {"base": "hot", "grill": {"turns": 3}}


def test_the_config_of_another_cell_is_refused():
    with pytest.raises(ConfigError, match="level is a Oven; this cell is described by a ConveyorConfig") as caught:
        ConveyorConfig.load(Oven())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("family", "name"), SHIPPED)
def test_a_level_written_in_full_or_in_short_is_read_back_the_same(family, name, tmp_path):
    """What a training run keeps of its level is the level."""
    config = family.load(name, mismatch=0.5)
    path = tmp_path / "env.yaml"
    path.write_text(yaml.safe_dump(config.model_dump(mode="json"), sort_keys=False))
    assert family.load(path) == config
    assert family.load(serialize_level(config)) == config
    assert family.load({"base": name, "name": name, "mismatch": 0.5}) == config


def test_a_level_is_written_as_json_can_hold_it(tmp_path):
    assert serialize_level("hot") == "hot"
    assert serialize_level(tmp_path / "a.yaml") == str(tmp_path / "a.yaml")
    assert serialize_level({"limits": {"percent": (30, 40)}}) == {"limits": {"percent": [30, 40]}}
    assert Oven.load(serialize_level(Oven.load("hotter"))) == Oven.load("hotter")


BAD_NAMES = ("a/b", "../../x", "a\\b", ".", "..", ".hidden", "", "a\nb", "a\0b", "\u202ea", "x" * 101)


@pytest.mark.parametrize("name", BAD_NAMES)
def test_a_name_that_would_lie_elsewhere_or_break_a_line_is_refused(name):
    with pytest.raises(ConfigError, match=r"^config: name is ") as caught:
        ConveyorConfig.load({"name": name})
    assert "\n" not in str(caught.value)


GOOD_NAMES = ("Müll, 2. Schicht", "line|2", "a: b", "`x`", "hall 2", "x" * 100, "<b>", "1e5", "010")


@pytest.mark.parametrize("name", GOOD_NAMES)
def test_any_other_name_will_do(name, tmp_path):
    config = ConveyorConfig.load({"name": name})
    (tmp_path / "level.yaml").write_text(yaml_text(config.model_dump(mode="json")), encoding="utf-8")
    assert ConveyorConfig.load(tmp_path / "level.yaml") == config


@pytest.mark.parametrize(
    ("level", "said"),
    [
        ({"mismatch": True}, "mismatch is True: input should be a number"),
        ({"motion": {"dwell": False}}, "motion.dwell is False: input should be a number"),
        ({"grip": {"safety": True}}, "grip.safety is True: input should be a number"),
        ({"picks_per_shift": True}, "picks_per_shift is True: input should be a number"),
        ({"mismatch": "0.5"}, "mismatch is '0.5': input should be a number, not text; write 0.5 without quotes"),
        ({"mismatch": "1:30"}, "mismatch is '1:30': input should be a valid number"),
        ({"belt": {"speed": "1e-1"}}, "belt.speed is '1e-1': input should be a number, not text; write 1e-1 without"),
        ({"limits": {"percent": ["40", 60]}}, "limits.percent is .*not text; write 40 without quotes"),
        ({"limits": {"percent": [True, 60]}}, "limits.percent is .*not true or false"),
    ],
)
def test_truths_and_text_are_no_numbers_at_any_depth(level, said):
    with pytest.raises(ConfigError, match=said):
        ConveyorConfig.load(level)
