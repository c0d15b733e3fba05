"""The one way a controller is judged: by training, the command line, the benchmark and the report alike.

The number of parallel environments is fixed and independent of the machine, so the same seed always means
the same objects; on PnTRelease-v0 they do not depend on the actions either, which pairs the throws of
different controllers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np

from pnt_gym.arrays import joined, take
from pnt_gym.cells.base.core import Core

from ..controllers import controller_of, make_controller
from ..controllers.adaptive import is_told
from ..controllers.own import Policy
from ..controllers.protocol import Controller, Learner, Observation, Outcome
from ..dispatchers.registry import line_controller, line_of, the_line
from ..ground.cli import UsageError, at_least
from ..ground.environments import Env, as_vector, core_of, make_vector, stream_seed
from ..ground.versions import versions
from .throws import Throws, purity_by_bin, summary, throw_records
from .work_shifts import SHIFTS, judged

NUM_ENVS = 16
PICKS = 200
PRACTICE = 120

Progress = Callable[[int], None]
"""Called with the number of throws just done."""


def evaluate(
    policy: Any,
    env: str | gym.Env[Any, Any] | Env,
    picks: int | None = None,
    seed: int = 0,
    *,
    practice: int | None = None,
    online: bool = False,
    trust: bool = False,
    progress: Callable[[str, int], None] | None = None,
    **options: Any,
) -> dict[str, Any]:
    """What a policy is worth on held-out objects: the figures and throws that `agents.evaluate --json` writes.

        def policy(observations):  # (N, D) to actions (N, A) within [-1, 1]; zero is the planner's own throw
            return np.zeros((len(observations), 2))

        print(evaluate(policy, "PnTConveyor-v0", 200)["success_rate"])

    Args:
        policy: such a function, a controller or a model of stable-baselines3, each taken as it is; the class of a
            controller; or the name of one as `--controller` takes it, which practises first.
        env: an id, or MODULE:ID; a single environment, wrapped or not; or a vector environment with SAME_STEP
            autoreset. Its number of rows is part of what the seed means: 16 for an id unless `num_envs` says otherwise,
            1 for a single environment.
        picks: throws to count, at least 1, or shifts of a line; None for 32 of those, for 200 throws, or for a whole
            episode of every row where what a throw teaches pays later in it.
        seed: names the objects; no training or practice with any seed sees them.
        practice: throws before for one that learns; None for 120 if `policy` is a name that knows nothing, else none.
        online: go on learning during the evaluation.
        trust: run the code in an RL-Zoo folder or a model.zip that `policy` names.
        progress: told after each batch whether it was "practice" or "evaluation", and how many throws.
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
        if line_of(cells) is not None:
            return {
                "env": env if isinstance(env, str) else _name(cells),
                **_worked(policy, cells, picks, seed, progress),
            }
        controller = _made(policy, cells, seed, trust)
        wanted = usual_practice(controller) if isinstance(policy, str) and practice is None else practice or 0
        practised = wanted if isinstance(controller, Learner) else 0
        tell = progress or (lambda name, count: None)
        practise(controller, cells, practised, seed, progress=partial(tell, "practice"))
        picks = usual_picks(cells) if picks is None else picks
        throws = held_out(controller, cells, picks, seed, online=online, progress=partial(tell, "evaluation"))
        head = {
            "env": env if isinstance(env, str) else _name(cells),
            "controller": policy if isinstance(policy, str) else controller.name,
        }
        return head | _told(seed, throws, cells, {"practice": practised, "online": online})
    finally:
        if isinstance(env, str):
            cells.close()


def _worked(
    policy: Any, env: Env, shifts: int | None, seed: int, progress: Callable[[str, int], None] | None
) -> dict[str, Any]:
    """What a controller of a line is worth: by name, as it is, or a function of observations that returns choices."""
    core = the_line(env)
    worker = line_controller(policy, core) if isinstance(policy, str) else policy
    worker = worker if hasattr(worker, "act") else Policy(policy, "function", np.int64)
    worker.reset(seed)
    tell = None if progress is None else partial(progress, "evaluation")
    found = judged(worker, env, SHIFTS if shifts is None else shifts, seed, tell)
    return {"controller": policy if isinstance(policy, str) else worker.name, **found}


