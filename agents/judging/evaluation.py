"""Evaluation of one controller in an environment, or of several controllers on the same held-out units."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from inspect import signature
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium as gym

from ..controllers import state
from ..controllers.protocol import Controller, Learner, learns
from ..controllers.state import save_state
from ..ground.cli import NUM_ENVS, UsageError, at_least, check_known
from ..ground.environments import OPTIONS, Env, as_vector, make_vector
from ..ground.outputs import deliver_text
from ..ground.tables import throws_bar
from . import trials
from .loop import Progress
from .record import Record, Row
from .recorder import Recorder
from .trial import Trial


def evaluate(
    policy: Any,
    env: str | gym.Env[Any, Any] | Env,
    picks: int | None = None,
    seed: int = 0,
    *,
    practice: int | None = None,
    online: bool = False,
    trust: bool = False,
    progress: Callable[[str, int], object] | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Evaluate a policy on held-out objects; return figures by name, and `throws`, a mapping for each throw.

    A policy may be a function:

        def policy(observations):  # (N, D) to actions (N, A) within [-1, 1]; zero is the planner's own throw
            return np.zeros((len(observations), 2))

        print(evaluate(policy, "PnTConveyor-v0", 200)["success_rate"])

    Args:
        policy: a function as above, a controller or a model of stable-baselines3, each used as it is; the class of a
            controller; or the name of a controller as `--controller` takes it, which practises first.
        env: an id, or MODULE:ID; a single environment, wrapped or not; or a vector environment with SAME_STEP
            autoreset. The objects depend on the seed and on the number of rows: 16 for an id unless `num_envs` is
            given, 1 for a single environment.
        picks: number of throws, at least 1, or of work shifts of a line; None for 32 work shifts, for 200 throws, or
            for a whole episode of every row where a throw teaches the policy something for later throws.
        seed: seed of the objects; no training or practice with any seed sees these objects.
        practice: practice throws of a learning controller; None for 120 if `policy` names an untrained one, else for 0.
        online: let the controller go on learning during the evaluation.
        trust: run the code in an RL-Zoo folder or a model.zip that `policy` names.
        progress: called after each batch with "practice" or "evaluation" and the number of throws or shifts.
        options: level, action_mode, num_envs and threads for an id, see `make_vector`.

    Raises:
        UsageError: there is no such policy or environment, the two do not fit, or no throws are asked for.
        MetricError: no landing was measured.
    """
    at_least({"picks": picks, "seed": seed}, picks=1, seed=0)
    with open_cells(env, options, signature(evaluate).parameters) as cells:
        trial, tell = trials.of(cells), progress or (lambda name, count: None)
        controller = trial.controller(policy, trust=trust)
        if isinstance(policy, str | type):
            controller.reset(seed)
        state.check(controller, practice=practice, online=online)
        usual = trial.practice(controller) if isinstance(policy, str) and practice is None else practice or 0
        steps = usual if learns(controller) else 0
        controller = trial.practise(controller, steps, seed, progress=partial(tell, "practice"))
        count = trial.count() if picks is None else picks
        record = trial.run(controller, count, seed, online=online, progress=partial(tell, "evaluation"))
        return {
            "env": env if isinstance(env, str) else env_name(cells),
            "controller": policy if isinstance(policy, str) else controller.name,
            "level": trial.core.config.name,
            "seed": seed,
            "practice": steps,
            **record.report(),
        }


@contextmanager
def open_cells(
    env: str | gym.Env[Any, Any] | Env, options: Mapping[str, Any], further: Iterable[str] = ()
) -> Generator[Env, None, None]:
    """Vector environment of an id, closed at the end, or of an environment that is made already.

    Args:
        env: the id or the environment.
        options: options of `make_vector` by name.
        further: names that the caller takes beside these options, for the error about an unknown name.

    Raises:
        UsageError: there is no such environment or option, or an environment with options is made already.
    """
    check_known("argument", options, (*OPTIONS, *further))
    if options and not isinstance(env, str):
        raise UsageError(f"{next(iter(options))} cannot change an environment that is made already; give it with an id")
    cells = make_vector(env, **{"num_envs": NUM_ENVS, **options}) if isinstance(env, str) else as_vector(env)
    try:
        yield cells
    finally:
        if isinstance(env, str):
            cells.close()


class Judgement(NamedTuple):
    """Record of an evaluation, the number of practice steps before the evaluation, and the conditions in words."""

    record: Record
    practice: int
    conditions: str


@dataclass(frozen=True)
class Learning:
    """What a controller learns around its evaluation."""

    practice: int | None = None
    """Number of practice steps before the evaluation; None for the usual number."""
    online: bool = False
    """Let the controller go on learning during the evaluation."""
    load: Path | None = None
    """File of a state that the controller begins with."""
    save: Path | None = None
    """File to which the learned state is saved."""


def judge(
    trial: Trial, controller: Controller, count: int, seed: int, learning: Learning, log: Path | None = None
) -> Judgement:
    """Let a controller practise, then evaluate it, with a progress bar for each.

    Args:
        trial: trial of the environment.
        controller: already reset.
        count: number of held-out units.
        seed: seed of the units.
        learning: what the controller learns before and during the evaluation.
        log: file of a log of the evaluated throws; None for no log.

    Raises:
        UsageError: the throws of the environment have no log; or practice, `online` or a file is given for a controller
            that does not learn, or the file does not fit this controller.
    """
    steps = state.steps(controller, trial.practice(controller), learning.practice, learning.load, learning.save)
    state.check(controller, online=learning.online)
    recorder = None if log is None else Recorder(trial.core)
    name = trial.core.config.name
    conditions = f"level {name}, {count} {trial.unit}, seed {seed}"
    conditions += f", after {steps} practice {trial.step}s" if steps else ""
    with throws_bar() as bar:
        judged = controller
        if steps:
            advance = partial(bar.advance, bar.add_task("practice", total=steps))
            judged = trial.practise(controller, steps, seed, progress=advance)
        advance = partial(bar.advance, bar.add_task("evaluation", total=count))
        judged = judged if recorder is None else recorder.watch(judged)
        record = trial.run(judged, count, seed, online=learning.online, progress=advance)
    if learning.save is not None and isinstance(controller, Learner):
        save_state(controller, learning.save)
    if recorder is not None and log is not None:
        deliver_text(log, recorder.text(seed, record))
    return Judgement(record, steps, conditions)


def evaluate_all(
    trial: Trial,
    entries: Sequence[tuple[str, Controller, int]],
    count: int,
    seed: int,
    *,
    practice_seed: int | None = None,
    progress: Callable[[str], Progress] | None = None,
) -> list[Row]:
    """Evaluate several controllers on the same held-out units.

    Args:
        trial: trial of the environment.
        entries: label of each controller, the controller, and the number of its practice or training steps.
        count: number of units.
        seed: seed of the units.
        practice_seed: seed of a practice of that number of steps; None for controllers that have already learned.
        progress: returns the callback for a label, which is called with the number of units just done.

    Returns:
        A row for each controller, as `Record.comparison` takes them.
    """
    rows: list[Row] = []
    for label, controller, steps in entries:
        judged = controller if practice_seed is None else trial.practise(controller, steps, practice_seed)
        record = trial.run(judged, count, seed, progress=None if progress is None else progress(label))
        rows.append((label, steps, record.summary()))
    return rows


def env_name(env: Any) -> str:
    """Id of an environment object, or of the environment in its first row; without a spec the name of its class."""
    inner = env.unwrapped.envs[0] if hasattr(env.unwrapped, "envs") else env
    return type(inner.unwrapped).__name__ if inner.spec is None else inner.spec.id
