"""Policy wrapper: stacks the last K observations of a shift, and adds the policy's action to a base controller's.

Training and evaluation use the same wrapper. The base controller needs no practice. With K = 1 over `analytic` the
wrapper changes nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, final

import numpy as np
from gymnasium.spaces import Box, Dict
from gymnasium.vector import VectorWrapper
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from pnt_gym.arrays import Bools
from pnt_gym.names import unknown_name

from ..ground.cli import UsageError
from ..ground.environments import Env
from ..learning.hyperparameters import MAX_STACK, RECURRENT
from ..policies.actor import Actor
from . import adaptive, named
from .adaptive import PRETRAINED, begins_shift
from .named import CHEATS, GRASPING_NAMES, POSTERIOR
from .protocol import Actions, Controller, Observation

PLANNER: Final = "analytic"
"""The controller whose action is zero."""
BASES: Final = (PLANNER, *PRETRAINED, POSTERIOR, *(name for name in GRASPING_NAMES if name not in CHEATS))
"""Base controllers: they need no practice, read no hidden values, and draw no random numbers."""

Stacked = NDArray[np.float32]


@final
class PolicyWrapper:
    """Stack of observations and base controller for N rows of an environment.

    Args:
        stack: number of observations that the policy sees at once, K.
        base: base controller, whose action the policy corrects.
    """

    def __init__(self, stack: int, base: Controller) -> None:
        self.stack, self._base_controller = stack, base
        self._base: Actions = np.zeros((0, 0), dtype=np.float32)
        self._recent: Stacked = np.zeros((0, stack, 0), dtype=np.float32)

    def begin(self, seed: int) -> None:
        """Forget all observations."""
        self._base_controller.reset(seed)
        self._recent = self._recent[:0]

    def stack_observation(self, observation: Observation) -> Stacked:
        """Stacked observations of coming throws (N, K * D), with pictures vectors and base actions (N, K * D + A).

        To be called once before each throw.

        The oldest observation comes first; zeros stand for observations before the shift.
        """
        self._base, features = self._base_controller.act(observation), observation.features
        if len(self._recent) != len(features):
            self._recent = np.zeros((len(features), self.stack, features.shape[1]), dtype=np.float32)
        self._recent[begins_shift(observation)] = 0.0
        self._recent = np.concatenate([self._recent[:, 1:], features[:, None]], axis=1)
        stacked = self._recent.reshape(len(features), -1)
        # A policy that sees pictures looks where the base controller would grasp, too.
        return stacked if observation.image is None else np.concatenate([stacked, self._base], axis=1)

    def peek(self, features: Stacked) -> Stacked:
        """Stacked observations after the last throw (N, K * D), without changing the stack."""
        return np.concatenate([self._recent[:, 1:], features[:, None]], axis=1).reshape(len(features), -1)

    def total_action(self, action: NDArray[Any]) -> Actions:
        """Actions (N, A) for the environment: the base controller's plus those of the policy."""
        return np.clip(self._base + action, -1.0, 1.0).astype(np.float32)


def make(env: Env, stack: int, over: str) -> PolicyWrapper:
    """Policy wrapper of an environment.

    Args:
        env: the environment.
        stack: number of observations that the policy sees at once.
        over: name of the base controller.

    Raises:
        UsageError: the stack or the base controller is invalid, or impossible in this environment.
    """
    if not 1 <= stack <= MAX_STACK:
        raise UsageError(f"stack is {stack}; a policy sees from 1 to {MAX_STACK} observations at once")
    if over not in BASES:
        raise UsageError(f"over: {unknown_name('controller that needs no practice', over, BASES)}")
    if stack > 1:
        adaptive.check(env, f"a stack of {stack} observations")
    return PolicyWrapper(stack, named.make(over, env))


def wrap(env: Env, arguments: Mapping[str, Any]) -> Env:
    """Environment as a policy sees it, wrapped by the `algo`, `stack` and `over` of a training.

    Raises:
        UsageError: as for `make`, or a recurrent policy whose observations do not mark the beginning of a
            shift.
    """
    if arguments["algo"] in RECURRENT:
        adaptive.check(env, f"algorithm {arguments['algo']!r}")
    if (arguments["stack"], arguments["over"]) == (1, PLANNER):
        return env
    return _WrappedEnv(env, make(env, arguments["stack"], arguments["over"]))


