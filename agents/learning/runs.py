"""The folder of a training run: its arguments, its policy, and the checkpoints from which the run can go on.

args.yml            arguments of the run         config.yml          hyperparameters (RL-Zoo syntax)
    env.yaml            the level in full            versions.json       of Python and packages
    git.txt             commit, if there is one      command.txt         the command line
    progress.csv        seconds of training, success and landing error, over all resumes
    policy.npz          newest policy (see `agents.policies`), sufficient for throwing
    model.zip           newest model with optimisers replay_buffer.npz   replay buffer
    checkpoints/N/      all that is needed to go on from throw N

A run folder appears complete or not at all, and so does each checkpoint in it. A run folder is data, whoever made it:
policy.npz, memory and random state are numbers. stable-baselines3 can load model.zip too; here only its tensors and
counts are read, into networks that args.yml and config.yml describe. Nothing is unpickled. Only training needs torch.
"""

from __future__ import annotations

import json
import random
import re
import shutil
import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.errors import one_sentence
from pnt_gym.reading import arrays_of, json_of, yaml_text

from ..ground.cli import UsageError
from ..ground.files import read_yaml, replace_file, stamp, sweep, temporary_path, write_json, write_text
from ..ground.versions import git_state, versions
from ..policies.actor import Actor
from ..policies.scorer import Scorer
from .hyperparameters import MASKED, MAX_STACK, RESIDUAL, SCORING, hyperparameters
from .hyperparameters import WHOLE as RANGES

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecEnv

HEADER: Final = 1024
"""Largest size of an array's header in a file [bytes]."""


def load_memory(memory: Any, path: Path) -> None:
    """Fill a new replay buffer from a file of a checkpoint.

    Raises:
        ValueError: the file is of a buffer of another size, or of another kind, or its numbers are not finite.
    """
    arrays = _arrays(memory)
    names = re.compile("|".join([*arrays, "pos", "full"]))
    stored = arrays_of(path, names, sum(array.nbytes + HEADER for array in arrays.values()) + 4 * HEADER)
    pos, full = int(stored["pos"]), bool(stored["full"])
    if not 0 <= pos < memory.buffer_size:
        raise ValueError(f"pos is {pos}; it must be from 0 to {memory.buffer_size - 1}")
    for name, array in arrays.items():
        rows, values = array[: None if full else pos], stored[name]
        if (values.shape, values.dtype) != (rows.shape, rows.dtype):
            raise ValueError(f"{name} is {values.dtype} {values.shape}; it must be {rows.dtype} {rows.shape}")
        if not np.isfinite(values).all():
            raise ValueError(f"{name} has numbers that are not finite")
        rows[:] = values
    memory.pos, memory.full = pos, full


def _arrays(memory: Any) -> dict[str, NDArray[Any]]:
    """Arrays of a replay buffer by name; of one for pictures beside vectors, those in its dictionaries too."""
    parts = {name: value for name, value in vars(memory).items() if isinstance(value, dict)}
    inner = {f"{name}_{key}": array for name, part in parts.items() for key, array in part.items()}
    return {name: value for name, value in {**vars(memory), **inner}.items() if isinstance(value, np.ndarray)}


def save_random(model: BaseAlgorithm, path: Path) -> None:
    """Write the state of every random generator of a training as JSON."""
    import torch  # noqa: PLC0415 - a second to import

    name, words, *position = np.random.get_state()  # noqa: NPY002 - the generator that stable-baselines3 draws from
    state = {
        "torch": torch.get_rng_state().tolist(),
        "numpy": [name, np.asarray(words).tolist(), *position],
        "python": random.getstate(),
        "actions": model.action_space.np_random.bit_generator.state,
    }
    path.write_text(json.dumps(state), encoding="utf-8")


