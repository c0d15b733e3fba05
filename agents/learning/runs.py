"""The folder of a training run: what it was asked for, what it learned, and how to go on with it.

    args.yml            what was asked for           config.yml          hyperparameters (RL-Zoo syntax)
    env.yaml            the level in full            versions.json       of Python and packages
    git.txt             commit, if there is one      command.txt         the command line
    progress.csv        success and landing error while training
    policy.npz          newest policy (see `agents.policies`): all that is needed to throw with it
    model.zip           the same with what it learns by  replay_buffer.npz   its memory
    checkpoints/N/      all that is needed to go on from throw N

A run folder appears complete or not at all, and so does each checkpoint in it. It is data, whoever made it: policy.npz,
memory and random state are numbers; of model.zip, which stable-baselines3 can load too, only tensors and counts are
read here, into networks that args.yml and config.yml describe. Nothing is unpickled. Only who learns on needs torch.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.reading import yaml_text

from ..ground.cli import UsageError
from ..ground.files import read_yaml, replace_file, sweep, unfinished, write_json, write_text
from ..ground.versions import git_state, versions
from ..policies.actor import Actor
from ..policies.scorer import Scorer
from .hyperparameters import hyperparameters
from .memory import load_memory, load_random, save_memory, save_random

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecEnv

OfThrows = Literal["sac", "td3", "ppo", "tqc", "recurrent_ppo"]
OfChoices = Literal["maskable_ppo", "residual_ppo"]
Algorithm = Literal[OfThrows, OfChoices]
ALGORITHMS: tuple[OfThrows, ...] = get_args(OfThrows)
"""Those that correct throws."""
CHOOSING: tuple[OfChoices, ...] = get_args(OfChoices)
"""Those that choose, of what a mask says there is."""
SCORING: tuple[Algorithm, ...] = ("residual_ppo",)
"""Those whose policies are scorers, one network for all choices alike."""
ON_POLICY: tuple[Algorithm, ...] = ("ppo", "recurrent_ppo")
"""Those that learn from every step once, and keep no memory of throws."""
RECURRENT: tuple[Algorithm, ...] = ("recurrent_ppo",)
"""Those whose policies remember what they have seen of a shift."""
ARGUMENTS = ("env", "level", "algo", "steps", "seed", "num_envs", "action_mode", "checkpoint_every")
LATER = {"fidelity": "full", "full_last": 0, "stack": 1, "over": "analytic"}
"""Arguments that older runs do not know, and what they did."""
WHOLE = ("steps", "seed", "num_envs", "checkpoint_every", "full_last", "stack")
"""Of all arguments those that are whole numbers; the others are text."""
MOST_MODEL: int = 2**28
"""Bytes of a model, packed or not."""
POLICY, MODEL, MEMORY, RANDOM = "policy.npz", "model.zip", "replay_buffer.npz", "random.json"


def create(
    folder: Path,
    arguments: Mapping[str, Any],
    settings: Mapping[str, Any],
    config: LevelConfig,
    model: BaseAlgorithm,
) -> None:
    """Write a new run folder with its checkpoint 0.

    Raises:
        UsageError: the folder holds something already, or cannot be written.
    """
    check_new(folder)
    sweep(folder.parent)
    parts = unfinished(folder)
    try:
        shutil.rmtree(parts, ignore_errors=True)
        parts.mkdir(parents=True)
        write_arguments(parts, arguments)
        write_text(parts / "config.yml", yaml_text({arguments["env"]: dict(settings)}))
        write_text(parts / "env.yaml", yaml_text(config.model_dump(mode="json")))
        write_json(parts / "versions.json", versions())
        write_text(parts / "command.txt", " ".join(sys.argv) + "\n")
        state = git_state()
        if state is not None:
            write_text(parts / "git.txt", state)
        save_checkpoint(parts, model)
        if folder.is_dir():
            folder.rmdir()  # empty, or check_new would have refused
        parts.rename(folder)
    except OSError as error:
        raise UsageError(f"cannot write run folder {str(folder)!r}: {error.strerror}") from None
    finally:
        shutil.rmtree(parts, ignore_errors=True)


def name_of(asked: Mapping[str, Any], level: object) -> str:
    """What a folder of a run is called, by what the run was asked for and its level; no part of it is a folder.

    Raises:
        UsageError: a file cannot be called so.
    """
    env_id = asked["env"].rpartition(":")[2].replace("/", "-")  # Gymnasium's ids may have a namespace
    name = f"{env_id}-{level}-{asked['algo']}-seed{asked['seed']}"
    if not isinstance(level, str) or Path(name).name != name or not name.isprintable():
        raise UsageError(f"level {level!r} of environment {asked['env']!r} has a name that no folder can have")
    return name


@contextmanager
def nothing_left(folder: Path) -> Generator[None, None, None]:
    """Remove a new run folder if an error ends the block before the first leg is done: it would block the next try."""
    try:
        yield
    except Exception:
        if len(checkpoints(folder)) == 1:
            shutil.rmtree(folder.rename(unfinished(folder)))
        raise


def write_arguments(folder: Path, arguments: Mapping[str, Any]) -> None:
    """Note what a run is asked for; a resumed run may be asked for more throws."""
    write_text(folder / "args.yml", yaml_text(dict(arguments)))


def check_new(folder: Path) -> None:
    """Make sure that a new run overwrites nothing.

    Raises:
        UsageError: something is there already.
    """
    if folder.is_file() or (folder.is_dir() and any(folder.iterdir())):
        raise UsageError(f"{str(folder)!r} exists already; choose another --out, or continue it with --resume")


def read_arguments(folder: Path) -> dict[str, Any]:
    """What a run was asked for.

    Raises:
        UsageError: there is no such run folder, or it is damaged.
    """
    if not folder.is_dir():
        raise UsageError(f"run folder {str(folder)!r} does not exist")
    if not (folder / "args.yml").is_file():
        raise UsageError(f"{str(folder)!r} is not a run folder: it has no args.yml")
    data = read_yaml(folder / "args.yml", f"run folder {str(folder)!r} is damaged:")
    if isinstance(data, dict):
        data = {**LATER, **data}
    missing = [name for name in ARGUMENTS if not isinstance(data, dict) or name not in data]
    if missing:
        raise UsageError(f"run folder {str(folder)!r} is damaged: args.yml lacks {', '.join(missing)}")
    for name in (*ARGUMENTS, *LATER):
        kind = int if name in WHOLE else str
        if not (isinstance(data[name], kind) and not isinstance(data[name], bool)):
            raise UsageError(f"run folder {str(folder)!r} is damaged: args.yml has {name} {data[name]!r}")
    if data["algo"] not in (*ALGORITHMS, *CHOOSING):
        raise UsageError(f"run folder {str(folder)!r} is damaged: args.yml has algo {data['algo']!r}")
    return data


def load_actor(folder: Path, checkpoint: Path | None = None) -> Actor:
    """The newest policy of a run, or that of one of its checkpoints.

    Raises:
        UsageError: the folder or its policy is missing or damaged, or does not correct throws.
    """
    asked = read_arguments(folder)
    if asked["algo"] in CHOOSING:
        raise UsageError(f"run folder {str(folder)!r} is of a policy that chooses; it is for --env {asked['env']}")
    return Actor.load(policy_of(folder, checkpoint))


def load_numbers(folder: Path, checkpoint: Path | None = None) -> Actor | Scorer:
    """The newest policy of a run, or that of one of its checkpoints, whether it corrects throws or chooses.

    Raises:
        UsageError: the folder or its policy is missing or damaged.
    """
    kind = Scorer if read_arguments(folder)["algo"] in SCORING else Actor
    return kind.load(policy_of(folder, checkpoint))


def policy_of(folder: Path, checkpoint: Path | None = None) -> Path:
    """The file of a run's newest policy, or of that of one of its checkpoints.

    Raises:
        UsageError: it is missing.
    """
    file = (checkpoint or folder) / POLICY
    if not file.is_file():
        old = f"; before 0.2.0 none was written: its {MODEL} can be used with --trust"
        more = old if (folder / MODEL).is_file() else ""
        raise UsageError(f"run folder {str(folder)!r} is damaged: {POLICY} is missing{more}")
    return file


def load_model(folder: Path, env: VecEnv | None = None, checkpoint: Path | None = None) -> BaseAlgorithm:
    """The newest model of a run, or that of one of its checkpoints: it can learn on.

    Raises:
        UsageError: the folder or its model is missing or damaged.
    """
    from .sb3 import load_tensors  # noqa: PLC0415 - imports torch

    asked = read_arguments(folder)
    settings = hyperparameters(asked["algo"], asked["env"], folder / "config.yml")
    file = (checkpoint or folder) / MODEL
    if not file.is_file():
        raise UsageError(f"run folder {str(folder)!r} is damaged: {MODEL} is missing")
    return load_tensors(file, asked, settings, env)


def save_checkpoint(folder: Path, model: BaseAlgorithm) -> None:
    """Keep policy, model, memory and random state at the present throw, and make them the newest of the run.

    Raises:
        UsageError: the policy cannot be kept as numbers.
    """
    from ..policies.weights import actor_of  # noqa: PLC0415 - imports torch

    actor = actor_of(model)
    place = folder / "checkpoints" / f"{model.num_timesteps:08d}"
    sweep(place.parent)
    parts = unfinished(place)
    shutil.rmtree(parts, ignore_errors=True)
    parts.mkdir(parents=True)
    actor.save(parts / POLICY)
    model.save(parts / MODEL)
    if getattr(model, "replay_buffer", None) is not None:
        save_memory(model.replay_buffer, parts / MEMORY)  # type: ignore[attr-defined]
    save_random(model, parts / RANDOM)
    shutil.rmtree(place, ignore_errors=True)
    parts.rename(place)
    _newest(folder)


def _newest(folder: Path) -> None:
    """Make the last checkpoint the newest of the run, as far as a kill has kept that from being done."""
    *others, last = checkpoints(folder)
    for name in (POLICY, MODEL, MEMORY):
        if (last / name).is_file():
            replace_file(folder / name, partial(shutil.copyfile, last / name))
    # Only the last checkpoint is continued; the others keep their policy.
    for old in others:
        (old / MEMORY).unlink(missing_ok=True)


def checkpoints(folder: Path) -> list[Path]:
    """Checkpoints of a run from first to last."""
    place = folder / "checkpoints"
    return sorted(p for p in place.iterdir() if p.name.isdigit()) if place.is_dir() else []


def restore(folder: Path, env: VecEnv) -> BaseAlgorithm:
    """The model of a run's last checkpoint with its memory and random state, ready to go on.

    Raises:
        UsageError: the folder is missing or damaged.
    """
    found = checkpoints(folder)
    if not found:
        raise UsageError(f"run folder {str(folder)!r} is damaged: it has no checkpoint")
    last = found[-1]
    model = load_model(folder, env, last)
    try:
        if getattr(model, "replay_buffer", None) is not None:
            load_memory(model.replay_buffer, last / MEMORY)  # type: ignore[attr-defined]
        load_random(model, last / RANDOM)
    except Exception as error:
        # There is no telling what a torn or foreign file upsets.
        raise UsageError(
            f"run folder {str(folder)!r} is damaged: checkpoint {last.name} is truncated, or of another version"
        ) from error
    if int(last.name) != model.num_timesteps:
        raise UsageError(f"run folder {str(folder)!r} is damaged: checkpoint {last.name} is of another throw")
    _newest(folder)
    sweep(last.parent)
    return model
