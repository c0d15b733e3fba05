"""Small datasets for tests, and whether what is in them comes out of their environments again."""

from __future__ import annotations

from typing import Any

import minari
import numpy as np

from agents.throws import LANDING
from tests.tools.commands import answered

WORK = ("--jobs", "1", "--work", "kept")
SMALL = ("agents.dataset", "--score-throws", "8", "--num-envs", "4", "--expert", "analytic", *WORK)
NAME = "pnt_gym/release/waste-random-v0"


def collected(*arguments: str, name: str = "a_b/c-v0") -> minari.MinariDataset:
    code, words = answered(*SMALL, "--name", name, *arguments)
    assert code == 0, words
    return minari.load_dataset(name)


def known(dataset: minari.MinariDataset) -> list[dict[str, Any]]:
    return list(dataset.storage.get_episode_metadata(dataset.episode_indices))


def replayed(dataset: minari.MinariDataset) -> list[tuple[bool, bool]]:
    """Whether each episode terminated or was truncated, after everything in it came out of the environment again."""
    env, ends = dataset.recover_environment(), []
    columns = dataset.storage.metadata["columns"]
    for episode, told in zip(dataset.iterate_episodes(), known(dataset), strict=True):
        observation, info = env.reset(seed=told["seed"])
        assert np.array_equal(observation, episode.observations[0])
        assert info["kind"] == episode.infos["outcome"][0, columns["outcome"].index("kind")]
        for k, action in enumerate(episode.actions):
            hidden = env.unwrapped.core.hidden()
            observation, reward, terminated, truncated, info = env.step(action)
            assert np.array_equal(observation, episode.observations[k + 1])
            assert reward == episode.rewards[k]
            assert (terminated, truncated) == (episode.terminations[k], episode.truncations[k])
            found = dict(zip(columns["outcome"], episode.infos["outcome"][k + 1], strict=True))
            found |= {name: episode.infos[name][k + 1] for name in ("landing_error", "is_success")}
            assert found.keys() == info.keys()
            if info.get("dropped"):  # its landing is no throw's
                info |= dict.fromkeys(LANDING, np.nan)
            np.testing.assert_array_equal([*found.values()], [float(info[name]) for name in found])
            if hidden:
                np.testing.assert_array_equal(episode.infos["hidden"][k + 1], np.concatenate([*hidden.values()]))
                assert [*hidden] == columns["hidden"]
        assert len(episode) == told["total_steps"] == len(episode.observations) - 1
        ends.append((bool(terminated), bool(truncated)))
    return ends
