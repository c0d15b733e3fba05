"""Models of stable-baselines3: making new ones, and loading them from files."""

from __future__ import annotations

import json
import math
import pickle
import re
import sys
import warnings
from collections.abc import Mapping
from copy import deepcopy
from inspect import signature
from io import BytesIO
from pathlib import Path
from typing import Any, Final, final
from zipfile import ZipFile

import gymnasium as gym
import numpy as np
import torch
from gymnasium.spaces import Box, Dict, Discrete
from numpy.typing import NDArray
from stable_baselines3 import A2C, PPO, SAC, TD3
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.save_util import recursive_getattr
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecNormalize

from pnt_gym.errors import PntGymError, one_sentence
from pnt_gym.names import unknown_name
from pnt_gym.reading import ReadError, archive, parsed_json

from ..ground.cli import UsageError, about, check_known
from .bandit_sac import BanditSAC
from .hyperparameters import (
    FALLING,
    MASKED,
    MOST_MODEL,
    RECURRENT,
    RESIDUAL,
    WIDEST,
    algorithm_arguments,
    initial_value,
)
from .vec_env import rows_thrown

COUNTS = ("num_timesteps", "_n_updates", "_episode_num")
"""Counts of a model's learning; all other state is in tensors or follows from the hyperparameters."""
SMALL = 0.01
"""Factor on the last layer of a new policy: its first throws are the analytic planner's."""
MARKS: Final = {
    "tqc": "top_quantiles_to_drop_per_net",
    "td3": "target_policy_noise",
    "sac": "target_entropy",
    "recurrent_ppo": "_process_sequence",
    "ppo": "clip_range",
    "a2c": "vf_coef",
}
"""Attribute that a stored model of each algorithm or its policy has, and later algorithms lack; DDPG is a kind of
TD3."""
PARTS: Final = re.compile(r"data|[a-z_.]+\.pth|_stable_baselines3_version|system_info\.txt")
"""Names of the members of a model's file."""
INNER: Final = re.compile(r"[\w.]+/(?:data\.pkl|data/\d+|version|byteorder|\.[\w./]+)")
"""Names of the members of a file of tensors."""


@final
class ThrownBuffer(ReplayBuffer):
    """Replay buffer of throws alone: it leaves out failed picks and dropped objects, which no action influences.

    In a batch, a throw of another row replaces each of these. A batch without any throw is left out, unless the buffer
    is empty, because nothing can be sampled from an empty buffer.
    """

    def add(
        self,
        obs: NDArray[Any],
        next_obs: NDArray[Any],
        action: NDArray[Any],
        reward: NDArray[Any],
        done: NDArray[Any],
        infos: list[dict[str, Any]],
    ) -> None:
        """Add the throws of one step of all rows."""
        throw_rows = rows_thrown(infos)
        if not throw_rows and self.size() > 0:
            return
        sources = np.arange(len(infos))
        replaced = np.setdiff1d(sources, throw_rows)
        sources[replaced] = np.resize(throw_rows or replaced, len(replaced))
        super().add(
            obs[sources],
            next_obs[sources],
            action[sources],
            reward[sources],
            done[sources],
            [infos[row] for row in sources],
        )


@final
class Falling:
    """A learning rate that falls linearly to 0 over a whole training; stable-baselines3 knows the present leg alone.

    Args:
        begin: the rate at the first throw.
    """

    def __init__(self, begin: float) -> None:
        self.begin, self.share = begin, 1.0

    def __call__(self, remaining: float) -> float:
        """Learning rate when a share `remaining` of the throws up to the end of this leg is left."""
        return self.begin * max(1.0 - (1.0 - remaining) * self.share, 0.0)


def begin(model: BaseAlgorithm, end: int, total: int) -> None:
    """Set a model's learning rate for a leg that ends at throw `end` of `total`."""
    if isinstance(model.learning_rate, Falling):
        model.learning_rate.share = end / total


def algorithm_class(name: str) -> type[BaseAlgorithm]:
    """The class of an algorithm.

    Raises:
        UsageError: the name is unknown.
    """
    if name == "tqc":
        from sb3_contrib import TQC  # noqa: PLC0415 - only this algorithm needs it

        return TQC
    if name == "recurrent_ppo":
        from sb3_contrib import RecurrentPPO  # noqa: PLC0415 - as above

        return RecurrentPPO
    if name in MASKED:
        from sb3_contrib import MaskablePPO  # noqa: PLC0415 - as above

        return MaskablePPO
    classes: dict[str, type[BaseAlgorithm]] = {"sac": BanditSAC, "td3": TD3, "ppo": PPO, "a2c": A2C}
    if name not in classes:
        raise UsageError(unknown_name("algorithm", name, (*RESIDUAL, *MASKED)))
    return classes[name]


