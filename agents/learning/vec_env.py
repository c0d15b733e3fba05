"""Adapter from Gymnasium's vector environments to stable-baselines3."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any, Final, cast, final

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn

from pnt_gym.cells.base.core import EPISODE_SUCCESS
from pnt_gym.errors import one_sentence

from ..ground import environments
from ..ground.cli import UsageError, check_known
from ..ground.environments import Env, core_of
from ..ground.infos import results
from ..ground.infos import rows_thrown as rows_with_throw

INFO_KEYS = ("is_success", "landing_error", "cycle_time", "picked", "dropped", "value", "dt")
"""Info keys of a throw that are passed to the learner's callbacks."""
MASKS: Final = "action_masks"
"""Name by which sb3-contrib asks for the masks of valid actions."""


def rows_thrown(infos: Sequence[Mapping[str, Any]]) -> list[int]:
    """Rows with a throw, without failed picks and dropped objects."""
    return [row for row, info in enumerate(infos) if info.get("picked", True) and not info.get("dropped", False)]


def _learnable(observation: Any) -> Any:
    """A copy of observations with 32 bits; pictures beside vectors stay bytes."""
    if isinstance(observation, Mapping):
        return {name: np.array(part) for name, part in observation.items()}
    return np.array(observation, dtype=np.float32)


@final
class SameStepVecEnv(VecEnv):
    """Adapts a Gymnasium vector environment with SAME_STEP autoreset to the VecEnv conventions.

    Per finished episode `infos` holds `terminal_observation`, `TimeLimit.truncated`, `episode` (return r, length l,
    seconds since the start t) and in sequences `episode_success`; every throw has `is_success`, `landing_error` and
    `cycle_time`, and a step in which a row's pick goes on has none of them.

    Args:
        env: the environment.
        even: give failed picks and dropped objects, which no action influences, the mean reward of the throws of the
            same step; for algorithms without a replay buffer that could leave them out.
        price: price of a second between decisions, subtracted from the reward beyond the environment's own price [1/s].

    Raises:
        UsageError: the environment has another autoreset mode.
    """

    def __init__(self, env: Env, *, even: bool = False, price: float = 0.0) -> None:
        environments.check(env)
        self.env = env
        self._even, self._price = even, price
        self._start = time.perf_counter()
        self._actions: NDArray[Any] = np.zeros(0)
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)
        self._clear()

    def reset(self) -> Any:
        """Reset every row, with the seeds of the last `seed` call, if any."""
        seeded = [s for s in self._seeds if s is not None]
        # Vector environments accept a seed for each row, which their base class does not annotate.
        seeds: Any = seeded if len(seeded) == self.num_envs else None
        observation, info = self.env.reset(seed=seeds)
        self.reset_infos = [{key: info[key][i] for key in ("kind",) if key in info} for i in range(self.num_envs)]
        self._reset_seeds()
        self._reset_options()
        self._clear()
        return _learnable(observation)

    def step_async(self, actions: NDArray[Any]) -> None:
        """Keep the actions (N, A), or choices (N,), for `step_wait`."""
        self._actions = np.asarray(actions, dtype=self.action_space.dtype)

    def step_wait(self) -> VecEnvStepReturn:
        """Step the environment; rows whose episode has ended return the first observation of the next one."""
        observation, reward, terminated, truncated, info = self.env.step(self._actions)
        dones = np.logical_or(terminated, truncated)
        self._returns += reward
        self._lengths += 1
        columns = results(info, self.num_envs)
        if self._price:
            reward = reward - self._price * columns["dt"]
        ends = rows_with_throw(info, self.num_envs)
        keys = [key for key in INFO_KEYS if key in columns]
        infos = [{key: columns[key][i].item() for key in keys} if ends[i] else {} for i in range(self.num_envs)]
        for i in np.flatnonzero(dones).tolist():
            timed_out = bool(truncated[i] and not terminated[i])
            seconds = round(time.perf_counter() - self._start, 6)
            share = info.get("final_info", {}).get(EPISODE_SUCCESS)
            infos[i].update(
                {
                    **({} if share is None else {EPISODE_SUCCESS: float(share[i])}),
                    "terminal_observation": _learnable(info["final_obs"][i]),
                    "TimeLimit.truncated": timed_out,
                    "episode": {"r": float(self._returns[i]), "l": int(self._lengths[i]), "t": seconds},
                }
            )
        self._returns[dones] = 0.0
        self._lengths[dones] = 0
        rows = rows_thrown(infos) if self._even else []
        if rows:  # rows without a throw get the mean reward of the throws
            evened = np.full_like(reward, np.mean(reward[rows]))
            evened[rows] = reward[rows]
            reward = evened
        return _learnable(observation), np.asarray(reward, dtype=np.float32), dones, infos

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """An attribute of the vector environment, once per row."""
        value = cast("Any", core_of(self.env)).masks if attr_name == MASKS else getattr(self.env, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the vector environment, for all rows at once."""
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
        """Call a method of the vector environment once; every row gets its result, but masks are per row."""
        if method_name == MASKS:
            masks = cast("Any", core_of(self.env)).masks()
            return [masks[row] for row in self._get_indices(indices)]
        result = getattr(self.env, method_name)(*method_args, **method_kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[Any], indices: VecEnvIndices = None) -> list[bool]:
        """False for every row, because this class keeps the episode statistics itself."""
        return [False for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """One image per row, None where the environment does not render."""
        images: Any = self.env.render() if self.render_mode == "rgb_array" else None
        return [None] * self.num_envs if images is None else list(images)

    def _clear(self) -> None:
        self._returns = np.zeros(self.num_envs)
        self._lengths = np.zeros(self.num_envs, dtype=np.int64)


def open_cells(env: str | Env, **options: Any) -> SameStepVecEnv:
    """A vector environment for stable-baselines3; `pnt_gym.sb3_vec_env` is this function.

    Args:
        env: an id, or a vector environment.
        options: of an id: level, num_envs, threads and action_mode.

    Raises:
        UsageError: there is no such environment or option, the environment has options already, or it is no vector
            environment in the autoreset mode SAME_STEP.
    """
    check_known("argument", options, environments.OPTIONS)
    if isinstance(env, str):
        return SameStepVecEnv(environments.make_vector(env, **options))
    if options:
        raise UsageError(f"{next(iter(options))} cannot change an environment that is made already; give it with an id")
    if not isinstance(env, VectorEnv):
        raise UsageError(f"env is {one_sentence(repr(env), 80)}; it must be an id or a vector environment")
    return SameStepVecEnv(env)
