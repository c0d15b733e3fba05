"""Small datasets for tests, and whether what is in them comes out of their environments again."""

from typing import Any

import minari
import numpy as np

from agents.dataset.episodes import FIGURES
from agents.ground.infos import LANDING
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
        entry = of_entry(columns, episode, 0)
        np.testing.assert_equal({name: entry[name] for name in info}, info)
        for k, action in enumerate(episode.actions):
            hidden = getattr(env.unwrapped.core, "hidden", dict)()
            observation, reward, terminated, truncated, info = env.step(action)
            assert np.array_equal(observation, episode.observations[k + 1])
            assert reward == episode.rewards[k]
            assert (terminated, truncated) == (episode.terminations[k], episode.truncations[k])
            figures = {name: info.pop(name) for name in [*info] if name.startswith(FIGURES)}
            if info.get("dropped"):  # its landing is no throw's
                info |= dict.fromkeys(LANDING, np.nan)
            np.testing.assert_equal(of_entry(columns, episode, k + 1), info)
            if hidden:
                np.testing.assert_array_equal(episode.infos["hidden"][k + 1], np.concatenate([*hidden.values()]))
                assert [*hidden] == columns["hidden"]
        np.testing.assert_equal({name: told[name] for name in told if name.startswith(FIGURES)}, figures)
        assert len(episode) == told["total_steps"] == len(episode.observations) - 1
        ends.append((bool(terminated), bool(truncated)))
    return ends


def of_entry(columns: dict[str, list[str]], episode: minari.EpisodeData, k: int) -> dict[str, Any]:
    """What `infos` tell in one entry, but for what is hidden, by the keys of the environment's info."""
    found = dict(zip(columns["outcome"], episode.infos["outcome"][k], strict=True))
    return found | {name: values[k] for name, values in episode.infos.items() if name not in columns}


def column(dataset: minari.MinariDataset, which: str, name: str) -> np.ndarray:
    """A column of `outcome` or `hidden`, of all throws of all episodes."""
    at = dataset.storage.metadata["columns"][which].index(name)
    return np.concatenate([episode.infos[which][1:, at] for episode in dataset.iterate_episodes()])
