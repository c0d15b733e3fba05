"""Every baseline and agent by name, behind one protocol."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from gymnasium.vector import VectorEnv

from agents.cli import UsageError
from agents.controllers.analytic import Analytic
from agents.controllers.ballistic import AnalyticHeight, MeanLead
from agents.controllers.cell_table import mean_shift, virtual_goal
from agents.controllers.mlp import Mlp
from agents.controllers.oracle import Oracle
from agents.controllers.protocol import Controller, Learner, Observation, Outcome
from agents.controllers.random import Random
from agents.controllers.regression import OnPolicyRegression
from agents.controllers.ridge import Ridge
from agents.controllers.sb3 import Sb3
from agents.files import replace_file

Env = VectorEnv[Any, Any, Any]

_ANY_ACTIONS: Mapping[str, Callable[..., Controller]] = {
    "analytic": lambda env: Analytic(action_count(env)),
    "random": lambda env: Random(action_count(env)),
}
_SHIFTS: Mapping[str, Callable[..., Controller]] = {
    "analytic_height": lambda env: AnalyticHeight(env.unwrapped.core.config),
    "mean_lead": lambda env: MeanLead(env.unwrapped.core.config),
    "mean_shift": lambda env: mean_shift(env.unwrapped.core.config),
    "virtual_goal": lambda env, **options: virtual_goal(env.unwrapped.core.config, **options),
    "ridge": lambda env: OnPolicyRegression("ridge", env.unwrapped.core.config, Ridge()),
    "mlp": lambda env, **options: OnPolicyRegression("mlp", env.unwrapped.core.config, Mlp(**options)),
    "oracle": lambda env, **options: Oracle(env.unwrapped.core, **options),
}
NAMES = (*_ANY_ACTIONS, *_SHIFTS)

__all__ = [
    "NAMES",
    "Controller",
    "Learner",
    "Observation",
    "Outcome",
    "load_state",
    "make_controller",
    "save_state",
]


def action_count(env: Env) -> int:
    """Numbers in one action."""
    return int(np.prod(env.single_action_space.shape or (1,)))


def make_controller(name: str, env: Env, **options: Any) -> Controller:
    """The controller of a name or of a run folder, fitted to an environment.

    Args:
        name: one of `NAMES`, or the folder of a training run.
        env: the environment it will act in.
        options: settings of that controller, e.g. `gain` of virtual_goal or `width` of mlp.

    Raises:
        UsageError: neither a name nor a run folder, or a controller that cannot act in this environment.
    """
    if name in _ANY_ACTIONS:
        return _ANY_ACTIONS[name](env, **options)
    if name in _SHIFTS:
        if not hasattr(env.unwrapped, "core"):
            raise UsageError(f"controller {name!r} needs a cell it can ask, which this environment does not offer")
        if action_count(env) != 2:
            raise UsageError(
                f"controller {name!r} shifts the landing and needs an action of 2 numbers, "
                f"not {action_count(env)}; use the action mode release_point or virtual_goal"
            )
        return _SHIFTS[name](env, **options)
    if Path(name).is_dir():
        return Sb3.load(Path(name), int(np.prod(env.single_observation_space.shape or (1,))), action_count(env))
    raise UsageError(
        f"{name!r} is neither a controller nor a run folder; controllers are {', '.join(NAMES)}, "
        "and a run folder is what `python -m agents.train` leaves in runs/"
    )


def save_state(controller: Learner, path: Path) -> None:
    """Write what a controller learned to a .npz file, at once."""

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:  # given a name, numpy would append a suffix
            np.savez(file, controller=np.array(controller.name), **controller.state())

    replace_file(path, write)


def load_state(controller: Learner, path: Path) -> None:
    """Take over what a controller of the same name has saved.

    Raises:
        UsageError: the file is missing or damaged, or belongs to another controller.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            state: dict[str, np.ndarray] = {name: file[name] for name in file.files}
        owner = str(state.pop("controller"))
    except FileNotFoundError:
        raise UsageError(f"{str(path)!r} does not exist") from None
    except (OSError, ValueError, KeyError, EOFError, BadZipFile):
        raise UsageError(f"{str(path)!r} holds no saved controller") from None
    if owner != controller.name:
        raise UsageError(f"{str(path)!r} was saved by {owner!r}, not by {controller.name!r}")
    controller.restore(state)
