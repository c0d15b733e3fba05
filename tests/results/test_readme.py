"""What the README shows a reader works as it stands."""

import re
from pathlib import Path

import pytest
import yaml

from pnt_gym.cells.conveyor.config import ConveyorConfig

README = (Path(__file__).resolve().parents[2] / "README.md").read_text(encoding="utf-8")


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


@pytest.mark.parametrize("code", blocks("python"))
def test_python_blocks_run(code):
    exec(compile(code, "README.md", "exec"), {})


def test_the_example_cell_is_a_working_level():
    (text,) = blocks("yaml")
    config = ConveyorConfig.load(yaml.safe_load(text))
    assert config.items == ("can", "pet_05", "lid")
    assert [b.name for b in config.bins.fixed] == ["metal", "plastic"]


def test_every_shipped_level_is_in_the_table():
    for name in ConveyorConfig.level_names():
        assert f"| `{name}` |" in README


def test_make_targets_in_the_readme_exist():
    makefile = (Path(__file__).resolve().parents[2] / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"^make ([a-z-]+)", README, flags=re.MULTILINE):
        assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE), target
