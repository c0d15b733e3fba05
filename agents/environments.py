"""One way to open an environment for every command, with a clear error for a wrong name."""

from __future__ import annotations

import warnings
import zlib
from typing import Any, Literal

import gymnasium as gym
import numpy as np
from gymnasium.vector import VectorEnv

import pnt_gym
from agents.cli import UsageError
from pnt_gym.config import CellConfig, load
from pnt_gym.residual import ActionMode

Role = Literal["train", "practice", "evaluate"]


def known_environments() -> tuple[str, ...]:
    """Ids that the package registers."""
    return tuple(pnt_gym.ENV_IDS)


def check_environment(env_id: str) -> None:
    """Make sure that an environment exists.

    Raises:
        UsageError: it does not.
    """
    if env_id not in known_environments() and env_id not in gym.registry:
        raise UsageError(f"unknown environment {env_id!r}; known are {', '.join(known_environments())}")


def make_vector(
    env_id: str,
    level: str | CellConfig = "nominal",
    num_envs: int = 16,
    threads: int = 2,
    action_mode: ActionMode = "release_point",
) -> VectorEnv[Any, Any, Any]:
    """Open a vector environment.

    Raises:
        UsageError: no such environment.
        ConfigError: no such level, or one that describes no working cell.
    """
    check_environment(env_id)
    config = load(level)
    with warnings.catch_warnings():
        # Gymnasium announces Box bounds and precision that are meant here.
        warnings.filterwarnings("ignore", category=UserWarning, module="gymnasium")
        return gym.make_vec(env_id, num_envs=num_envs, level=config, action_mode=action_mode, threads=threads)


def stream_seed(role: Role, seed: int, start: int = 0) -> int:
    """Environment seed for a use of the cell.

    Training, practice and evaluation with the same `seed` never see the same throws.

    Args:
        role: what the throws are for.
        seed: the user's seed, at least 0.
        start: number of throws already done; a resumed stream goes on instead of starting over.
    """
    entropy = [seed, zlib.crc32(role.encode()), start]
    # 31 bits less room for the rows of a vector environment, which add their index.
    return int(np.random.SeedSequence(entropy).generate_state(1)[0] >> 2)
