"""Datasets of throws: what Minari reads back is what the environment gives again."""

import re
import shutil
import socket
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import gymnasium as gym
import minari
import numpy as np
import pytest
import yaml

from agents.dataset.episodes import LEAST_SEED, episode_seeds
from agents.ground.environments import stream_seed
from agents.ground.places import POLICY, SHIPPED
from agents.ground.versions import versions
from pnt_gym.cells.conveyor.observation import HIDDEN
from tests.tools.commands import answered, refused
from tests.tools.datasets import NAME, SMALL, WORK, collected, known, replayed
from tests.tools.nightly import with_nightly

pytestmark = pytest.mark.usefixtures("worker_here")
BLOCKS = re.findall(r"```python\n(.*?)```", (SHIPPED / "docs" / "datasets.md").read_text(), flags=re.DOTALL)


@pytest.fixture
def dataset(sets: Path) -> minari.MinariDataset:
    return minari.load_dataset(NAME)


def test_every_throw_comes_again_bit_for_bit(dataset: minari.MinariDataset) -> None:
    assert (dataset.total_episodes, dataset.total_steps) == (22, 22)
    assert replayed(dataset) == [(True, False)] * 22
    assert len({tuple(episode.actions[0]) for episode in dataset.iterate_episodes()}) == 22


def test_what_was_no_throw_stands_there_too(dataset: minari.MinariDataset) -> None:
    """With what it cost, and without a landing."""
    columns, episodes = dataset.storage.metadata["columns"]["outcome"], [*dataset.iterate_episodes()]
    told = {name: [episode.infos["outcome"][1, columns.index(name)] for episode in episodes] for name in columns}
    picked, dropped = (np.array(told[name]) == 1.0 for name in ("picked", "dropped"))
    assert (~picked).any()
    assert dropped.any()
    thrown = picked & ~dropped
    for values in (told["landing_along"], told["landing_across"], [e.infos["landing_error"][1] for e in episodes]):
        assert np.array_equal(np.isfinite(values), thrown)
    assert not any(episode.infos["is_success"][1] for episode, was in zip(episodes, thrown, strict=True) if not was)
    assert all(np.isfinite(episode.rewards).all() for episode in episodes)


def test_seeds_are_those_of_no_other_use(dataset: minari.MinariDataset) -> None:
    seeds = [told["seed"] for told in known(dataset)]
    assert seeds == [*islice(episode_seeds("dataset", 0, 0), 22)]
    assert not {*seeds} & {*islice(episode_seeds("dataset", 0, 1), 1000)}
    assert not {*seeds} & {
        *islice(episode_seeds("evaluate", 0, 0), 1000),
        *islice(episode_seeds("dataset", 1, 0), 1000),
    }
    highest = max(stream_seed(role, seed) for role in ("train", "practice", "evaluate") for seed in range(50))
    assert highest + 100_000 < LEAST_SEED <= min(seeds)


def test_what_is_hidden_is_the_truth_and_not_what_is_seen(dataset: minari.MinariDataset) -> None:
    names = dataset.storage.metadata["columns"]["hidden"]
    assert names == [one.name for one in HIDDEN]
    hidden = np.array([episode.infos["hidden"][1] for episode in dataset.iterate_episodes()])
    mass, delay = hidden[:, names.index("mass")], hidden[:, names.index("delay")]
    seen = np.array([episode.observations[0] for episode in dataset.iterate_episodes()])
    measured = np.exp(0.8 * seen[:, 17] - 4.2)  # ln_mass, by the centre and scale of the manual
    assert 0.02 < np.std(np.log(measured / mass)) < 0.3
    assert (delay > 0.0).all()
    assert (delay < 0.1).all()


