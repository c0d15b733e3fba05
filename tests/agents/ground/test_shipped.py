"""Policies that ship have names that hold in a checkout and in an installed package."""

import sys
import tomllib
from contextlib import closing
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import pytest

import pnt_gym
from agents.controllers import make_controller
from agents.ground import shipped
from agents.ground.cli import UsageError
from agents.ground.environments import make_vector
from agents.ground.places import SHIPPED
from agents.ground.shipped import POLICIES, PREFIX, is_shipped, module_of
from agents.learning import trained
from agents.results.entries import is_learned
from pnt_gym.cells.conveyor.config import ConveyorConfig
from tests.tools.commands import figures_of, output_of, refused

HAND_TEXTS = [*sorted((SHIPPED / "docs").glob("*.md")), SHIPPED / "README.md"]


@pytest.mark.parametrize("name", POLICIES)
def test_a_name_is_a_policy_of_its_environment_that_is_in_the_wheel(name: str) -> None:
    place, policy = shipped.place(PREFIX + name), POLICIES[name]
    assert pnt_gym.shipped_policy(name) == place
    assert is_learned(PREFIX + name)
    if policy.controller:
        assert place == ConveyorConfig.file_of("cells")
        assert trained.resolve(PREFIX + name, None, None, None)[:2] == (policy.env, "cells")
        return
    files = [place] if place.suffix == ".npz" else [place / part for part in ("policy.npz", "args.yml", "env.yaml")]
    wheel = tomllib.loads((SHIPPED / "pyproject.toml").read_text())["tool"]["hatch"]["build"]["targets"]["wheel"]
    for file in files:
        assert file.is_file()
        path = f"/{file.relative_to(SHIPPED).as_posix()}"
        assert any(fnmatch(path, pattern) for pattern in wheel["include"]), path
    if place.is_dir():
        assert trained.resolve(PREFIX + name, None, None, None)[0] == policy.env


def test_names_of_modules_and_paths_are_no_shipped_names() -> None:
    assert module_of("mine:Class") == "mine"
    assert module_of("shipped:waste-sac") is module_of("analytic") is None
    assert not is_shipped("analytic")
    assert shipped.place("runs/mine") == Path("runs/mine")
    with pytest.raises(UsageError, match=r"'shipped:waste-sak'; did you mean 'shipped:waste-sac'\? known are "):
        shipped.place("shipped:waste-sak")


def test_a_shipped_policy_is_judged_by_its_name_and_by_its_folder(tmp_path: Path) -> None:
    options = "--env PnTRelease-v0 --level waste --picks 16 --num-envs 16"
    by_name = figures_of(f"evaluate --controller shipped:waste-sac {options}", tmp_path)
    by_folder = figures_of(f"evaluate --controller {shipped.place('shipped:waste-sac')} {options}", tmp_path)
    assert by_name.pop("controller") == "shipped:waste-sac"
    assert by_folder.pop("controller") != "shipped:waste-sac"
    assert by_name == by_folder


class _WithoutTorch:
    """Finds no torch."""

    def find_spec(self, name: str, *_: Any) -> None:
        if name.partition(".")[0] == "torch":
            raise ImportError(name)


def test_what_adapts_is_judged_in_cells_that_nobody_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "torch", raising=False)
    monkeypatch.setattr(sys, "meta_path", [_WithoutTorch(), *sys.meta_path])
    options = "--num-envs 2 --picks 80"
    figures = figures_of(f"evaluate --controller shipped:cells {options}", tmp_path)
    assert (figures["env"], figures["level"]) == ("PnTAdapt-v0", "cells")
    assert figures["landing_error_second_half_m"] < 0.025
    said = "needs observations of the previous landing"
    assert said in refused("agents.evaluate", "--controller", "shipped:cells", "--env", "PnTRelease-v0")


def test_shipped_policies_decide_on_lines_and_release(tmp_path: Path) -> None:
    line = "--env PnTLine-v0 --level skills3 --shifts 1 --num-envs 1"
    figures = figures_of(f"evaluate {line} --controller shipped:line/skills3", tmp_path)
    assert figures["controller"] == "shipped:line/skills3"
    assert figures["value_per_min"] > 100.0
    scored = figures_of(f"evaluate {line} --controller shipped:line/value", tmp_path)
    assert scored["value_per_min"] != figures["value_per_min"]


def test_a_wrong_shipped_name_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    sentence = "unknown shipped policy 'shipped:nobody'; known are shipped:waste-sac, "
    assert sentence in refused("agents.evaluate", "--controller", "shipped:nobody")
    assert sentence in refused("agents.evaluate", "--env", "PnTLine-v0", "--controller", "shipped:nobody")
    assert sentence in refused("agents.roster", "--where", "nobody")
    said = "'shipped:line/value' decides on a line; here controllers correct throws"
    with closing(make_vector("PnTRelease-v0", "waste", 1, 1)) as env, pytest.raises(UsageError, match=said):
        make_controller("shipped:line/value", env)


def test_the_lists_of_controllers_and_levels(tmp_path: Path) -> None:
    text = output_of("roster", tmp_path)
    for word in ("ridge", "price_beam", "oracle_drift", *(PREFIX + name for name in POLICIES)):
        assert word in text
    assert output_of("roster --where waste-sac", tmp_path).strip() == str(shipped.place("shipped:waste-sac"))
    levels = output_of("levels", tmp_path)
    assert all(PREFIX + name in levels for name in POLICIES)


@pytest.mark.parametrize("page", HAND_TEXTS, ids=lambda page: page.name)
def test_no_page_names_a_policy_by_a_path(page: Path) -> None:
    assert "results/policies/" not in page.read_text(encoding="utf-8")
