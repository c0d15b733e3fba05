"""Masks and values of vector infos, compared with Gymnasium's own vector environment."""

from __future__ import annotations

from functools import partial
from typing import Any, Final

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import pnt_gym
from tests.tools.fuzz_basis import Find, Random, pick

SHORT: Final = {"picks_per_shift": 2}
LEVELS: Final[dict[str, Any]] = {
    "PnTConveyor-v0": {"base": "waste", **SHORT},
    "PnTAdapt-v0": {"base": "drift_mix", **SHORT},
    "PnTRelease-v0": {"base": "waste", **SHORT},
    "OneJointThrow-v0": "late",
    "OneJointSort-v0": "late",
    "OneJointAssembly-v0": "ideal",
    "GripperToss-v0": "late",
    "PnTLine-v0": {"base": "skills3", "duration": 5.0},
}
"""Levels whose episodes are short."""
ROWS: Final = 2
STEPS: Final = 12


def infos_case(random: Random) -> str:
    """Steps of both forms of an environment in an autoreset mode, with the same seeds and actions."""
    env_id, mode = pick(random, pnt_gym.ENV_IDS), pick(random, AutoresetMode)
    limit = pick(random, (None, None, 1, 3))
    seed = int(random.integers(10**6))
    what = f"{env_id} {mode} limit {limit} seed {seed}"
    try:
        given = {} if limit is None else {"max_episode_steps": limit}
        makers = [partial(gym.make, env_id, level=LEVELS[env_id], **given) for _ in range(ROWS)]
        ours = gym.make_vec(env_id, num_envs=ROWS, level=LEVELS[env_id], autoreset_mode=mode, **given)
        step_both(what, random, ours, SyncVectorEnv(makers, autoreset_mode=mode), seed)
    except Find:
        raise
    except Exception as error:
        raise Find(f"{what}: {type(error).__name__}: {error}") from error
    return what


def step_both(what: str, random: Random, ours: Any, theirs: Any, seed: int) -> None:
    """The same seed and actions in both forms; whatever they tell is compared."""
    compare(f"{what} reset", ours.reset(seed=seed)[1], theirs.reset(seed=seed)[1])
    for step in range(STEPS):
        shape = ours.action_space.shape
        discrete = ours.action_space.dtype.kind == "i"
        actions = random.integers(16, size=shape) if discrete else random.uniform(-1.0, 1.0, shape)
        (*mine, info), (*other, known) = ours.step(actions), theirs.step(actions)
        compare(f"{what} step {step}", info, known)
        over = mine[2] | mine[3]
        if not all(np.array_equal(a, b) for a, b in zip(mine, other, strict=True)):
            raise Find(f"{what} step {step}: observations, rewards or ends differ")
        if ours.metadata["autoreset_mode"] is AutoresetMode.DISABLED and over.any():
            options = {"reset_mask": over}
            compare(f"{what} reset {step}", *(env.reset(options=dict(options))[1] for env in (ours, theirs)))
    ours.close()
    theirs.close()


def compare(what: str, ours: dict[str, Any], theirs: dict[str, Any]) -> None:
    """Make sure that masks are the same, and values where a mask holds; ours may have values that no mask holds for."""
    if missing := theirs.keys() - ours.keys():
        raise Find(f"{what}: {sorted(missing)} are missing")
    for name, values in ours.items():
        if name.startswith("_"):
            continue
        masks = [np.asarray(info.get(f"_{name}", np.zeros(ROWS, dtype=np.bool_))) for info in (ours, theirs)]
        if not np.array_equal(*masks):
            raise Find(f"{what}: mask of {name} is {masks[0]}, Gymnasium's is {masks[1]}")
        if name == "final_info" and masks[0].any():
            compare(f"{what} final_info", values, theirs[name])
        elif name != "final_info" and masks[0].any():
            rows = np.flatnonzero(masks[0])
            if not all(np.array_equal(values[row], theirs[name][row], equal_nan=True) for row in rows):
                raise Find(f"{what}: {name} is {values}, Gymnasium's is {theirs[name]}")