def load_random(model: BaseAlgorithm, path: Path) -> None:
    """Set every random generator to the state that `save_random` has written."""
    import torch  # noqa: PLC0415 - as above

    state = json_of(path)
    torch.set_rng_state(torch.tensor(state["torch"], dtype=torch.uint8))
    np.random.set_state(tuple(state["numpy"]))  # noqa: NPY002 - as above
    version, words, gauss = state["python"]
    random.setstate((version, tuple(words), gauss))
    model.action_space.np_random.bit_generator.state = state["actions"]


ARGUMENTS = ("env", "level", "algo", "steps", "seed", "num_envs", "action_mode", "checkpoint_every")
LATER = {
    "fidelity": "full", "full_last": 0, "stack": 1, "over": "analytic", "eval_picks": None, "tensorboard": False
}  # fmt: skip
"""Arguments that older run folders lack, with the values of those runs; None for the default of the kind of trial."""
WHOLE: Final = {
    "steps": RANGES["n_timesteps"],
    "num_envs": RANGES["n_envs"],
    "checkpoint_every": RANGES["n_timesteps"],
    "full_last": (0, RANGES["n_timesteps"][1]),
    "seed": (0, 2**32 - 1),
    "stack": (1, MAX_STACK),
    "eval_picks": (0, 10**9),
}
"""Ranges of the arguments that are whole numbers."""
FLAGS = ("tensorboard",)
"""Arguments that are true or false; the arguments that are neither flags nor whole numbers are text."""
POLICY, MODEL, MEMORY, RANDOM = "policy.npz", "model.zip", "replay_buffer.npz", "random.json"


