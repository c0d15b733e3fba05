"""Datasets for offline learning in Minari's format: their names, their content, and writing them at once.

Minari's layout suits long episodes: an episode of one throw takes 25 kB. A dataset is repacked before it appears under
its name; then a throw takes 6 kB. The three pictures of a pick with two steps take 17 kB, half of their bytes.
"""

from __future__ import annotations

import os
import re
import shutil
import warnings
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
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

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.features import merge_numbered
from pnt_gym.errors import one_sentence

from ..ground.cli import UsageError
from ..ground.files import sweep, temporary_path
from ..ground.versions import git_state, versions
from .crew import Crew, Scores
from .episodes import Episode

PLACE: Final = "MINARI_DATASETS_PATH"
"""Environment variable with Minari's folder of datasets."""
SEPARATE: Final = ("landing_error", "is_success")
"""Values with an array of their own in `infos`. Every array of an episode costs space and time, so all other values
share two arrays, `outcome` and `hidden`."""
PIECE: Final = 1000
"""Number of episodes written at a time."""
PICTURES: Final = {"compression": "gzip", "compression_opts": 1}
"""Settings of arrays of bytes, which are pictures; they then take half the space."""
MAIN: Final = "main_data.hdf5"
"""Minari's name for the file with all episodes."""


@final
@dataclass(frozen=True)
class Home:
    """The folder of all datasets on this machine."""

    folder: Path

    @classmethod
    def of(cls, folder: Path | None) -> Home:
        """The given folder, or for None Minari's default folder."""
        default = os.environ.get(PLACE) or Path.home() / ".minari" / "datasets"
        return cls(Path(default if folder is None else folder).absolute())  # Minari fails on a relative path

    def check(self, name: str) -> None:
        """Make sure that a new dataset can have this name in the folder.

        Raises:
            UsageError: the name is not valid, or is taken.
        """
        check(name)
        if (self.folder / name).exists():
            raise UsageError(f"{name!r} exists already in {str(self.folder)!r}; choose another --name, or remove it")
        for above in Path(name).parents:
            if (self.folder / above / "data").exists():
                place = str(self.folder / above)
                raise UsageError(f"{name!r} would lie in {place!r}, which Minari takes for a dataset: it holds 'data'")

    @contextmanager
    def create(self, name: str) -> Generator[None, None, None]:
        """Let the block create a dataset in a temporary folder, and move the dataset into this one at its end."""
        self.folder.mkdir(parents=True, exist_ok=True)
        sweep(self.folder)
        elsewhere = temporary_path(self.folder / "dataset")
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
    """Set Minari's folder of datasets during the block."""
    before = os.environ.get(PLACE)
    os.environ[PLACE] = str(folder)
    try:
        yield
    finally:
        os.environ.pop(PLACE)
        if before is not None:
            os.environ[PLACE] = before


def check(name: str) -> None:
    """Make sure that a name is a valid id of a Minari dataset with a version.

    Raises:
        UsageError: the name is not valid.
    """
    match = DATASET_ID_RE.fullmatch(name)
    if match is None or match["version"] is None:
        raise UsageError(
            f"--name is {one_sentence(repr(name), 80)}; it must be NAMESPACE/NAME-vN of letters, digits, - and _, for "
            "instance pnt_gym/release/waste-random-v0"
        )


def check_recoverable(env: gym.Env[Any, Any]) -> None:
    """Make sure that a dataset's metadata can name the entry point of its environment.

    Raises:
        UsageError: the environment is registered with a class or a function instead of a string.
    """
    spec = env.spec
    if spec is not None and callable(spec.entry_point):
        raise UsageError(
            f"environment {spec.id!r} is registered with an object, which no dataset can name; register it with "
            "entry_point 'MODULE:CLASS'"
        )


def name(env_id: str, level: str, label: str) -> str:
    """Default name of a dataset by environment, level and controller."""
    task = re.sub(r"-v\d+$", "", env_id.rpartition(":")[2]).removeprefix("PnT")
    words = re.sub(r"(?<=[a-z\d])(?=[A-Z])", "_", task).lower()
    plain = [re.sub(r"[^A-Za-z\d]+", "_", part).strip("_") or "own" for part in (words, level, label)]
    return f"pnt_gym/{plain[0]}/{plain[1]}-{plain[2]}-v0"


@final
@dataclass(frozen=True)
class Facts:
    """Metadata of a dataset: by Minari's own names, and further ones of ours."""

    minari: Mapping[str, Any]
    ours: Mapping[str, Any]


def write(
    name: str, env: gym.Env[Any, Any], episodes: Iterable[Episode], facts: Facts, progress: Callable[[int, int], None]
) -> None:
    """Create a dataset in Minari's current folder of datasets.

    Args:
        name: name of the dataset.
        env: single environment that reproduces every episode.
        episodes: at least one episode; an iterator may yield them as they are collected.
        facts: metadata of the dataset.
        progress: called with the number of repacked episodes and the number of all episodes.
    """
    remaining = iter(episodes)
    pieces = iter(lambda: list(islice(remaining, PIECE)), [])
    first = next(pieces)
    with warnings.catch_warnings():
        # Minari warns of missing metadata, and Gymnasium of intended bounds.
        warnings.simplefilter("ignore", UserWarning)
        dataset = minari.create_dataset_from_buffers(
            name, [*map(_buffer, first)], env, env, data_format="hdf5", jpeg_encoding=False, **facts.minari
        )
        _write(dataset, first)
        for piece in pieces:
            dataset.update_dataset_from_buffer([*map(_buffer, piece)])
            _write(dataset, piece)
    # Rewrite every array of an HDF5 file in one block, without the index of growing arrays.
    file = Path(dataset.storage.data_path) / MAIN
    small = temporary_path(file)
    with h5py.File(file) as old, h5py.File(small, "w", track_order=True) as new:
        new.attrs.update(old.attrs)
        for number, (episode_name, episode) in enumerate(old.items(), start=1):
            _copy(episode, new.create_group(episode_name))
            progress(number, len(old))
    small.replace(file)
    dataset.storage.update_metadata({**facts.ours, "dataset_size": dataset.storage.get_size()})


