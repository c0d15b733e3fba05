"""The plant on the page of levels: it loads as it stands, and every mistake in it is one sentence."""

from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym  # noqa: F401
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError
from pnt_gym.reading import yaml_text
from tests.tools.plant import plant, plant_text

GONE = object()


def changed(changes: Mapping[str, Any]) -> dict[str, Any]:
    """The plant with some values changed, by their place: `cell.items`, `robots.1.x`."""
    level: Any = deepcopy(plant())
    for place, value in changes.items():
        *above, key = [int(part) if part.isdigit() else part for part in place.split(".")]
        section = level
        for part in above:
            section = section[part]
        if value is GONE:
            del section[key]
        else:
            section[key] = value
    return level


def test_the_plant_loads_at_the_first_attempt_and_throws(tmp_path: Path):
    (tmp_path / "plant.yaml").write_text(plant_text())
    config = LineConfig.load(tmp_path / "plant.yaml")
    assert config.name == "plant"
    assert config.cell.items == ("hdpe", "brick", "alu")
    assert config.cell.shares().tolist() == [0.5, 0.3, 0.2]
    assert config.values().tolist() == [1.0, 1.0, 3.0]
    assert config.can_take().tolist() == [[True] * 3, [True, True, False], [True, False, False]]
    assert set(config.assumed()) == {"hdpe", "brick", "alu"}
    env = gym.make("PnTLine-v0", level={"base": str(tmp_path / "plant.yaml"), "throws": "flight", "duration": 10.0})
    _, info = env.reset(seed=0)
    taken = 0
    for _ in range(6):
        _, _, over, _, info = env.step(np.int64(0))
        taken += bool(info["picked"])
        if over:
            break
    assert taken > 0
    env.close()


@pytest.mark.parametrize("base", LineConfig.level_names())
def test_the_plant_may_differ_from_any_line(base):
    config = LineConfig.load({**plant(), "base": base})
    assert (config.cell.mix, config.value.of) == ({"hdpe": 5.0, "brick": 3.0, "alu": 2.0}, {"alu": 3.0})
    alike = changed({"cell.mix": GONE, "value": GONE})
    assert LineConfig.load({**alike, "base": base}).cell.mix is None
    assert LineConfig.load({**alike, "base": base}).value.of == {}


def test_a_cell_is_a_file_beside_the_line_or_differences_from_it(tmp_path: Path):
    (tmp_path / "cell.yaml").write_text(yaml_text(plant()["cell"]))
    for number, cell in enumerate(
        ("cell.yaml", {"base": "cell.yaml"}, {"base": "cell.yaml", "limits": {"percent": [40]}})
    ):
        (tmp_path / f"line{number}.yaml").write_text(yaml_text({**changed({"cell": cell}), "base": "skills3"}))
    lines = [LineConfig.load(tmp_path / f"line{number}.yaml") for number in range(3)]
    assert lines[0].cell == lines[1].cell
    assert lines[0].cell.belt.neighbours == "ghosts"
    assert ConveyorConfig.load(tmp_path / "cell.yaml").belt.neighbours == "solid"
    assert lines[0].cell.mix == {"hdpe": 5.0, "brick": 3.0, "alu": 2.0}
    assert (lines[0].cell.limits.percent, lines[2].cell.limits.percent) == ((30.0,), (40.0,))
    assert lines[0].value.of == {"alu": 3.0}
    (tmp_path / "fast.yaml").write_text("base: line0.yaml\ncell: {belt: {speed: 0.3}}\n")
    fast = LineConfig.load(tmp_path / "fast.yaml")
    assert (fast.cell.belt.speed, fast.cell.items) == (0.3, ("hdpe", "brick", "alu"))


def test_a_shipped_cell_serves_a_line():
    config = LineConfig.load({"cell": "nominal"})
    assert config.cell.items == ConveyorConfig.load("nominal").items
    assert config.value.of == {}


