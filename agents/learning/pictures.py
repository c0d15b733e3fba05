"""Learning from pictures beside vectors, with stable-baselines3: a small extractor of features, and a replay buffer."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Final, final

import numpy as np
import torch
from gymnasium.spaces import Dict, Space
from numpy.typing import NDArray
from stable_baselines3.common.buffers import BaseBuffer, ReplayBuffer
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.type_aliases import DictReplayBufferSamples
from torch import Tensor, nn
from torch.nn import functional

from pnt_gym.cells.grasp.config import CHANNELS

from ..policies.eye import FEATURES, SQUARE, grid

WIDTHS: Final = (32, 24, 16)
"""Maps of the convolutions: of single squares of pixels, then twice of 3 by 3 squares."""
SIDES: Final = (1, 3, 3)


@final
class PictureExtractor(BaseFeaturesExtractor):
    """Features of a picture, see `agents.policies.eye`, and the entries of the vector beside it.

    Args:
        observation_space: a picture `image` and a vector `vector`.
    """

    def __init__(self, observation_space: Space[Any]) -> None:
        assert isinstance(observation_space, Dict)
        (entries,) = observation_space["vector"].shape or (0,)
        super().__init__(observation_space, FEATURES * WIDTHS[-1] + entries)
        widths = pairwise((CHANNELS * SQUARE**2, *WIDTHS))
        self.convolutions = nn.ModuleList(
            nn.Conv2d(before, after, side, padding=side // 2)
            for (before, after), side in zip(widths, SIDES, strict=True)
        )
        self.grid: Tensor
        self.register_buffer("grid", torch.as_tensor(grid(), dtype=torch.float32), persistent=False)

    def forward(self, observations: dict[str, Tensor]) -> Tensor:
        """Features (N, F) of pictures as shares of 255 and vectors."""
        return torch.cat([self.look(observations["image"])[1], observations["vector"]], dim=1)

    def look(self, images: Tensor) -> tuple[Tensor, Tensor]:
        """Maps before the last convolution (N, C, 12, 12), and features (N, F), of pictures as shares of 255."""
        value = functional.pixel_unshuffle(images, SQUARE)
        *hidden, last = self.convolutions
        for layer in hidden:
            value = functional.silu(layer(value))
        maps = last(value).flatten(2)
        where = maps.softmax(2) @ self.grid
        return value, torch.cat([where[..., 0], where[..., 1], maps.amax(2)], dim=1)


@final
class PictureBuffer(ReplayBuffer):
    """Replay buffer that keeps one picture of each step, as bytes.

    The picture stays the same until a pick ends, so a step needs no second picture for the step after. The end of a
    pick counts as an end, on the belt too: what a pick leaves to later picks is not learned.
    """

    def __init__(self, buffer_size: int, observation_space: Any, action_space: Any, device: Any = "auto",
                 n_envs: int = 1, optimize_memory_usage: bool = False) -> None:  # fmt: skip
        BaseBuffer.__init__(self, buffer_size, observation_space, action_space, device, n_envs=n_envs)
        del optimize_memory_usage
        self.buffer_size = max(buffer_size // n_envs, 1)
        shape, spaces = (self.buffer_size, n_envs), observation_space.spaces
        self.images = np.zeros((*shape, *spaces["image"].shape), dtype=np.uint8)
        self.vectors = np.zeros((*shape, *spaces["vector"].shape), dtype=np.float32)
        self.next_vectors = np.zeros_like(self.vectors)
        self.actions = np.zeros((*shape, self.action_dim), dtype=np.float32)
        self.rewards, self.ends = np.zeros(shape, dtype=np.float32), np.zeros(shape, dtype=np.float32)

    def add(self, obs: Any, next_obs: Any, action: NDArray[Any], reward: NDArray[Any], done: NDArray[Any],
            infos: list[dict[str, Any]]) -> None:  # fmt: skip
        """Add one step of all rows."""
        del done
        at = self.pos
        self.images[at], self.vectors[at], self.next_vectors[at] = obs["image"], obs["vector"], next_obs["vector"]
        self.actions[at], self.rewards[at] = action, reward
        self.ends[at] = ["cycle_time" in info for info in infos]
        self.pos = (at + 1) % self.buffer_size
        self.full = self.full or self.pos == 0

    def sample(self, batch_size: int, env: Any = None) -> Any:
        """Draw steps."""
        return BaseBuffer.sample(self, batch_size, env)

    def _get_samples(self, batch_inds: NDArray[Any], env: Any = None) -> Any:
        """The steps of some positions, each of a row drawn at random."""
        del env
        # The generator that stable-baselines3 draws from.
        place = batch_inds, np.random.randint(0, self.n_envs, size=len(batch_inds))  # noqa: NPY002
        images, columns = self.to_torch(self.images[place]), (self.ends[place], self.rewards[place])
        ends, rewards = (self.to_torch(column[:, None]) for column in columns)
        return DictReplayBufferSamples(
            observations={"image": images, "vector": self.to_torch(self.vectors[place])},
            actions=self.to_torch(self.actions[place]),
            next_observations={"image": images, "vector": self.to_torch(self.next_vectors[place])},
            dones=ends,
            rewards=rewards,
        )
