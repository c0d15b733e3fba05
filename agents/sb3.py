"""Gymnasium's vector environments as stable-baselines3 expects them, and the algorithms on them."""

from __future__ import annotations

import json
import pickle
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from io import BytesIO
from pathlib import Path
from typing import Any, Final, cast, final
from zipfile import ZipFile

import gymnasium as gym
import numpy as np
import torch
from gymnasium.spaces import Box, Discrete
from numpy.typing import NDArray
from stable_baselines3 import A2C, PPO, SAC, TD3
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecNormalize
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn

from pnt_gym.errors import PntGymError, one_sentence

from .actor import ACTIVATIONS, Actor, Lstm
from .cli import UsageError
from .environments import Env, check_autoreset, core_of
from .hyperparameters import FALLING, begin, checked
from .runs import ALGORITHMS, CHOOSING, RECURRENT
from .scorer import Scorer
from .throws import results

COUNTS = ("num_timesteps", "_n_updates", "_episode_num")
"""What a model counts while it learns; the rest of its state is tensors, or settled by the hyperparameters."""
INFO_KEYS = ("is_success", "landing_error", "cycle_time", "picked", "dropped", "value", "dt")
"""What of a throw's info reaches the learner's callbacks."""
SMALL = 0.01
"""Factor on the last layer of a new policy: its first throws are the analytic planner's."""
MASKS: Final = "action_masks"
"""By this name sb3-contrib asks what can be chosen."""
MARKS: Final = {
    "tqc": "top_quantiles_to_drop_per_net",
    "td3": "target_policy_noise",
    "sac": "target_entropy",
    "recurrent_ppo": "_process_sequence",
    "ppo": "clip_range",
    "a2c": "vf_coef",
}
"""What a stored model of each algorithm or its policy has, and none of an algorithm after it; DDPG is a kind of TD3."""


@final
class Falling:
    """A learning rate that falls to 0 along a line over a whole training; stable-baselines3 knows of its leg alone.

    Args:
        begin: the rate at the first throw.
    """

    def __init__(self, begin: float) -> None:
        self.begin, self.share = begin, 1.0

    def __call__(self, remaining: float) -> float:
        """The rate when so much is left of the throws from the first one to the end of this leg."""
        return self.begin * max(1.0 - (1.0 - remaining) * self.share, 0.0)


def begin_leg(model: BaseAlgorithm, end: int, total: int) -> None:
    """Tell a model before it learns on that the leg ends with so many throws of all."""
    if isinstance(model.learning_rate, Falling):
        model.learning_rate.share = end / total


def algorithm_class(name: str) -> type[BaseAlgorithm]:
    """The class of an algorithm.

    Raises:
        UsageError: unknown name.
    """
    if name == "tqc":
        from sb3_contrib import TQC  # noqa: PLC0415 - only this algorithm needs it

        return TQC
    if name == "recurrent_ppo":
        from sb3_contrib import RecurrentPPO  # noqa: PLC0415 - as above

        return RecurrentPPO
    if name in CHOOSING:
        from sb3_contrib import MaskablePPO  # noqa: PLC0415 - as above

        return MaskablePPO
    classes: dict[str, type[BaseAlgorithm]] = {"sac": SAC, "td3": TD3, "ppo": PPO, "a2c": A2C}
    if name not in classes:
        raise UsageError(f"unknown algorithm {name!r}; known are {', '.join((*ALGORITHMS, *CHOOSING))}")
    return classes[name]


def load_policy(file: Path, env: VecEnv | None = None) -> BaseAlgorithm:
    """The model in a file that stable-baselines3 wrote; runs code in it.

    Raises:
        UsageError: it is damaged, or of no algorithm of `MARKS`.
    """
    torch.set_num_threads(1)  # small networks are slower on many threads than on one
    try:
        with ZipFile(file) as parts:
            stored = json.loads(parts.read("data"))
        algo = next(name for name, mark in MARKS.items() if mark in {*stored, *stored["policy_class"]})
        return algorithm_class(algo).load(file, env=env, device="cpu")
    except Exception as error:
        # There is no telling what a torn or foreign file upsets in there.
        kinds = ", ".join(MARKS)
        raise UsageError(f"{str(file)!r} is damaged: {file.name} is truncated or not a model of {kinds}") from error


