"""A dataset of `PnTGrasp-v0` keeps pictures as bytes, and replays as others do."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.tools.datasets import collected, known

pytestmark = pytest.mark.usefixtures("worker_here", "here")


def test_pictures_come_back_and_every_step_comes_again() -> None:
    dataset = collected(
        "--env", "PnTGrasp-v0", "--controller", "centre", "--throws", "20", "--seed", "3", name="grasp/centre-v0"
    )
    env, lengths = dataset.recover_environment(), set[int]()
    for episode, facts in zip(dataset.iterate_episodes(), known(dataset), strict=True):
        images, vectors = (episode.observations[name] for name in ("image", "vector"))
        assert (images.dtype, images.shape[1:], vectors.shape[1:]) == (np.uint8, (5, 48, 48), (32,))
        observation, _ = env.reset(seed=facts["seed"])
        for k, action in enumerate(episode.actions):
            np.testing.assert_array_equal(observation["image"], images[k])
            np.testing.assert_array_equal(observation["vector"], vectors[k])
            observation, reward, terminated, _, _ = env.step(action)
            assert (reward, terminated) == (episode.rewards[k], episode.terminations[k])
        np.testing.assert_array_equal(observation["image"], images[-1])
        lengths.add(len(episode.actions))
    # An object that is held at once takes a grasp and a throw, one that fails twice two grasps or one.
    assert 2 in lengths
    file = Path(dataset.storage.data_path) / "main_data.hdf5"
    with h5py.File(file) as stored:
        picture = stored["episode_0/observations/image"]
        assert picture.id.get_storage_size() < 0.7 * picture.size
