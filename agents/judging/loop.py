"""The loop of evaluation and practice: controllers act and learn, batch of throws by batch of throws."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeAlias

import numpy as np

from pnt_gym.arrays import concatenate_records, take

from ..controllers.protocol import Controller, Learner, Observation, Outcome, learns
from ..ground.environments import Env, core_of, stream_seed
from .throws.data import Throws

Progress: TypeAlias = Callable[[int], object]
"""Called with the number of throws, or other units, just done."""


def throw_held_out(
    controller: Controller,
    env: Env,
    picks: int,
    seed: int,
    *,
    online: bool = False,
    progress: Progress | None = None,
) -> Throws:
    """Let a controller, without practice, throw `picks` held-out objects; the arguments are those of `Trial.run`."""
    return _collect(throw_batches(controller, env, picks, stream_seed("evaluate", seed), learn=online), progress)


def practise(
    controller: Controller, env: Env, throws: int, seed: int, *, start: int = 0, progress: Progress | None = None
) -> None:
    """Let a learning controller practise on `throws` throws; for other controllers or 0 throws nothing happens.

    The throws depend on the seed and on the number of rows of `env`. The controller has already practised on `start`
    throws with this seed, so the practice continues with other throws.
    """
    if not learns(controller) or throws == 0:
        return
    if isinstance(controller, Learner):
        controller.begin_practice(throws)
    _collect(throw_batches(controller, env, throws, stream_seed("practice", seed, start), learn=True), progress)
    if isinstance(controller, Learner):
        controller.end_practice()


def throw_batches(
    controller: Controller, env: Env, picks: int, env_seed: int, *, learn: bool = False
) -> Iterator[Throws]:
    """Carry out throws and yield batch after batch; the last batch is cut so that `picks` throws are yielded in all."""
    correction = core_of(env).correction
    errors = () if correction is None else correction.error_keys
    features, info = env.reset(seed=env_seed)
    throws_done = 0
    while throws_done < picks:
        observation = observed(features, info.get("kind", np.zeros(env.num_envs)))
        action = controller.act(observation)
        features, reward, _, _, info = env.step(action)
        part = take(Throws.of(info, np.asarray(reward), errors), slice(picks - throws_done))
        if learn:
            count = len(part)  # the last batch may hold more rows than were asked for
            observation = take(observation, slice(count))
            outcome_fields = (part.error, part.is_success, part.cycle_time, part.clipped)
            controller.learn(Outcome(observation, action[:count], *outcome_fields))
        throws_done += len(part)
        yield part


def observed(features: Any, kind: Any) -> Observation:
    """Coming picks as a controller's observation, from an environment's observations and the `kind` of its info."""
    return Observation(np.array(features, dtype=np.float32), np.array(kind, dtype=np.int64))


def _collect(batches: Iterable[Throws], progress: Progress | None) -> Throws:
    parts: list[Throws] = []
    for part in batches:
        parts.append(part)
        if progress is not None:
            progress(len(part))
    return concatenate_records(parts)
