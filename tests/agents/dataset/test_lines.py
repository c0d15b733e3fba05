"""Datasets of decisions at a line of robots: masks, what is hidden, and shifts that come again."""

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import yaml

from agents.dataset.collection import Collection, ControllerRecipe
from agents.ground.places import SHIPPED
from agents.ground.work import Job
from agents.policies.scorer import Scorer
from pnt_gym.cells.line.config import LineConfig
from tests.tools.commands import refused
from tests.tools.datasets import SMALL, collected, column, known, replayed
from tests.tools.line import with_table
from tests.tools.nightly import with_nightly
from tests.tools.throws import SHORT_LINE

pytestmark = pytest.mark.usefixtures("worker_here")
LINE = ("--env", "PnTLine-v0", "--expert", "atc")
BASIC = ("value", "skills3")
BLOCKS = re.findall(r"```python\n(.*?)```", (SHIPPED / "docs" / "datasets.md").read_text(), flags=re.DOTALL)


@pytest.fixture
def levels(here: Path) -> Path:
    """A folder with short shifts: by a table, with robots that differ, and in the air."""
    for base in BASIC:
        (here / f"{base}.yaml").write_text(yaml.safe_dump({"base": base, "duration": 8.0}))
    (here / "flight.yaml").write_text(yaml.safe_dump(SHORT_LINE))
    return here


FLOWN = ("flight", "atc", 12)


@pytest.mark.parametrize(
    ("level", "controller", "throws"),
    with_nightly([("value", "random", 30), ("skills3", "price_beam", 30), FLOWN], [FLOWN]),
)
def test_every_shift_comes_again_bit_for_bit(levels: Path, level: str, controller: str, throws: int) -> None:
    dataset = collected(*LINE, "--level", f"{level}.yaml", "--controller", controller, "--throws", f"{throws}")
    (levels / f"{level}.yaml").unlink()  # a dataset stands by itself
    ends, lengths = replayed(dataset), [told["total_steps"] for told in known(dataset)]
    assert {*ends} == {(False, True)}
    assert sum(lengths[:-1]) < throws <= sum(lengths)
    assert len({told["seed"] for told in known(dataset)}) == len(lengths) > 1


@pytest.mark.usefixtures("levels")
@pytest.mark.parametrize("controller", ["random", "spt"])
def test_masks_are_of_the_decision_that_follows_and_rule_out_nothing_that_was_chosen(controller: str) -> None:
    dataset = collected(*LINE, "--level", "value.yaml", "--controller", controller, "--throws", "20")
    for episode in dataset.iterate_episodes():
        mask = episode.infos["action_mask"]
        assert (mask.dtype, mask.shape) == (np.bool_, (len(episode) + 1, 16))
        assert mask[np.arange(len(episode)), episode.actions].all()
        assert not mask[-1].any()
        # An observation says of every choice first whether there is one.
        assert np.array_equal(mask, episode.observations[:, 13:].reshape(-1, 16, 18)[:, :, 0] > 0.5)
    assert not column(dataset, "outcome", "invalid_action").any()
    assert len({*np.concatenate([episode.actions for episode in dataset.iterate_episodes()])}) > 3


CONFUSED: dict[str, Any] = {
    "base": "skills3",
    "duration": 40.0,
    "cell": {"classifier": {"confusion": {"can": {"can": 0.5, "tray": 0.5}}}},
}
"""A line that takes cans for trays now and then."""


def test_what_is_hidden_of_a_choice_becomes_of_it_when_it_is_chosen(here: Path) -> None:
    (here / "confused.yaml").write_text(yaml.safe_dump(with_table(CONFUSED, here)))
    dataset = collected(*LINE, "--level", "confused.yaml", "--throws", "60")
    (episode,) = dataset.iterate_episodes()

    def hidden(name: str) -> np.ndarray:
        choices = np.stack([column(dataset, "hidden", f"{name}_{k}") for k in range(16)], axis=1)
        assert np.array_equal(np.isfinite(choices), episode.infos["action_mask"][:-1])
        return choices[np.arange(len(episode)), episode.actions]

    for name in ("true_kind", "picked", "sorted", "value"):
        assert np.array_equal(hidden(name), column(dataset, "outcome", name))
        assert len({*hidden(name)}) > 1
    assert np.array_equal(hidden("is_success"), episode.infos["is_success"][1:])
    assert (hidden("is_success") > hidden("sorted")).any()
    value = column(dataset, "outcome", "value")
    assert np.array_equal(hidden("worth")[value > 0.0], value[value > 0.0])
    assert (column(dataset, "outcome", "item") != hidden("true_kind")).any()