def load_tensors(
    file: Path, asked: Mapping[str, Any], settings: Mapping[str, Any], env: VecEnv | None = None
) -> BaseAlgorithm:
    """The model of a run, made as its arguments and settings say and filled with the tensors and counts of its file.

    Nothing is unpickled, so nothing in the file is run.

    Raises:
        UsageError: it is damaged, or of other settings.
    """
    try:
        with ZipFile(file) as parts:
            stored = json.loads(parts.read("data"))
            tensors = {name: _tensors(parts.read(name)) for name in parts.namelist() if name.endswith(".pth")}
        model: Any = _made(asked["algo"], env or _nowhere(stored, asked["num_envs"]), settings, asked["seed"])
        states, variables = model._get_torch_save_params()
        model.set_parameters({name: tensors[f"{name}.pth"] for name in states})
        for name in variables:
            getattr(model, name).data = tensors["pytorch_variables.pth"][name].data
        for name in COUNTS:
            setattr(model, name, int(stored.get(name, 0)))
    except PntGymError:
        raise
    except Exception as error:
        raise UsageError(f"{str(file)!r} is damaged: {file.name} is truncated or not a model of its run") from error
    return model


def _nowhere(stored: Mapping[str, Any], count: int) -> VecEnv:
    """Nothing but the spaces of a stored model and a number of rows: what it takes to make one that only acts."""
    nowhere: gym.Env[Any, Any] = gym.Env()
    seen, action = (tuple(stored[f"{name}_space"]["_shape"]) for name in ("observation", "action"))
    count_of = stored["action_space"].get("n")
    nowhere.observation_space = Box(-np.inf, np.inf, seen)
    nowhere.action_space = Box(-1.0, 1.0, action) if count_of is None else Discrete(int(count_of))
    rows = DummyVecEnv([lambda: nowhere])
    rows.num_envs = count
    return rows