def columns(episode: Episode) -> dict[str, list[str]]:
    """Names of the columns of the arrays `outcome` and `hidden` in `infos`; an array without columns is left out."""
    outcome = [name for name, values in episode.info.items() if not (name in SEPARATE or values.ndim > 1)]
    groups = {"outcome": outcome, "hidden": list(episode.hidden)}
    return {name: names for name, names in groups.items() if names}


def _write(dataset: minari.MinariDataset, episodes: Sequence[Episode]) -> None:
    """Write the figures of the last episodes of a dataset into the metadata of these episodes."""
    first = dataset.storage.total_episodes - len(episodes)
    entries = [(first + k, dict(episode.figures)) for k, episode in enumerate(episodes) if episode.figures]
    if entries:
        dataset.storage.update_episode_metadata([figures for _, figures in entries], [index for index, _ in entries])


def _buffer(episode: Episode) -> EpisodeBuffer:
    last = np.arange(len(episode)) == len(episode) - 1
    infos = {name: values == 1.0 if name == "is_success" else values for name, values in episode.info.items()}
    # Minari's info arrays have an entry for the reset, so the hidden values of throw k are entry k + 1, as its outcome.
    hidden = {name: np.concatenate([[np.nan], values]) for name, values in episode.hidden.items()}
    tables = {"outcome": infos, "hidden": hidden}
    arrays: dict[str, Any] = {"actions": episode.actions, "rewards": episode.rewards}
    return EpisodeBuffer(
        seed=episode.seed,
        observations=episode.observations,
        **arrays,
        terminations=last & episode.terminated,
        truncations=last & (not episode.terminated),
        infos={
            **{name: values for name, values in infos.items() if name in SEPARATE or values.ndim > 1},
            **{name: _table(tables[name], names) for name, names in columns(episode).items()},
        },
    )


def _table(values: Mapping[str, Floats], names: Sequence[str]) -> Floats:
    return np.stack([values[name] for name in names], axis=-1)


def _copy(old: h5py.Group, new: h5py.Group) -> None:
    new.attrs.update(old.attrs)
    for name, part in old.items():
        if isinstance(part, h5py.Group):
            _copy(part, new.create_group(name))
        else:
            new.create_dataset(name, data=part[()], **(PICTURES if part.dtype == np.uint8 else {}))


NEEDED: Final = ("pnt_gym", "mujoco", "gymnasium", "numpy", "scipy")
"""Packages whose versions decide whether throws are equal bit for bit."""


def facts_of(
    crew: Crew, scores: Scores, columns: Mapping[str, Sequence[str]], authorship: Mapping[str, str | None]
) -> Facts:
    """Metadata of a dataset, for Minari and of our own.

    Args:
        crew: the controllers of the dataset.
        scores: mean returns of random actions and of the expert.
        columns: names of the columns of the arrays in `infos`.
        authorship: `author`, `author_email` and `code_permalink` of Minari's metadata.
    """
    core = crew.trial.core
    minari = {
        "algorithm_name": crew.algorithm,
        **authorship,
        "ref_min_score": scores.lowest,
        "ref_max_score": scores.highest,
        "num_episodes_average_score": scores.episodes,
        "description": description(crew, scores, columns),
        "requirements": [f"{name}=={versions()[name]}" for name in NEEDED],
    }
    ours = {
        "seed": crew.seed,
        "num_envs": crew.trial.env.num_envs,
        "practice": crew.practice(crew.thrower),
        "noise": list(crew.noise),
        "expert": crew.expert,
        "items": list(core.item_names),
        "level": core.config.model_dump(mode="json"),
        "versions": versions(),
        "commit": (git_state() or "").partition("\n")[0] or None,
    }
    return Facts(minari, {"columns": columns, "pnt_gym": ours})


def description(crew: Crew, scores: Scores, columns: Mapping[str, Sequence[str]]) -> str:
    """Description of the dataset in words, for its metadata."""
    core = crew.trial.core
    quantities = merge_numbered(getattr(core.cell, "hidden", ()))
    hidden = "; ".join(f"{quantity.name} [{quantity.unit}], {quantity.meaning}" for quantity in quantities)
    parts = [
        f"Throws of {crew.env_id}, level {core.config.name}, action mode {core.action_mode}, by {crew.algorithm}"
        f"{_text(crew)}.",
        "Reset the recovered environment with the seed of an episode and give it its actions: with the packages of "
        "`requirements`, observations and rewards are the same bit for bit.",
        "In `infos`, entry k + 1 is of throw k, and entry 0, of the reset, NaN or False; what a reset tells too is of "
        "the throw that follows: entry k belongs to observation k. `landing_error` is in metres.",
        f"Columns of `outcome`, as in the manual of the environment: {', '.join(columns['outcome'])}.",
        f"Columns of `hidden`, which no observation tells: {hidden}." if hidden else "",
        f"Score 0 is the mean return of random actions, score 1 that of {crew.expert}, on {scores.episodes} other "
        "episodes.",
    ]
    return " ".join(filter(None, parts))


def _text(crew: Crew) -> str:
    """Noise on the actions in words; empty without noise."""
    deviations = ", ".join(f"{deviation:g}" for deviation in crew.noise)
    in_turn = ", in turn" if len(crew.noise) > 1 else ""
    return f" with normal noise on the actions (standard deviation {deviations}{in_turn})" if crew.noise else ""
