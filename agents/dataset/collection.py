"""Throws of a controller in chunks: each chunk is an independent job, done by any process in any order."""

from __future__ import annotations

import hashlib
import io
import json
import re
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.reading import MOST_NUMBERS, arrays_of, bytes_of, parsed_json

from ..controllers.protocol import Controller, Learner, State
from ..ground import parcel
from ..ground.environments import Env, Role, make_vector, stream_seed
from ..ground.files import check_form
from ..ground.shipped import module_of
from ..ground.versions import code_digest
from ..ground.work import Job, key
from ..judging import trials
from .episodes import Episode, Noise, episode_seeds, episodes

CHUNK: Final = 512
"""Approximate number of throws of a job: a job takes seconds, because it is repeated when its machine dies."""
MOST_CHUNK: Final = 2**31
"""Largest size of the arrays of a job [bytes]."""
PARTS: Final = re.compile(r"\w+(?:/[\w .:-]+)*")
"""Names of the arrays of a job."""
_INFO: Final = "told"
"""Name of the info in the archives of a job; archives of stopped collections have it too."""
_CODE: Final = (
    "pnt_gym/**/*.py",
    "pnt_gym/**/*.yaml",
    "pnt_gym/**/*.json",
    "configs/cells/**/*.yaml",
    "configs/cells/**/*.json",
    "configs/line_rules.yaml",
    "agents/controllers/*.py",
    "agents/dispatchers/*.py",
)
"""Code on which throws depend and which is loaded by a name, and the levels, tables and settings that the code
reads."""


@final
@dataclass(frozen=True)
class ControllerRecipe:
    """A controller as data, from which any machine can build the controller.

    Attributes:
        name: name as `--controller` takes it; for a trained policy the name of its folder or file among `files`.
        files: contents of a trained policy's files by path (see `agents.learning.trained.files`).
        trust: run code in the files.
        state: learned state; None for a controller that does not learn.
    """

    name: str
    files: Mapping[str, bytes]
    trust: bool
    state: State | None

    def build(self, env: Env, seed: int) -> Controller:
        """The controller for an environment, with its random generators reset to the seed."""
        with TemporaryDirectory() as folder:
            for path, content in self.files.items():
                (Path(folder) / path).parent.mkdir(parents=True, exist_ok=True)
                (Path(folder) / path).write_bytes(content)
            name = str(Path(folder) / self.name) if self.files else self.name
            controller = trials.of(env).controller(name, trust=self.trust)
        controller.reset(seed)
        if self.state is not None and isinstance(controller, Learner):
            controller.restore(self.state)
        return controller

    def digest(self) -> str:
        """Digest of all attributes."""
        parts = {name: np.ascontiguousarray(array).tobytes() for name, array in (self.state or {}).items()}
        digest = hashlib.sha256(self.name.encode())
        for name, content in sorted({**self.files, **parts}.items()):
            digest.update(f"{name} {len(content)} ".encode() + content)
        return digest.hexdigest()


@final
@dataclass(frozen=True)
class Collection:
    """Throws of a controller in an environment, to be collected.

    Attributes:
        env: id of the environment.
        level: name of a shipped level, or the config of another one.
        mode: action mode.
        num_envs: largest number of cells side by side.
        episode: largest or approximate number of throws in an episode.
        recipe: the controller.
        role: purpose of the throws, which separates their random streams.
        seed: seed of the throws.
        noise: standard deviations of the noise on the actions, one chunk after the other in turn; none without noise.
    """

    env: str
    level: str | LevelConfig
    mode: str
    num_envs: int
    episode: int
    recipe: ControllerRecipe
    role: Role
    seed: int
    noise: tuple[float, ...] = ()

    def jobs(self, name: str, throws: int) -> list[Job]:
        """Jobs of the chunks that hold a number of throws together, in order; the last episode is completed."""
        size = self.episode * max(1, round(CHUNK / self.episode))
        level = self.level
        level_data, files = (level, ()) if isinstance(level, str) else (level.model_dump(mode="json"), level.files())
        digest = key(
            env=self.env,
            level=level_data,
            files=[hashlib.sha256(bytes_of(file, MOST_NUMBERS)).hexdigest() for file in files],
            settings=[self.mode, self.num_envs, self.role, self.seed, *self.noise],
            thrower=self.recipe.digest(),
            code=code_digest(_CODE, ["agents.dataset.collection"]),
            own=[parcel.digest(name) for name in self.modules],
        )
        return [
            Job(f"{name}-{n}", f"{digest}-{least}", partial(collect, self, n, least), least, "npz")
            for n, least in enumerate(min(size, throws - start) for start in range(0, throws, size))
        ]

    @property
    def modules(self) -> list[str]:
        """Names of the user's modules that the jobs import."""
        names = [self.env, *([] if self.recipe.files else [self.recipe.name])]
        return sorted({module for name in names if (module := module_of(name)) is not None})


