"""Every baseline and agent, by name or from elsewhere, behind one protocol."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from gymnasium import Space

from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.core import LineCore
from pnt_gym.errors import one_sentence
from pnt_gym.reading import AccessError, arrays_of

from ..ground.cli import UsageError
from ..ground.environments import Env, core_of
from ..ground.outputs import deliver
from ..ground.places import ADAPTIVE
from .adaptive import IN_CONTEXT, STATIC, Adaptive, is_told
from .analytic import Analytic
from .ballistic import AnalyticHeight, MeanLead
from .bucket_table import mean_shift, virtual_goal
from .in_context import InContext
from .mlp import Mlp
from .newton import NewtonGoal
from .oracle import Oracle
from .own import controller_of, own_controller, trained_policy
from .protocol import Controller, Learner, Observation, Outcome
from .random import Random
from .regression import OnPolicyRegression
from .ridge import Ridge
from .trackers import Kalman, Known, Nothing, RecursiveRidge, RunningMean, Tracker

MISSING: Final = os.strerror(errno.ENOENT)
STATE: Final = re.compile(r"\w[\w .:-]*")
"""Names of the arrays that a controller saves."""
_ANY_ACTIONS: Mapping[str, Callable[..., Controller]] = {
    "analytic": lambda env: Analytic(_entries(env.single_action_space)),
    "random": lambda env: Random(_entries(env.single_action_space)),
}
_SHIFTS: Mapping[str, Callable[..., Controller]] = {
    "analytic_height": lambda env, correction: AnalyticHeight(_conveyor(env, "analytic_height"), correction),
    "mean_lead": lambda env, correction: MeanLead(_conveyor(env, "mean_lead"), correction),
    "mean_shift": lambda env, correction: mean_shift(correction),
    "virtual_goal": lambda env, correction, **options: virtual_goal(correction, **options),
    "newton_goal": lambda env, correction: NewtonGoal(correction),
    "ridge": lambda env, correction: OnPolicyRegression("ridge", correction, _features(env), Ridge()),
    "mlp": lambda env, correction, **options: OnPolicyRegression("mlp", correction, _features(env), Mlp(**options)),
    "oracle": lambda env, correction, **options: Oracle(_whole_core(env), correction, **options),
}
_TRACKERS: Mapping[str, Callable[..., Tracker]] = {
    STATIC: lambda core: Nothing(),
    "ema": lambda core, **options: RunningMean(**options),
    "kalman": lambda core, **options: Kalman(
        core.config.belt.camera_x, **{"noise": core.config.feedback.noise, **options}
    ),
    "recursive_ridge": lambda core, **options: RecursiveRidge(**options),
    IN_CONTEXT: lambda core, **options: InContext(core.config.belt.camera_x, **options),
    "oracle_drift": Known,
}
"""What is taken from the static policy's shift, of controllers that are told of the throw before."""
NAMES = (*_ANY_ACTIONS, *_SHIFTS, *_TRACKERS)

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
    if isinstance(getattr(env.unwrapped, "core", None), LineCore):
        raise UsageError(
            f"controller {one_sentence(name, 80)!r} corrects throws; a line is worked by others, see `evaluate`"
        )
    if name in _ANY_ACTIONS:
        return _ANY_ACTIONS[name](env, **options)
    if name in _SHIFTS:
        return _SHIFTS[name](env, _needed_correction(name, env), **options)
    if name in _TRACKERS:
        return _adaptive(name, env, options)
    if os.path.isdir(name) or name.endswith(".zip"):
        return trained_policy(Path(name), env, trust=trust)
    if ":" in name:
        return own_controller(name, env, **options)
    raise UsageError(
        f"{one_sentence(name, 80)!r} is neither a controller nor a run folder; controllers are {', '.join(NAMES)}, "
        "MODULE:CLASS and MODEL.zip, and a run folder is what training leaves in runs/"
    )


