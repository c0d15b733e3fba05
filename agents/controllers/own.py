"""Controllers from elsewhere: a user's class, a function, a model of stable-baselines3, or a trained policy."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeAlias, final

import numpy as np
from gymnasium.spaces import Dict
from numpy.typing import NDArray

from pnt_gym.errors import PntGymError, one_sentence
from pnt_gym.names import unknown_name

from ..ground.cli import UsageError, about, check_known, user_code
from ..ground.environments import Env, core_of, import_user_module
from ..ground.places import module_name
from ..learning import trained
from ..learning.runs import RunFolder
from ..learning.trained import STATISTICS
from ..policies.actor import Actor
from . import adaptive, between
from .between import PLANNER, MemoryPolicy
from .protocol import Actions, Controller, Observation

Function: TypeAlias = Callable[..., Any]
"""Observations (N, D), or vectors and pictures, to actions (N, A)."""
METHODS: Final = ("reset", "act", "learn")
"""Methods that the class of a controller must have."""


@final
class Policy(Controller):
    """Controller from a function of observations to actions, without learning; `note` is a sentence for its table."""

    def __init__(self, function: Function, name: str, kind: Any = np.float32, note: str = "") -> None:
        self.function, self.name, self._kind, self.note = function, name, kind, note

    def act(self, observation: Observation) -> Actions:
        """Actions of the function (N, A)."""
        pictures = () if observation.image is None else (observation.image,)
        return np.asarray(self.function(observation.features, *pictures), dtype=self._kind)


def controller_of(policy: Any, env: Env) -> Controller:
    """Controller from a class, an object, a model or a function.

    Args:
        policy: a controller or the class of one, a model of stable-baselines3, or a function of observations to actions
            (N, A), which gets observations as the vector environment gives them: an array (N, D), or of an environment
            with pictures a mapping with "vector" (N, D) and "image" (N, 5, H, W).
        env: the environment in which the controller will act.

    Raises:
        UsageError: the policy is none of these, or a model that does not fit the environment.
    """
    if inspect.isclass(policy):
        return _make(policy, repr(policy.__name__), env)
    if hasattr(policy, "act"):
        return _check(policy, repr(type(policy).__name__))
    if hasattr(policy, "predict"):
        return _policy(policy, type(policy).__name__.lower(), env)
    if callable(policy):
        name = getattr(policy, "__name__", type(policy).__name__)
        has_pictures = isinstance(env.single_observation_space, Dict)
        act = (lambda vector, image: policy({"image": image, "vector": vector})) if has_pictures else policy
        return Policy(act, name, kind=env.single_action_space.dtype)
    raise UsageError(f"a policy is a controller, a model or a function of observations, not {policy!r}")


def import_controller(reference: str, env: Env, **options: Any) -> Controller:
    """Controller of the class MODULE:CLASS; `Controller` describes the class.

    Raises:
        UsageError: the class does not exist, cannot be instantiated, or is no controller.
    """
    module, _, name = reference.partition(":")
    place = import_user_module(module)
    controller_class = getattr(place, name, None)
    if not inspect.isclass(controller_class):
        classes = [key for key, value in vars(place).items() if inspect.isclass(value) and value.__module__ == module]
        raise UsageError(f"module {module!r}: {unknown_name('class', name, classes)}")
    _check(controller_class, repr(reference), METHODS)  # before any call: a plan of others may name any class
    return _make(controller_class, repr(reference), env, **options)


def _make(factory: Callable[..., Any], name: str, env: Env, **options: Any) -> Controller:
    try:
        parameters = inspect.signature(factory).parameters
        if not any(part.kind is part.VAR_KEYWORD for part in parameters.values()):
            with about(f"controller {name}"):
                check_known("setting", options, [part for part in parameters if part != "core"])
        if "core" in parameters:
            options["core"] = core_of(env)
        with user_code(f"controller {name}"):
            controller = factory(**options)
    except PntGymError:
        raise
    except Exception as error:
        raise UsageError(f"controller {name} cannot be made: {type(error).__name__}: {one_sentence(error)}") from error
    return _check(controller, name)


def _check(controller: Any, name: str, parts: Sequence[str] = ("name", *METHODS)) -> Any:
    missing = [part for part in parts if not hasattr(controller, part)]
    if missing:
        base = f"{module_name('agents.controllers')}.Controller"
        raise UsageError(f"controller {name} has no {' and no '.join(missing)}; inherit {base}")
    return controller


def load(place: Path, env: Env, *, trust: bool = False) -> Controller:
    """Policy of a run folder, or with `trust`, because loading runs code, of an RL-Zoo folder or a model file.

    Raises:
        UsageError: the policy is missing, damaged or not trusted, or does not fit the environment.
    """
    files, label = trained.find(place), f"the policy of {str(place)!r}"
    if files.is_run:
        run = RunFolder(place)
        return run_policy(run.actor(), run.arguments, env, label)
    trained.check(place, trust)
    from ..learning import sb3  # noqa: PLC0415 - torch takes a second to import
    from ..learning.sb3 import load_policy  # noqa: PLC0415 - torch takes a second to import
    from ..learning.vec_env import SameStepVecEnv  # noqa: PLC0415 - as above

    model = load_policy(files.model)
    policy = _policy(model, type(model).__name__.lower(), env, label)
    if files.statistics is None:
        if isinstance(policy, Policy):
            policy.note = f"{label} gets raw observations: no {STATISTICS} lies beside {files.model.name}"
        return policy
    if not isinstance(policy, Policy):
        raise UsageError(f"{label} is recurrent and takes normalised observations; only one of the two is supported")
    statistics = sb3.statistics(files.statistics, SameStepVecEnv(env))

    def predict(features: NDArray[np.float32]) -> Any:
        normalised_features: Any = statistics.normalize_obs(features)
        return policy.function(normalised_features)

    return Policy(predict, policy.name, note=f"{label} gets observations normalised by {files.statistics}")


def run_policy(actor: Actor, arguments: Mapping[str, Any], env: Env, label: str, name: str | None = None) -> Controller:
    """Controller from a trained policy stored as numbers, with the policy wrapper of its training.

    Args:
        actor: the policy.
        arguments: arguments of the training.
        env: the environment in which the policy will act.
        label: name of the policy in error messages.
        name: name in tables; None for the algorithm's.

    Raises:
        UsageError: the policy does not fit the environment.
    """
    return _actor_controller(actor, name or arguments["algo"], env, label, arguments["stack"], arguments["over"])


def _actor_controller(actor: Actor, name: str, env: Env, label: str, stack: int = 1, over: str = PLANNER) -> Controller:
    input_size, output_size = actor.sizes
    sees = isinstance(env.single_observation_space, Dict)
    if sees != (actor.eye is not None):
        raise UsageError(
            f"{label} {'sees no' if sees else 'needs'} pictures, which this environment has" + ("" if sees else " not")
        )
    further = output_size if sees and over != PLANNER else 0  # entries of the base controller's action
    _check_fit((input_size - further,), (output_size,), env, label, stack)
    if actor.lstm is None and (stack, over) == (1, PLANNER):
        return Policy(actor, name)
    if actor.lstm is not None:
        adaptive.check(env, label)
    return MemoryPolicy(actor, name, between.make(env, stack, over))


def _policy(model: Any, name: str, env: Env, label: str = "the model") -> Controller:
    """Controller of a stable-baselines3 model's mean action.

    Raises:
        UsageError: the model does not fit the environment.
    """
    if hasattr(getattr(model, "policy", None), "lstm_actor"):
        from ..policies import weights  # noqa: PLC0415 - as above

        actor = weights.actor(model)
        assert isinstance(actor, Actor)  # scorers have no LSTM
        return _actor_controller(actor, name, env, label)
    if isinstance(model.observation_space, Dict) and isinstance(env.single_observation_space, Dict):
        _check_fit(model.observation_space["vector"].shape, model.action_space.shape, env, label)
        return Policy(lambda v, i: model.predict({"image": i, "vector": v}, deterministic=True)[0], name)
    _check_fit(model.observation_space.shape, model.action_space.shape, env, label)
    core: Any = core_of(env)
    is_masked = "action_masks" in inspect.signature(model.predict).parameters

    def predict(features: NDArray[np.float32]) -> Any:
        masks = {"action_masks": core.masks()} if is_masked else {}
        return model.predict(features, deterministic=True, **masks)[0]

    return Policy(predict, name, kind=env.single_action_space.dtype)


def _check_fit(inputs: Any, outputs: Any, env: Env, label: str, stack: int = 1) -> None:
    space = env.single_observation_space
    entries = space["vector"].shape if isinstance(space, Dict) else space.shape
    shapes = ((*(stack * size for size in entries or ()),), env.single_action_space.shape)
    if (inputs, outputs) != shapes:
        raise UsageError(
            f"{label} takes observations {inputs} and gives actions {outputs}, but the environment has {shapes[0]} and "
            f"{shapes[1]}"
        )