def test_it_says_what_it_is(sets: Path, dataset: minari.MinariDataset) -> None:
    told = dataset.storage.metadata
    assert dataset.env_spec.id == "PnTRelease-v0"
    assert dataset.env_spec.kwargs == {"level": "waste"}
    assert (told["author"], told["author_email"]) == ({"Ada"}, {"ada@here"})
    assert (told["algorithm_name"], told["code_permalink"]) == ("random", "https://here/code")
    assert f"mujoco=={versions()['mujoco']}" in told["requirements"]
    assert told["pnt_gym"]["versions"] == versions()
    assert told["pnt_gym"]["level"]["name"] == "waste"
    assert told["minari_version"] == minari.__version__
    assert all(f"{one.name} [{one.unit}], {one.meaning}" in told["description"] for one in HIDDEN)
    assert all(name in told["description"] for name in told["columns"]["outcome"])
    assert minari.list_local_datasets().keys() == {NAME}
    assert str(SHIPPED) not in str(told)
    assert str(sets) not in str(told)


def test_the_scores_are_mean_returns_on_other_throws(dataset: minari.MinariDataset) -> None:
    told, env = dataset.storage.metadata, gym.make("PnTRelease-v0", level="waste")
    random, returns = np.random.default_rng(stream_seed("evaluate", 0, 0)), []
    seeds = [*islice(episode_seeds("evaluate", 0, 0), 8)]
    # Random actions are drawn for all cells at a time, for four cells twice; the planner's own throw is zero.
    actions = np.concatenate([random.uniform(-1.0, 1.0, (4, 2)) for _ in range(2)]).astype(np.float32)
    for given in (actions, np.zeros((8, 2))):
        rewards = []
        for seed, action in zip(seeds, given, strict=True):
            env.reset(seed=seed)
            rewards.append(env.step(action)[1])
        returns.append(np.mean(rewards))
    assert [told["ref_min_score"], told["ref_max_score"]] == returns
    assert told["num_episodes_average_score"] == 8
    assert minari.get_normalized_score(dataset, returns[1]) == 1.0


def test_a_name_that_is_taken_is_refused_and_a_killed_command_swept(sets: Path) -> None:
    (sets / ".dataset.999999999.tmp").mkdir()
    before = {path: path.read_bytes() for path in sets.rglob("*") if path.is_file()}
    assert f"'{NAME}' exists already" in refused(*SMALL, "--throws", "4")
    assert {path: path.read_bytes() for path in sets.rglob("*") if path.is_file()} == before
    assert collected("--throws", "4").total_steps == 4
    assert not [*sets.glob(".*.tmp")]
    minari.delete_dataset("a_b/c-v0")
    shutil.rmtree(sets / "a_b")


CELLS = {
    "shifts": ("random", "--env", "PnTConveyor-v0", "--level", "short.yaml", "--throws", "13"),
    "drift": ("ema", "--env", "PnTAdapt-v0", "--level", "drift.yaml", "--throws", "7", "--expert", "oracle_drift"),
    "assembly": ("analytic", "--env", "OneJointAssembly-v0", "--level", "mild.yaml", "--throws", "16"),
    "learner": ("virtual_goal", "--env", "OneJointSort-v0", "--practice", "16", "--throws", "5"),
    "mode": ("random", "--env", "GripperToss-v0", "--action-mode", "release_point", "--throws", "4"),
    "alone": ("random", "--env", "alone:ReleaseAlone-v0", "--throws", "6"),
    "silent": ("random", "--env", "alone:ReleaseSilent-v0", "--throws", "6"),
}
ALONE = """
import gymnasium as gym
from pnt_gym.envs.conveyor import PnTReleaseEnv

class Silent:
    def __init__(self, core):
        self.__dict__["inner"] = core
    def __getattr__(self, name):
        if name in ("hidden", "inner"):
            raise AttributeError(name)
        return getattr(self.inner, name)

class SilentEnv(PnTReleaseEnv):
    @classmethod
    def make_core(cls, *arguments):
        return Silent(super().make_core(*arguments))

gym.register("ReleaseAlone-v0", entry_point="pnt_gym.envs.conveyor:PnTReleaseEnv")
gym.register("ReleaseSilent-v0", entry_point="alone:SilentEnv")
gym.register("ReleaseClass-v0", entry_point=PnTReleaseEnv)
"""


