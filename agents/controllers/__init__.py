"""Controllers of throws: every baseline and agent, by name or from a user's module, behind one protocol."""

from __future__ import annotations

import os
from typing import Any

from gymnasium.spaces import Box

from pnt_gym.errors import one_sentence
from pnt_gym.names import unknown_name

from ..ground import shipped
from ..ground.cli import UsageError, about, check_known
from ..ground.environments import Env
from ..ground.shipped import CORRECTING, DECIDING, PREFIX, is_shipped, module_of
from . import named, own
from .named import GRASPING_NAMES, NAMES
from .own import controller_of, import_controller
from .protocol import Controller, Learner, Observation, Outcome
from .state import load_state, save_state

__all__ = [
    "GRASPING_NAMES",
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
    """Controller by its name, from a trained policy or from a user's module, fitted to an environment.

    Args:
        name: one of `NAMES`; a shipped policy such as shipped:cells; a run folder, an RL-Zoo folder or a model.zip
            (see `agents.learning.trained`); or MODULE:CLASS (see `Controller`), which imports MODULE.
        env: the environment in which the controller will act.
        trust: allow an RL-Zoo folder or a model.zip, whose loading runs their code.
        options: settings of the controller, e.g. `gain` of virtual_goal or `width` of mlp.

    Raises:
        UsageError: the name fits none of these, or the controller cannot act in this environment.
    """
    if not isinstance(env.single_action_space, Box):
        raise UsageError(
            f"controller {one_sentence(name, 80)!r} corrects throws; the actions of this environment are choices"
        )
    if name in NAMES:
        return named.make(name, env, **options)
    place = shipped.place(name)
    if is_shipped(name) and name.removeprefix(PREFIX) in DECIDING:
        raise UsageError(f"{name!r} decides on a line; here controllers correct throws")
    if is_shipped(name) and (own_name := CORRECTING[name.removeprefix(PREFIX)].controller):
        return named.make(own_name, env, **options)
    if os.path.isdir(place) or name.endswith(".zip"):
        with about(f"controller {name!r}"):
            check_known("setting", options, ())
        return own.load(place, env, trust=trust)
    if module_of(name) is not None:
        return import_controller(name, env, **options)
    further = ", MODULE:CLASS, MODEL.zip, and a run folder, as training leaves them in runs/"
    raise UsageError(unknown_name("controller", name, (*NAMES, *shipped.names(CORRECTING)), further))
