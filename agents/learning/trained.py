"""Policies that stable-baselines3 has trained, wherever they lie, and what is known about their training.

Three places are understood:

    runs/MY_RUN/                    a run folder of `agents.train`: policy.npz, args.yml, env.yaml
    logs/sac/MyEnv-v0_1/            one of RL-Zoo: MyEnv-v0.zip, or best_model.zip where training was cut short, and
                                    MyEnv-v0/ with args.yml, config.yml and perhaps vecnormalize.pkl
    any/model.zip                   a single model, with vecnormalize.pkl beside it if its observations were normalised

Of algorithms those of `agents.learning.sb3.MARKS` are understood, of RL-Zoo's settings all but wrappers and stacked
frames.

A run folder is data (see `agents.learning.runs`). The other two are code: stable-baselines3 unpickles parts of a model
and all of vecnormalize.pkl, so they are loaded only for a user who says `--trust`. YAML is read as data everywhere, and
a module that a run folder names as the home of its environment is imported only if the user names it too.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import yaml

from pnt_gym.reading import PlainLoader, ReadError, bytes_of, yaml_of

from ..ground.cli import UsageError
from . import runs

STATISTICS: Final = "vecnormalize.pkl"
REFUSED: Final = ("env_wrapper", "vec_env_wrapper", "frame_stack")
"""Settings of RL-Zoo that put something between environment and policy."""


@final
@dataclass(frozen=True)
class Trained:
    """A policy on disk."""

    model: Path
    statistics: Path | None
    """Of its observations, by which they were normalised (VecNormalize)."""
    known: Mapping[str, Any]
    """Of `env`, `level` and `action_mode` of its training those that are recorded."""
    is_run: bool = False
    """It lies in a run folder of `agents.train`, which holds no code."""


@final
class _ZooLoader(PlainLoader):
    """Reads YAML with ordered mappings, as RL-Zoo writes them, as data."""


def _ordered(loader: _ZooLoader, node: yaml.SequenceNode) -> dict[str, Any]:
    (pairs,) = loader.construct_sequence(node, deep=True)
    return dict(pairs)


_ZooLoader.add_constructor("tag:yaml.org,2002:python/object/apply:collections.OrderedDict", _ordered)
_ZooLoader.add_constructor("tag:yaml.org,2002:python/tuple", lambda loader, node: loader.construct_sequence(node))


def find_trained(place: Path) -> Trained:
    """The policy in a run folder, an RL-Zoo folder or a model file.

    Raises:
        UsageError: there is none, or it was trained in a way that is not understood.
    """
    if place.suffix == ".zip":
        if not place.is_file():
            raise UsageError(f"model {str(place)!r} does not exist")
        return Trained(place, _there(place.with_name(STATISTICS)), {})
    inner = sorted(path.parent for path in place.glob("*/args.yml"))
    if inner and not (place / "args.yml").is_file():
        return _zoo(place, inner[0])
    asked = runs.read_arguments(place)
    known = {"env": asked["env"], "level": str(place / "env.yaml"), "action_mode": asked["action_mode"]}
    return Trained(runs.policy_of(place), None, known, is_run=True)


def files_of(place: Path) -> dict[str, bytes]:
    """Contents of the files of a trained policy, or of a scorer (.npz), by path from beside the place.

    Raises:
        UsageError: there is no policy in it, or it cannot be read.
    """
    root = place.resolve()
    kept = [root] if root.suffix == ".npz" else _parts(root)
    try:
        return {path.relative_to(root.parent).as_posix(): bytes_of(path, runs.MOST_MODEL) for path in kept}
    except ReadError as error:
        raise UsageError(f"cannot read the files of {str(place)!r}: {error}") from None


def _parts(place: Path) -> list[Path]:
    """Files that `find_trained` reads, and those that are read of what it finds."""
    found = find_trained(place)
    kept = [found.model, *([] if found.statistics is None else [found.statistics])]
    if place.is_dir():
        kept += [path for pattern in ("*.y*ml", "*/args.yml", "*/config.yml") for path in place.glob(pattern)]
    return kept


def _zoo(place: Path, inner: Path) -> Trained:
    asked, settings = _zoo_yaml(inner / "args.yml"), _zoo_yaml(inner / "config.yml")
    for name in REFUSED:
        if settings.get(name) not in (None, 1):
            raise UsageError(f"the policy of {str(place)!r} was trained with {name}, which is not understood here")
    models = [place / f"{inner.name}.zip", place / "best_model.zip"]
    found = [model for model in models if model.is_file()]
    if not found:
        raise UsageError(f"{str(place)!r} holds neither {models[0].name} nor {models[1].name}")
    kwargs = asked.get("env_kwargs")
    told = {**(kwargs if isinstance(kwargs, dict) else {}), "env": asked.get("env")}
    known = {name: told[name] for name in ("env", "level", "action_mode") if isinstance(told.get(name), str)}
    return Trained(found[0], _there(inner / STATISTICS), known)


def _zoo_yaml(path: Path) -> dict[str, Any]:
    try:
        return dict(yaml_of(path, loader=_ZooLoader))
    except Exception:  # see `agents.ground.files`
        raise UsageError(f"{str(path)!r} cannot be read as RL-Zoo writes it") from None


def _there(path: Path) -> Path | None:
    return path if path.is_file() else None


def check_trust(place: Path, trusted: bool) -> None:
    """Make sure that the user wants what may run code.

    Raises:
        UsageError: it has not been said.
    """
    if not trusted:
        raise UsageError(
            f"{str(place)!r} is not a run folder of agents.train: loading it runs whatever code its author put in; "
            "give --trust if you trust its source"
        )


def setting(
    controller: str, env: str | None, level: str | None, action_mode: str | None
) -> tuple[str, str | None, str | None]:
    """Environment id, level and action mode: as asked for, else those of the controller's training, else the defaults.

    Level and mode are None for the environment's own.

    Raises:
        UsageError: the run folder names an environment of somebody's module, and the user does not.
    """
    place = Path(controller)
    known = find_trained(place).known if os.path.isdir(place) else {}  # False for a name too long to be one
    found = own_environment(controller, known.get("env", "PnTConveyor-v0")) if env is None else env
    mode = known.get("action_mode") if action_mode is None else action_mode
    return found, known.get("level") if level is None else level, mode


def own_environment(folder: str | Path, env_id: str) -> str:
    """The environment that a run folder names, if that imports nothing.

    Raises:
        UsageError: it is in a module that only the user may have imported.
    """
    if ":" in env_id:
        raise UsageError(f"{str(folder)!r} is of an environment in a module; give --env {env_id} to import it")
    return env_id
