"""Judging: one controller in an environment, or several controllers on the same held-out units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import gymnasium as gym

from ..controllers.protocol import Controller, Learner
from ..ground.amounts import NUM_ENVS
from ..ground.cli import UsageError, at_least
from ..ground.environments import Env, as_vector, make_vector
from ..ground.tables import throws_bar
from .loop import Progress
from .record import Record, Row
from .trial import Trial
from .trials import trial_of


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
    """Judge a policy on held-out objects; return the figures and throws that `agents.evaluate --json` writes.

        def policy(observations):  # (N, D) to actions (N, A) within [-1, 1]; zero is the planner's own throw
            return np.zeros((len(observations), 2))

        print(evaluate(policy, "PnTConveyor-v0", 200)["success_rate"])

    Args:
        policy: such a function, a controller or a model of stable-baselines3, each taken as it is; the class of a
            controller; or the name of one as `--controller` takes it, which practises first.
        env: an id, or MODULE:ID; a single environment, wrapped or not; or a vector environment with SAME_STEP
            autoreset. Its number of rows is part of what the seed means: 16 for an id unless `num_envs` says otherwise,
            1 for a single environment.
        picks: throws to count, at least 1, or work shifts of a line; None for 32 of those, for 200 throws, or for a
            whole episode of every row where what a throw teaches pays later in it.
        seed: of the objects; no training or practice with any seed sees these objects.
        practice: throws before for one that learns; None for 120 if `policy` is a name that knows nothing, else none.
        online: go on learning during the evaluation.
        trust: run the code in an RL-Zoo folder or a model.zip that `policy` names.
        progress: told after each batch whether it was "practice" or "evaluation", and how many throws or shifts.
        options: level, action_mode, num_envs and threads of an id, see `make_vector`.

    Returns:
        Figures by name, and `throws`, a mapping for each throw.

    Raises:
        UsageError: no such policy or environment, two that do not fit, or no throws.
        MetricError: the landing of no throw is known.
    """
    at_least({"picks": picks, "seed": seed}, picks=1, seed=0)
    if options and not isinstance(env, str):
        raise UsageError(f"{next(iter(options))} is settled by the environment; it goes with an id only")
    cells = make_vector(env, **{"num_envs": NUM_ENVS, **options}) if isinstance(env, str) else as_vector(env)
    try:
        trial, tell = trial_of(cells), progress or (lambda name, count: None)
        controller = trial.controller(policy, trust=trust)
        if isinstance(policy, str | type):
            controller.reset(seed)
        usual = trial.practice(controller) if isinstance(policy, str) and practice is None else practice or 0
        steps = usual if isinstance(controller, Learner) else 0
        controller = trial.practise(controller, steps, seed, progress=partial(tell, "practice"))
        count = trial.count() if picks is None else picks
        record = trial.run(controller, count, seed, online=online, progress=partial(tell, "evaluation"))
        return {
            "env": env if isinstance(env, str) else _name(cells),
            "controller": policy if isinstance(policy, str) else controller.name,
            "level": trial.core.config.name,
            "seed": seed,
            "practice": steps,
            **record.report(),
        }
    finally:
        if isinstance(env, str):
            cells.close()


def judge(
    trial: Trial, controller: Controller, count: int, seed: int, *, practice: int = 0, online: bool = False
) -> Record:
    """Let a controller practise, and judge it, with a progress bar for each.

    Args:
        trial: of the environment.
        controller: already reset.
        count: number of held-out units.
        seed: names the units.
        practice: number of steps of the practice.
        online: go on learning during the evaluation.
    """
    with throws_bar() as bar:
        if practice:
            advance = partial(bar.advance, bar.add_task("practice", total=practice))
            controller = trial.practise(controller, practice, seed, progress=advance)
        advance = partial(bar.advance, bar.add_task("evaluation", total=count))
        return trial.run(controller, count, seed, online=online, progress=advance)


def compare(
    trial: Trial,
    entries: Sequence[tuple[str, Controller, int]],
    count: int,
    seed: int,
    *,
    practice_seed: int | None = None,
    progress: Callable[[str], Progress] | None = None,
) -> list[Row]:
    """Let several controllers do the same held-out units.

    Args:
        trial: of the environment.
        entries: label of each controller, the controller, and the number of steps that it has learned from.
        count: number of units.
        seed: names the units.
        practice_seed: of the practice, in which controllers that learn do that number of steps first; None for
            controllers that have already learned from them.
        progress: gives what is called with the number of units just done, by label.

    Returns:
        A row for each controller, as `Record.comparison` takes them.
    """
    rows: list[Row] = []
    for label, controller, steps in entries:
        judged = controller if practice_seed is None else trial.practise(controller, steps, practice_seed)
        record = trial.run(judged, count, seed, progress=None if progress is None else progress(label))
        rows.append((label, steps, record.summary()))
    return rows


def _name(env: Any) -> str:
    """Id of an environment that was handed over, or of the one in its first row."""
    inner = env.unwrapped.envs[0] if hasattr(env.unwrapped, "envs") else env
    return type(inner.unwrapped).__name__ if inner.spec is None else inner.spec.id
