"""Datasets for offline learning in Minari's format: their names, what stands in them, and how they get there at once.

Minari writes episodes of one throw in a layout made for long ones, so that a throw takes 25 kB; a dataset is packed
before it appears under its name, and takes 6 kB then.
"""

from __future__ import annotations

import os
import re
import shutil
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Final, final

import gymnasium as gym
import h5py
import minari
import numpy as np
import PIL  # noqa: F401 - Minari needs it and does not say so
from minari.data_collector import EpisodeBuffer
from minari.dataset.minari_dataset import DATASET_ID_RE, parse_dataset_id
from minari.namespace import create_namespace, list_local_namespaces
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.errors import one_sentence

from ..ground.cli import UsageError
from ..ground.files import sweep, unfinished
from .episodes import Episode

PLACE: Final = "MINARI_DATASETS_PATH"
"""Environment variable that tells Minari where datasets are."""
ALONE: Final = ("landing_error", "is_success")
"""Numbers that stand in `infos` by themselves; every array of an episode costs space and time, so others share two."""
PIECE: Final = 1000
"""Episodes written at a time."""
MAIN: Final = "main_data.hdf5"
"""Minari's name for the file with all episodes."""


@final
@dataclass(frozen=True)
class Home:
    """The folder of all datasets on this machine."""

    folder: Path

    @classmethod
    def of(cls, folder: Path | None) -> Home:
        """The user's, or Minari's own if that is None."""
        own = os.environ.get(PLACE) or Path.home() / ".minari" / "datasets"
        return cls(Path(own if folder is None else folder).absolute())  # Minari stumbles over another

    def check_free(self, name: str) -> None:
        """Make sure that a dataset can get this name here.

        Raises:
            UsageError: it is no name, or taken.
        """
        check_name(name)
        if (self.folder / name).exists():
            raise UsageError(f"{name!r} exists already in {str(self.folder)!r}; choose another --name, or remove it")
        for above in Path(name).parents:
            if (self.folder / above / "data").exists():
                place = str(self.folder / above)
                raise UsageError(f"{name!r} would lie in {place!r}, which Minari takes for a dataset: it holds 'data'")

    @contextmanager
    def made(self, name: str) -> Generator[None, None, None]:
        """Let the block create a dataset with Minari, elsewhere; it gets its place when the block is over."""
        self.folder.mkdir(parents=True, exist_ok=True)
        sweep(self.folder)
        elsewhere = unfinished(self.folder / "dataset")
        elsewhere.mkdir()
        try:
            with _minari_in(elsewhere):
                yield
            with _minari_in(self.folder):
                namespace = parse_dataset_id(name)[0]
                if namespace is not None and namespace not in list_local_namespaces():
                    create_namespace(namespace)
            (elsewhere / name).rename(self.folder / name)
        finally:
            shutil.rmtree(elsewhere, ignore_errors=True)


@contextmanager
def _minari_in(folder: Path) -> Generator[None, None, None]:
    """Minari looks for datasets in a folder during the block."""
    before = os.environ.get(PLACE)
    os.environ[PLACE] = str(folder)
    try:
        yield
    finally:
        os.environ.pop(PLACE)
        if before is not None:
            os.environ[PLACE] = before


def check_name(name: str) -> None:
    """Make sure that a name is one of Minari's.

    Raises:
        UsageError: it is not.
    """
    found = DATASET_ID_RE.fullmatch(name)
    if found is None or found["version"] is None:
        raise UsageError(
            f"--name is {one_sentence(repr(name), 80)}; it must be NAMESPACE/NAME-vN of letters, digits, - and _, for "
            "instance pnt_gym/release/waste-random-v0"
        )


def check_recoverable(env: gym.Env[Any, Any]) -> None:
    """Make sure that a dataset can say in a file how its environment is made.

    Raises:
        UsageError: the environment is registered with a class or a function.
    """
    spec = env.spec
    if spec is not None and callable(spec.entry_point):
        raise UsageError(
            f"environment {spec.id!r} is registered with an object, which no dataset can name; register it with "
            "entry_point 'MODULE:CLASS'"
        )


def proper_name(env_id: str, level: str, label: str) -> str:
    """The name of a dataset by task, level and controller."""
    task = re.sub(r"-v\d+$", "", env_id.rpartition(":")[2]).removeprefix("PnT")
    words = re.sub(r"(?<=[a-z\d])(?=[A-Z])", "_", task).lower()
    plain = [re.sub(r"[^A-Za-z\d]+", "_", part).strip("_") or "own" for part in (words, level, label)]
    return f"pnt_gym/{plain[0]}/{plain[1]}-{plain[2]}-v0"