@final
class RunFolder:
    """A run folder; its files are read on access.

    Args:
        path: the folder; reading from a folder that does not exist raises a UsageError.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def create(
        cls,
        path: Path,
        arguments: Mapping[str, Any],
        settings: Mapping[str, Any],
        config: LevelConfig,
        model: BaseAlgorithm,
    ) -> Self:
        """Write a new run folder with its checkpoint 0.

        Raises:
            UsageError: the folder is not empty, or cannot be written.
        """
        check(path)
        sweep(path.parent)
        parts = cls(temporary_path(path))
        try:
            shutil.rmtree(parts.path, ignore_errors=True)
            parts.path.mkdir(parents=True)
            parts._describe(arguments, settings, config)
            parts.save(model)
            if path.is_dir():
                path.rmdir()  # empty, or `check` would have refused
            parts.path.rename(path)
        except OSError as error:
            raise UsageError(f"cannot write run folder {str(path)!r}: {error.strerror}") from None
        finally:
            shutil.rmtree(parts.path, ignore_errors=True)
        return cls(path)

    def _describe(self, arguments: Mapping[str, Any], settings: Mapping[str, Any], config: LevelConfig) -> None:
        """Write arguments, hyperparameters, level, versions and command line of a new run."""
        self.write(arguments)
        write_text(self.path / "config.yml", yaml_text({arguments["env"]: dict(settings)}))
        write_text(self.path / "env.yaml", yaml_text(config.model_dump(mode="json")))
        write_json(self.path / "versions.json", versions())
        write_text(self.path / "command.txt", " ".join(sys.argv) + "\n")
        state = git_state()
        if state is not None:
            write_text(self.path / "git.txt", state)

    @contextmanager
    def remove_on_error(self) -> Generator[None, None, None]:
        """Remove a new folder if an error ends the block before the first leg is done, to free its name."""
        try:
            yield
        except Exception:
            if len(self.checkpoints) == 1:
                shutil.rmtree(self.path.rename(temporary_path(self.path)))
            raise

    def write(self, arguments: Mapping[str, Any]) -> None:
        """Write the arguments of the run; a resumed run may get more throws."""
        write_text(self.path / "args.yml", yaml_text(dict(arguments)))

    @property
    def arguments(self) -> dict[str, Any]:
        """Arguments of the run; args.yml is read again only after a change.

        Raises:
            UsageError: there is no such run folder, or the folder is damaged.
        """
        file = self.path / "args.yml"
        if not self.path.is_dir():
            raise UsageError(f"run folder {str(self.path)!r} does not exist")
        if not file.is_file():
            raise UsageError(f"{str(self.path)!r} is not a run folder: it has no args.yml")
        return dict(_arguments(self.path, stamp(file)))

    @property
    def checkpoints(self) -> list[Path]:
        """Folders of the checkpoints from first to last."""
        place = self.path / "checkpoints"
        return sorted(p for p in place.iterdir() if p.name.isdigit()) if place.is_dir() else []

    def actor(self, checkpoint: Path | None = None) -> Actor:
        """Read the newest policy, or the policy of a checkpoint, of a run that corrects throws.

        Raises:
            UsageError: the folder or its policy is missing or damaged, or the policy does not correct throws.
        """
        arguments = self.arguments
        if arguments["algo"] in MASKED:
            reason = f"is of a policy that chooses; it is for --env {arguments['env']}"
            raise UsageError(f"run folder {str(self.path)!r} {reason}")
        return Actor.load(self.policy_file(checkpoint))

    def load_policy(self, checkpoint: Path | None = None) -> Actor | Scorer:
        """Read the newest policy, or the policy of a checkpoint, of a run that corrects throws or chooses objects.

        Raises:
            UsageError: the folder or its policy is missing or damaged.
        """
        kind = Scorer if self.arguments["algo"] in SCORING else Actor
        return kind.load(self.policy_file(checkpoint))

    def policy_file(self, checkpoint: Path | None = None) -> Path:
        """File of the newest policy, or of the policy of a checkpoint.

        Raises:
            UsageError: the file is missing.
        """
        file = (checkpoint or self.path) / POLICY
        if not file.is_file():
            old = f"; before 0.2.0 none was written: its {MODEL} can be used with --trust"
            raise _error(self.path, f"{POLICY} is missing{old if (self.path / MODEL).is_file() else ''}")
        return file

    def load(self, env: VecEnv | None = None, checkpoint: Path | None = None) -> BaseAlgorithm:
        """Read the newest model, or the model of a checkpoint, which can go on learning.

        Raises:
            UsageError: the folder or its model is missing or damaged.
        """
        from . import sb3  # noqa: PLC0415 - imports torch

        arguments = self.arguments
        settings = hyperparameters(arguments["algo"], arguments["env"], self.path / "config.yml")
        file = (checkpoint or self.path) / MODEL
        if not file.is_file():
            raise _error(self.path, f"{MODEL} is missing")
        return sb3.load(file, arguments, settings, env)

    def save(self, model: BaseAlgorithm) -> None:
        """Write policy, model, memory and random state as a new checkpoint, and make it the newest of the run.

        Raises:
            UsageError: the policy cannot be written as arrays.
        """
        from ..policies import weights  # noqa: PLC0415 - imports torch

        actor = weights.actor(model)
        place = self.path / "checkpoints" / f"{model.num_timesteps:08d}"
        sweep(place.parent)
        parts = temporary_path(place)
        shutil.rmtree(parts, ignore_errors=True)
        parts.mkdir(parents=True)
        actor.save(parts / POLICY)
        model.save(parts / MODEL)
        if getattr(model, "replay_buffer", None) is not None:
            memory: Any = model.replay_buffer  # type: ignore[attr-defined]
            rows: dict[str, Any] = {name: array[: memory.size()] for name, array in _arrays(memory).items()}
            np.savez(parts / MEMORY, pos=memory.pos, full=memory.full, **rows)
        save_random(model, parts / RANDOM)
        shutil.rmtree(place, ignore_errors=True)
        parts.rename(place)
        self._renew()

    def _renew(self) -> None:
        """Copy the files of the last checkpoint to the run folder, also after a kill between writing and copying."""
        *earlier, last = self.checkpoints
        for name in (POLICY, MODEL, MEMORY):
            if (last / name).is_file():
                replace_file(self.path / name, partial(shutil.copyfile, last / name))
        # Only the last checkpoint can be continued; earlier ones keep their policy.
        for old in earlier:
            (old / MEMORY).unlink(missing_ok=True)

    def restore(self, env: VecEnv) -> BaseAlgorithm:
        """Read the model of the last checkpoint with its memory and random state, ready to go on.

        Raises:
            UsageError: the folder is missing or damaged.
        """
        checkpoints = self.checkpoints
        if not checkpoints:
            raise _error(self.path, "it has no checkpoint")
        last = checkpoints[-1]
        model = self.load(env, last)
        try:
            if getattr(model, "replay_buffer", None) is not None:
                load_memory(model.replay_buffer, last / MEMORY)  # type: ignore[attr-defined]
            load_random(model, last / RANDOM)
        except Exception as error:
            # A truncated or foreign file may raise anything.
            raise _error(self.path, f"checkpoint {last.name} is truncated, or of another version") from error
        if int(last.name) != model.num_timesteps:
            raise _error(self.path, f"checkpoint {last.name} is of another throw")
        self._renew()
        sweep(last.parent)
        return model


@lru_cache(maxsize=8)
def _arguments(folder: Path, _stamp: tuple[int, ...]) -> Mapping[str, Any]:
    """Read args.yml of a folder, once for each stamp of the file."""
    data = read_yaml(folder / "args.yml", f"run folder {str(folder)!r} is damaged:")
    if isinstance(data, dict):
        data = {**LATER, **data}
    missing = [name for name in ARGUMENTS if not isinstance(data, dict) or name not in data]
    if missing:
        raise _error(folder, f"args.yml lacks {', '.join(missing)}")
    for name in (*ARGUMENTS, *LATER):
        if not _fits(name, data[name]):
            valid = "from {:,} to {:,}".format(*WHOLE[name]) if name in WHOLE else "text"
            valid = "true or false" if name in FLAGS else valid
            raise _error(folder, f"args.yml has {name} {one_sentence(repr(data[name]), 80)}; it must be {valid}")
    if data["algo"] not in (*RESIDUAL, *MASKED):
        raise _error(folder, f"args.yml has algo {one_sentence(repr(data['algo']), 80)}")
    return data


def _fits(name: str, value: object) -> bool:
    """Whether a value is one that an argument of a run can have."""
    if value is None:
        return LATER.get(name, "") is None
    if name in FLAGS or isinstance(value, bool):
        return name in FLAGS and isinstance(value, bool)
    if name not in WHOLE:
        return isinstance(value, str)
    return isinstance(value, int) and WHOLE[name][0] <= value <= WHOLE[name][1]


def _error(folder: Path, reason: str) -> UsageError:
    """Error of a damaged run folder."""
    return UsageError(f"run folder {str(folder)!r} is damaged: {reason}")


def check(folder: Path) -> None:
    """Make sure that the folder of a new run is empty or does not exist.

    Raises:
        UsageError: there is a file, or a folder that is not empty.
    """
    if folder.is_file() or (folder.is_dir() and any(folder.iterdir())):
        raise UsageError(f"{str(folder)!r} exists already; choose another --out, or continue it with --resume")


def name(run_args: Mapping[str, Any], level: object) -> str:
    """Name of a run's folder, from the run's arguments and level; the name has no path separators.

    Raises:
        UsageError: the name is no valid file name.
    """
    env_id = run_args["env"].rpartition(":")[2].replace("/", "-")  # Gymnasium's ids may have a namespace
    name = f"{env_id}-{level}-{run_args['algo']}-seed{run_args['seed']}"
    if not isinstance(level, str) or Path(name).name != name or not name.isprintable():
        raise UsageError(f"level {level!r} of environment {run_args['env']!r} has a name that no folder can have")
    return name
