"""Whole episodes of a controller, each with the seed that gives it again in the single environment."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import Any, Final, final

import gymnasium as gym
import numpy as np
from gymnasium.vector.utils import concatenate, create_empty_array, iterate
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats

from .controllers.protocol import Controller
from .environments import Env, Role, cores_of
from .evaluation import observed
from .throws import results

LEAST_SEED: Final = 2**31
"""`stream_seed` gives smaller ones, so no episode here begins as one of a training, practice or evaluation."""
MOST_SEED: Final = 2**53
"""Below it, any file format holds whole numbers exactly."""


@final
@dataclass(frozen=True)
class Episode:
    """The T throws between `reset(seed=seed)` of the single environment and the end."""

    seed: int
    observations: Any
    """(T + 1, ...), or a mapping of such where the space has parts."""
    actions: NDArray[Any]
    """As they were given to the environment (T, ...)."""
    rewards: Floats
    """(T,)"""
    terminated: bool
    """Its last throw ended it; if not, it was cut there."""
    told: Mapping[str, Floats]
    """What the environment tells, by the keys of its info (T + 1,): entry k + 1 is of throw k. In entry 0, before the
    first throw, all is NaN but `kind`, which is of the coming throw everywhere."""
    hidden: Mapping[str, Floats]
    """What no observation tells of the throws, by name (T,)."""

    def __len__(self) -> int:
        return len(self.rewards)


def episode_seeds(role: Role, seed: int, chunk: int) -> Iterator[int]:
    """Endless seeds of the episodes in a chunk: the same for the same arguments."""
    draws = np.random.default_rng([seed, zlib.crc32(role.encode()), chunk])
    while True:
        yield int(draws.integers(LEAST_SEED, MOST_SEED))


def episodes(controller: Controller, env: Env, throws: int, seeds: Iterator[int]) -> Iterator[Episode]:
    """Let a controller throw whole episodes, and yield them in the order of their seeds.

    Args:
        controller: as it is.
        env: a vector environment with SAME_STEP autoreset; a row takes the next seed when its episode is over.
        throws: of the episodes together; the last one may hold more.
        seeds: of the episodes.
    """
    done = following = 0
    finished: dict[int, Episode] = {}
    for number, found in _played(controller, env, seeds):
        finished[number] = found
        while following in finished:
            episode = finished.pop(following)
            yield episode
            following, done = following + 1, done + len(episode)
            if done >= throws:
                return


@final
@dataclass
class _Open:
    """An episode that is going on."""

    number: int
    seed: int
    observations: list[Any] = field(default_factory=list)
    actions: list[Any] = field(default_factory=list)
    rewards: list[float] = field(default_factory=list)
    told: list[Mapping[str, float]] = field(default_factory=list)
    hidden: list[Mapping[str, float]] = field(default_factory=list)

    def closed(self, space: gym.Space[Any], terminated: bool) -> Episode:
        """The episode, now that it is over."""
        before = dict.fromkeys(self.told[1], np.nan) | self.told[0]
        return Episode(
            seed=self.seed,
            observations=concatenate(space, self.observations, create_empty_array(space, len(self.observations))),
            actions=np.stack(self.actions),
            rewards=np.array(self.rewards, dtype=np.float64),
            terminated=terminated,
            told=_columns([before, *self.told[1:]]),
            hidden=_columns(self.hidden),
        )


def _played(controller: Controller, env: Env, seeds: Iterator[int]) -> Iterator[tuple[int, Episode]]:
    """Endless episodes as they end, each with its place among the seeds."""
    begun = zip(count(), seeds, strict=False)
    cores, over = cores_of(env), np.ones(env.num_envs, dtype=np.bool_)
    rows = [_Open(*next(begun)) for _ in range(env.num_envs)]
    seen, kind = _begin(env, rows, over, np.zeros(env.num_envs))
    while True:
        action = _given(env.single_action_space, controller.act(observed(seen, kind)))
        hidden = _by_row([core.hidden() for core in cores])
        seen, reward, terminated, truncated, info = env.step(action)
        over, told, last = terminated | truncated, _by_row([_told(info, env.num_envs)]), _last(env, seen, info)
        for row, episode in enumerate(rows):
            episode.observations.append(last[row])
            episode.actions.append(action[row])
            episode.rewards.append(float(reward[row]))
            episode.told.append(told[row])
            episode.hidden.append(hidden[row])
        for row in np.flatnonzero(over):
            yield rows[row].number, rows[row].closed(env.single_observation_space, bool(terminated[row]))
            rows[row] = _Open(*next(begun))
        kind = np.array([one["kind"] for one in told])
        if over.any():
            seen, kind = _begin(env, rows, over, kind)


def _begin(env: Env, rows: Sequence[_Open], chosen: Bools, kind: Floats) -> tuple[Any, Floats]:
    """Begin the episodes of some rows; what is then seen in all rows, and of which kind (N,) the coming throws are."""
    seeds = [episode.seed if new else None for episode, new in zip(rows, chosen, strict=True)]
    seen, info = env.reset(seed=seeds, options={"reset_mask": chosen})  # pyright: ignore[reportArgumentType]
    kind = np.where(chosen, info.get("kind", 0), kind)
    for row, one in enumerate(iterate(env.observation_space, seen)):
        if chosen[row]:
            rows[row].observations.append(one)
            rows[row].told.append({"kind": float(kind[row])})
    return seen, kind


def _given(space: gym.Space[Any], actions: Any) -> NDArray[Any]:
    """Actions as they are given and kept: members of the space, which environments clip to anyway."""
    given = np.asarray(actions, dtype=space.dtype)
    return np.clip(given, space.low, space.high) if isinstance(space, gym.spaces.Box) else given


def _told(info: Mapping[str, Any], rows: int) -> dict[str, NDArray[Any]]:
    """What a step of a vector environment tells of its throws, and the kind of the throws that come after them."""
    final = info.get("final_info", {})
    over = np.asarray(info.get("_final_info", np.zeros(rows, dtype=np.bool_)))
    kind = info.get("kind", np.zeros(rows))
    return {**results(info, rows), "kind": np.where(over, final.get("kind", kind), kind)}


def _last(env: Env, seen: Any, info: Mapping[str, Any]) -> list[Any]:
    """The observation after the throw of each row, be it the last one of an episode or not."""
    found = list(iterate(env.observation_space, seen))
    for row in np.flatnonzero(info.get("_final_obs", ())):
        found[row] = _row(info["final_obs"], row)
    return found


def _row(values: Any, row: int) -> Any:
    return {name: _row(part, row) for name, part in values.items()} if isinstance(values, Mapping) else values[row]


def _by_row(parts: Sequence[Mapping[str, NDArray[Any]]]) -> list[dict[str, float]]:
    """One mapping per row from one of arrays, or several that follow each other."""
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    rows = sum(len(next(iter(part.values()), ())) for part in parts)
    return [{name: float(values[row]) for name, values in whole.items()} for row in range(rows)]


def _columns(rows: Sequence[Mapping[str, float]]) -> dict[str, Floats]:
    return {name: np.array([row[name] for row in rows], dtype=np.float64) for name in rows[0]}
