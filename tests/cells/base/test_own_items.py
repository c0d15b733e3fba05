"""Items of a level's own: what a level does not give is that of the shape or of a similar item, and is *assumed*."""

from typing import Any

import pytest

from pnt_gym.cells.base.catalogue import BY_SHAPE, CATALOGUE, OF_ITEM, SEEN_ITEMS, TYPICAL, complete_item
from pnt_gym.cells.base.items import SHAPES, Item
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.errors import ConfigError

LID: dict[str, Any] = {"name": "lid", "shape": "box", "size": [0.07, 0.07, 0.012], "mass": 0.006}
BIN = {"name": "all", "x": 0.0, "y": 0.45, "size": [0.3, 0.3]}


def load(*entries: dict[str, Any], **changes: Any) -> ConveyorConfig:
    level = {"items": [entry["name"] for entry in entries], "extra_items": list(entries), "bins": {"fixed": [BIN]}}
    return ConveyorConfig.load({**level, **changes})


@pytest.mark.parametrize("shape", SHAPES)
def test_a_shape_has_the_usual_values_of_the_catalogue(shape):
    alike = [CATALOGUE[name] for name in SEEN_ITEMS if CATALOGUE[name].shape == shape]
    for key in BY_SHAPE:
        values = sorted(getattr(item, key) for item in alike)
        assert TYPICAL[shape][key] in values
        assert sum(value <= TYPICAL[shape][key] for value in values) >= len(values) / 2
        assert sum(value >= TYPICAL[shape][key] for value in values) >= len(values) / 2


def test_name_shape_size_and_mass_are_enough():
    (lid,) = load(LID).item_list()
    assert (lid.drag, lid.seal_force) == (TYPICAL["box"]["drag"], TYPICAL["box"]["seal_force"])
    assert set(lid.assumed) == {*BY_SHAPE, *OF_ITEM}
    (known,) = load({**LID, "drag": 0.9, "pick_chance": 0.8}).item_list()
    assert (known.drag, known.pick_chance) == (0.9, 0.8)
    assert set(lid.assumed) - set(known.assumed) == {"drag", "pick_chance"}


def test_an_item_is_like_another():
    (small,) = load({"name": "small", "like": "can", "size": [0.09, 0.053, 0.053], "mass": 0.010}).item_list()
    can = CATALOGUE["can"]
    assert (small.shape, small.drag, small.seal_force) == ("cylinder", can.drag, can.seal_force)
    assert small.residue == can.residue > 0.0
    assert small.cup_radius is None  # fitted to the size
    assert {"shape", "drag", "residue"} <= set(small.assumed)
    assert not {"size", "mass", "name", "source", "like"} & set(small.assumed)
    twin = complete_item({"name": "twin", "like": "can"})
    assert Item(**{**twin, "source": can.source, "assumed": ()}) == can.model_copy(update={"name": "twin"})
    itself = complete_item({"name": "can", "like": "can", "pick_chance": 0.5})
    assert itself["assumed"] == ()
    flat = complete_item({**LID, "like": "can"})
    assert flat["rolling_friction"] == TYPICAL["box"]["rolling_friction"]


def test_a_level_written_in_full_says_what_is_assumed_and_is_the_level():
    config = load(LID)
    again = ConveyorConfig.load(config.model_dump(mode="json"))
    assert again == config
    assert again.assumed() == {
        "lid": {key: getattr(config.item_list()[0], key) for key in config.item_list()[0].assumed}
    }
    assert ConveyorConfig.load("waste").assumed() == {}


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "unknown twin": ({"name": "x", "like": "cann"}, "item 'x' is like unknown item 'cann'; did you mean 'can'?"),
    "no twin": ({"name": "x", "like": ["can"]}, "item 'x' is like unknown item"),
    "name alone": ({"name": "x"}, "3 problems:\n- key 'extra_items.0.shape' is missing\n- key"),
    "grams": ({**LID, "mass": 60}, "extra_items.0.mass is 60: input should be less than or equal to 5 kg"),
    "millimetres": ({**LID, "size": [70, 0.07, 0.012]}, "size.0 is 70: input should be less than or equal to 1 m"),
    "two sizes": ({**LID, "size": [0.07, 0.012]}, "extra_items.0.size is [0.07, 0.012]: input should have 3 values"),
    "a name of words": ({**LID, "name": "HDPE lid"}, "'HDPE lid': it must begin with a small letter, and hold small"),
    "too heavy": ({**LID, "mass": 2.0}, "seal_force of 'lid' is 12.0 N, assumed, but must exceed its weight of 19.620"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_item_is_named(case):
    entry, sentence = WRONG[case]
    with pytest.raises(ConfigError) as caught:
        load(entry)
    assert sentence in str(caught.value)


def test_an_item_that_never_comes_is_told():
    with pytest.raises(ConfigError, match=r"extra_items: 'lid' is not in `items`, .* name it there"):
        ConveyorConfig.load({"extra_items": [LID]})


def test_new_items_leave_out_what_the_base_says_of_the_old_ones():
    dense = ConveyorConfig.load("dense")
    assert dense.classifier.confusion
    fresh = ConveyorConfig.load({"base": "dense", "items": ["can", "carton"], "bins": {"fixed": [BIN]}})
    assert fresh.classifier.confusion == {}
    level = {"mix": {"paper": 3, "metal_can": 1}, "classifier": {"confusion": {"paper": {"paper": 1.0}}}}
    two = ConveyorConfig.load({**level, "items": ["metal_can", "paper"]})
    assert (two.mix, list(two.classifier.confusion)) == ({"paper": 3.0, "metal_can": 1.0}, ["paper"])
    added = ConveyorConfig.load({"base": "newcomers", "items": ["can", "wet_paper"]})
    assert [item.name for item in added.extra_items] == ["wet_paper"]


def test_every_wrong_key_has_a_line():
    with pytest.raises(ConfigError) as caught:
        ConveyorConfig.load({"binz": 1, "percent": [40], "belt": {"sped": 1, "speed": -1}, "mismatch": 9})
    assert str(caught.value) == (
        "config has 5 problems:\n"
        "- unknown key 'belt.sped' (perhaps belt.speed)\n"
        "- unknown key 'binz' (perhaps bins)\n"
        "- unknown key 'percent' (perhaps limits.percent)\n"
        "- mismatch is 9: input should be less than or equal to 3\n"
        "- belt.speed is -1: input should be greater than 0 m/s"
    )
    with pytest.raises(ConfigError, match=r"limits.percent is 40: input should be a list, as in \[40\]"):
        ConveyorConfig.load({"limits": {"percent": 40}})
    with pytest.raises(ConfigError, match=r"bins is \[\]: input should be a section, with keys fixed, random and rim"):
        ConveyorConfig.load({"bins": []})
    with pytest.raises(ConfigError, match=r"^config has 45 problems:\n(- .*\n){12}- and 33 more$"):
        ConveyorConfig.load({"bins": {"fixed": [{**BIN, "name": f"bin {i}", "y": -0.3} for i in range(9)]}})