@pytest.fixture
def alone(here: Path) -> Iterator[None]:
    """Environments of the user's without a vector form, where nothing is hidden, or nothing tells what is."""
    (here / "alone.py").write_text(ALONE)
    yield
    for name in ("Alone", "Silent", "Class"):
        gym.registry.pop(f"Release{name}-v0", None)
    sys.modules.pop("alone", None)


@pytest.mark.usefixtures("alone")
@pytest.mark.parametrize("which", with_nightly(CELLS, ["drift", "silent"]))
def test_any_task_and_controller(here: Path, which: str) -> None:
    (here / "short.yaml").write_text(yaml.safe_dump({"base": "waste", "picks_per_shift": 3}))
    (here / "mild.yaml").write_text(yaml.safe_dump({"mismatch": 0.1}))
    (here / "drift.yaml").write_text(yaml.safe_dump({"base": "drift_mix", "fidelity": "flight", "picks_per_shift": 3}))
    who, *options = CELLS[which]
    dataset = collected("--controller", who, *options)
    for level in here.glob("*.yaml"):  # a dataset stands by itself
        level.unlink()
    ends, throws = replayed(dataset), int(options[options.index("--throws") + 1])
    lengths = [told["total_steps"] for told in known(dataset)]
    assert sum(lengths[:-1]) < throws <= sum(lengths)
    assert dataset.storage.metadata["algorithm_name"] == who
    belt = which in ("shifts", "drift")
    assert {*ends} == {(not belt, belt)}
    if belt:
        assert lengths == [3] * (5 if which == "shifts" else 3)
    if which == "assembly":
        assert {*lengths} == {1, 2}
    assert dataset.storage.metadata["pnt_gym"]["practice"] == (16 if which == "learner" else 0)
    assert ("hidden" in dataset.storage.metadata["columns"]) == (which != "silent")


@pytest.mark.usefixtures("alone")
def test_an_environment_that_no_file_can_name_is_refused_before_anything_is_thrown(here: Path) -> None:
    words = refused(*SMALL, "--env", "alone:ReleaseClass-v0", "--throws", "4")
    assert "register it with entry_point 'MODULE:CLASS'" in words
    assert not (here / "kept").exists()


def test_nothing_is_fetched_or_sent(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise AssertionError("a connection")

    for name in ("socket", "create_connection", "getaddrinfo"):
        monkeypatch.setattr(socket, name, refuse)
    assert collected("--throws", "4").total_steps == 4


def test_the_expert_is_the_policy_that_ships(here: Path) -> None:
    options = ("--controller", "expert", "--throws", "32", "--score-throws", "32", "--num-envs", "16", *WORK)
    code, words = answered("agents.dataset", *options)
    assert code == 0, words
    dataset = minari.load_dataset("pnt_gym/release/waste-expert-v0")
    told = dataset.storage.metadata
    assert told["algorithm_name"] == f"sac of {POLICY.name}"
    assert told["ref_max_score"] > told["ref_min_score"] + 0.2
    error, reward = np.array([(one.infos["landing_error"][1], one.rewards[0]) for one in dataset.iterate_episodes()]).T
    assert np.isfinite(error).sum() > 16
    assert np.nanmean(error) < 0.03
    assert reward[np.isfinite(error)].mean() > 1.0


@pytest.mark.parametrize("block", BLOCKS[:2], ids=["replay", "learn"])
def test_the_page_does_what_it_says(sets: Path, block: str, capsys: pytest.CaptureFixture[str]) -> None:
    for many, few in (("steps=4000", "steps=4"), ("steps=2000", "steps=4"), ("picks=500", "picks=16")):
        block = block.replace(many, few)
    exec(compile(block, "datasets.md", "exec"), {"__name__": "page"})
    assert "fit" not in block or 0.0 < float(capsys.readouterr().out) < 1.0
