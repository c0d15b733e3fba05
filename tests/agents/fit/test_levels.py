"""Levels from which a fit begins, and those that it writes."""

from pathlib import Path

import numpy as np
import pytest

from agents.fit import design, writing
from agents.fit.fitted import fit_log
from agents.fit.parameters import level_at, priors, read_level, with_seals
from agents.fit.posterior import SealChance
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.config import LineConfig
from tests.tools.commands import output_of
from tests.tools.fitting import WASTE, level, throw, usual_log

LINE = "cell: {suction: {leak: 0.02}}\nrobots: [{name: first, x: 0.0}]\n"
NAMED = "cell: dense\nrobots: [{name: first, x: 0.0}]\n"


def with_flights(config: ConveyorConfig) -> ConveyorConfig:
    return config.model_copy(update={"fidelity": "flight"})


def test_a_line_gives_its_cell(tmp_path: Path) -> None:
    for text, like in {LINE: LineConfig.load("nominal").cell, NAMED: ConveyorConfig.load("dense")}.items():
        path = tmp_path / "line.yaml"
        path.write_text(text)
        config, is_line = read_level(path)
        assert is_line
        assert config.fidelity == "flight"
        assert config.suction.leak == (0.02 if text == LINE else like.suction.leak)
        assert (config.items, config.bins) == (like.items, like.bins)
    assert read_level("line3")[1]
    assert read_level("waste") == (with_flights(ConveyorConfig.load("waste")), False)


def test_a_fit_of_a_line_writes_a_whole_level_of_its_cell(tmp_path: Path) -> None:
    (tmp_path / "line.yaml").write_text(LINE)
    config, _ = read_level(tmp_path / "line.yaml")
    (tmp_path / "log.csv").write_text(throw(level_at(config, {"tau": 0.012}), 40)[0].text(config.items))
    output_of("fit log.csv --level line.yaml --free tau --out f.yaml", tmp_path)
    loaded = ConveyorConfig.load(tmp_path / "f.yaml")
    assert (loaded.suction.leak, loaded.belt, loaded.bins) == (0.02, config.belt, config.bins)
    assert loaded.suction.tau == pytest.approx(0.012, abs=0.001)
    output_of("evaluate --controller analytic --env PnTRelease-v0 --level f.yaml --picks 8", tmp_path)


def test_fitted_seals_are_values_of_the_level(tmp_path: Path) -> None:
    """Cups of the level that a fit writes seal as often as was fitted."""
    fitted = fit_log(usual_log(), WASTE, priors(WASTE, ["valve", "tau"]))
    low = [SealChance(item, 10, 3, 0.3, 0.1, 0.5) for item in WASTE.items]
    object.__setattr__(fitted, "seals", low)
    path = tmp_path / "f.yaml"
    path.write_text(writing.text(fitted, fitted.posterior.samples(), "waste", path, "it"))
    loaded = with_flights(ConveyorConfig.load(path))
    assert {item.pick_chance for item in loaded.item_list()} == {0.3}
    log, _ = throw(loaded, 240)
    assert 0.2 < np.mean(log.sealed) < 0.36  # of 0.3, less where lips overhang


def test_items_of_the_users_own_keep_their_keys(tmp_path: Path) -> None:
    own = {"name": "lid", "like": "can", "size": [0.07, 0.05, 0.05], "mass": 0.006}
    config = level(items=[*WASTE.items, "lid"], extra_items=[own])
    fitted = fit_log(usual_log(), config, priors(config, ["valve", "tau"]))
    path = tmp_path / "f.yaml"
    base = tmp_path / "base.yaml"
    base.write_text(f"base: waste\nitems: {[*WASTE.items, 'lid']}\nextra_items: [{own}]\n")
    path.write_text(writing.text(fitted, fitted.posterior.samples(), str(base), path, "it"))
    loaded = ConveyorConfig.load(path)
    assert loaded.items == config.items
    lids = [next(item for item in c.item_list() if item.name == "lid") for c in (loaded, config)]
    assert lids[0] == lids[1]
    changed = with_seals(config, {"lid": 0.5}).item_list()[-1]
    assert changed == lids[1].model_copy(update={"pick_chance": 0.5})


def test_a_plan_says_why_it_has_no_throw_of_an_item(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.fit.design.POOL", 60)
    mix = {name: 1.0 for name in WASTE.items if name not in ("cap", "cork")} | {"cork": 1e-4}
    config = level(mix=mix)
    plan = design.plan_throws(config, priors(config, ["valve", "tau"]), 4, 0)
    thrown = {config.items[kind] for kind in plan.throws.kind}
    named = {sentence.removeprefix("No throw of ").partition(":")[0]: sentence for sentence in plan.absent}
    assert named.keys() == set(config.items) - thrown
    assert named["cap"] == "No throw of cap: the level's mix has none."
    assert "none of 60 simulated picks is one" in named["cork"]
    others = [sentence for name, sentence in named.items() if name not in ("cap", "cork")]
    assert others
    assert all("% of what the last chosen throw adds" in sentence for sentence in others)
    shares = [int(sentence.partition("would add ")[2].partition("%")[0]) for sentence in others]
    assert max(shares) <= 100
