"""`agents.levels` lists levels, prints one in full, and writes one to start from."""

from pathlib import Path

import numpy as np
import pytest

from agents.ground import levels
from agents.ground.files import json_text
from agents.ground.levels import FAMILIES, assumed_text, shipped_levels
from agents.ground.places import SHIPPED
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.engine import mujoco
from pnt_gym.reading import parsed_json, yaml_of
from tests.tools.commands import output_of, refused
from tests.tools.plant import plant_text


@pytest.mark.parametrize(("family", "name"), [(family, name) for family, _, name in shipped_levels()])
def test_a_new_level_is_the_old_one_until_it_is_changed(desk: Path, family: str, name: str) -> None:
    output_of(f"levels --new mine.yaml --like {family}/{name}", desk)
    text = (desk / "mine.yaml").read_text()
    assert max(map(len, text.splitlines())) <= 120
    assert text.count("\n# ") + text.count("\n  # ") >= 1
    assert FAMILIES[family].load("mine.yaml") == FAMILIES[family].load(name, name="mine")


def test_a_level_is_printed_in_full_by_name_or_file(desk: Path) -> None:
    assert output_of("levels --show waste", desk) == output_of("levels --show PnT/waste", desk)
    (desk / "plant.yaml").write_text(plant_text())
    text = output_of("levels --show plant.yaml", desk)
    assert "# brick: assumed, as the level does not say: drag 1.05, com_depth 0.5, seal_force 12" in text
    (desk / "full.yaml").write_text(text)
    assert LineConfig.load("full.yaml") == LineConfig.load("plant.yaml")
    assert yaml_of("full.yaml")["cell"]["extra_items"][0]["assumed"][0] == "drag"


def test_what_is_assumed_is_short_on_the_terminal_and_whole_in_a_file(desk: Path) -> None:
    (desk / "plant.yaml").write_text(plant_text())
    config = LineConfig.load("plant.yaml")
    assert "zones (3 of them)" in assumed_text(config)
    written = parsed_json(json_text(levels.values(config)))["assumed"]["alu"]
    assert [zone["chance"] for zone in written["zones"]] == [0.8, 0.7, 0.4]
    assert written["drag"] == 1.15


WRONG = {
    "--show nominal": "level 'nominal' is one of PnT/nominal, PnTLine/nominal, OneJoint/nominal, GripperToss/nominal",
    "--show nowhere": "unknown level 'nowhere'; known are",
    "--show none.yaml": "cannot read level file 'none.yaml': No such file",
    "--like waste": "--like goes with --new FILE.yaml",
    "--new mine.txt": "--new is 'mine.txt'; it must end in .yaml or .yml",
    "--new mine.yaml --like none.yaml": "cannot read level file 'none.yaml'",
    "--new mine.yaml --like old.yaml": "--like is 'old.yaml'; it must be a shipped level",
    "--mjcf .": "--mjcf is '.', which exists and is not empty; give another folder",
    "--new old.yaml": "'old.yaml' exists already; give --new another name",
}


@pytest.mark.parametrize("options", WRONG)
def test_what_cannot_be_shown_or_written_is_one_sentence(desk: Path, options: str) -> None:
    (desk / "old.yaml").write_text("base: waste\n")
    assert WRONG[options] in refused("agents.levels", *options.split())
    assert [path.name for path in desk.iterdir()] == ["old.yaml"]


def test_the_robots_are_written_as_models_that_stand_at_home(tmp_path):
    said = output_of("levels --mjcf models", tmp_path)
    assert "models has the robots t3kr, gripper and ur10e_class" in said
    for name, loops in (("t3kr", 12), ("gripper", 12), ("ur10e_class", 0)):
        folder = tmp_path / "models" / name
        assert {path.name for path in folder.iterdir()} == {f"{name}.xml", "scene.xml", "LICENSE", "README.md"}
        assert (folder / "LICENSE").read_text() == (SHIPPED / "LICENSE").read_text()
        model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        home = data.qpos.copy()
        for _ in range(1000):
            mujoco.mj_step(model, data)
        # The motors hold the robot where the key has it, and its loops stay closed.
        assert np.abs(data.qpos - home).max() < 2e-3
        assert np.abs(data.efc_pos[: data.ne]).max(initial=0.0) < 1e-5
        assert data.ne >= loops
