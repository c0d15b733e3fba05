"""Zones of items: what may stand in a level, and what is refused in a sentence."""

import pytest

from pnt_gym.cells.base.catalogue import CATALOGUE
from pnt_gym.cells.base.items import Item
from pnt_gym.cells.base.zones import MOST_ZONES
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.errors import ConfigError


def level(**keys):
    return {"base": "waste", "items": ["mine"], "extra_items": [{"name": "mine", "like": "tray", **keys}]}


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"zones": [{"at": [0.9, 0.0], "size": [0.3, 0.5]}]}, "|at| + size is 1.2, but must be from 0 to 1"),
        ({"zones": [{"at": [0.0, -0.7], "size": [0.3, 0.5]}]}, "a zone of size 0.5 at y = -0.7 is partly outside"),
        ({"zones": [{}] * (MOST_ZONES + 1)}, "at most 6"),
        ({"zones": [{"depth": 0.05}]}, "depth of a zone of 'mine' is 0.05 m, but must be"),
        ({"zones": [{"shape": "star"}]}, "'rect', 'disc' or 'bowl'"),
    ],
)
def test_what_is_no_surface_is_refused_in_a_sentence(keys, sentence):
    with pytest.raises(ConfigError) as complaint:
        ConveyorConfig.load(level(**keys))
    text = str(complaint.value)
    assert sentence in text
    assert "\n" not in text
    assert len(text) < 600


def test_an_item_like_another_has_its_surface():
    mine = ConveyorConfig.load(level(mass=0.02)).item_list()[0]
    assert mine.zones == CATALOGUE["tray"].zones
    assert mine.zones
    assert mine.look == CATALOGUE["tray"].look


def test_items_survive_their_text():
    for item in CATALOGUE.values():
        assert Item.model_validate(item.model_dump(mode="json")) == item
