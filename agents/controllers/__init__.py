"""Every controller, by name, from a run folder, or from a module of the user."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from gymnasium.spaces import Box

from pnt_gym.errors import one_sentence

from ..ground.cli import UsageError
from ..ground.environments import Env
from .named import NAMES, named_controller
from .own import controller_of, own_controller, trained_policy
from .protocol import Controller, Learner, Observation, Outcome
from .state import load_state, save_state

__all__ = [
    "NAMES",
    "Controller",
    "Learner",
    "Observation",
    "Outcome",
    "controller_of",
    "load_state",
    "make_controller",
    "save_state",
]


def make_controller(name: str, env: Env, *, trust: bool = False, **options: Any) -> Controller:
    """The controller of a name, of a trained policy, or of somebody's module, fitted to an environment.

    Args:
        name: one of `NAMES`; a run folder, an RL-Zoo folder or a model.zip (see `agents.learning.trained`); or
            MODULE:CLASS (see `Controller`), which imports MODULE.
        env: the environment it will act in.
        trust: load an RL-Zoo folder or a model.zip, which runs code in them.
        options: settings of that controller, e.g. `gain` of virtual_goal or `width` of mlp.

    Raises:
        UsageError: none of these, or a controller that cannot act in this environment.
    """
    if not isinstance(env.single_action_space, Box):
        raise UsageError(
            f"controller {one_sentence(name, 80)!r} corrects throws; the actions of this environment are choices"
        )
    if name in NAMES:
        return named_controller(name, env, **options)
    if os.path.isdir(name) or name.endswith(".zip"):
        return trained_policy(Path(name), env, trust=trust)
    if ":" in name:
        return own_controller(name, env, **options)
    raise UsageError(
        f"{one_sentence(name, 80)!r} is neither a controller nor a run folder; controllers are {', '.join(NAMES)}, "
        "MODULE:CLASS and MODEL.zip, and a run folder is what training leaves in runs/"
    )
