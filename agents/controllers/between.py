"""Policy wrapper: stacks the last K observations of a shift, and adds the policy's action to a base controller's.

Training and evaluation use the same wrapper. The base controller needs no practice. With K = 1 over `analytic` the
wrapper changes nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, final

import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import VectorWrapper
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from pnt_gym.arrays import Bools

from ..ground.cli import UsageError
from ..ground.environments import Env
from ..learning.algorithms import RECURRENT
from ..policies.actor import Actor
from .adaptive import READY, begins, check_begins
from .named import named_controller
from .protocol import Actions, Controller, Observation

PLANNER: Final = "analytic"
"""The controller whose action is zero."""
OVER: Final = (PLANNER, "analytic_height", "mean_lead", *READY)
"""Base controllers: they need no practice, read no hidden values, and draw no random numbers."""
MOST: Final = 100
"""Observations in a stack at most."""

Seen = NDArray[np.float32]


@final
class Between:
    """Stack of observations and base controller for N rows of an environment.

    Args:
        stack: number of observations that the policy sees at once, K.
        under: base controller, whose action the policy corrects.
    """

    def __init__(self, stack: int, under: Controller) -> None:
        self.stack, self._under = stack, under
        self._base: Actions = np.zeros((0, 0), dtype=np.float32)
        self._recent: Seen = np.zeros((0, stack, 0), dtype=np.float32)

    def begin(self, seed: int) -> None:
        """Forget all observations."""
        self._under.reset(seed)
        self._recent = self._recent[:0]

    def seen(self, observation: Observation) -> Seen:
        """Stacked observations of coming throws (N, K * D); to be called once before each throw.

        The oldest observation comes first; zeros stand for observations before the shift.
        """
        self._base, features = self._under.act(observation), observation.features
        if len(self._recent) != len(features):
            self._recent = np.zeros((len(features), self.stack, features.shape[1]), dtype=np.float32)
        self._recent[begins(observation)] = 0.0
        self._recent = self._after(features)
        return self._recent.reshape(len(features), -1)

    def last(self, features: Seen) -> Seen:
        """Stacked observations after the last throw (N, K * D), without changing the stack."""
        return self._after(features).reshape(len(features), -1)

    def whole(self, given: NDArray[Any]) -> Actions:
        """Actions (N, A) for the environment: the base controller's plus those of the policy."""
        return np.clip(self._base + given, -1.0, 1.0).astype(np.float32)

    def _after(self, features: Seen) -> Seen:
        return np.concatenate([self._recent[:, 1:], features[:, None]], axis=1)


def between(env: Env, stack: int, over: str) -> Between:
    """Policy wrapper of an environment.

    Args:
        env: the environment.
        stack: number of observations that the policy sees at once.
        over: name of the base controller.

    Raises:
        UsageError: the stack or the base controller is invalid, or impossible in this environment.
    """
    if not 1 <= stack <= MOST:
        raise UsageError(f"stack is {stack}; a policy sees from 1 to {MOST} observations at once")
    if over not in OVER:
        raise UsageError(f"over is {over!r}; it must be a controller that needs no practice: {', '.join(OVER)}")
    if stack > 1:
        check_begins(env, f"a stack of {stack} observations")
    return Between(stack, named_controller(over, env))


def as_seen(env: Env, asked: Mapping[str, Any]) -> Env:
    """Environment as a policy sees it, wrapped by the `algo`, `stack` and `over` of a training.

    Raises:
        UsageError: as for `make_wrapper`, or a recurrent policy whose observations do not mark the begin of a
            shift.
    """
    if asked["algo"] in RECURRENT:
        check_begins(env, f"algorithm {asked['algo']!r}")
    if (asked["stack"], asked["over"]) == (1, PLANNER):
        return env
    return _Seen(env, between(env, asked["stack"], asked["over"]))


@final
class _Seen(VectorWrapper[Any, Any, Any, Any, Any]):
    """Vector environment with SAME_STEP autoreset and a policy wrapper; all rows are reset together."""

    def __init__(self, env: Env, through: Between) -> None:
        super().__init__(env)
        self._through = through
        space: Any = env.single_observation_space
        low, high = (np.tile(bound, through.stack) for bound in (space.low, space.high))
        self.single_observation_space = Box(low, high, dtype=space.dtype)
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)

    def reset(self, *, seed: Any = None, options: dict[str, Any] | None = None) -> tuple[Seen, dict[str, Any]]:
        features, info = self.env.reset(seed=seed, options=options)
        self._through.begin(0)
        return self._seen(features, info), info

    def step(self, actions: Any) -> tuple[Seen, Any, Any, Any, dict[str, Any]]:
        features, reward, terminated, truncated, info = self.env.step(self._through.whole(actions))
        over = np.logical_or(terminated, truncated)
        if over.any():
            info = info | {"final_obs": self._ends(info["final_obs"], over)}
        return self._seen(features, info), reward, terminated, truncated, info

    def _seen(self, features: Any, info: Mapping[str, Any]) -> Seen:
        kind = np.array(info.get("kind", np.zeros(self.num_envs)), dtype=np.int64)
        return self._through.seen(Observation(np.array(features, dtype=np.float32), kind))

    def _ends(self, last: Any, over: Bools) -> NDArray[Any]:
        """Stacked observations at the ends of episodes, None in the other rows (N,)."""
        width = self.env.single_observation_space.shape
        whole = np.stack([last[row] if ended else np.zeros(width or ()) for row, ended in enumerate(over)])
        found, stacked = np.full(len(over), None, dtype=object), self._through.last(whole.astype(np.float32))
        for row in np.flatnonzero(over):
            found[row] = stacked[row]
        return found


@final
class Remembering(Controller):
    """Controller from a policy with a memory of the shift or with a base controller.

    Args:
        actor: the policy.
        name: name in tables.
        through: wrapper between the environment and the policy.
    """

    def __init__(self, actor: Actor, name: str, through: Between) -> None:
        self.name = name
        self._actor, self._through = actor, through
        self._memory = actor.blank(0)

    def reset(self, seed: int) -> None:
        """Forget all observations and the policy's memory."""
        self._through.begin(seed)
        self._memory = self._actor.blank(0)

    def act(self, observation: Observation) -> Actions:
        """Sum of the base controller's action and the policy's, (N, A)."""
        fresh, memory = begins(observation), self._memory
        if len(memory) != len(fresh):
            memory = self._actor.blank(len(fresh))
        memory = np.where(fresh[:, None, None], 0.0, memory)
        given, self._memory = self._actor.after(self._through.seen(observation), memory)
        return self._through.whole(given)