def load_policy(file: Path) -> BaseAlgorithm:
    """Load a model from a file of stable-baselines3; runs code in the file.

    Raises:
        UsageError: the file is damaged, or of no algorithm of `MARKS`.
    """
    torch.set_num_threads(1)  # small networks are slower on many threads than on one
    sys.modules.setdefault("agents.sb3", sys.modules[__name__])  # its name in models of older versions
    try:
        with ZipFile(file) as parts:
            stored = json.loads(parts.read("data"))
        algo = next(name for name, mark in MARKS.items() if mark in {*stored, *stored["policy_class"]})
        return algorithm_class(algo).load(file, device="cpu")
    except Exception as error:
        # A truncated or foreign file may raise anything in the library.
        kinds = ", ".join(MARKS)
        raise UsageError(f"{str(file)!r} is damaged: {file.name} is truncated or not a model of {kinds}") from error


def load(
    file: Path, run_args: Mapping[str, Any], settings: Mapping[str, Any], env: VecEnv | None = None
) -> BaseAlgorithm:
    """Load a run's model: build it from arguments and settings, then fill in the tensors and counts of its file.

    Nothing is unpickled, so no code in the file is run.

    Raises:
        UsageError: the file is damaged, or of other settings.
    """
    try:
        with archive(file, PARTS, MOST_MODEL) as (parts, infos):
            stored = parsed_json(parts.read("data"))
            names = [info.filename for info in infos if info.filename.endswith(".pth")]
            tensors = {name: _read(parts.read(name)) for name in names}
        _check(tensors)
        model: Any = _make(run_args["algo"], env or _stub_env(stored, run_args["num_envs"]), settings, run_args["seed"])
        states, variables = model._get_torch_save_params()
        model.set_parameters({name: tensors[f"{name}.pth"] for name in states})
        for name in states:
            # Make sure that the moments of an optimiser have the shapes of the weights that they belong to.
            part = recursive_getattr(model, name)
            for weight, moments in part.state.items() if isinstance(part, torch.optim.Optimizer) else ():
                if any(
                    torch.is_tensor(value) and value.ndim and value.shape != weight.shape for value in moments.values()
                ):
                    raise ValueError("moments of other weights")
        for name in variables:
            getattr(model, name).data = tensors["pytorch_variables.pth"][name].data
        for name in COUNTS:
            setattr(model, name, int(stored.get(name, 0)))
    except ReadError as error:
        reason = f"{file.name} is truncated or not a model of its run: {error}"
        raise UsageError(f"{str(file)!r} is damaged: {reason}") from error
    except PntGymError:
        raise
    except Exception as error:
        raise UsageError(f"{str(file)!r} is damaged: {file.name} is truncated or not a model of its run") from error
    return model


def _stub_env(stored: Mapping[str, Any], count: int) -> VecEnv:
    """A stub environment with the spaces of a stored model and a number of rows, for a model that only acts."""
    stub: gym.Env[Any, Any] = gym.Env()
    observation, action = (tuple(stored[f"{name}_space"]["_shape"]) for name in ("observation", "action"))
    count_of = stored["action_space"].get("n")
    if max(math.prod(observation), math.prod(action), int(count_of or 0)) > WIDEST:
        raise ValueError("spaces of absurd sizes")
    stub.observation_space = Box(-np.inf, np.inf, observation)
    stub.action_space = Box(-1.0, 1.0, action) if count_of is None else Discrete(int(count_of))
    rows = DummyVecEnv([lambda: stub])
    rows.num_envs = count
    return rows


def _read(data: bytes) -> dict[str, Any]:
    with archive(BytesIO(data), INNER, MOST_MODEL), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # errors report foreign files
        return torch.load(BytesIO(data), map_location="cpu", weights_only=True)


def _check(values: Any) -> None:
    """Make sure that all tensors in nested mappings and lists are finite.

    Raises:
        ValueError: one is not.
    """
    if isinstance(values, torch.Tensor) and not bool(torch.isfinite(values).all()):
        raise ValueError("a tensor whose numbers are not finite")
    for part in values.values() if isinstance(values, dict) else values if isinstance(values, list) else ():
        _check(part)