def _adaptive(name: str, env: Env, options: Mapping[str, Any]) -> Adaptive:
    """A controller that is told of the throw before, with a static policy that ships.

    `static` has learned under drift; what lies under the others in a cell without, where nothing blurs what it learns.
    """
    correction, core = _needed_correction(name, env), core_of(env)
    if not is_told(core):
        raise UsageError(f"controller {name!r} goes by what is told of the throw before; use --env PnTAdapt-v0")
    tracker, file = _TRACKERS[name](core, **options), STATIC if name == STATIC else IN_CONTEXT
    shipped = read_state(ADAPTIVE / f"{file}.npz")[1]
    return Adaptive(name, correction, _features(env), core.item_names, tracker, shipped)


def _needed_correction(name: str, env: Env) -> Correction:
    """The correction of an environment, which has none in some action modes."""
    core = core_of(env)
    if core.correction is not None:
        return core.correction
    if not core.shift_modes:
        raise UsageError(f"controller {name!r} shifts the landing, which no action mode of this environment does")
    sizes = sorted({core.action_sizes[mode] for mode in core.shift_modes})
    raise UsageError(
        f"controller {name!r} shifts the landing and needs an action of {' or '.join(map(str, sizes))} numbers, "
        f"not {_entries(env.single_action_space)}; use the action mode {' or '.join(core.shift_modes)}"
    )


def _whole_core(env: Env) -> Core:
    """The core of all rows, unless each has its own."""
    core = core_of(env)
    if hasattr(env.unwrapped, "envs") and env.num_envs > 1:
        raise UsageError("controller 'oracle' looks ahead in all cells at once; here each has its own: use 1 cell")
    return core


def _conveyor(env: Env, name: str) -> ConveyorConfig:
    """The level of an environment that has to be a conveyor."""
    config = core_of(env).config
    if not isinstance(config, ConveyorConfig):
        raise UsageError(f"controller {name!r} knows the physics of the conveyor only; choose another one here")
    return config


def _features(env: Env) -> int:
    return _entries(env.single_observation_space)


def _entries(space: Space[Any]) -> int:
    """Numbers in one action or observation."""
    return int(np.prod(space.shape or (1,)))


def save_state(controller: Learner, path: Path) -> None:
    """Write what a controller learned to a .npz file, at once."""

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:  # given a name, numpy would append a suffix
            np.savez(file, controller=np.array(knowledge(controller)[0]), **controller.state())

    deliver(path, write)


def load_state(controller: Learner, path: Path) -> None:
    """Take over what a controller of the same name has saved.

    Raises:
        UsageError: the file is missing or damaged, or belongs to another controller.
    """
    owner, state = read_state(path)
    wanted = knowledge(controller)
    if owner not in wanted:
        raise UsageError(f"{str(path)!r} was saved by {owner!r}, not by {' or '.join(map(repr, wanted))}")
    try:
        controller.restore(state)
    except UsageError:
        raise
    except Exception:
        raise UsageError(f"{str(path)!r} holds no state of {owner!r} that is understood here") from None


def knowledge(controller: Learner) -> tuple[str, ...]:
    """Whose knowledge a controller can take over, first of what kind its own is: a static policy may lie under it."""
    if not isinstance(controller, Adaptive):
        return (controller.name,)
    return (IN_CONTEXT,) if controller.name == IN_CONTEXT else (STATIC, IN_CONTEXT)


def read_state(path: Path) -> tuple[str, dict[str, np.ndarray]]:
    """Whose knowledge a file holds, and what it is.

    Raises:
        UsageError: the file is missing or damaged.
    """
    try:
        state = arrays_of(path, STATE)
        return str(state.pop("controller")), state
    except AccessError as error:
        said = f"holds no saved controller: {error}" if str(error) != MISSING else "does not exist"
        raise UsageError(f"{str(path)!r} {said}") from None
    except Exception:  # there is no telling what a torn or foreign file upsets
        raise UsageError(f"{str(path)!r} holds no saved controller") from None
