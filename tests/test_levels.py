"""Levels of any kind of cell: read by name, file, mapping or config, from the cell's own folder."""

import pytest
import yaml

from pnt_gym import levels
from pnt_gym.config import CellConfig, load
from pnt_gym.errors import ConfigError
from pnt_gym.sections import Section


class Oven(Section):
    name: str = "custom"
    heat: float = 200.0


@pytest.fixture
def shelf(tmp_path, monkeypatch):
    """Shipped levels of the conveyor in the folder itself, those of the oven in a folder of its own."""
    for path, data in (("nominal.yaml", {"bins": {}}), ("oven/nominal.yaml", {}), ("oven/hot.yaml", {"heat": 300.0})):
        file = tmp_path / path
        file.parent.mkdir(exist_ok=True)
        file.write_text(yaml.safe_dump(data))
    monkeypatch.setattr(levels, "_shipped", lambda folder: tmp_path / folder)
    return tmp_path


def test_every_cell_has_its_own_levels(shelf):
    assert levels.level_names() == ("nominal",)
    assert levels.level_names("oven") == ("hot", "nominal")
    assert levels.level_names("fridge") == ()
    assert levels.read_level("oven", Oven, "hot", {}) == Oven(name="hot", heat=300.0)
    assert levels.read_level("oven", Oven, "nominal", {"heat": 90.0}) == Oven(name="nominal", heat=90.0)
    with pytest.raises(ConfigError, match="unknown level 'cold'; shipped levels are hot, nominal, or give a YAML file"):
        levels.read_level("oven", Oven, "cold", {})


def test_a_file_a_mapping_and_a_config_are_read_alike(shelf):
    config = Oven(name="hot", heat=300.0)
    assert levels.read_level("oven", Oven, shelf / "oven" / "hot.yaml", {}) == config
    assert levels.read_level("oven", Oven, {"name": "hot", "heat": 300.0}, {}) == config
    assert levels.read_level("oven", Oven, config, {}) == config


def test_the_config_of_another_cell_is_refused():
    with pytest.raises(ConfigError, match="level is a Oven; this cell is described by a CellConfig") as caught:
        levels.read_level("", CellConfig, Oven(), {})
    assert "\n" not in str(caught.value)


def test_a_config_written_in_full_is_read_back_the_same(tmp_path):
    """What a training run keeps of its level is the level."""
    config = load("waste", mismatch=0.5)
    path = tmp_path / "env.yaml"
    path.write_text(yaml.safe_dump(config.model_dump(mode="json"), sort_keys=False))
    assert load(path) == config
