"""Masks and values of vector infos, compared with Gymnasium's own vector environment."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from gymnasium.vector import AutoresetMode

import pnt_gym
from benchmarks.fuzz_cases.basis import Draws, Find
from tests.tools.vectors import assert_same_steps, both

STEPS: Final = 12


def infos_case(draws: Draws) -> str:
    """Steps of both forms of an environment in an autoreset mode, with the same seeds and actions."""
    env_id, mode = draws.pick(pnt_gym.ENV_IDS), draws.pick(AutoresetMode)
    limit, seed = draws.pick((None, None, 1, 3)), draws.integer(10**6)
    subject = f"{env_id} {mode} limit {limit} seed {seed}"
    arguments: dict[str, Any] = {} if limit is None else {"max_episode_steps": limit}
    try:
        ours, theirs = both(env_id, mode.value, **arguments)
        shape, discrete = (STEPS, *ours.action_space.shape), ours.action_space.dtype.kind == "i"
        random = draws.generator()
        actions = random.integers(16, size=shape) if discrete else random.uniform(-1.0, 1.0, shape)
        assert_same_steps(ours, theirs, np.asarray(actions, dtype=ours.action_space.dtype), seed)
        ours.close()
        theirs.close()
    except Exception as error:  # what both forms are given must work
        raise Find(f"{subject}: {type(error).__name__}: {error}") from error
    return subject
