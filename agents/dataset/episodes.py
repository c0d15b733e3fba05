"""Whole episodes of a controller, each with the seed that reproduces the episode in the single environment."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, count
from typing import Any, Final, TypeAlias, final

import gymnasium as gym
import numpy as np
from gymnasium.vector.utils import concatenate, create_empty_array, iterate
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.core import EPISODE_SUCCESS

from ..controllers.protocol import Controller
from ..ground.environments import Env, Role, cores_of
from ..judging.loop import observed
from ..judging.throws import results

LEAST_SEED: Final = 2**31
"""Least seed of an episode. `stream_seed` returns smaller seeds, so no training, practice or evaluation has this
one."""
MOST_SEED: Final = 2**53
"""Upper bound of the seeds; file formats with 64-bit floats hold smaller integers exactly."""
FIGURES: Final = ("shift_", EPISODE_SUCCESS)
"""Beginnings of the info keys that hold figures of a whole work shift or episode, at its end."""

Rows: TypeAlias = Mapping[str, NDArray[Any]]
"""Arrays of N rows by name, (N, ...) each."""


@final
@dataclass(frozen=True)
class Episode:
    """The T throws between `reset(seed=seed)` of the single environment and the end."""

    seed: int
    observations: Any
    """Observations (T + 1, ...), or a mapping of arrays where the space is a Dict."""
    actions: NDArray[Any]
    """Actions as the environment received them (T, ...)."""
    rewards: Floats
    """Rewards (T,)."""
    terminated: bool
    """Whether the last throw terminated the episode; otherwise the episode was truncated."""
    info: Mapping[str, NDArray[Any]]
    """Values of the environment's info by key (T + 1,): entry k + 1 belongs to throw k, and entry 0, before the first
    throw, is NaN. Values that a reset returns as well, such as `kind`, belong to the coming throw in every entry;
    arrays of several numbers have shape (T + 1, ...) and their own type."""
    hidden: Mapping[str, Floats]
    """Hidden quantities of the throws, which no observation contains, by name (T,)."""
    figures: Mapping[str, Any] = field(default_factory=dict)
    """Figures of the whole episode, numbers or lists of numbers, from the info at its end."""

    def __len__(self) -> int:
        return len(self.rewards)


def episode_seeds(role: Role, seed: int, chunk: int) -> Iterator[int]:
    """Endless seeds of the episodes in a chunk; equal arguments give equal seeds."""
    draws = np.random.default_rng([seed, zlib.crc32(role.encode()), chunk])
    while True:
        yield int(draws.integers(LEAST_SEED, MOST_SEED))


@final
@dataclass(frozen=True)
class Noise:
    """Normal noise on continuous actions, as a behaviour policy that explores."""

    deviation: float
    """Standard deviation, in units of an action."""
    generator: np.random.Generator


def episodes(
    controller: Controller, env: Env, throws: int, seeds: Iterator[int], noise: Noise | None = None
) -> Iterator[Episode]:
    """Let a controller throw whole episodes, and yield them in the order of their seeds.

    Args:
        controller: acts as it is, without practice.
        env: a vector environment with SAME_STEP autoreset; a row takes the next seed when its episode ends.
        throws: number of throws of all episodes together; the last episode is completed.
        seeds: seeds of the episodes.
        noise: noise on the controller's actions; None for none.
    """
    throws_done = following = 0
    finished: dict[int, Episode] = {}
    for number, ended in _play(controller, env, seeds, noise):
        finished[number] = ended
        while following in finished:
            episode = finished.pop(following)
            yield episode
            following, throws_done = following + 1, throws_done + len(episode)
            if throws_done >= throws:
                return


@final
@dataclass
class _OpenEpisode:
    """An episode that has not ended, with its steps so far."""

    number: int
    seed: int
    observations: list[Any] = field(default_factory=list)
    actions: list[Any] = field(default_factory=list)
    rewards: list[float] = field(default_factory=list)
    infos: list[Mapping[str, Any]] = field(default_factory=list)
    hidden: list[Mapping[str, Any]] = field(default_factory=list)

    def close(self, space: gym.Space[Any], terminated: bool, figures: Mapping[str, Any]) -> Episode:
        """The finished episode, with its steps as arrays."""
        return Episode(
            seed=self.seed,
            observations=concatenate(space, self.observations, create_empty_array(space, len(self.observations))),
            actions=np.stack(self.actions),
            rewards=np.array(self.rewards, dtype=np.float64),
            terminated=terminated,
            info=_columns(self.infos, names=chain.from_iterable(self.infos[1:])),
            hidden=_columns(self.hidden, names=self.hidden[0]),
            figures=figures,
        )


def _play(controller: Controller, env: Env, seeds: Iterator[int], noise: Noise | None) -> Iterator[tuple[int, Episode]]:
    """Endless episodes as they end, each with its index among the seeds."""
    begun = zip(count(), seeds, strict=False)
    cores, over = cores_of(env), np.ones(env.num_envs, dtype=np.bool_)
    rows = [_OpenEpisode(*next(begun)) for _ in range(env.num_envs)]
    observations, coming = _begin(env, rows, over, {})
    while True:
        kind = coming.get("kind", np.zeros(env.num_envs))
        chosen, space = controller.act(observed(observations, kind)), env.single_action_space
        if noise is not None:
            chosen = np.asarray(chosen) + noise.deviation * noise.generator.standard_normal(np.shape(chosen))
        # The episode keeps actions as the environment receives actions: of the space's type, and clipped to the space.
        action = np.asarray(chosen, dtype=space.dtype)
        action = np.clip(action, space.low, space.high) if isinstance(space, gym.spaces.Box) else action
        # A core of the user's may hide nothing.
        parts = [getattr(core, "hidden", dict)() for core in cores]
        hidden = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        observations, reward, terminated, truncated, info = env.step(action)
        over, infos = terminated | truncated, _throw_infos(info, coming, env.num_envs)
        last = list(iterate(env.observation_space, observations))
        for row in np.flatnonzero(info.get("_final_obs", ())).tolist():  # where an episode has ended
            last[row] = _row(info["final_obs"], row)
        for row, episode in enumerate(rows):
            episode.observations.append(last[row])
            episode.actions.append(action[row])
            episode.rewards.append(float(reward[row]))
            episode.infos.append(_row(infos, row))
            episode.hidden.append(_row(hidden, row))
        for row in np.flatnonzero(over):
            figures = _figures(info, int(row), env.num_envs)
            yield rows[row].number, rows[row].close(env.single_observation_space, bool(terminated[row]), figures)
            rows[row] = _OpenEpisode(*next(begun))
        coming = {name: infos[name] for name in coming if name in infos}
        if over.any():
            observations, coming = _begin(env, rows, over, coming)


def _begin(env: Env, rows: Sequence[_OpenEpisode], chosen: Bools, before: Rows) -> tuple[Any, Rows]:
    """Begin the episodes of some rows; observations of all rows, and info values of their coming throws."""
    seeds = [episode.seed if new else None for episode, new in zip(rows, chosen, strict=True)]
    observations, info = env.reset(seed=seeds, options={"reset_mask": chosen})  # pyright: ignore[reportArgumentType]
    coming = {name: _select(chosen, values, before.get(name, values)) for name, values in _numbers(info, rows).items()}
    for row, observation in enumerate(iterate(env.observation_space, observations)):
        if chosen[row]:
            rows[row].observations.append(observation)
            rows[row].infos.append(_row(coming, row))
    return observations, coming


def _numbers(info: Mapping[str, Any], rows: Sequence[Any]) -> Rows:
    """Numeric arrays of a vector info that have a value for every row, (N, ...) each."""
    arrays = {name: np.asarray(values) for name, values in info.items() if not name.startswith("_")}
    numeric = {name: values for name, values in arrays.items() if values.dtype.kind in "biuf"}
    return {name: values for name, values in numeric.items() if values.shape[:1] == (len(rows),)}


def _throw_infos(info: Mapping[str, Any], coming: Rows, rows: int) -> Rows:
    """Info values of the throws of one step, and info values of the coming throws.

    Args:
        info: info of the step.
        coming: earlier info values of these throws; at the end of an episode `final_info` replaces the values of the
            next one.
        rows: number of rows N.
    """
    over, final = np.asarray(info.get("_final_info", np.zeros(rows, dtype=np.bool_))), info.get("final_info", {})
    infos: dict[str, NDArray[Any]] = {}
    for name, values in results(info, rows).items():
        if name not in coming and not name.startswith(FIGURES):
            infos[name] = np.where(_info_mask(info, name, rows), values.astype(np.float64), np.nan)
    for name in coming:
        if name in info:
            infos[name] = _select(over, np.asarray(final.get(name, info[name])), np.asarray(info[name]))
    return infos


def _figures(info: Mapping[str, Any], row: int, rows: int) -> dict[str, Any]:
    """Figures of the whole episode that has ended in one of N rows, from the vector info, as plain values."""
    final: Mapping[str, Any] = info.get("final_info", {})
    names = [name for name in final if name.startswith(FIGURES) and _info_mask(info, name, rows)[row]]
    return {name: np.asarray(final[name][row]).tolist() for name in names}


def _info_mask(info: Mapping[str, Any], name: str, rows: int) -> Bools:
    """Mask of the rows that have a value in a vector info (N,); from `final_info` where an episode has ended."""
    masks = [np.asarray(part.get(f"_{name}", name in part)) for part in (info.get("final_info", {}), info)]
    return np.where(np.asarray(info.get("_final_info", np.zeros(rows, dtype=np.bool_))), *masks)


def _select(mask: Bools, values: NDArray[Any], alternatives: NDArray[Any]) -> NDArray[Any]:
    """Values (N, ...) in the rows of a mask, and other values elsewhere."""
    return np.where(mask.reshape(-1, *[1] * (values.ndim - 1)), values, alternatives)


def _row(values: Any, row: int) -> Any:
    return {name: _row(part, row) for name, part in values.items()} if isinstance(values, Mapping) else values[row]


def _columns(steps: Sequence[Mapping[str, Any]], names: Iterable[str]) -> dict[str, NDArray[Any]]:
    """Values of T steps by name: numbers as float64 (T,), NaN where a step has none, or arrays (T, ...)."""
    columns = {name: np.stack([step.get(name, np.nan) for step in steps]) for name in dict.fromkeys(names)}
    return {name: values.astype(np.float64) if values.ndim == 1 else values for name, values in columns.items()}
