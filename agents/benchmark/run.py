"""Computing one piece of the benchmark: learn, carry out the held-out throws or work shifts, and return them all."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from pnt_gym.errors import PntGymError
from pnt_gym.reading import MOST_NUMBERS, bytes_of

from ..controllers import Learner
from ..controllers.protocol import Controller, SeparateControllers
from ..controllers.state import load_state
from ..ground.cli import UsageError
from ..ground.parcel import arithmetic, torch_arithmetic
from ..ground.work import Job
from ..judging.trial import Trial
from ..judging.trials import open_trial
from ..learning.runs import POLICY, RunFolder
from ..results.digests import bytes_digest, level_digest, policy_digest
from ..results.entries import TRAINED, computes_with_torch, labels_of, settings_of
from ..results.plan import Piece, entry_controller
from .stored import POLICIES, STORED_FROM, Stored, state_bytes, store

ControllerFactory: TypeAlias = Callable[[str, Trial], Controller]
"""Returns the trained controller of a name for the trial that evaluates it."""


class Lesson(NamedTuple):
    """A controller that has learned, or need not.

    Attributes:
        throws: number of throws that the controller learned from.
        seconds: time of learning.
        make_controller: returns the controller for a trial.
        policy: digest of the controller; None if each controller of a name has one of its own.
        content: returns the content of a file of the policy; None if the policy cannot be stored.
    """

    throws: int
    seconds: float
    make_controller: ControllerFactory
    policy: str | None = None
    content: Callable[[], bytes] | None = None


def jobs(planned: Iterable[Piece]) -> list[Job]:
    """Pieces of a plan as jobs that processes do side by side."""
    return [Job(piece.name, piece.key, partial(run_piece, piece), piece.cost) for piece in planned]


def run_piece(piece: Piece, folder: Path, stored: Stored | None = None) -> dict[str, Any]:
    """Results of a piece of work, and the policies that took long to learn.

    Args:
        piece: the piece of work.
        folder: a training keeps its run folder below this folder and goes on from there.
        stored: policy with which to throw instead of learning one.
    """
    plan, entry = piece.plan, piece.entry
    results: list[dict[str, Any]] = []
    policies: dict[str, str] = {}
    names = list(zip(labels_of(entry), (entry.controller, *entry.also), strict=True))
    for lesson in _learn(piece, folder) if stored is None else [_recall(piece, folder, stored)]:
        for level, (label, name) in product(piece.levels, names):
            with closing(_trial(piece, level)) as trial:
                count = plan.count_of(type(trial), level, entry)
                controller = lesson.make_controller(name, trial)
                policy = lesson.policy or policy_digest(name, controller)
                record = trial.run(controller, count, plan.seed, online=entry.online)
                digests = {"policy": policy, "level": level_digest(trial.core.config), **_origin(piece, stored)}
            head = {"label": label, "controller": name, "throws": lesson.throws, "seed": piece.seed}
            details = {"level": level, "train_level": piece.train_level, "learn_seconds": lesson.seconds}
            results.append({**head, **details, "digests": digests, "columns": record.columns()})
            if lesson.content is not None and (name in TRAINED or lesson.seconds >= STORED_FROM):
                store(policies, policy, lesson.content())
    return {"results": results, POLICIES: policies}


def _origin(piece: Piece, stored: Stored | None) -> dict[str, str]:
    """Digest of the code, and fingerprints of the arithmetic that throws depend on: a stored policy fits nothing."""
    origins = {"code": piece.code, "arithmetic": arithmetic()}
    return {**origins, "torch": torch_arithmetic()} if stored is None and computes_with_torch(piece.entry) else origins


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
        content = partial(state_bytes, controller) if isinstance(controller, Learner) else None
        yield Lesson(piece.throws[0], seconds, partial(_transfer, controller, piece), content=content)
    else:  # the controller that a search returns acts on every level alike
        yield Lesson(piece.throws[0], seconds, lambda name, trial: learner)


@contextmanager
def _pupil(piece: Piece) -> Generator[tuple[Controller, Trial], None, None]:
    """The controller of a piece before its practice, and the trial in which the controller practises."""
    with closing(_trial(piece, piece.train_level, piece.entry.practice_envs)) as trial:
        controller = entry_controller(trial, piece.entry, piece.entry.controller)
        controller.reset(piece.seed)
        yield controller, trial


def _recall(piece: Piece, folder: Path, stored: Stored) -> Lesson:
    """The lesson of a policy that is stored, so that nothing has to be learned.

    Raises:
        UsageError: the policy is damaged, or of another controller.
    """
    file, is_training = folder / POLICY, piece.entry.controller in TRAINED
    file.write_bytes(stored.content)
    try:
        make_controller = _recall_training(piece, folder) if is_training else _restore(piece, file)
    except PntGymError as error:
        reason = str(error).replace(f"run folder {str(folder)!r}", "it").replace(repr(str(file)), "it")
        raise UsageError(f"the stored policy cannot be used: {reason}") from None
    policy = bytes_digest(stored.content) if is_training else None
    return Lesson(stored.throws, 0.0, make_controller, policy)


def _recall_training(piece: Piece, folder: Path) -> ControllerFactory:
    """The controllers of a training whose policy lies in a folder."""
    run = RunFolder(folder)
    with closing(_trial(piece, piece.train_level)) as trial:
        run.write_arguments({**_training_arguments(piece, trial), "action_mode": trial.core.action_mode})
        make_controller = partial(_checkpoint_policy, run, None, run.arguments)
        make_controller(piece.entry.controller, trial)  # a damaged policy is named before the first throw
    return make_controller


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
        run_args = _training_arguments(piece, trial)
        with closing(Session(trial, run_args, trial.hyperparameters(run_args, settings), threads=1)) as session:
            model = run.restore(session.env) if run.checkpoints else session.create(run.path)[1]
            for throws in piece.throws:
                began = time.perf_counter()
                if model.num_timesteps < throws:
                    session.learn(model, run, Stop(), checkpoint_every=throws, until=throws, quiet=True)
                seconds = round(time.perf_counter() - began, 1)
                place = next(p for p in run.checkpoints if int(p.name) >= throws)
                content = bytes_of(run.policy_file(place), MOST_NUMBERS)
                make_controller = partial(_checkpoint_policy, run, place, session.run_args)
                yield Lesson(throws, seconds, make_controller, bytes_digest(content), lambda content=content: content)


def _training_arguments(piece: Piece, trial: Trial) -> dict[str, Any]:
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


def _checkpoint_policy(
    run: RunFolder, place: Path | None, run_args: dict[str, Any], name: str, trial: Trial
) -> Controller:
    """Policy of a training, or of a checkpoint of it, as a controller for an evaluation level."""
    return trial.policy(run, place, run_args, name)


def _transfer(controller: Controller, piece: Piece, name: str, trial: Trial) -> Controller:
    """Controller of an evaluation level with a trained controller's state; one per cell if all go on learning."""
    count = trial.env.num_envs if piece.entry.online else 1
    receivers = [_copy_knowledge(controller, piece, name, trial) for _ in range(count)]
    return SeparateControllers(receivers) if piece.entry.online else receivers[0]


def _copy_knowledge(controller: Controller, piece: Piece, name: str, trial: Trial) -> Controller:
    receiver = entry_controller(trial, piece.entry, name)
    receiver.reset(piece.seed)
    if isinstance(receiver, Learner) and isinstance(controller, Learner) and max(piece.throws) > 0:
        receiver.restore(controller.state())
    return receiver
