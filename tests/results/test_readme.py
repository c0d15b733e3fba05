"""What README and pages show a reader works as it stands."""

import re
import shlex
from importlib import import_module
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
import tyro
import yaml

import pnt_gym  # noqa: F401 - registers the environments
from agents.ground.console import COMMANDS
from docs.pages.made import hand_text
from pnt_gym.cells.conveyor.config import ConveyorConfig

ROOT = Path(__file__).resolve().parents[2]
PAGES = {"README.md": ROOT / "README.md", **{p.relative_to(ROOT).as_posix(): p for p in ROOT.glob("docs/**/*.md")}}
BUILT = ("docs/_build/", "docs/results/")
"""Folders that a build of the site leaves."""
TEXTS = {
    name: hand_text(path.read_text(encoding="utf-8")) for name, path in PAGES.items() if not name.startswith(BUILT)
}
SCREENS = 110
"""Lines that the README may have: two screens."""


def blocks(language):
    """Blocks of code by page; those with a file name are the guide's, which has a test of its own."""
    return [
        pytest.param(code, id=f"{name}-{index}")
        for name, text in TEXTS.items()
        for index, code in enumerate(re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE))
    ]


def commands():
    """Words of every command line that a page shows, the guide's aside."""
    texts = [block.values[0].replace("\\\n", "") for block in blocks("sh") if "extend" not in block.id]
    lines = [" ".join(line.split()) for text in texts for line in text.splitlines()]
    return sorted({line for line in lines if line and not line.startswith("#")})


def reads_a_file(block):
    """Whether a block reads a dataset or a log; tests/agents/dataset and tests/agents/fit have these files."""
    return any(page in block.id for page in ("datasets", "docs/fit"))


@pytest.mark.parametrize("code", [block for block in blocks("python") if not reads_a_file(block)])
def test_python_blocks_run(code):
    exec(compile(code, "page", "exec"), {})


def shown(*keys):
    """The example on the page of levels that says these keys beside its base, as a mapping."""
    levels = [yaml.safe_load(block.values[0]) for block in blocks("yaml") if block.id.startswith("docs/levels.md")]
    (found,) = (level for level in levels if set(keys) == set(level) - {"base", "name"})
    return found


def test_the_example_levels_work():
    cell = ConveyorConfig.load(shown("mismatch", "items", "extra_items", "limits", "bins"))
    held = ConveyorConfig.load(shown("grip"))
    assert cell.items == ("can", "pet_05", "lid")
    assert [b.name for b in cell.bins.fixed] == ["metal", "plastic"]
    assert held.grip.limit
    assert held.grip.safety == "surface"
    soft, chosen = ConveyorConfig.load(shown("cup")), ConveyorConfig.load(shown("belt", "dispatch", "patience"))
    assert soft.swings
    assert soft.cup.fitted
    assert (chosen.belt.gap, chosen.dispatch) == ("edge", "atc")
    some = ConveyorConfig.load(shown("throwable"))
    assert (some.planner, some.throwable.drag_area, some.throwable.drag_shift) == ("auto", 2.5, 0.05)
    wrong = ConveyorConfig.load(shown("classifier", "bins"))
    assert wrong.pick.fails
    assert wrong.bins.emptied == 8
    assert wrong.confusion()[wrong.items.index("can"), wrong.items.index("can_crushed")] == 0.05
    assert ConveyorConfig.load(shown("reward")).items == ConveyorConfig.load("waste").items


@pytest.mark.parametrize("base", ["nominal", "waste", "unseen", "tight", "fast"])
def test_the_example_of_a_plain_cell_makes_any_level_plain(base):
    said = shown("belt", "bins", "grip", "cup", "pick", "dispatch") | {"base": base}
    plain = ConveyorConfig.load(f"{base}_plain")
    assert ConveyorConfig.load(said).model_copy(update={"name": plain.name}) == plain
    assert plain.model_copy(update={"name": base}) != ConveyorConfig.load(base)


def test_the_example_of_a_reward_pays_what_the_page_says():
    """At least 1 for a throw in its bin, 1.2 at most, nothing beside it beyond 0.10 m, nor for a pick that failed."""
    env = gym.make_vec("PnTRelease-v0", num_envs=32, level=shown("reward"))
    env.reset(seed=0)
    _, reward, *_, info = env.step(np.zeros(env.action_space.shape))
    hit, picked, error = info["is_success"], info["picked"], info["landing_error"]
    assert hit.any()
    assert (picked & ~hit).any()
    assert (~picked).any()
    np.testing.assert_allclose(reward[picked], (hit + 0.2 * np.clip(1.0 - error / 0.10, 0.0, None))[picked])
    assert (reward[~picked] == 0.0).all()


@pytest.mark.parametrize("line", commands())
def test_commands_exist_with_these_options(line):
    """Make knows the target, the command parses the words; `reproduce` checks its paper itself."""
    words = shlex.split(line, comments=True)
    if words[0] == "make":
        makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
        assert re.search(rf"^{words[1]}:", makefile, flags=re.MULTILINE)
    elif words[0] == "python" and words[1].startswith("benchmarks/"):
        assert (ROOT / words[1]).is_file()
    else:
        count = 2 if words[1] == "line" else 1
        module, given = (
            (COMMANDS[" ".join(words[1 : 1 + count])][0], words[1 + count :])
            if words[0] == "pnt-gym"
            else (f"{words[2].removeprefix('agents.')}.__main__", words[3:])
        )
        tyro.cli(import_module(f"agents.{module}").Arguments, args=given)


def test_the_readme_is_two_screens():
    assert len(TEXTS["README.md"].splitlines()) <= SCREENS


@pytest.mark.parametrize("name", TEXTS)
def test_links_to_files_lead_somewhere(name):
    """On a code host, made parts included: Sphinx checks those of the site."""
    text = PAGES[name].read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?:|#)([^)#\s]+)[^)]*\)", text):
        assert (PAGES[name].parent / target).exists(), target
