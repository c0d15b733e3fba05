"""Registry of the controllers with a name, and their descriptions."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from gymnasium import Space

from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.core import Core

from ..ground.cli import UsageError, about, check_known, settings_of
from ..ground.environments import Env, core_of
from ..ground.places import ADAPTIVE
from . import state
from .adaptive import IN_CONTEXT, STATIC, Adaptive, has_feedback
from .fitted_q import FittedQ
from .goals import virtual_goal
from .grasp_oracle import GraspOracle
from .grasps import Centre, GraspController, Place, new_release, shipped_release
from .in_context import InContext
from .oracle import Analytic, Oracle, Random
from .places import TrueSurface, centroid, flattest, local_mlp
from .protocol import Controller
from .regression import Mlp, OnPolicyRegression, Ridge
from .remembering import Remembering
from .shift_values import ShiftValues
from .trackers import Kalman, NoTracker, OracleTracker, RecursiveRidge, RunningMean, Tracker


def _fitted_planner(env: Env, correction: Correction) -> Controller:
    from .fitted_planner import FittedPlanner  # noqa: PLC0415 - SciPy takes half a second to import

    return FittedPlanner(_shared_core("fitted_planner", env), correction)


_ANY_ACTIONS: Mapping[str, Callable[..., Controller]] = {
    "analytic": lambda env: Analytic(_count(env.single_action_space), core_of(env).action_mode),
    "random": lambda env: Random(_count(env.single_action_space)),
}
_SHIFTS: Mapping[str, Callable[..., Controller]] = {
    "virtual_goal": lambda env, correction, **options: virtual_goal(correction, **options),
    "ridge": lambda env, correction: OnPolicyRegression("ridge", correction, _features(env), Ridge()),
    "mlp": lambda env, correction, **options: OnPolicyRegression("mlp", correction, _features(env), Mlp(**options)),
    "fitted_planner": _fitted_planner,
    "oracle": lambda env, correction, **options: Oracle(_shared_core("oracle", env), correction, **options),
}
POSTERIOR: Final = "posterior"
"""The controller that adapts by the physics of a cell, without practice."""


def _posterior(core: Core, correction: Correction, prior: str = "cells") -> Controller:
    from .posterior import Posterior  # noqa: PLC0415 - SciPy takes half a second to import

    return Posterior(core.config, correction, prior)


_TRACKERS: Mapping[str, Callable[..., Tracker]] = {
    STATIC: lambda core: NoTracker(),
    "ema": lambda core, **options: RunningMean(**options),
    "kalman": lambda core, **options: Kalman(
        core.config.belt.camera_x, **{"noise": core.config.feedback.noise, **options}
    ),
    "recursive_ridge": lambda core, **options: RecursiveRidge(**options),
    IN_CONTEXT: lambda core, **options: InContext(core.config.belt.camera_x, bool(core.config.cells.ranges), **options),
    "oracle_drift": OracleTracker,
}
"""Trackers by controller; the tracker's effect is subtracted from the static policy's offset."""
_SETTINGS: Mapping[str, Callable[..., Any]] = {
    "virtual_goal": virtual_goal,
    "mlp": Mlp,
    "oracle": Oracle,
    "ema": RunningMean,
    "kalman": Kalman,
    "recursive_ridge": RecursiveRidge,
    IN_CONTEXT: InContext,
    POSTERIOR: _posterior,
}
"""What takes the settings of controllers that have any and do not grasp."""
_PLACES: Mapping[str, Callable[..., Place]] = {
    "centre": lambda core: Centre(),
    "centroid": centroid,
    "flattest": flattest,
    "local_mlp": local_mlp,
    "true_surface": TrueSurface,
}
"""Rules where to grasp by controller; each throws with the same paces and the same residual."""
_GRASPS: Mapping[str, Any] = {
    "fitted_q": FittedQ,
    "oracle_grasp": GraspOracle,
    "remembering": Remembering,
    "shift_values": ShiftValues,
}
"""Controllers that choose where to grasp in ways of their own: one learns from rewards, one simulates beforehand,
and two remember what their shift has shown."""
_RELEASES: Final[Mapping[str, Callable[..., OnPolicyRegression]]] = {"shipped": shipped_release, "none": new_release}
"""How the residual of a controller that grasps begins."""
CHEATS: Final = ("true_surface", "oracle_grasp", "oracle", "oracle_drift")
"""Controllers that know what is hidden."""
GRASPING_NAMES = (*_PLACES, *_GRASPS)
"""Names of the controllers that choose where to grasp."""
NAMES = (*_ANY_ACTIONS, *_SHIFTS, *_TRACKERS, POSTERIOR, *GRASPING_NAMES)


def make(name: str, env: Env, **options: Any) -> Controller:
    """Controller of one of `NAMES`, fitted to an environment.

    Raises:
        UsageError: the controller cannot act in this environment, or has no such settings.
    """
    with about(f"controller {name!r}"):
        check_known("setting", options, _settings(name))
    if name in _ANY_ACTIONS:
        return _ANY_ACTIONS[name](env, **options)
    if name in _SHIFTS:
        return _SHIFTS[name](env, _correction(name, env), **options)
    if name in GRASPING_NAMES:
        return _make(name, env, options)
    # The static policy of `static` has learned under drift; that of the other adaptive controllers in a cell without
    # drift, whose landings are not blurred.
    correction, core = _correction(name, env), core_of(env)
    if not has_feedback(core):
        raise UsageError(f"controller {name!r} needs observations of the previous landing; use --env PnTAdapt-v0")
    if name == POSTERIOR:
        return _posterior(core, correction, **options)
    tracker, file = _TRACKERS[name](core, **options), STATIC if name == STATIC else IN_CONTEXT
    shipped = state.read(ADAPTIVE / f"{file}.npz")[1]
    return Adaptive(name, correction, _features(env), core.item_names, tracker, shipped)


def _settings(name: str) -> list[str]:
    """Names of the settings of a controller."""
    if name in GRASPING_NAMES:
        own = settings_of(*([_GRASPS[name]] if name in _GRASPS else [_PLACES[name], GraspController]))
        return ["residual", *(setting for setting in own if setting != "release")]
    return settings_of(*([_SETTINGS[name]] if name in _SETTINGS else []))


def _make(name: str, env: Env, options: Mapping[str, Any]) -> Controller:
    """Controller that grasps, with the residual that ships, or with none for the option `residual=none`."""
    core: Any = core_of(env)  # a part says so where it is no cell that grasps
    others = dict(options)
    begin = others.pop("residual", "shipped")
    if begin not in _RELEASES:
        raise UsageError(f"residual is {begin!r}; it must be 'shipped' or 'none'")
    release = _RELEASES[begin](core, name)
    if name in _GRASPS:
        return _GRASPS[name](core, release, **others)
    of_place = {key: others.pop(key) for key in options if key in inspect.signature(_PLACES[name]).parameters}
    return GraspController(name, core, _PLACES[name](core, **of_place), release=release, **others)


def _correction(name: str, env: Env) -> Correction:
    """Correction of an environment; some action modes have none."""
    core = core_of(env)
    if core.correction is not None and core.action_mode in core.shift_modes:
        return core.correction
    if not core.shift_modes:
        raise UsageError(f"controller {name!r} shifts the landing, which no action mode of this environment does")
    sizes = sorted({core.action_sizes[mode] for mode in core.shift_modes})
    raise UsageError(
        f"controller {name!r} shifts the landing and needs an action of {' or '.join(map(str, sizes))} numbers, "
        f"not {_count(env.single_action_space)}; use the action mode {' or '.join(core.shift_modes)}"
    )


def _shared_core(name: str, env: Env) -> Core:
    """Core of all rows, unless each row has its own."""
    core = core_of(env)
    if hasattr(env.unwrapped, "envs") and env.num_envs > 1:
        raise UsageError(
            f"controller {name!r} simulates all cells at once, and these are stepped one by one: use 1 cell"
        )
    return core


def _features(env: Env) -> int:
    return _count(env.single_observation_space)


def _count(space: Space[Any]) -> int:
    """Number of entries of one action or observation."""
    return int(np.prod(space.shape or (1,)))


DESCRIBED_IN: Final[Mapping[str, Any]] = {
    "virtual_goal": virtual_goal,
    "ridge": Ridge,
    "mlp": Mlp,
}
"""Objects whose docstring describes a controller, where the class of the controller serves several."""
WORDS: Final[Mapping[str, str]] = {
    "static": "An MLP that was trained under the drift of `day`; it does not adapt",
    "ema": "An MLP, minus the running mean of its errors in this shift",
    "kalman": "An MLP, minus the effect of valve delay, camera and encoder on each throw, as two filters estimate it",
    "recursive_ridge": "An MLP, minus a recursive ridge regression of its errors on features of the plan",
    "in_context": "An MLP, minus the prediction of a recurrent network that was trained on simulated shifts",
    "centre": "Grasps the middle of the outline",
    "centroid": "Grasps the middle of what the picture shows of the object",
    "flattest": "Grasps where the picture is flat under the cup and around; `rule` is depth, colour or naive",
    "local_mlp": "Grasps where a network on features of the picture expects the most; it learned from tries on `grasp`",
    "fitted_q": "Grasps and throws by two networks of values, which learned on `grasp` from rewards alone",
    "remembering": "Grasps, gives up and corrects by rules that remember readings of the gauge and landings of a shift",
    "shift_values": "Grasps, throws and gives up by networks that learned from many shifts to use such a memory",
    "true_surface": "Cheats: grasps where a try is worth most by the true surface, without the error of the cup",
    "oracle_grasp": "Cheats: simulates each try and each throw first, and takes the fastest throw that is sorted",
    "oracle_drift": "Cheats: an MLP, minus the effect of the true drift; draught is not corrected",
}
"""Descriptions of controllers that share a class: each names its estimate of the drift, or its place to grasp."""


def describe(name: str, controller: Controller) -> str:
    """The first paragraph of the docstring of a controller, or the words for it in `WORDS`."""
    text = WORDS.get(name) or inspect.getdoc(DESCRIBED_IN.get(name) or type(controller)) or ""
    return " ".join(text.split("\n\n", 1)[0].rstrip(".").split())