def usual_picks(env: Env) -> int:
    """Throws that are counted unless others are asked for: 200, or whole episodes where one throw teaches the next.

    Where throws are told of those before, only whole episodes are judged fairly.
    """
    core = core_of(env)
    return env.num_envs * core.cell.episode if is_told(core) else PICKS


def usual_practice(controller: Controller) -> int:
    """Throws from which a controller learns before it is judged, unless others are asked for: 120, or its own word."""
    return getattr(controller, "practice", PRACTICE)


def _told(seed: int, throws: Throws, env: Env, how: dict[str, Any]) -> dict[str, Any]:
    """The JSON contract, but for the names of environment and controller."""
    core = core_of(env)
    return {
        "level": core.config.name,
        "seed": seed,
        **summary(throws),
        **_bins(throws, core),
        "dwell_s": core.dwell,
        **how,
        "num_envs": env.num_envs,
        "action_mode": core.action_mode,
        "versions": versions(),
        "throws": throw_records(throws, core.item_names),
    }


def _bins(throws: Throws, core: Core) -> dict[str, Any]:
    """Purity of each bin that has a name, where the cell tells in which an object ended."""
    names = core.cell.target_names if "belongs" in throws.told else ()
    return {"purity_by_bin": purity_by_bin(throws, names)} if names else {}


def _made(policy: Any, env: Env, seed: int, trust: bool) -> Controller:
    controller = make_controller(policy, env, trust=trust) if isinstance(policy, str) else controller_of(policy, env)
    if isinstance(policy, str | type):
        controller.reset(seed)
    return controller


def _name(env: Any) -> str:
    """Id of an environment that was handed over, or of the one in its first row."""
    inner = env.unwrapped.envs[0] if hasattr(env.unwrapped, "envs") else env
    return type(inner.unwrapped).__name__ if inner.spec is None else inner.spec.id


def held_out(
    controller: Controller,
    env: Env,
    picks: int,
    seed: int,
    *,
    online: bool = False,
    progress: Progress | None = None,
) -> Throws:
    """Let a controller, as it is, throw `picks` held-out objects; the arguments are those of `evaluate`."""
    return _collect(thrown(controller, env, picks, stream_seed("evaluate", seed), learn=online), progress)


def practise(
    controller: Controller, env: Env, throws: int, seed: int, *, start: int = 0, progress: Progress | None = None
) -> None:
    """Let a controller that learns throw `throws` objects first; others, and 0 throws, do nothing.

    The number of rows of `env` is part of what the seed means. `start` throws with this seed are already behind the
    controller, so that others follow.
    """
    if not isinstance(controller, Learner) or throws == 0:
        return
    controller.begin_practice(throws)
    _collect(thrown(controller, env, throws, stream_seed("practice", seed, start), learn=True), progress)
    controller.end_practice()


def thrown(controller: Controller, env: Env, picks: int, env_seed: int, *, learn: bool = False) -> Iterator[Throws]:
    """Carry out throws and yield each batch of them; the last batch is cut to `picks` in all."""
    correction = core_of(env).correction
    errors = () if correction is None else correction.told
    features, info = env.reset(seed=env_seed)
    done = 0
    while done < picks:
        seen = observed(features, info.get("kind", np.zeros(env.num_envs)))
        action = controller.act(seen)
        features, reward, _, _, info = env.step(action)
        part = take(Throws.of(info, np.asarray(reward), errors), slice(picks - done))
        if learn:
            count = len(part)  # the last batch may hold more rows than were asked for
            seen = take(seen, slice(count))
            told = (part.error, part.is_success, part.cycle_time, part.clipped)
            controller.learn(Outcome(seen, action[:count], *told))
        done += len(part)
        yield part


def observed(features: Any, kind: Any) -> Observation:
    """Coming picks as a controller sees them, from what an environment returned and the `kind` of its info."""
    return Observation(np.array(features, dtype=np.float32), np.array(kind, dtype=np.int64))


def _collect(batches: Iterable[Throws], progress: Progress | None) -> Throws:
    parts: list[Throws] = []
    for part in batches:
        parts.append(part)
        if progress is not None:
            progress(len(part))
    return joined(parts)