@final
class _WrappedEnv(VectorWrapper[Any, Any, Any, Any, Any]):
    """Vector environment with SAME_STEP autoreset and a policy wrapper; all rows are reset together."""

    def __init__(self, env: Env, wrapper: PolicyWrapper) -> None:
        super().__init__(env)
        self._wrapper = wrapper
        space: Any = env.single_observation_space
        self._sees_pictures = isinstance(space, Dict)
        if self._sees_pictures:
            action: Any = env.single_action_space
            entries = space["vector"]
            low, high = (np.append(*ends) for ends in ((entries.low, action.low), (entries.high, action.high)))
            self.single_observation_space = Dict({"image": space["image"], "vector": Box(low, high, dtype=np.float32)})
            self.observation_space = batch_space(self.single_observation_space, env.num_envs)
            return
        low, high = (np.tile(bound, wrapper.stack) for bound in (space.low, space.high))
        self.single_observation_space = Box(low, high, dtype=space.dtype)
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        features, info = self.env.reset(seed=seed, options=options)
        self._wrapper.begin(0)
        return self._stacked(features, info), info

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        features, reward, terminated, truncated, info = self.env.step(self._wrapper.total_action(actions))
        over = np.logical_or(terminated, truncated)
        if over.any():
            info = info | {"final_obs": self._final_observations(info["final_obs"], over)}
        return self._stacked(features, info), reward, terminated, truncated, info

    def _stacked(self, features: Any, info: Mapping[str, Any]) -> Any:
        kind = np.array(info.get("kind", np.zeros(self.num_envs)), dtype=np.int64)
        if self._sees_pictures:
            vector, image = np.array(features["vector"]), np.array(features["image"])
            return {"image": image, "vector": self._wrapper.stack_observation(Observation(vector, kind, image))}
        return self._wrapper.stack_observation(Observation(np.array(features, dtype=np.float32), kind))

    def _final_observations(self, last: Any, over: Bools) -> NDArray[Any]:
        """Stacked observations at the ends of episodes, None in the other rows (N,).

        Beside a picture, zeros stand for the base action, because no action follows.
        """
        if self._sees_pictures:
            nothing = np.zeros(self.single_action_space.shape or (), dtype=np.float32)
            ends = np.full(len(over), None, dtype=object)
            for row in np.flatnonzero(over):
                ends[row] = {**last[row], "vector": np.append(last[row]["vector"], nothing)}
            return ends
        width = self.env.single_observation_space.shape
        whole = np.stack([last[row] if ended else np.zeros(width or ()) for row, ended in enumerate(over)])
        observations, stacked = np.full(len(over), None, dtype=object), self._wrapper.peek(whole.astype(np.float32))
        for row in np.flatnonzero(over):
            observations[row] = stacked[row]
        return observations


@final
class MemoryPolicy(Controller):
    """Controller from a policy with a memory of the shift or with a base controller.

    Args:
        actor: the policy.
        name: name in tables.
        wrapper: wrapper between the environment and the policy.
    """

    def __init__(self, actor: Actor, name: str, wrapper: PolicyWrapper) -> None:
        self.name = name
        self._actor, self._wrapper = actor, wrapper
        self._memory = actor.initial_memory(0)

    def reset(self, seed: int) -> None:
        """Forget all observations and the policy's memory."""
        self._wrapper.begin(seed)
        self._memory = self._actor.initial_memory(0)

    def act(self, observation: Observation) -> Actions:
        """Sum of the base controller's action and the policy's, (N, A)."""
        fresh, memory = begins_shift(observation), self._memory
        if len(memory) != len(fresh):
            memory = self._actor.initial_memory(len(fresh))
        memory = np.where(fresh[:, None, None], 0.0, memory)
        stacked = self._wrapper.stack_observation(observation)
        if self._actor.eye is not None:
            return self._wrapper.total_action(self._actor(stacked, observation.image))
        action, self._memory = self._actor.act_with_memory(stacked, memory)
        return self._wrapper.total_action(action)