def _tensors(data: bytes) -> dict[str, Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # an error says what is wrong with a foreign file
        return torch.load(BytesIO(data), map_location="cpu", weights_only=True)


def load_statistics(file: Path, env: VecEnv) -> VecNormalize:
    """By what observations are normalised; runs code in the file.

    Raises:
        UsageError: it is damaged, or of other observations.
    """
    try:
        return VecNormalize.load(str(file), env)
    except (OSError, EOFError, pickle.PickleError, ValueError, AttributeError, AssertionError, ImportError):
        raise UsageError(f"{str(file)!r} is damaged, or of other observations than this environment's") from None


def build(algo: str, env: VecEnv, settings: Mapping[str, Any], seed: int) -> BaseAlgorithm:
    """A new model whose first policy is the analytic planner, give or take its exploration.

    Args:
        algo: one of `ALGORITHMS`.
        env: the adapted environment.
        settings: hyperparameters in RL-Zoo syntax; `n_timesteps` and `n_envs` are for the caller.
        seed: of network weights and exploration.

    Raises:
        UsageError: the settings do not fit the algorithm.
    """
    model = _made(algo, env, settings, seed)
    start_at_zero(model)
    return model


def _made(algo: str, env: VecEnv, settings: Mapping[str, Any], seed: int) -> BaseAlgorithm:
    """A model with random weights."""
    torch.set_num_threads(1)  # small networks are slower on many threads than on one
    chosen = checked(deepcopy(dict(settings)))  # stable-baselines3 adds to the dicts it is given
    policy = _policy(algo, chosen.pop("policy", None))
    if isinstance(chosen.get(FALLING), str):
        chosen[FALLING] = Falling(begin(chosen[FALLING]))
    kind = algorithm_class(algo)
    if issubclass(kind, OffPolicyAlgorithm):
        chosen.setdefault("replay_buffer_class", ThrownBuffer)
    try:
        return kind(policy, env, seed=seed, device="cpu", verbose=0, **chosen)
    except PntGymError:
        raise
    except Exception as error:
        # There is no telling what a setting of the wrong kind upsets in there.
        raise UsageError(f"hyperparameters do not fit {algo}: {one_sentence(error)}") from error


def _policy(algo: str, asked: str | None) -> str | type[Any]:
    """The policy of an algorithm: the usual one unless another is asked for.

    Raises:
        UsageError: there can be no other.
    """
    if algo == "residual_ppo":
        from .residual import ResidualPolicy  # noqa: PLC0415 - only this algorithm needs it

        if asked is not None:
            raise UsageError(f"hyperparameter policy is {asked!r}; residual_ppo has a policy of its own: leave it out")
        return ResidualPolicy
    return asked or ("MlpLstmPolicy" if algo in RECURRENT else "MlpPolicy")


def start_at_zero(model: BaseAlgorithm) -> None:
    """Scale the layer that gives the mean action down to nearly nothing; a scorer begins as the rule anyway."""
    policy: Any = model.policy
    if hasattr(policy, "numbers"):
        return
    heads = [policy.action_net] if isinstance(model, OnPolicyAlgorithm) else [policy.actor.mu]
    if isinstance(model, TD3):
        heads.append(policy.actor_target.mu)  # a copy made before: both must start alike
    with torch.no_grad():
        for head in heads:
            *_, last = (layer for layer in head.modules() if isinstance(layer, torch.nn.Linear))
            last.weight.mul_(SMALL)
            last.bias.zero_()


def actor_of(model: BaseAlgorithm) -> Actor | Scorer:
    """The policy by which a model acts when it does not explore, as numbers.

    Raises:
        UsageError: it is not a network of full layers with one known activation, for observations in one vector.
    """
    policy, seen = cast("Any", model.policy), model.observation_space
    if hasattr(policy, "numbers"):
        return policy.numbers()
    steps, bound = _steps(model)
    full, between = {type(step) for step in steps[::2]}, {type(step) for step in steps[1::2]}
    known = [name for name in ACTIVATIONS if between <= {getattr(torch.nn, name)}]
    recurrent = getattr(policy, "lstm_actor", None)
    plain = recurrent is None or _is_plain(recurrent)
    if full != {torch.nn.Linear} or not known or not plain or not isinstance(seen, Box) or len(seen.shape) != 1:
        raise UsageError(
            "the policy cannot be kept as numbers: it must take an observation in one vector, through full layers "
            f"(net_arch), with activation_fn one of {', '.join(ACTIVATIONS)} of nn, a recurrent one "
            "through one plain LSTM before them"
        )
    lstm = None if recurrent is None else _lstm(recurrent)
    layers = tuple((step.weight.detach().numpy().copy(), step.bias.detach().numpy().copy()) for step in steps[::2])
    if isinstance(model.action_space, Discrete):
        low = np.full(int(model.action_space.n), np.finfo(np.float32).min, dtype=np.float32)
        return Actor(layers, known[0], "scores", bound, low, -low)
    given = cast("Box", model.action_space)
    output = "squashed" if policy.squash_output else "clipped"
    return Actor(layers, known[0], output, bound, given.low, given.high, lstm)


def _is_plain(lstm: torch.nn.LSTM) -> bool:
    """One layer that goes one way, with biases."""
    return (lstm.num_layers, lstm.proj_size, lstm.bidirectional, lstm.bias, lstm.batch_first) == (
        1, 0, False, True, False,
    )  # fmt: skip


def _lstm(lstm: torch.nn.LSTM) -> Lstm:
    seen, kept, *biases = (part.detach().numpy().copy() for part in lstm.parameters())
    return Lstm(seen, kept, biases[0] + biases[1])


def _steps(model: BaseAlgorithm) -> tuple[list[Any], float]:
    """Full layers of a policy, with activations between them, and the bound of the last one's numbers."""
    policy: Any = model.policy
    if isinstance(model, OnPolicyAlgorithm):
        parts = [policy.mlp_extractor.policy_net, policy.action_net]
    else:
        parts = [policy.actor.mu] if isinstance(model, TD3) else [policy.actor.latent_pi, policy.actor.mu]
    steps = [step for part in parts for step in part.modules() if not isinstance(step, torch.nn.Sequential)]
    if isinstance(model, TD3):
        steps.pop()  # tanh, which the others leave to their distribution
    return (steps[:-1], steps[-1].max_val) if isinstance(steps[-1], torch.nn.Hardtanh) else (steps, np.inf)  # gSDE


def _thrown(infos: Sequence[Mapping[str, Any]]) -> list[int]:
    """Rows in which an action had a say."""
    return [row for row, info in enumerate(infos) if info.get("picked", True) and not info.get("dropped", False)]


def _evened(reward: NDArray[Any], infos: Sequence[Mapping[str, Any]]) -> NDArray[Any]:
    """Rewards (N,), of what was no throw the mean of the throws; as they are where there is none."""
    thrown = _thrown(infos)
    if not thrown:
        return reward
    evened = np.full_like(reward, np.mean(reward[thrown]))
    evened[thrown] = reward[thrown]
    return evened


@final
class ThrownBuffer(ReplayBuffer):
    """A memory of throws: what no action had a say in, a pick that failed or an object lost on the way, is not kept.

    In its place in a batch stands a throw of another row; a batch without any throw is not kept at all, but in an empty
    memory, from which nothing could be drawn.
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
        """Keep the throws of one step of all rows."""
        thrown = _thrown(infos)
        if not thrown and self.size() > 0:
            return
        kept = np.arange(len(infos))
        others = np.setdiff1d(kept, thrown)
        kept[others] = np.resize(thrown or others, len(others))
        parts = (part[kept] for part in (obs, next_obs, action, reward, done))
        super().add(*parts, [infos[row] for row in kept])


@final
class SameStepVecEnv(VecEnv):
    """Adapts a Gymnasium vector environment with SAME_STEP autoreset to the VecEnv conventions.

    Per finished episode `infos` holds `terminal_observation`, `TimeLimit.truncated` and `episode` (return r,
    length l, seconds since the start t); every throw has `is_success`, `landing_error` and `cycle_time`.

    Args:
        env: the environment.
        even: what no action had a say in, a pick that failed or an object lost on the way, gets the mean reward of the
            throws beside it: for algorithms that keep no memory from which to leave it out.
        price: of a second between decisions, taken off the reward beside what the environment itself takes off [1/s].

    Raises:
        UsageError: the environment resets in another way.
    """

    def __init__(self, env: Env, *, even: bool = False, price: float = 0.0) -> None:
        check_autoreset(env)
        self.env = env
        self._even, self._price = even, price
        self._start = time.perf_counter()
        self._actions: NDArray[Any] = np.zeros(0)
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)
        self._clear()

    def reset(self) -> NDArray[np.float32]:
        """Reset every row; with the seeds of the last `seed` call if there was one."""
        seeded = [s for s in self._seeds if s is not None]
        observation, info = self.env.reset(seed=seeded if len(seeded) == self.num_envs else None)
        self.reset_infos = [{key: info[key][i] for key in ("kind",) if key in info} for i in range(self.num_envs)]
        self._reset_seeds()
        self._reset_options()
        self._clear()
        return np.array(observation, dtype=np.float32)

    def step_async(self, actions: NDArray[Any]) -> None:
        """Keep the actions (N, A), or (N,) of choices, for `step_wait`."""
        self._actions = np.asarray(actions, dtype=self.action_space.dtype)

    def step_wait(self) -> VecEnvStepReturn:
        """Throw; rows whose episode ended are already reset in the observation returned."""
        observation, reward, terminated, truncated, info = self.env.step(self._actions)
        done = np.logical_or(terminated, truncated)
        self._returns += reward
        self._lengths += 1
        found = results(info, self.num_envs)
        if self._price:
            reward = reward - self._price * found["dt"]
        infos = [{key: found[key][i].item() for key in INFO_KEYS if key in found} for i in range(self.num_envs)]
        for i in np.flatnonzero(done):
            infos[i].update(self._ending(info, i, bool(truncated[i] and not terminated[i])))
        self._returns[done] = 0.0
        self._lengths[done] = 0
        reward = _evened(reward, infos) if self._even else reward
        return np.array(observation, dtype=np.float32), np.asarray(reward, dtype=np.float32), done, infos

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of the one environment, once per row."""
        value = self._masks if attr_name == MASKS else getattr(self.env, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the one environment: for all rows at once."""
        if indices is not None:
            raise UsageError("the rows of a vector environment share their attributes; set them without indices")
        setattr(self.env, attr_name, value)

    def env_method(
        self,
        method_name: str,
        *method_args: Any,
        indices: VecEnvIndices = None,
        **method_kwargs: Any,
    ) -> list[Any]:
        """Call a method of the one environment, once; its result stands for each row, but masks are of each row."""
        if method_name == MASKS:
            masks = self._masks()
            return [masks[row] for row in self._get_indices(indices)]
        result = getattr(self.env, method_name)(*method_args, **method_kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: VecEnvIndices = None) -> list[bool]:
        """Episode statistics are kept here, so no row is wrapped in anything."""
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """One image per row, None where the environment does not render."""
        images = self.env.render() if self.render_mode == "rgb_array" else None
        return list(images) if images is not None else [None] * self.num_envs

    @property
    def _masks(self) -> Callable[[], NDArray[np.bool_]]:
        """The method that tells what can be chosen in each row (N, A); an AttributeError where nothing is chosen."""
        return cast("Any", core_of(self.env)).masks

    def _clear(self) -> None:
        self._returns = np.zeros(self.num_envs)
        self._lengths = np.zeros(self.num_envs, dtype=np.int64)

    def _ending(self, info: Mapping[str, Any], row: int, timed_out: bool) -> dict[str, Any]:
        seconds = round(time.perf_counter() - self._start, 6)
        return {
            "terminal_observation": np.array(info["final_obs"][row], dtype=np.float32),
            "TimeLimit.truncated": timed_out,
            "episode": {"r": float(self._returns[row]), "l": int(self._lengths[row]), "t": seconds},
        }
