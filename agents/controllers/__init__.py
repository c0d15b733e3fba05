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
from agents.controllers.newton import NewtonGoal
from agents.controllers.oracle import Oracle
from agents.controllers.protocol import Controller, Learner, Observation, Outcome
from agents.controllers.random import Random
from agents.controllers.regression import OnPolicyRegression, Regressor
from agents.controllers.ridge import Ridge
from agents.controllers.sb3 import Sb3
from agents.files import replace_file
from pnt_gym.config import CellConfig
from pnt_gym.correction import Correction

Env = VectorEnv[Any, Any, Any]

_ANY_ACTIONS: Mapping[str, Callable[..., Controller]] = {
    "analytic": lambda env: Analytic(action_count(env)),
    "random": lambda env: Random(action_count(env)),
}
_CONVEYOR: Mapping[str, Callable[..., Controller]] = {
    "analytic_height": lambda env, correction: AnalyticHeight(_conveyor(env, "analytic_height"), correction),
    "mean_lead": lambda env, correction: MeanLead(_conveyor(env, "mean_lead"), correction),
}
_SHIFTS: Mapping[str, Callable[..., Controller]] = {
    **_CONVEYOR,
    "mean_shift": lambda env, correction: mean_shift(correction),
    "virtual_goal": lambda env, correction, **options: virtual_goal(correction, **options),
    "newton_goal": lambda env, correction: NewtonGoal(correction),
    "ridge": lambda env, correction: _regression("ridge", env, correction, Ridge()),
    "mlp": lambda env, correction, **options: _regression("mlp", env, correction, Mlp(**options)),
    "oracle": lambda env, correction, **options: Oracle(env.unwrapped.core, correction, **options),
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


def observation_count(env: Env) -> int:
    """Entries of one observation."""
    return int(np.prod(env.single_observation_space.shape or (1,)))


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
        return _SHIFTS[name](env, _needed_correction(name, env), **options)
    if Path(name).is_dir():
        return Sb3.load(Path(name), observation_count(env), action_count(env))
    raise UsageError(
        f"{name!r} is neither a controller nor a run folder; controllers are {', '.join(NAMES)}, "
        "and a run folder is what `python -m agents.train` leaves in runs/"
    )


def _needed_correction(name: str, env: Env) -> Correction:
    """The correction of an environment.

    Raises:
        UsageError: it has none in its action mode.
    """
    core = getattr(env.unwrapped, "core", None)
    if core is None:
        raise UsageError(f"controller {name!r} needs a cell it can ask, which this environment does not offer")
    if core.correction is not None:
        return core.correction
    if not core.shift_modes:
        raise UsageError(f"controller {name!r} shifts the landing, which no action mode of this environment does")
    sizes = sorted({core.action_sizes[mode] for mode in core.shift_modes})
    raise UsageError(
        f"controller {name!r} shifts the landing and needs an action of {' or '.join(map(str, sizes))} numbers, "
        f"not {action_count(env)}; use the action mode {' or '.join(core.shift_modes)}"
    )


def _conveyor(env: Env, name: str) -> CellConfig:
    """The level of a conveyor environment.

    Raises:
        UsageError: the environment is another one.
    """
    config = env.unwrapped.core.config
    if not isinstance(config, CellConfig):
        raise UsageError(f"controller {name!r} knows the physics of the conveyor only; choose another one here")
    return config


def _regression(name: str, env: Env, correction: Correction, regressor: Regressor) -> OnPolicyRegression:
    return OnPolicyRegression(name, correction, observation_count(env), regressor)


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
