"""Computing one piece of the benchmark: learn, carry out the held-out throws or work shifts, and return them all."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from functools import partial
from itertools import product
from pathlib import Path
from shutil import copyfile
from tempfile import TemporaryDirectory
from typing import Any, Final, NamedTuple, Self, TypeAlias

import numpy as np

from pnt_gym.errors import PntGymError
from pnt_gym.reading import MOST_NUMBERS, arrays_of, bytes_of

from ..controllers import Learner
from ..controllers.protocol import Controller, SeparateControllers
from ..controllers.state import STATE, load_state, save_state
from ..ground.archives import archive_of
from ..ground.cli import UsageError
from ..ground.files import check_form, json_text
from ..ground.work import Job
from ..judging.trial import Trial
from ..judging.trials import open_trial
from ..learning.runs import POLICY, RunFolder
from ..results import columns, content, entries
from ..results.entries import TRAINED, settings_of
from ..results.plan import Piece, entry_controller

ControllerFactory: TypeAlias = Callable[[str, Trial], Controller]
"""Returns the trained controller of a name for the trial that evaluates it."""
STORED_FROM: Final = 2000
"""Throws of learning from which the policy of a controller that is not trained is stored."""
LARGEST: Final = 400_000
"""Largest policy that is stored [bytes]: thirty larger ones would make a result as large as a repository."""


class Lesson(NamedTuple):
    """A controller that has learned, or need not.

    Attributes:
        throws: number of throws that the controller learned from.
        seconds: time of learning.
        make_controller: returns the controller for a trial.
        save: writes the policy to a file; None if the policy cannot be stored.
    """

    throws: int
    seconds: float
    make_controller: ControllerFactory
    save: Callable[[Path], object] | None = None


class Part(NamedTuple):
    """Results of a piece of work.

    Attributes:
        results: rows with all columns.
        policies: content of the policies that learned from many throws, by the names of their files.
        seconds: time that the piece took [s].
    """

    results: Sequence[content.Result]
    policies: Mapping[str, bytes]
    seconds: float

    def pack(self) -> bytes:
        """Content of a file that keeps the part until a result is written."""
        rows, decimals, tables = columns.without_columns(self.results)
        head = {"seconds": self.seconds, "decimals": decimals, "results": rows}
        files = {f"{content.POLICY} {name}": text for name, text in self.policies.items()}
        files["head"] = json_text(head).encode()
        return archive_of({**tables, **{name: np.frombuffer(text, np.uint8) for name, text in files.items()}})

    @classmethod
    def read(cls, file: Path) -> Self:
        """The part in a file.

        Raises:
            UsageError: the file is missing or damaged.
        """
        arrays = content.arrays(file, rf"head|{columns.TABLES}|{content.POLICY} .*")
        with check_form(file):
            head = json.loads(arrays.pop("head").tobytes())
            names = [name for name in arrays if name.startswith(content.POLICY)]
            policies = {name.removeprefix(f"{content.POLICY} "): arrays.pop(name).tobytes() for name in names}
            return cls(columns.with_columns(file, head["results"], arrays, head["decimals"]), policies, head["seconds"])


def jobs(planned: Iterable[Piece]) -> list[Job]:
    """Pieces of a plan as jobs that processes do side by side."""
    return [Job(piece.name, piece.key, partial(_packed, piece), piece.cost, "npz") for piece in planned]


def _packed(piece: Piece, folder: Path) -> bytes:
    return run_piece(piece, folder).pack()


def run_piece(piece: Piece, folder: Path, stored: bytes | None = None) -> Part:
    """Results of a piece of work, and the policies that learned from many throws.

    Args:
        piece: the piece of work.
        folder: a training keeps its run folder below this folder and goes on from there.
        stored: content of the file of a policy with which to throw instead of learning one.
    """
    began = time.perf_counter()
    results: list[dict[str, Any]] = []
    policies: dict[str, bytes] = {}
    for lesson in _learn(piece, folder) if stored is None else [_recall(piece, folder, stored)]:
        file = piece.policy_file(lesson.throws)
        policy = None if stored is not None else _policy(piece, lesson)
        policies |= {} if policy is None else {file: policy}
        results += _run(piece, lesson, {} if policy is None else {content.POLICY: file})
    return Part(results, policies, round(time.perf_counter() - began, 1))


def _run(piece: Piece, lesson: Lesson, details: Mapping[str, str]) -> Iterator[dict[str, Any]]:
    """Rows of the controllers of an entry after a lesson, one for each of them and each level."""
    plan, entry = piece.plan, piece.entry
    names = zip(entries.labels(entry), (entry.controller, *entry.also), strict=True)
    for level, (label, name) in product(piece.levels, list(names)):
        with closing(_trial(piece, level)) as trial:
            count = plan.count(type(trial), level, entry)
            record = trial.run(lesson.make_controller(name, trial), count, plan.seed, online=entry.online)
        head = {"label": label, "controller": name, "throws": lesson.throws, "seed": piece.seed}
        head |= {"level": level, "train_level": piece.train_level, "learn_seconds": lesson.seconds}
        yield {**head, **details, "columns": record.columns()}


def _policy(piece: Piece, lesson: Lesson) -> bytes | None:
    """Content of the file of a policy; None where few throws were learned from, or the file would be large."""
    if lesson.save is None or not (piece.entry.controller in TRAINED or lesson.throws >= STORED_FROM):
        return None
    with TemporaryDirectory() as folder:
        file = Path(folder) / POLICY
        lesson.save(file)
        policy = bytes_of(file, MOST_NUMBERS)
        return archive_of(arrays_of(file, STATE)) if len(policy) <= LARGEST else None


def _trial(piece: Piece, level: str, count: int | None = None) -> Trial:
    place = piece.configs.get(level, piece.plan.level(level))
    return open_trial(piece.plan.env, place, count or piece.plan.num_envs, 1, piece.entry.action_mode)


def _learn(piece: Piece, folder: Path) -> Iterator[Lesson]:
    """A lesson for each number of throws of the piece."""
    if piece.entry.controller in TRAINED:
        yield from _train(piece, folder)
        return
    with _pupil(piece) as (controller, trial):
        began = time.perf_counter()
        learner = trial.practise(controller, piece.throws[0], piece.seed)
        seconds = round(time.perf_counter() - began, 1)
    if learner is controller:
        save = partial(save_state, controller) if isinstance(controller, Learner) else None
        yield Lesson(piece.throws[0], seconds, partial(_transfer, controller, piece), save)
    else:  # the controller that a search returns acts on every level alike
        yield Lesson(piece.throws[0], seconds, lambda name, trial: learner)


@contextmanager
def _pupil(piece: Piece) -> Generator[tuple[Controller, Trial], None, None]:
    """The controller of a piece before its practice, and the trial in which the controller practises."""
    with closing(_trial(piece, piece.train_level, piece.entry.practice_envs)) as trial:
        controller = entry_controller(trial, piece.entry, piece.entry.controller)
        controller.reset(piece.seed)
        yield controller, trial


def _recall(piece: Piece, folder: Path, stored: bytes) -> Lesson:
    """The lesson of a policy that is stored, so that nothing has to be learned.

    Raises:
        UsageError: the policy is damaged, or of another controller.
    """
    file, is_training = folder / POLICY, piece.entry.controller in TRAINED
    file.write_bytes(stored)
    try:
        make_controller = _recall_training(piece, folder) if is_training else _restore(piece, file)
    except PntGymError as error:
        reason = str(error).replace(f"run folder {str(folder)!r}", "it").replace(repr(str(file)), "it")
        raise UsageError(f"the stored policy cannot be used: {reason}") from None
    return Lesson(piece.throws[0], 0.0, make_controller)


def _recall_training(piece: Piece, folder: Path) -> ControllerFactory:
    """The controllers of a training whose policy lies in a folder."""
    run = RunFolder(folder)
    with closing(_trial(piece, piece.train_level)) as trial:
        run.write({**_arguments(piece, trial), "action_mode": trial.core.action_mode})
        run_args = run.arguments
        trial.policy(run, None, run_args, piece.entry.controller)  # a damaged policy is named before the first throw
    return lambda name, trial: trial.policy(run, None, run_args, name)


def _restore(piece: Piece, file: Path) -> ControllerFactory:
    """The controllers that take over what lies in a file."""
    with _pupil(piece) as (controller, _):
        if not isinstance(controller, Learner):
            raise UsageError(f"controller {controller.name!r} learns nothing that could be stored")
        load_state(controller, file)
    return partial(_transfer, controller, piece)


def _train(piece: Piece, folder: Path) -> Iterator[Lesson]:
    """Train, or resume training, and yield the policy at each count of throws or decisions."""
    from ..learning.progress import Stop  # noqa: PLC0415 - imports torch
    from ..training.session import Session  # noqa: PLC0415 - as above

    run = RunFolder(folder / f"{piece.name}-{piece.key}-run")
    settings = settings_of(piece.entry, piece.plan.env)
    with closing(_trial(piece, piece.train_level, settings.get("n_envs"))) as trial:
        run_args = _arguments(piece, trial)
        with closing(Session(trial, run_args, trial.hyperparameters(run_args, settings), threads=1)) as session:
            model = run.restore(session.env) if run.checkpoints else session.create(run.path)[1]
            for throws in piece.throws:
                began = time.perf_counter()
                if model.num_timesteps < throws:
                    session.learn(model, run, Stop(until=throws), checkpoint_every=throws, quiet=True)
                seconds = round(time.perf_counter() - began, 1)
                place = next(p for p in run.checkpoints if int(p.name) >= throws)
                yield Lesson(
                    throws,
                    seconds,
                    lambda name, trial, place=place: trial.policy(run, place, session.run_args, name),
                    partial(copyfile, run.policy_file(place)),
                )


def _arguments(piece: Piece, trial: Trial) -> dict[str, Any]:
    """Arguments of a piece's training in the cells of a trial."""
    return {
        "env": piece.plan.env,
        "level": piece.train_level,
        "algo": piece.entry.controller,
        "steps": max(piece.throws),
        "seed": piece.seed,
        "checkpoint_every": max(piece.throws),
        "num_envs": trial.env.num_envs,
        **{name: getattr(piece.entry, name) for name in ("stack", "over", "fidelity")},
    }


def _transfer(controller: Controller, piece: Piece, name: str, trial: Trial) -> Controller:
    """Controller of an evaluation level with a trained controller's state; one per cell if all go on learning."""
    count = trial.env.num_envs if piece.entry.online else 1
    receivers = [_copy(controller, piece, name, trial) for _ in range(count)]
    return SeparateControllers(receivers) if piece.entry.online else receivers[0]


def _copy(controller: Controller, piece: Piece, name: str, trial: Trial) -> Controller:
    receiver = entry_controller(trial, piece.entry, name)
    receiver.reset(piece.seed)
    if isinstance(receiver, Learner) and isinstance(controller, Learner) and max(piece.throws) > 0:
        receiver.restore(controller.state())
    return receiver
