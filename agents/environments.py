"""One way to open an environment for every command, with a clear error for a wrong name."""

from __future__ import annotations

import warnings
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import gymnasium as gym
import numpy as np
from gymnasium.vector import VectorEnv

import pnt_gym
from agents.cli import UsageError
from pnt_gym.correction import Correction
from pnt_gym.levels import LevelConfig

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
    level: str | Path | LevelConfig | Mapping[str, Any] = "nominal",
    num_envs: int = 16,
    threads: int = 2,
    action_mode: str | None = None,
) -> VectorEnv[Any, Any, Any]:
    """Open a vector environment.

    Args:
        env_id: id of the environment.
        level: one of the environment's own levels, or a YAML file, a mapping or a config for its kind of cell.
        num_envs: cells simulated side by side.
        threads: threads that simulate.
        action_mode: one of the environment's own modes; None for its default.

    Raises:
        UsageError: no such environment.
        ConfigError: no such level or action mode, or a level that describes no working cell.
    """
    check_environment(env_id)
    mode = {} if action_mode is None else {"action_mode": action_mode}
    with warnings.catch_warnings():
        # Gymnasium announces Box bounds and precision that are meant here.
        warnings.filterwarnings("ignore", category=UserWarning, module="gymnasium")
        return gym.make_vec(env_id, num_envs=num_envs, level=level, threads=threads, **mode)


def level_in_full(env_id: str, level: str) -> LevelConfig:
    """A level in full, as an environment reads it.

    Raises:
        UsageError: no such environment.
        ConfigError: no such level, or one that describes no working cell.
    """
    env = make_vector(env_id, level, num_envs=1, threads=1)
    try:
        return env.unwrapped.core.config
    finally:
        env.close()


def correction_of(env: VectorEnv[Any, Any, Any]) -> Correction | None:
    """What an action of the environment means to a controller that learns from errors."""
    return getattr(getattr(env.unwrapped, "core", None), "correction", None)


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
