"""Computing one piece of the benchmark: learn, carry out the held-out throws or work shifts, and return them all."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from ..controllers import Learner
from ..controllers.apart import SeparateControllers
from ..controllers.protocol import Controller
from ..jobs.work import Job
from ..judging.trial import Trial
from ..judging.trials import open_trial
from ..learning.runs import RunFolder
from .digests import bytes_digest, level_digest, policy_digest
from .entries import TRAINED, labels_of, settings_of
from .plan import Piece, entry_controller

ControllerFactory: TypeAlias = Callable[[str, Trial], Controller]
"""Returns the trained controller of a name for the trial that evaluates it."""


class Lesson(NamedTuple):
    """A controller that has learned, or need not.

    Attributes:
        throws: number of throws that the controller learned from.
        seconds: time of learning.
        make_controller: returns the controller for a trial.
        policy: digest of the controller; None if each controller of a name has one of its own.
    """

    throws: int
    seconds: float
    make_controller: ControllerFactory
    policy: str | None = None


def jobs(planned: Iterable[Piece]) -> list[Job]:
    """Pieces of a plan as jobs that processes do side by side."""
    return [Job(piece.name, piece.key, partial(run_piece, piece), piece.cost) for piece in planned]


def run_piece(piece: Piece, folder: Path) -> dict[str, Any]:
    """Results of a piece of work; a training keeps its run folder below `folder` and goes on from there."""
    plan, entry = piece.plan, piece.entry
    results: list[dict[str, Any]] = []
    names = list(zip(labels_of(entry), (entry.controller, *entry.also), strict=True))
    for lesson in _learn(piece, folder):
        for level, (label, name) in product(piece.levels, names):
            with closing(_trial(piece, level)) as trial:
                count = plan.count_of(type(trial), level, entry)
                controller = lesson.make_controller(name, trial)
                policy = lesson.policy or policy_digest(name, controller)
                record = trial.run(controller, count, plan.seed, online=entry.online)
                digests = {"policy": policy, "level": level_digest(trial.core.config), "code": piece.code}
            head = {"label": label, "controller": name, "throws": lesson.throws, "seed": piece.seed}
            details = {"level": level, "train_level": piece.train_level, "learn_seconds": lesson.seconds}
            results.append({**head, **details, "digests": digests, "columns": record.columns()})
    return {"results": results}


def _trial(piece: Piece, level: str, count: int | None = None) -> Trial:
    place = piece.configs.get(level, piece.plan.level(level))
    return open_trial(piece.plan.env, place, count or piece.plan.num_envs, 1, piece.entry.action_mode)


def _learn(piece: Piece, folder: Path) -> Iterator[Lesson]:
    """A lesson for each number of throws of the piece."""
    if piece.entry.controller in TRAINED:
        yield from _train(piece, folder)
        return
    with closing(_trial(piece, piece.train_level, piece.entry.practice_envs)) as trial:
        controller = entry_controller(trial, piece.entry, piece.entry.controller)
        controller.reset(piece.seed)
        began = time.perf_counter()
        learner = trial.practise(controller, piece.throws[0], piece.seed)
        seconds = round(time.perf_counter() - began, 1)
    if learner is controller:
        yield Lesson(piece.throws[0], seconds, partial(_transfer, controller, piece))
    else:  # the controller that a search returns acts on every level alike
        yield Lesson(piece.throws[0], seconds, lambda name, trial: learner)


def _train(piece: Piece, folder: Path) -> Iterator[Lesson]:
    """Train, or resume training, and yield the policy at each count of throws or decisions."""
    from ..learning.progress import Stop  # noqa: PLC0415 - imports torch
    from ..training.session import Session  # noqa: PLC0415 - as above

    algo, entry, run = piece.entry.controller, piece.entry, RunFolder(folder / f"{piece.name}-{piece.key}-run")
    settings = settings_of(entry, piece.plan.env)
    run_args = {
        "env": piece.plan.env,
        "level": piece.train_level,
        "algo": algo,
        "steps": max(piece.throws),
        "seed": piece.seed,
        "checkpoint_every": max(piece.throws),
        **{name: getattr(entry, name) for name in ("stack", "over", "fidelity")},
    }
    with closing(_trial(piece, piece.train_level, settings.get("n_envs"))) as trial:
        run_args["num_envs"] = trial.env.num_envs
        with closing(Session(trial, run_args, trial.hyperparameters(run_args, settings), threads=1)) as session:
            model = run.restore(session.env) if run.checkpoints else session.create(run.path)[1]
            for throws in piece.throws:
                began = time.perf_counter()
                if model.num_timesteps < throws:
                    session.learn(model, run, Stop(), checkpoint_every=throws, until=throws, quiet=True)
                seconds = round(time.perf_counter() - began, 1)
                place = next(p for p in run.checkpoints if int(p.name) >= throws)
                policy = bytes_digest(run.policy_file(place).read_bytes())
                yield Lesson(throws, seconds, partial(_checkpoint_policy, run, place, session.run_args), policy)


def _checkpoint_policy(run: RunFolder, place: Path, run_args: dict[str, Any], name: str, trial: Trial) -> Controller:
    """Policy of a training's checkpoint as a controller for an evaluation level."""
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
