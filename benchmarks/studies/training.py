"""What learning from flights costs and saves, judged in the full physics."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Final, NamedTuple

import torch

from agents.controllers import make_controller
from agents.controllers.between import PLANNER
from agents.controllers.own import run_policy
from agents.controllers.protocol import Controller
from agents.ground.cli import NUM_ENVS
from agents.ground.environments import Env, core_of, make_vector
from agents.judging.loop import practise, throw_held_out
from agents.judging.throw_record import summary
from agents.learning.hyperparameters import hyperparameters
from agents.learning.progress import Stop
from agents.learning.runs import RunFolder
from agents.learning.sb3 import build
from agents.learning.vec_env import SameStepVecEnv
from agents.learning.windows import ThrowWindow
from agents.results.study import Amount, Figures, Settings
from agents.training.session import learn

ENV: Final = "PnTRelease-v0"


class Lesson(NamedTuple):
    """What is learned from, and how it is judged.

    Attributes:
        full: cells in the full physics.
        flight: the same cells in flights alone.
        share: of the throws that are flights, the first ones.
        seed: of the learning.
        amount: throws by which a policy is judged.
    """

    full: Env
    flight: Env
    share: float
    seed: int
    amount: Amount


def figures(settings: Settings, amount: Amount) -> list[Figures]:
    """What a learner is worth after each number of throws.

    Seconds are processor time of learning alone, with 16 cells on one core, so that what else the machine does is not
    in them.

    Args:
        settings: `level`, `learner`, `seed`, the `share` of the throws that are flights, and `marks`: the numbers of
            throws by learner and, where the physics changes on the way, under `changing`.
        amount: held-out throws.
    """
    torch.set_num_threads(1)
    level, share, learner = settings["level"], settings["share"], settings["learner"]
    marks = settings["marks"][learner]
    marks = [mark for mark in marks if mark <= settings["most"] * (2 if share == 1.0 else 1)]
    with (
        closing(make_vector(ENV, level, NUM_ENVS, 1)) as full,
        closing(make_vector(ENV, {**level, "fidelity": "flight"}, NUM_ENVS, 1)) as flight,
    ):
        lesson = Lesson(full, flight, share, settings["seed"], amount)
        if learner == "sac" and share not in (0.0, 1.0):
            ends = [mark for mark in settings["changing"] if mark <= settings["most"]]
            # A training that changes its physics is judged when it is over, so each length is one of its own.
            return [list(_sac(lesson, [round(share * end), end]))[-1] for end in ends]
        return list(LEARNERS[learner](lesson, marks))


def _worth(controller: Controller, lesson: Lesson) -> Figures:
    """What a controller is worth in the full physics; lengths in m."""
    worth = summary(throw_held_out(controller, lesson.full, lesson.amount.throws, lesson.amount.seed))
    return {name: worth[name] for name in ("landing_error_mean_m", "success_rate", "sorted_per_min")}


def _sac(lesson: Lesson, marks: list[int]) -> Iterator[Figures]:
    """One training, judged at each mark."""
    env, window, seconds = SameStepVecEnv(lesson.full), ThrowWindow(), 0.0
    core = core_of(lesson.full)
    run_args = {"env": ENV, "level": core.config.name, "algo": "sac", "seed": lesson.seed, "num_envs": NUM_ENVS}
    run_args |= {"steps": marks[-1], "checkpoint_every": 2 * marks[-1], "action_mode": core.action_mode}
    run_args |= {"stack": 1, "over": PLANNER}
    with tempfile.TemporaryDirectory() as place:
        folder, settings = Path(place) / "run", hyperparameters("sac", ENV)
        model = build("sac", env, settings, lesson.seed)
        run = RunFolder.create(folder, run_args, settings, core.config, model)
        for mark in marks:
            quick = lesson.flight if mark <= lesson.share * marks[-1] else None
            began = time.process_time()
            learn(model, env, run, {**run_args, "steps": mark}, Stop(), window, quick=quick, quiet=True)
            seconds += time.process_time() - began
            policy = run_policy(run.actor(run.checkpoints[-1]), run_args, lesson.full, "sac")
            yield {"throws": mark, "seconds": seconds, **_worth(policy, lesson)}


def _mlp(lesson: Lesson, marks: list[int]) -> Iterator[Figures]:
    """Regressions, each from throws of its own."""
    for mark in marks:
        controller = make_controller("mlp", lesson.full)
        controller.reset(lesson.seed)
        flights = round(lesson.share * mark)
        began = time.process_time()
        practise(controller, lesson.flight, flights, lesson.seed)
        practise(controller, lesson.full, mark - flights, lesson.seed, start=flights)
        seconds = time.process_time() - began
        yield {"throws": mark, "seconds": seconds, **_worth(controller, lesson)}


LEARNERS: Final[dict[str, Callable[[Lesson, list[int]], Iterator[Figures]]]] = {"sac": _sac, "mlp": _mlp}