def collect(collection: Collection, number: int, throws: int, _folder: Path) -> bytes:
    """Collect one chunk: whole episodes that hold a number of throws, and that depend on the chunk's number alone."""
    role, seed = collection.role, collection.seed
    rows = min(collection.num_envs, -(-throws // collection.episode))  # further rows would simulate unneeded throws
    with closing(make_vector(collection.env, collection.level, rows, 1, collection.mode)) as env:
        controller = collection.recipe.build(env, stream_seed(role, seed, number))
        noise = None
        if collection.noise:
            # The noise of a chunk comes from a random stream that no other draws share.
            stream = np.random.default_rng([seed, zlib.crc32(f"noise {role}".encode()), number])
            noise = Noise(collection.noise[number % len(collection.noise)], stream)
        return pack(episodes(controller, env, throws, episode_seeds(role, seed, number), noise))


def pack(episode_stream: Iterable[Episode]) -> bytes:
    """Episodes as a NumPy archive of plain arrays."""
    whole = list(episode_stream)
    arrays: dict[str, Any] = {
        "seed": np.array([episode.seed for episode in whole]),
        "terminated": np.array([episode.terminated for episode in whole]),
        "actions": np.concatenate([episode.actions for episode in whole]),
        "rewards": np.concatenate([episode.rewards for episode in whole]),
        "lengths": np.array([len(episode) for episode in whole]),
        "figures": np.array([json.dumps(episode.figures) for episode in whole]),
    }
    arrays |= _join("observations", [episode.observations for episode in whole])
    arrays |= _join(_INFO, [episode.info for episode in whole])
    arrays |= _join("hidden", [episode.hidden for episode in whole])
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def unpack(file: Path) -> Iterator[Episode]:
    """Episodes of an archive that `pack` has written.

    Raises:
        UsageError: the file is damaged, or of something else.
    """
    with check_form(file):
        return _episodes(arrays_of(file, PARTS, MOST_CHUNK))


def _episodes(arrays: Mapping[str, NDArray[Any]]) -> Iterator[Episode]:
    """Episodes of the arrays of an archive.

    Raises:
        ValueError: the arrays are no numbers, or do not fit together.
        LookupError: an array is missing.
    """
    lengths = arrays["lengths"]
    if lengths.dtype.kind != "i" or lengths.ndim != 1 or lengths.min(initial=1) < 1 or arrays["rewards"].ndim != 1:
        raise ValueError(f"lengths are {lengths.dtype} {lengths.shape}")
    throws, count = int(lengths.sum()), len(lengths)
    for name, array in arrays.items():
        rows = count if name in ("seed", "terminated", "lengths", "figures") else throws
        rows += count if name.partition("/")[0] in ("observations", _INFO) else 0
        if array.dtype.kind not in ("U" if name == "figures" else "fiub") or len(array) != rows:
            raise ValueError(f"{name} is {array.dtype} {array.shape}")
    throw_ends = np.cumsum(arrays["lengths"])[:-1]
    observation_ends = np.cumsum(arrays["lengths"] + 1)[:-1]  # an episode has one observation more than throws
    count = len(arrays["seed"])
    columns = (
        arrays["seed"].tolist(),
        _split("observations", arrays, observation_ends, count),
        np.split(arrays["actions"], throw_ends),
        np.split(arrays["rewards"], throw_ends),
        arrays["terminated"].tolist(),
        _split(_INFO, arrays, observation_ends, count),
        _split("hidden", arrays, throw_ends, count),
        [dict(parsed_json(text)) for text in arrays["figures"].tolist()],
    )
    return iter([Episode(*row) for row in zip(*columns, strict=True)])


def _join(name: str, parts: list[Any]) -> dict[str, NDArray[Any]]:
    """Concatenated arrays of episodes; arrays in nested mappings are named by their path."""
    if not isinstance(parts[0], Mapping):
        return {name: np.concatenate(parts)}
    inner = [_join(f"{name}/{part_name}", [part[part_name] for part in parts]) for part_name in parts[0]]
    return {path: array for arrays in inner for path, array in arrays.items()}


def _split(name: str, arrays: Mapping[str, NDArray[Any]], ends: NDArray[Any], count: int) -> list[Any]:
    """Arrays or nested mappings of each episode, from the arrays that `_join` has concatenated."""
    if name in arrays:
        return np.split(arrays[name], ends)
    below = dict.fromkeys(path[len(name) + 1 :].partition("/")[0] for path in arrays if path.startswith(f"{name}/"))
    parts = {part_name: _split(f"{name}/{part_name}", arrays, ends, count) for part_name in below}
    return [{part_name: part[n] for part_name, part in parts.items()} for n in range(count)]