MISTAKES: dict[str, tuple[dict[str, Any], str]] = {
    "two items misspelled": (
        {"cell.items": ["hpde", "brik", "alu"]},
        "items: unknown items 'hpde' and 'brik'; did you mean 'hdpe' and 'brick'? known are ",
    ),
    "items not named": ({"cell.items": GONE}, "extra_items: 'hdpe', 'brick' and 'alu' are not in `items`"),
    "items described where they are named": (
        {"cell.items": plant()["cell"]["extra_items"], "cell.extra_items": GONE},
        "input should be a list of names; describe an item of your own in extra_items and name it here",
    ),
    "an item described twice": (
        {"cell.extra_items.1.name": "hdpe"},
        "extra_items: 'hdpe' stands there more than once; items: unknown item 'brick'",
    ),
    "no items": ({"cell.items": None}, "items is None: input should be a list"),
    "mass in grams": (
        {"cell.extra_items.0.mass": 60},
        "extra_items.0.mass is 60: input should be less than or equal to 5",
    ),
    "size in millimetres": (
        {"cell.extra_items.1.size": [165, 60, 60]},
        "extra_items.1.size.0 is 165: input should be less than or equal to 1 m; extra_items.1.size.1 is 60: input",
    ),
    "diameter and length": (
        {"cell.extra_items.0.size": [0.2, 0.08]},
        "size is [0.2, 0.08]: input should have 3 values",
    ),
    "a bottle with two diameters": (
        {"cell.extra_items.0.size": [0.2, 0.08, 0.06]},
        "cylinder 'hdpe' needs one diameter, but W = 0.08 m and H = 0.06 m",
    ),
    "other words for keys": (
        {"cell.extra_items.0": {"name": "hdpe", "shape": "cylinder", "weight": 0.06, "dimensions": [0.2, 0.08]}},
        "unknown key 'extra_items.0.weight'; unknown key 'extra_items.0.dimensions'; key 'extra_items.0.size' is "
        "missing; key 'extra_items.0.mass' is missing",
    ),
    "another shape": (
        {"cell.extra_items.0.shape": "bottle"},
        "extra_items.0.shape is 'bottle': input should be 'ellipsoid', 'cylinder' or 'box'",
    ),
    "like a misspelled item": (
        {"cell.extra_items.2.like": "tary"},
        "'alu' is like unknown item 'tary'; did you mean 'tray'?",
    ),
    "bin for strangers": (
        {"cell.bins.fixed.0.accepts": ["hpde", "glass"]},
        "bin 'bottles': unknown items 'hpde' and 'glass'; did you mean 'hdpe'? known are hdpe, brick, alu; no "
        "bin accepts item 'hdpe'",
    ),
    "bins as a list": (
        {"cell.bins": plant()["cell"]["bins"]["fixed"]},
        "input should be a section, with keys fixed, r",
    ),
    "skills and values of strangers": (
        {"robots.1.skills": ["pet"], "value.of": {"glass": 2.0, "pet": 1.0}},
        "value.of: unknown items 'glass' and 'pet'; known are hdpe, brick, alu; skills of robot 'second': unknown item "
        "'pet'; known are",
    ),
    "percent as a number": ({"robots.1.percent": 30}, "robots.1.percent is 30: input should be a list, as in [30]"),
    "speed with its unit": ({"cell.belt.speed": "0.4 m/s"}, "belt.speed is '0.4 m/s': input should be a valid number"),
    "keys one level too high": (
        {"belt": {"speed": 0.4}, "robot": []},
        "unknown key 'belt' (perhaps cell.belt); unknown key 'robot' (perhaps robots)",
    ),
    "the assumed cup is too weak": (
        {"cell.extra_items.1.mass": 2.0},
        "seal_force of 'brick' is 12.0 N, assumed, but must",
    ),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_told_with_all_that_is_wrong(case):
    changes, sentences = MISTAKES[case]
    with pytest.raises(ConfigError) as caught:
        LineConfig.load(changed(changes))
    assert [part for part in sentences.split("; ") if part not in str(caught.value)] == []


def test_values_that_do_not_fit_together_are_told_at_once_when_each_is_possible():
    single = {"cell.belt.speed": "0.4 m/s", "duration": -1}
    together = {"cell.bins.fixed.1.x": -0.2, "robots.1.x": 0.3, "value.of": {"glass": 2.0}}
    for changes, said in (
        ({**single, **together}, ("belt.speed is '0.4 m/s'", "duration is -1")),
        ({"duration": -1, **together}, ("bin 'cartons' overlaps bin 'bottles'", "duration is -1")),
        ({"robots.1.x": 0.3, "value.of": {"glass": 2.0}}, ("windows that overlap", "value.of: unknown item 'glass'")),
    ):
        with pytest.raises(ConfigError) as caught:
            LineConfig.load(changed(changes))
        head, *problems = str(caught.value).split("\n- ")
        assert head == f"config has {len(problems)} problems:"
        assert [part for part in said if part not in str(caught.value)] == []


def test_a_misspelled_item_is_told_once():
    with pytest.raises(ConfigError) as caught:
        LineConfig.load(changed({"cell.items": ["hdpe", "brik", "alu"], "duration": -1}))
    assert "skills" not in str(caught.value)
