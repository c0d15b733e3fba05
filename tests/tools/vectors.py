"""Vector environments, ours beside Gymnasium's loop over single ones: short episodes, and the comparison of infos."""

from collections.abc import Container, Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np

from tests.tools.throws import (
    CONVEYOR,
    GRASP,
    GRIPPER,
    LINE,
    ONE_JOINT,
    SHORT_LINE,
    THROWS,
    same_bits,
    some_actions,
    vary,
)

N = 3
STEPS = dict.fromkeys(THROWS, 6) | dict.fromkeys(("OneJointThrow-v0", "OneJointSort-v0", *GRIPPER), 4)
STEPS |= dict.fromkeys(LINE, 30) | dict.fromkeys(GRASP, 16)
SHIFT = vary("waste", picks_per_shift=2)
LEVELS: dict[str, Any] = dict.fromkeys(CONVEYOR, SHIFT) | dict.fromkeys((*ONE_JOINT, *GRIPPER), "late")
LEVELS["PnTLine-v0"] = SHORT_LINE
LEVELS["PnTGrasp-v0"] = {"base": "grasp", "picks_per_shift": 2, "grasp": {"picks": "belt"}}
LEVELS["PnTAdapt-v0"] = vary("drift_mix", picks_per_shift=2)
LEVELS["OneJointAssembly-v0"] = "ideal"
"""An assembly goes on to its second throw only if the first succeeds."""
SMALL = {"OneJointAssembly-v0": 0.005}
"""Share of the whole range that actions take up, where it is not all."""


def actions(env_id: str, steps: int | None = None) -> np.ndarray:
    """Random actions (steps, 8, ...), the same in every call."""
    share = SMALL.get(env_id, 1.0)
    return some_actions(env_id, np.random.default_rng(0), steps or STEPS[env_id], 8, share=share)


def both(env_id: str, mode: str, **given: Any) -> tuple[Any, Any]:
    """The vector form of N cells, and Gymnasium's loop over N single ones."""
    given = {"level": LEVELS[env_id], **given}
    ours = gym.make_vec(env_id, num_envs=N, autoreset_mode=mode, **given)
    how = {"autoreset_mode": mode}
    theirs = gym.make_vec(env_id, num_envs=N, vectorization_mode="sync", vector_kwargs=how, **given)
    return ours, theirs


def assert_alike(given: Sequence[Any], other: Sequence[Any]) -> None:
    """Two steps or two resets gave the same bits, whatever the masks of their infos say."""
    (*values, info), (*others, info2) = given, other
    assert all(same_bits(one, two) for one, two in zip(values, others, strict=True))
    _assert_same_bits(info, info2)


def _assert_same_bits(info: Mapping[str, Any], other: Mapping[str, Any]) -> None:
    assert info.keys() == other.keys()
    for name, value in info.items():
        if isinstance(value, dict):
            _assert_same_bits(value, other[name])
        elif value.dtype == object:
            assert [one is None for one in value] == [one is None for one in other[name]]
            pairs = zip(value, other[name], strict=True)
            assert all(same_bits(one, two) for one, two in pairs if one is not None)
        else:
            assert same_bits(value, other[name]), name


def assert_same_info(mine: Mapping[str, Any], other: Mapping[str, Any], more: Container[str] = ()) -> None:
    """Two infos have the same keys, masks and, where masks hold, values; `mine` may have `more`, for no cell."""
    assert not set(other) - set(mine)
    for name in (key.removeprefix("_") for key in set(mine) - set(other)):
        assert name in more and not mine[f"_{name}"].any(), name
    for key, value in other.items():
        if isinstance(value, dict):
            assert_same_info(mine[key], value)
        elif key.startswith("_"):
            assert same_bits(mine[key], value), key
        else:
            where = other[f"_{key}"]
            assert mine[key].dtype == value.dtype, key
            pairs = zip(mine[key][where], value[where], strict=True)
            assert all(same_bits(first, second) for first, second in pairs), key


def assert_same_steps(ours: Any, theirs: Any, actions: np.ndarray, seed: int) -> list[Any]:
    """What each step gave, the same in both environments; each row is reset once more, so that they are out of step."""
    assert_same_reset(ours, theirs, seed=seed)
    disabled = ours.metadata["autoreset_mode"].value == "Disabled"
    steps = list[Any]()
    for number, action in enumerate(actions):
        (*mine, info), (*other, info2) = (env.step(action[:N]) for env in (ours, theirs))
        assert all(same_bits(one, two) for one, two in zip(mine, other, strict=True))
        assert_same_info(info, info2, info.get("final_info", ()))
        steps.append((*mine, info))
        anew = ((mine[2] | mine[3]) & disabled) | (number == np.arange(N))
        if anew.any():
            assert_same_reset(ours, theirs, options={"reset_mask": anew})
    return steps


def assert_same_reset(ours: Any, theirs: Any, seed: int | None = None, options: Any = None) -> None:
    """A reset gives the same in both; Gymnasium's takes the mask out of the options."""
    (mine, info), (other, info2) = (env.reset(seed=seed, options=options and {**options}) for env in (ours, theirs))
    assert same_bits(mine, other)
    assert_same_info(info, info2)
