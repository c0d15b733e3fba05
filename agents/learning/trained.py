"""Policies trained by stable-baselines3 in files of several kinds, and the recorded arguments of their training.

Three places are understood:

    runs/MY_RUN/                    a run folder of `agents.train`: policy.npz, args.yml, env.yaml
    logs/sac/MyEnv-v0_1/            one of RL-Zoo: MyEnv-v0.zip, or best_model.zip where training was cut short, and
                                    MyEnv-v0/ with args.yml, config.yml and perhaps vecnormalize.pkl
    any/model.zip                   a single model, with vecnormalize.pkl beside it if its observations were normalised

The algorithms of `agents.learning.sb3.MARKS` are understood, and all of RL-Zoo's settings but wrappers and stacked
frames.

A run folder is data (see `agents.learning.runs`). The other two can run code, because stable-baselines3 unpickles parts
of a model and all of vecnormalize.pkl; both are loaded only with `--trust`. YAML is always read as data. A run folder
may name a module that registers its environment; the module is imported only if the user names it too.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeVar, final

import yaml

from pnt_gym.reading import PlainLoader, ReadError, bytes_of, yaml_of

from ..ground import shipped
from ..ground.cli import UsageError
from .hyperparameters import MOST_MODEL
from .runs import RunFolder

LevelT = TypeVar("LevelT")
STATISTICS: Final = "vecnormalize.pkl"
REFUSED: Final = ("env_wrapper", "vec_env_wrapper", "frame_stack")
"""Settings of RL-Zoo that put a wrapper between environment and policy."""


@final
@dataclass(frozen=True)
class TrainedPolicy:
    """A policy on disk."""

    model: Path
    statistics: Path | None
    """File of the statistics that normalise the policy's observations (VecNormalize), if there is one."""
    task: Mapping[str, Any]
    """Recorded `env`, `level` and `action_mode` of the training."""
    is_run: bool = False
    """Whether the policy lies in a run folder of `agents.train`, which holds no code."""


@final
class _ZooLoader(PlainLoader):
    """Loader of YAML as data, including the ordered mappings of RL-Zoo."""


def _construct_mapping(loader: _ZooLoader, node: yaml.SequenceNode) -> dict[str, Any]:
    (pairs,) = loader.construct_sequence(node, deep=True)
    return dict(pairs)


_ZooLoader.add_constructor("tag:yaml.org,2002:python/object/apply:collections.OrderedDict", _construct_mapping)
_ZooLoader.add_constructor("tag:yaml.org,2002:python/tuple", _ZooLoader.construct_sequence)


def find(place: Path) -> TrainedPolicy:
    """Find the policy in a run folder, an RL-Zoo folder or a model file.

    Raises:
        UsageError: there is no policy, or its training used settings that are not understood.
    """
    if place.suffix == ".zip":
        if not place.is_file():
            raise UsageError(f"model {str(place)!r} does not exist")
        return TrainedPolicy(place, _file_or_none(place.with_name(STATISTICS)), {})
    inner = sorted(path.parent for path in place.glob("*/args.yml"))
    if inner and not (place / "args.yml").is_file():
        # A run folder of RL Zoo.
        folder = inner[0]
        run_args, settings = _read(folder / "args.yml"), _read(folder / "config.yml")
        for name in REFUSED:
            if settings.get(name) not in (None, 1):
                raise UsageError(f"the policy of {str(place)!r} was trained with {name}, which is not supported")
        models = [place / f"{folder.name}.zip", place / "best_model.zip"]
        existing = [model for model in models if model.is_file()]
        if not existing:
            raise UsageError(f"{str(place)!r} holds neither {models[0].name} nor {models[1].name}")
        kwargs = run_args.get("env_kwargs")
        recorded = {**(kwargs if isinstance(kwargs, dict) else {}), "env": run_args.get("env")}
        task = {name: recorded[name] for name in ("env", "level", "action_mode") if isinstance(recorded.get(name), str)}
        return TrainedPolicy(existing[0], _file_or_none(folder / STATISTICS), task)
    run = RunFolder(place)
    run_args = run.arguments
    task = {"env": run_args["env"], "level": str(place / "env.yaml"), "action_mode": run_args["action_mode"]}
    return TrainedPolicy(run.policy_file(), None, task, is_run=True)


