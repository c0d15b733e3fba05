"""A Gymnasium suite for sorting by throwing. Importing it registers the environments in `ENV_IDS`."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version
from typing import Final

import gymnasium

from pnt_gym.commands import compare, evaluate, fit, plan_line, sb3_vec_env, shipped_policy

__all__ = [
    "ENV_IDS",
    "__version__",
    "compare",
    "evaluate",
    "fit",
    "plan_line",
    "register_envs",
    "sb3_vec_env",
    "shipped_policy",
]

try:
    __version__ = version("pnt_gym")
except PackageNotFoundError:  # a source tree on the path, not installed
    __version__ = "0.0.0"

_ENTRY_POINTS: Final = {
    "PnTConveyor-v0": "pnt_gym.envs.conveyor:PnTConveyor",
    "PnTAdapt-v0": "pnt_gym.envs.conveyor:PnTAdapt",
    "PnTRelease-v0": "pnt_gym.envs.conveyor:PnTRelease",
    "OneJointThrow-v0": "pnt_gym.envs.one_joint:OneJointThrow",
    "OneJointSort-v0": "pnt_gym.envs.one_joint:OneJointSort",
    "OneJointAssembly-v0": "pnt_gym.envs.one_joint:OneJointAssembly",
    "PnTLine-v0": "pnt_gym.envs.line:PnTLine",
    "GripperToss-v0": "pnt_gym.envs.gripper:GripperToss",
    "PnTGrasp-v0": "pnt_gym.envs.grasp:PnTGrasp",
}
ENV_IDS: Final = tuple(_ENTRY_POINTS)
"""Ids of the environments, each with a single and a vector form."""


_SETTINGS: Final = {
    "PnTAdapt-v0": {"level": "day"},
    "PnTLine-v0": {"level": "single"},
    "PnTGrasp-v0": {"level": "grasp"},
}
"""Default keyword arguments of `gymnasium.make` for some environments."""


def register_envs() -> None:
    """Register the environments with Gymnasium; a second call changes nothing."""
    for env_id, entry_point in _ENTRY_POINTS.items():
        if env_id not in gymnasium.registry:
            gymnasium.register(  # pyright: ignore[reportUnknownMemberType]
                env_id,
                entry_point=f"{entry_point}Env",
                vector_entry_point=f"{entry_point}VectorEnv",
                kwargs=dict(_SETTINGS.get(env_id, {})),
            )


register_envs()