def statistics(file: Path, env: VecEnv) -> VecNormalize:
    """Load the statistics that normalise observations; runs code in the file.

    Raises:
        UsageError: the file is damaged, or of other observations.
    """
    try:
        return VecNormalize.load(str(file), env)
    except (OSError, EOFError, pickle.PickleError, ValueError, AttributeError, AssertionError, ImportError):
        raise UsageError(f"{str(file)!r} is damaged, or of other observations than this environment's") from None


def build(algo: str, env: VecEnv, settings: Mapping[str, Any], seed: int) -> BaseAlgorithm:
    """A new model whose first policy is the analytic planner, apart from exploration.

    Args:
        algo: one of `RESIDUAL`.
        env: the adapted environment.
        settings: hyperparameters in RL-Zoo syntax; `n_timesteps` and `n_envs` are for the caller.
        seed: seed of network weights and exploration.

    Raises:
        UsageError: the settings do not fit the algorithm.
    """
    model = _make(algo, env, settings, seed)
    _begin(model)
    return model


def _make(algo: str, env: VecEnv, settings: Mapping[str, Any], seed: int) -> BaseAlgorithm:
    """A model with random weights."""
    torch.set_num_threads(1)  # small networks are slower on many threads than on one
    chosen = algorithm_arguments(deepcopy(dict(settings)))  # stable-baselines3 adds to the dicts it is given
    sees_pictures = isinstance(env.observation_space, Dict)
    policy = _policy(algo, chosen.pop("policy", None), sees_pictures)
    if isinstance(chosen.get(FALLING), str):
        chosen[FALLING] = Falling(initial_value(chosen[FALLING]))
    kind = algorithm_class(algo)
    if issubclass(kind, OffPolicyAlgorithm) and not sees_pictures:  # a failed pick teaches who sees where to grasp
        chosen.setdefault("replay_buffer_class", ThrownBuffer)
    with about(f"hyperparameters do not fit {algo}"):
        # Names of the arguments of a class, and of classes below to which the class passes further ones.
        names: list[str] = []
        for base in kind.__mro__:
            if "__init__" in vars(base):
                parameters = signature(base).parameters.values()
                names += [part.name for part in parameters if part.kind not in (part.VAR_KEYWORD, part.VAR_POSITIONAL)]
                if all(part.kind is not part.VAR_KEYWORD for part in parameters):
                    break
        check_known("hyperparameter", chosen, names)
    try:
        return kind(policy, env, seed=seed, device="cpu", verbose=0, **chosen)
    except PntGymError:
        raise
    except Exception as error:
        # A setting of the wrong type may raise anything in the library.
        raise UsageError(f"hyperparameters do not fit {algo}: {one_sentence(error)}") from error


def _policy(algo: str, name: str | None, sees_pictures: bool) -> str | type[Any]:
    """The policy class of an algorithm: `name`, or the default for None.

    Raises:
        UsageError: the algorithm has only its own policy.
    """
    if algo == "residual_ppo":
        from .residual import ResidualPolicy  # noqa: PLC0415 - only this algorithm needs it

        if name is not None:
            raise UsageError(f"hyperparameter policy is {name!r}; residual_ppo has a policy of its own: leave it out")
        return ResidualPolicy
    usual = "MultiInputPolicy" if sees_pictures else "MlpPolicy"
    return name or ("MlpLstmPolicy" if algo in RECURRENT else usual)


def _begin(model: BaseAlgorithm) -> None:
    """Scale the layer of the mean action by `SMALL`, so that first actions are nearly zero; scorers need no scaling.

    SAC begins with a standard deviation that hardly depends on the observation, if `log_std_init` says which one.
    """
    policy: Any = model.policy
    if hasattr(policy, "numbers"):
        return
    spread = model.policy_kwargs.get("log_std_init")
    if isinstance(model, SAC) and spread is not None and not model.use_sde:
        with torch.no_grad():
            (head,) = (layer for layer in policy.actor.log_std.modules() if isinstance(layer, torch.nn.Linear))
            head.weight.mul_(SMALL)
            head.bias.fill_(spread)
    heads = [policy.action_net] if isinstance(model, OnPolicyAlgorithm) else [policy.actor.mu]
    if isinstance(model, TD3):
        heads.append(policy.actor_target.mu)  # the target is an earlier copy: both must start alike
    with torch.no_grad():
        for head in heads:
            *_, last = (layer for layer in head.modules() if isinstance(layer, torch.nn.Linear))
            last.weight.mul_(SMALL)
            last.bias.zero_()
