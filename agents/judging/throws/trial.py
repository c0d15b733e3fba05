"""Trials by throws: a controller corrects single throws, and held-out throws are counted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import joined, take

from ...controllers.adaptive import READY, is_told
from ...controllers.protocol import Controller, Learner, Observation, Outcome
from ...ground.cli import UsageError
from ...ground.environments import Env, core_of, stream_seed
from ...ground.places import ADAPTIVE
from ...jobs.code import code_digest
from ..card import Card
from ..trial import PRACTICE, Progress, Trial
from .card import CARD
from .data import Throws
from .record import ThrowRecord

ENDLESS: Final = 10**9
"""Throws."""
LOOKS: Final = 15
"""Throws that the oracle simulates for each that it carries out."""


@final
class ThrowTrial(Trial):
    """Throws of cells in which an action corrects one throw."""

    unit = "throws"
    options = Trial.options | {"picks_on", "floors", "also"}
    record = ThrowRecord

    def run(
        self,
        controller: Controller,
        count: int,
        seed: int,
        *,
        online: bool = False,
        progress: Progress | None = None,
    ) -> ThrowRecord:
        """Let a controller, as it is, throw `count` held-out objects."""
        throws = held_out(controller, self.env, count, seed, online=online, progress=progress)
        return ThrowRecord(throws, self.core, {"online": online, "num_envs": self.env.num_envs})

    def count(self) -> int:
        """200 throws, or whole episodes of every row where one throw teaches the next: only those are judged fairly."""
        return self.env.num_envs * self.core.cell.episode if is_told(self.core) else self.usual

    def practise(
        self, controller: Controller, steps: int, seed: int, *, progress: Progress | None = None
    ) -> Controller:
        """Let a controller that learns throw `steps` objects first."""
        practise(controller, self.env, steps, seed, progress=progress)
        return controller

    def peers(self, asked: Mapping[str, Any]) -> dict[str, int]:
        """The planner, a virtual goal where actions shift what a throw is judged by, and what the policy corrects."""
        learning = {} if self.core.correction is None else {"virtual_goal": PRACTICE}
        return {"analytic": 0, **learning, asked["over"]: 0}

    def steps(self, controller: Controller, seed: int) -> Iterator[Throws]:
        """Throws of one cell, one after the other."""
        return thrown(controller, self.env, ENDLESS, stream_seed("evaluate", seed))

    def check_count(self, count: int, num_envs: int, level: str) -> None:
        """Make sure that throws which depend on those before are measured in whole episodes."""
        if not is_told(self.core):
            return
        together = num_envs * self.core.cell.episode
        if count % together > 0:
            raise UsageError(
                f"picks is {count}; with num_envs {num_envs} and shifts of {self.core.cell.episode} picks on level "
                f"{level!r} it must be a multiple of {together}"
            )

    @classmethod
    def card(cls) -> Card:
        """Landing error, success and pace of throws."""
        return CARD

    @classmethod
    def depends(cls, name: str, levels: Sequence[Any], options: Mapping[str, Any], throws: Sequence[int]) -> Any:
        """What ships for those that adapt: it is known beforehand unless the controller itself learns it."""
        del levels, options
        return code_digest(("*.npz",), root=ADAPTIVE) if max(throws) == 0 and name in (*READY, "oracle_drift") else ""

    @classmethod
    def effort(cls, name: str, config: Any, count: int, num_envs: int) -> int:
        """Throws; the oracle simulates each several times."""
        del config, num_envs
        return (LOOKS if name == "oracle" else 1) * count


def held_out(
    controller: Controller,
    env: Env,
    picks: int,
    seed: int,
    *,
    online: bool = False,
    progress: Progress | None = None,
) -> Throws:
    """Let a controller, as it is, throw `picks` held-out objects; the arguments are those of `Trial.run`."""
    return _collect(thrown(controller, env, picks, stream_seed("evaluate", seed), learn=online), progress)


def practise(
    controller: Controller, env: Env, throws: int, seed: int, *, start: int = 0, progress: Progress | None = None
) -> None:
    """Let a controller that learns throw `throws` objects first; others, and 0 throws, do nothing.

    The number of rows of `env` is part of what the seed means. `start` throws with this seed are already behind the
    controller, so that others follow.
    """
    if not isinstance(controller, Learner) or throws == 0:
        return
    controller.begin_practice(throws)
    _collect(thrown(controller, env, throws, stream_seed("practice", seed, start), learn=True), progress)
    controller.end_practice()


def thrown(controller: Controller, env: Env, picks: int, env_seed: int, *, learn: bool = False) -> Iterator[Throws]:
    """Carry out throws and yield each batch of them; the last batch is cut to `picks` in all."""
    correction = core_of(env).correction
    errors = () if correction is None else correction.told
    features, info = env.reset(seed=env_seed)
    done = 0
    while done < picks:
        seen = observed(features, info.get("kind", np.zeros(env.num_envs)))
        action = controller.act(seen)
        features, reward, _, _, info = env.step(action)
        part = take(Throws.of(info, np.asarray(reward), errors), slice(picks - done))
        if learn:
            count = len(part)  # the last batch may hold more rows than were asked for
            seen = take(seen, slice(count))
            told = (part.error, part.is_success, part.cycle_time, part.clipped)
            controller.learn(Outcome(seen, action[:count], *told))
        done += len(part)
        yield part


def observed(features: Any, kind: Any) -> Observation:
    """Coming picks as a controller sees them, from what an environment returned and the `kind` of its info."""
    return Observation(np.array(features, dtype=np.float32), np.array(kind, dtype=np.int64))


def _collect(batches: Iterable[Throws], progress: Progress | None) -> Throws:
    parts: list[Throws] = []
    for part in batches:
        parts.append(part)
        if progress is not None:
            progress(len(part))
    return joined(parts)
