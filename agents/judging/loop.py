"""The loop of evaluation and practice: controllers act and learn, batch of throws by batch of throws."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Bools, concatenate_records, take

from ..controllers.protocol import Controller, Learner, Observation, Outcome, learns
from ..ground.environments import Env, core_of, stream_seed
from ..ground.fitting import on_one_thread
from ..ground.infos import rows_thrown
from .throws import Throws

Progress: TypeAlias = Callable[[int], object]
"""Called with the number of throws, or other units, just done."""


@on_one_thread
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


@on_one_thread
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
    """Carry out throws and yield batch after batch; the last batch is cut so that `picks` throws are yielded in all.

    A batch has one throw of every row. Where a throw takes several steps, rows that are ahead wait for the others to be
    yielded, so the throws of two controllers are paired.
    """
    correction = core_of(env).correction
    errors = () if correction is None else correction.error_keys
    features, info = env.reset(seed=env_seed)
    throws_done, queue = 0, _Queue(env.num_envs)
    while throws_done < picks:
        observation = observed(features, info.get("kind", np.zeros(env.num_envs)))
        action = controller.act(observation)
        features, reward, _, _, info = env.step(action)
        thrown = rows_thrown(info, env.num_envs)
        if not thrown.any():
            continue
        throws = Throws.of(info, np.asarray(reward), errors)
        if learn:
            count = min(env.num_envs, picks - throws_done) if thrown.all() else env.num_envs
            taught = np.flatnonzero(thrown[:count])
            seen = take(throws, taught)
            fields = (seen.error, seen.is_success, seen.cycle_time, seen.clipped, seen.reward)
            controller.learn(Outcome(take(observation, taught), action[taught], *fields))
        for batch in queue.add(throws, thrown):
            part = take(batch, slice(picks - throws_done))
            throws_done += len(part)
            if len(part):
                yield part


def observed(features: Any, kind: Any) -> Observation:
    """Coming picks as a controller's observation, from an environment's observations and the `kind` of its info."""
    kinds = np.array(kind, dtype=np.int64)
    if isinstance(features, Mapping):
        vector, image = features["vector"], np.array(features["image"], dtype=np.uint8)
        last = np.array(features["last"], dtype=np.float32) if "last" in features else None
        return Observation(np.array(vector, dtype=np.float32), kinds, image, last)
    return Observation(np.array(features, dtype=np.float32), kinds)


@final
class _Queue:
    """Throws of N rows that wait until every row has one."""

    def __init__(self, count: int) -> None:
        self._waiting = [deque[Throws]() for _ in range(count)]

    def add(self, throws: Throws, thrown: Bools) -> Iterator[Throws]:
        """Add the throws of some rows (N,); yields batches with one throw of every row."""
        if thrown.all() and not any(self._waiting):
            yield throws
            return
        for row in np.flatnonzero(thrown):
            self._waiting[row].append(take(throws, [row]))
        while all(self._waiting):
            yield concatenate_records([queue.popleft() for queue in self._waiting])


def _collect(batches: Iterable[Throws], progress: Progress | None) -> Throws:
    parts: list[Throws] = []
    for part in batches:
        parts.append(part)
        if progress is not None:
            progress(len(part))
    return concatenate_records(parts)
