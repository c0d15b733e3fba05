"""Throws in chunks: neither who makes them nor a stop on the way changes what they are."""

from collections.abc import Iterator
from contextlib import closing
from itertools import chain, islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.controllers import make_controller
from agents.dataset import collection
from agents.dataset.episodes import Episode, episode_seeds
from agents.ground.environments import make_vector
from agents.judging.loop import observed, practise
from tests.tools.commands import answered
from tests.tools.datasets import SMALL, collected, known, replayed
from tests.tools.nightly import with_nightly

pytestmark = pytest.mark.usefixtures("worker_here")


@pytest.mark.parametrize("jobs", with_nightly(["1", "2"], ["1"]))
def test_neither_processes_nor_cells_change_what_is_thrown(
    here: Path, monkeypatch: pytest.MonkeyPatch, jobs: str
) -> None:
    monkeypatch.setattr("agents.dataset.collection.CHUNK", 4)
    one = collected("--controller", "analytic", "--throws", "10")
    other = collected("--controller", "analytic", "--throws", "10", "--num-envs", "3", "--jobs", jobs, name="other-v0")
    assert [told["seed"] for told in known(one)] == [told["seed"] for told in known(other)]
    for mine, theirs in zip(one.iterate_episodes(), other.iterate_episodes(), strict=True):
        assert np.array_equal(mine.observations, theirs.observations)
        assert np.array_equal(mine.rewards, theirs.rewards)
        np.testing.assert_array_equal(mine.infos["hidden"], theirs.infos["hidden"])


def test_chunks_follow_each_other_and_each_throws_otherwise(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.dataset.collection.CHUNK", 6)
    monkeypatch.setattr("agents.dataset.offline.PIECE", 4)
    dataset = collected("--throws", "15")
    chunks = [[*islice(episode_seeds("dataset", 0, n), count)] for n, count in enumerate((6, 6, 3))]
    assert [told["seed"] for told in known(dataset)] == [*chain(*chunks)]
    assert len({tuple(episode.actions[0]) for episode in dataset.iterate_episodes()}) == 15
    assert replayed(dataset) == [(True, False)] * dataset.storage.metadata["total_episodes"]


def test_noise_shifts_the_planners_actions_and_chunks_take_deviations_in_turn(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agents.dataset.collection.CHUNK", 6)
    dataset = collected("--controller", "analytic", "--noise", "0", "0.2", "--throws", "18")
    actions = np.concatenate([episode.actions for episode in dataset.iterate_episodes()])
    assert (actions[:6] == 0.0).all()
    assert (actions[12:] == 0.0).all()
    assert (actions[6:12] != 0.0).all()
    assert 0.08 < actions[6:12].std() < 0.4
    assert replayed(dataset) == [(True, False)] * 18
    assert dataset.storage.metadata["pnt_gym"]["noise"] == [0.0, 0.2]
    assert (
        "by analytic with normal noise on the actions (standard deviation 0, 0.2, in turn)."
        in (dataset.storage.metadata["description"])
    )


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--noise", "0.1", "-0.2"), "--noise is -0.2; it must be from 0 to 10"),
        (("--noise", "nan"), "--noise is nan; it must be from 0 to 10"),
        (
            ("--env", "PnTLine-v0", "--level", "single", "--noise", "0.1"),
            "--noise has no effect: actions of environment 'PnTLine-v0' are choices, not numbers",
        ),
    ],
)
def test_noise_that_cannot_act_is_refused(here: Path, options: tuple[str, ...], sentence: str) -> None:
    assert answered("agents.dataset", *options) == (2, f"error: {sentence}\n")


@pytest.mark.parametrize("after", [0, 4])
def test_what_is_stopped_goes_on_and_leaves_no_dataset(here: Path, monkeypatch: pytest.MonkeyPatch, after: int) -> None:
    def stopped(name: str, env: Any, episodes: Iterator[Episode], *_: Any) -> None:
        assert len([*islice(episodes, after)]) == after
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("agents.dataset.offline.write", stopped)
        code, words = answered(*SMALL, "--throws", "5", "--name", "a_b/c-v0")
    assert (code, words) == (130, "interrupted\n")
    assert [*(here / "sets").rglob("*")] == []
    kept = {path: path.read_bytes() for path in (here / "kept").iterdir()}
    assert len(kept) == 3
    # What is there is not thrown again, and what is not comes as it was.
    throws = next(path for path in kept if path.name.startswith("throws-0"))
    throws.unlink()
    with monkeypatch.context() as patch:
        patch.setattr("agents.dataset.offline.write", stopped)
        answered(*SMALL, "--throws", "5", "--name", "a_b/c-v0")
    assert {path: path.read_bytes() for path in (here / "kept").iterdir()} == kept
    assert collected("--throws", "5").total_steps == 5
    assert not (here / "kept").exists()


@pytest.mark.nightly
def test_what_was_learned_travels(here: Path) -> None:
    """A chunk acts as the controller that has practised would."""
    options = ("--env", "OneJointSort-v0", "--practice", "48", "--throws", "8", "--seed", "3")
    dataset = collected("--controller", "virtual_goal", *options)
    with closing(make_vector("OneJointSort-v0", num_envs=4)) as env:
        controller = make_controller("virtual_goal", env)
        controller.reset(3)
        practise(controller, env, 48, 3)
    kind = dataset.storage.metadata["columns"]["outcome"].index("kind")
    for episode in dataset.iterate_episodes():
        seen = observed(episode.observations[:1], episode.infos["outcome"][:1, kind])
        assert np.array_equal(controller.act(seen)[0], episode.actions[0])
    assert len({tuple(episode.actions[0]) for episode in dataset.iterate_episodes()}) > 1


def test_an_expert_practises_as_often_as_asked(here: Path) -> None:
    """Random actions do not learn, but the option reaches the expert, whose mean return it changes."""
    options = ("--env", "OneJointSort-v0", "--throws", "4", "--expert", "virtual_goal")
    scores = [
        collected(*options, "--practice", practice, name=f"p{practice}-v0").storage.metadata["ref_max_score"]
        for practice in ("1", "48")
    ]
    assert scores[0] != scores[1]


def test_chunks_keep_every_bit_of_an_episode(tmp_path: Path) -> None:
    random = np.random.default_rng(0)

    def episode(seed: int, throws: int) -> Episode:
        image = random.integers(0, 255, (throws + 1, 5, 8, 8), dtype=np.uint8)
        seen = {"image": image, "more": {"vector": random.standard_normal((throws + 1, 3)).astype(np.float32)}}
        told = {"kind": random.standard_normal(throws + 1), "landing_error": np.full(throws + 1, np.nan)}
        actions, rewards = random.standard_normal((throws, 2)).astype(np.float32), random.standard_normal(throws)
        return Episode(seed, seen, actions, rewards, throws == 3, told, {"mass": random.standard_normal(throws)})

    def flat(found: Any) -> list[Any]:
        if isinstance(found, dict):
            return [part for name, value in found.items() for part in (name, *flat(value))]
        return [(found.dtype, found.shape, found.tobytes())] if isinstance(found, np.ndarray) else [found]

    given = [episode(2**53 - 1, 3), episode(2**31, 1), episode(2**40, 4)]
    (tmp_path / "a.npz").write_bytes(collection.pack(given))
    assert [flat(vars(one)) for one in collection.unpack(tmp_path / "a.npz")] == [flat(vars(one)) for one in given]
    assert collection.pack(collection.unpack(tmp_path / "a.npz")) == collection.pack(given)