@final
@dataclass(frozen=True)
class Facts:
    """What Minari's metadata tell of a dataset, by its own names, and ours on top."""

    minari: Mapping[str, Any]
    ours: Mapping[str, Any]


def write(
    name: str, env: gym.Env[Any, Any], episodes: Iterable[Episode], facts: Facts, packed: Callable[[int, int], None]
) -> None:
    """Create a dataset where Minari looks for them.

    Args:
        name: of the dataset.
        env: gives every episode again.
        episodes: at least one; they may come as they are thrown.
        facts: of the dataset.
        packed: told how many of all episodes are packed.
    """
    pieces = _pieces(episodes)
    first = next(pieces)
    with warnings.catch_warnings():
        # Minari announces what it is not told, and Gymnasium bounds that are meant.
        warnings.simplefilter("ignore", UserWarning)
        dataset = minari.create_dataset_from_buffers(
            name, _buffers(first), env, env, data_format="hdf5", jpeg_encoding=False, **facts.minari
        )
        _add_figures(dataset, first)
        for piece in pieces:
            dataset.update_dataset_from_buffer(_buffers(piece))
            _add_figures(dataset, piece)
    _pack(Path(dataset.storage.data_path) / MAIN, packed)
    dataset.storage.update_metadata({**facts.ours, "dataset_size": dataset.storage.get_size()})


def columns(episode: Episode) -> dict[str, list[str]]:
    """What stands in the columns of the arrays of `infos` that have some."""
    outcome = [name for name, values in episode.told.items() if not _alone(name, values)]
    found = {"outcome": outcome, "hidden": list(episode.hidden)}
    return {name: names for name, names in found.items() if names}


def _alone(name: str, values: NDArray[Any]) -> bool:
    """Whether what is told stands in `infos` by itself; what is several numbers a throw does as well."""
    return name in ALONE or values.ndim > 1


def _buffers(episodes: Sequence[Episode]) -> list[EpisodeBuffer]:
    return [_buffer(episode) for episode in episodes]


def _add_figures(dataset: minari.MinariDataset, episodes: Sequence[Episode]) -> None:
    """Let the metadata of the last episodes of a dataset tell what each came to as a whole."""
    first = dataset.storage.total_episodes - len(episodes)
    told = [(first + k, dict(episode.figures)) for k, episode in enumerate(episodes) if episode.figures]
    if told:
        dataset.storage.update_episode_metadata([figures for _, figures in told], [index for index, _ in told])


def _buffer(episode: Episode) -> EpisodeBuffer:
    last = np.arange(len(episode)) == len(episode) - 1
    told = episode.told
    # Minari's arrays of infos have an entry for the reset, so what is hidden of throw k stands beside its outcome.
    hidden = {name: np.concatenate([[np.nan], values]) for name, values in episode.hidden.items()}
    tables = {"outcome": told, "hidden": hidden}
    return EpisodeBuffer(
        seed=episode.seed,
        observations=episode.observations,
        actions=episode.actions,
        rewards=episode.rewards,
        terminations=last & episode.terminated,
        truncations=last & (not episode.terminated),
        infos={
            **{name: _flags(name, values) for name, values in told.items() if _alone(name, values)},
            **{name: _table(tables[name], names) for name, names in columns(episode).items()},
        },
    )


def _flags(name: str, values: NDArray[Any]) -> NDArray[Any]:
    """A success as a truth value; anything else as it is."""
    return values == 1.0 if name == "is_success" else values


def _table(values: Mapping[str, Floats], names: Sequence[str]) -> Floats:
    return np.stack([values[name] for name in names], axis=-1)


def _pieces(episodes: Iterable[Episode]) -> Iterator[list[Episode]]:
    rest = iter(episodes)
    while piece := list(islice(rest, PIECE)):
        yield piece


def _pack(file: Path, packed: Callable[[int, int], None]) -> None:
    """Write every array of an HDF5 file anew in one block, without the index that lets it grow."""
    small = unfinished(file)
    with h5py.File(file) as old, h5py.File(small, "w", track_order=True) as new:
        new.attrs.update(old.attrs)
        for done, (name, episode) in enumerate(old.items(), start=1):
            _copy(episode, new.create_group(name))
            packed(done, len(old))
    small.replace(file)


def _copy(old: h5py.Group, new: h5py.Group) -> None:
    new.attrs.update(old.attrs)
    for name, part in old.items():
        if isinstance(part, h5py.Group):
            _copy(part, new.create_group(name))
        else:
            new.create_dataset(name, data=part[()])
