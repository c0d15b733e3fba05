"""Many throws of a controller, in chunks: each is a job of its own, whoever does it and in whatever order."""

from __future__ import annotations

import hashlib
import io
import json
import re
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
from pnt_gym.reading import MOST_NUMBERS, arrays_of, bytes_of

from ..controllers.protocol import Controller, Learner, State
from ..ground.environments import Env, Role, make_vector, stream_seed
from ..jobs.code import code_digest
from ..jobs.parcel import own_code
from ..jobs.work import Job, key
from ..judging.makers import controller_for
from .episodes import Episode, episode_seeds, episodes

CHUNK: Final = 512
"""Throws of a job, about: it should take seconds, and be done again where a machine died."""
MOST_CHUNK: Final = 2**31
"""Bytes of the arrays of a job."""
PARTS: Final = re.compile(r"\w+(?:/[\w .:-]+)*")
"""Names of these arrays."""
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
"""Code that decides what is thrown and is found by a name, and the levels, tables and settings that it reads."""


@final
@dataclass(frozen=True)
class Thrower:
    """Who throws, with all that it takes to make it anywhere.

    Attributes:
        name: as `controller_for` takes it; of a trained policy that of its folder or file, which is among `files`.
        files: contents by path, of a trained policy (see `agents.learning.trained.files_of`).
        trust: run the code that may be in them.
        state: what it has learned, if it learns.
    """

    name: str
    files: Mapping[str, bytes]
    trust: bool
    state: State | None

    def made(self, env: Env, seed: int) -> Controller:
        """It, in an environment; whatever is random in it follows from the seed."""
        with TemporaryDirectory() as folder:
            for path, content in self.files.items():
                (Path(folder) / path).parent.mkdir(parents=True, exist_ok=True)
                (Path(folder) / path).write_bytes(content)
            name = str(Path(folder) / self.name) if self.files else self.name
            controller = controller_for(name, env, trust=self.trust)
        controller.reset(seed)
        if self.state is not None and isinstance(controller, Learner):
            controller.restore(self.state)
        return controller

    def digest(self) -> str:
        """Changes with all of that."""
        parts = {name: np.ascontiguousarray(array).tobytes() for name, array in (self.state or {}).items()}
        digest = hashlib.sha256(self.name.encode())
        for name, content in sorted({**self.files, **parts}.items()):
            digest.update(f"{name} {len(content)} ".encode() + content)
        return digest.hexdigest()


@final
@dataclass(frozen=True)
class Collection:
    """Throws of somebody in some environment.

    Attributes:
        env: id of the environment.
        level: a shipped one by its name, or all that it says.
        mode: of the actions.
        num_envs: most cells side by side.
        episode: most throws in an episode, or about as many as there are.
        thrower: who throws.
        role: what the throws are for.
        seed: names them.
    """

    env: str
    level: str | LevelConfig
    mode: str
    num_envs: int
    episode: int
    thrower: Thrower
    role: Role
    seed: int

    def jobs(self, name: str, throws: int) -> list[Job]:
        """Chunks that hold so many throws together, in their order; of their last episode all that there are."""
        size = self.episode * max(1, round(CHUNK / self.episode))
        digest = self._key()
        return [
            Job(f"{name}-{n}", f"{digest}-{least}", partial(collect, self, n, least), least, "npz")
            for n, least in enumerate(min(size, throws - start) for start in range(0, throws, size))
        ]

    def _key(self) -> str:
        ships = isinstance(self.level, str)
        return key(
            env=self.env,
            level=self.level if ships else self.level.model_dump(mode="json"),
            files=[]
            if ships
            else [hashlib.sha256(bytes_of(file, MOST_NUMBERS)).hexdigest() for file in self.level.files()],
            settings=[self.mode, self.num_envs, self.role, self.seed],
            thrower=self.thrower.digest(),
            code=code_digest(_CODE, ["agents.data.collection"]),
            own=[own_code(name) for name in self.modules],
        )

    @property
    def modules(self) -> list[str]:
        """Modules of the user's, that the work imports."""
        named = [self.env, *([] if self.thrower.files else [self.thrower.name])]
        return sorted({name.partition(":")[0] for name in named if ":" in name})


def collect(collection: Collection, number: int, throws: int, _folder: Path) -> bytes:
    """A chunk: whole episodes that hold so many throws, a function of its number and nothing that was done before."""
    role, seed = collection.role, collection.seed
    rows = min(collection.num_envs, -(-throws // collection.episode))  # more would throw what nobody asked for
    with closing(make_vector(collection.env, collection.level, rows, 1, collection.mode)) as env:
        controller = collection.thrower.made(env, stream_seed(role, seed, number))
        return packed(episodes(controller, env, throws, episode_seeds(role, seed, number)))


def packed(found: Iterable[Episode]) -> bytes:
    """Episodes as a NumPy archive of plain arrays."""
    whole = list(found)
    arrays: dict[str, Any] = {
        "seed": np.array([one.seed for one in whole]),
        "terminated": np.array([one.terminated for one in whole]),
        "actions": np.concatenate([one.actions for one in whole]),
        "rewards": np.concatenate([one.rewards for one in whole]),
        "lengths": np.array([len(one) for one in whole]),
        "figures": np.array([json.dumps(one.figures) for one in whole]),
    }
    for name in ("observations", "told", "hidden"):
        arrays |= _joined(name, [getattr(one, name) for one in whole])
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def unpacked(file: Path) -> Iterator[Episode]:
    """The episodes of such an archive."""
    arrays = arrays_of(file, PARTS, MOST_CHUNK)
    throws = np.cumsum(arrays["lengths"])[:-1]
    seen = np.cumsum(arrays["lengths"] + 1)[:-1]  # one more than there are throws
    count = len(arrays["seed"])
    columns = (
        arrays["seed"].tolist(),
        _parted("observations", arrays, seen, count),
        np.split(arrays["actions"], throws),
        np.split(arrays["rewards"], throws),
        arrays["terminated"].tolist(),
        _parted("told", arrays, seen, count),
        _parted("hidden", arrays, throws, count),
        map(json.loads, arrays["figures"].tolist()),
    )
    return (Episode(*row) for row in zip(*columns, strict=True))


def _joined(name: str, parts: list[Any]) -> dict[str, NDArray[Any]]:
    """Arrays of episodes one after the other; of mappings by the names on the way to them."""
    if not isinstance(parts[0], Mapping):
        return {name: np.concatenate(parts)}
    inner = [_joined(f"{name}/{one}", [part[one] for part in parts]) for one in parts[0]]
    return {path: array for arrays in inner for path, array in arrays.items()}


def _parted(name: str, arrays: Mapping[str, NDArray[Any]], ends: NDArray[Any], count: int) -> list[Any]:
    """What `_joined` has joined, for each of the episodes."""
    if name in arrays:
        return np.split(arrays[name], ends)
    below = dict.fromkeys(path[len(name) + 1 :].partition("/")[0] for path in arrays if path.startswith(f"{name}/"))
    parts = {one: _parted(f"{name}/{one}", arrays, ends, count) for one in below}
    return [{one: part[n] for one, part in parts.items()} for n in range(count)]