def files(place: Path) -> dict[str, bytes]:
    """Contents of the files of a trained policy, or of a scorer (.npz), by path relative to the parent folder.

    Raises:
        UsageError: there is no policy, or its files cannot be read.
    """
    root = place.resolve()
    paths = [root]
    if root.suffix != ".npz":  # the files that `find` or the loading of the policy reads
        policy = find(root)
        paths = [policy.model, *([] if policy.statistics is None else [policy.statistics])]
        if root.is_dir():
            paths += [path for pattern in ("*.y*ml", "*/args.yml", "*/config.yml") for path in root.glob(pattern)]
    try:
        return {path.relative_to(root.parent).as_posix(): bytes_of(path, MOST_MODEL) for path in paths}
    except ReadError as error:
        raise UsageError(f"cannot read the files of {str(place)!r}: {error}") from None


def _read(path: Path) -> dict[str, Any]:
    try:
        return dict(yaml_of(path, loader=_ZooLoader))
    except Exception:  # see `agents.ground.files`
        raise UsageError(f"{str(path)!r} cannot be read as RL-Zoo writes it") from None


def _file_or_none(path: Path) -> Path | None:
    return path if path.is_file() else None


def check(place: Path, trusted: bool) -> None:
    """Make sure that the user trusts a file that may run code.

    Raises:
        UsageError: the user has not given --trust.
    """
    if not trusted:
        raise UsageError(
            f"{str(place)!r} is not a run folder of `train`: loading it runs whatever code its author put in; "
            "give --trust if you trust its source"
        )


def resolve(
    controller: str, env: str | None, level: LevelT | None, action_mode: str | None
) -> tuple[str, LevelT | str | None, str | None]:
    """Environment id, level and action mode: as given, else of the controller's training, else the defaults.

    Level and mode are None for the environment's defaults.

    Raises:
        UsageError: the run folder's environment is in a module that the user has not named.
    """
    place, own = shipped.place(controller), shipped.POLICIES.get(controller.removeprefix(shipped.PREFIX))
    recorded = find(place).task if os.path.isdir(place) else {}  # False for a name too long to be one
    if own is not None and own.controller and shipped.is_shipped(controller):
        recorded = {"env": own.env, "level": place.stem}
    env_id = importless_environment(controller, recorded.get("env", "PnTConveyor-v0")) if env is None else env
    mode = recorded.get("action_mode") if action_mode is None else action_mode
    return env_id, recorded.get("level") if level is None else level, mode


def resolve_shared_task(
    controllers: Sequence[str], env: str | None, level: LevelT | None
) -> tuple[str, LevelT | str | None, str | None]:
    """Environment id, level and action mode of several controllers: as given, else of the training of one of them.

    Raises:
        UsageError: controllers were trained in different environments and no environment is given.
    """
    tasks = [resolve(controller, env, level, None) for controller in controllers]
    trained = [task for task in tasks if task[1:] != (level, None)]
    for task in trained:
        if (task[0], task[2]) != (trained[0][0], trained[0][2]):
            raise UsageError(
                f"controllers were trained in {trained[0][0]} and {task[0]}, with actions {trained[0][2]} and "
                f"{task[2]}; compare controllers of one environment and action mode"
            )
    return [*trained, *tasks, resolve("analytic", env, level, None)][0]


def importless_environment(folder: str | Path, env_id: str) -> str:
    """Id of a run folder's environment, if opening the environment imports no user's module.

    Raises:
        UsageError: the environment is in a module, which is imported only if the user names it.
    """
    if ":" in env_id:
        raise UsageError(f"{str(folder)!r} is of an environment in a module; give --env {env_id} to import it")
    return env_id