@pytest.mark.usefixtures("levels")
def test_where_throws_are_simulated_the_objects_are_hidden_and_no_end_is_foretold() -> None:
    dataset = collected(*LINE, "--level", "flight.yaml", "--controller", "atc", "--throws", "10")
    names = {name.rpartition("_")[0] for name in dataset.storage.metadata["columns"]["hidden"]}
    assert names == {"true_kind", "worth", "mass", "height", "seal", "delay"}
    mass, height = column(dataset, "hidden", "mass_0"), column(dataset, "hidden", "height_0")
    assert ((mass > 0.001) & (mass < 1.0) & (height > 0.001) & (height < 0.5)).all()
    (first, *_) = dataset.iterate_episodes()
    assert np.isfinite(first.infos["landing_error"][1:]).any()


@pytest.mark.usefixtures("levels")
def test_the_figures_of_a_shift_are_those_of_its_decisions() -> None:
    dataset = collected(*LINE, "--level", "skills3.yaml", "--controller", "fifo", "--throws", "50")
    for episode, told in zip(dataset.iterate_episodes(), known(dataset), strict=True):
        outcome = dict(zip(dataset.storage.metadata["columns"]["outcome"], episode.infos["outcome"].T, strict=True))
        assert told["shift_attempts"] == len(episode)
        assert told["shift_value_per_min"] == pytest.approx(np.nansum(outcome["value"]) * 60.0 / 8.0)
        assert len(told["shift_picks_by_robot"]) == 3
        assert not any(name.startswith("shift_") for name in outcome)
        assert {*outcome["robot"][:-1]} <= {0, 1, 2}
        assert np.array_equal(outcome["robot"][:-1], outcome["by"][1:])


def test_another_table_of_throws_in_the_same_file_is_another_dataset(levels: Path) -> None:
    level = with_table({"base": "single", "duration": 5.0}, levels)
    config, file = LineConfig.load(level), Path(level["chances"])

    def digest() -> str:
        return jobs_of(config)[0].key

    before, told = digest(), json.loads(file.read_text())
    assert digest() == before
    file.write_text(json.dumps(told | {"picked": [1.0] * 4}))
    assert digest() != before


def jobs_of(config: LineConfig) -> list[Job]:
    thrower = ControllerRecipe("atc", {}, False, None)
    return Collection("PnTLine-v0", config, "choice", 4, 5, thrower, "dataset", 0).jobs("throws", 10)


POLICIES = SHIPPED / "results" / "policies" / "PnTLine-v0" / "value"
OWN = """
import gymnasium as gym

class Last:
    name = "last"
    def reset(self, seed): pass
    def learn(self, outcome): pass
    def act(self, observation):
        there = observation.features[:, 13:].reshape(-1, 16, 18)[:, :, 0] > 0.5
        return 15 - there[:, ::-1].argmax(axis=1)

gym.register("LineAlone-v0", entry_point="pnt_gym.envs.line:PnTLineEnv")
gym.register("LineCut-v0", entry_point="pnt_gym.envs.line:PnTLineEnv", max_episode_steps=4)
"""


@pytest.fixture
def own(levels: Path) -> Iterator[Path]:
    """A module of the user's with a controller and environments."""
    (levels / "mine.py").write_text(OWN)
    Scorer.linear().save(levels / "scorer.npz")
    yield levels
    for env_id in ("LineAlone-v0", "LineCut-v0"):
        gym.registry.pop(env_id, None)
    sys.modules.pop("mine", None)


@pytest.mark.usefixtures("own")
@pytest.mark.parametrize(
    ("controller", "name"),
    [
        (str(POLICIES / "residual_ppo"), "residual_ppo of residual_ppo"),
        ("scorer.npz", "scorer"),
        ("mine:Last", "last"),
        ("guided_beam", "guided_beam"),
    ],
)
def test_whoever_decides_on_a_line_collects(controller: str, name: str) -> None:
    dataset = collected(*LINE, "--level", "value.yaml", "--controller", controller, "--throws", "9")
    assert dataset.storage.metadata["algorithm_name"] == name
    assert {*replayed(dataset)} == {(False, True)}


@pytest.mark.usefixtures("own")
@pytest.mark.parametrize(("env", "length"), [("LineAlone-v0", 0), ("LineCut-v0", 4)])
def test_a_line_without_a_vector_form_is_collected_one_by_one(env: str, length: int) -> None:
    options = ("--env", f"mine:{env}", "--level", "value.yaml", "--expert", "atc", "--throws", "9")
    assert "steps 4 lines one by one" in refused(*SMALL, *options)
    dataset = collected(*options, "--num-envs", "1")
    assert {*replayed(dataset)} == {(False, True)}
    assert all(told["total_steps"] == length for told in known(dataset) if length)


@pytest.mark.nightly
@pytest.mark.usefixtures("here")
def test_the_page_clones_the_expert_among_the_choices_that_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    collected(*LINE, "--level", "value", "--controller", "expert", "--throws", "9", name="pnt_gym/line/value-expert-v0")
    block = BLOCKS[2].replace("(2000, 256)", "(20, 64)").replace("picks=32", "picks=1")
    exec(compile(block, "datasets.md", "exec"), {"__name__": "page"})
    assert 10.0 < float(capsys.readouterr().out) < 200.0
