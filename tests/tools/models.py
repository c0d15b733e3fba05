"""Models of stable-baselines3: for the cell of `tests.tools.lob`, and those that a run left."""

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from agents.learning.runs import RunFolder


class Space(gym.Env[Any, Any]):
    """The spaces of the package's cell, to make models for it."""

    observation_space = gym.spaces.Box(-5, 5, (2,), np.float32)
    action_space = gym.spaces.Box(-1, 1, (1,), np.float32)

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        return self.np_random.standard_normal(2).astype(np.float32) * 0.1 + 2.0, {}

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        return self.reset()[0], 0.0, True, False, {}


def weights(folder: Path, checkpoint: Path | None = None) -> list[np.ndarray]:
    """All numbers of the model that a run left."""
    return [part.detach().numpy() for part in RunFolder(folder).load(None, checkpoint).policy.parameters()]


def model(algorithm: Any, env: Any = None) -> Any:
    return algorithm("MlpPolicy", env or Space(), policy_kwargs={"net_arch": [8]}, device="cpu", seed=1)
