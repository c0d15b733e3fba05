"""Random cases: levels, actions, calls and command lines each with one right answer.

A case works, or is refused in one sentence by an error that pnt_gym or Gymnasium defines. Anything else is a find: any
other exception, a warning of the engine or of the arithmetic, a number that is none, a level that is taken and cannot
be thrown in.
"""

from __future__ import annotations

import contextlib
import copy
import pickle
import warnings
import zlib
from collections.abc import Callable
from functools import cache, partial
from typing import Any, Final

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import load_env_creator

import pnt_gym
from benchmarks.fuzz_cases.basis import JUNK, Draws, Find, Refused, find_simplest, finite, refusable
from benchmarks.fuzz_cases.changed import changed_case
from benchmarks.fuzz_cases.files import file_case, output_case
from benchmarks.fuzz_cases.formats import FORMATS
from benchmarks.fuzz_cases.infos import infos_case
from benchmarks.fuzz_cases.levels import hours_case, level_case
from benchmarks.fuzz_cases.lines import line_case
from pnt_gym.errors import ActionError


def judge_case(kind: str, draws: Draws) -> None:
    """Try a case.

    Raises:
        Find: it neither works nor is refused well.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        subject = KINDS[kind](draws)
    complaints = [str(w.message) for w in caught if not is_expected(w)]
    if complaints:
        raise Find(f"{subject}: warned {complaints[0]!r}")


def judge_cases(kind: str, number: int, count: int, before: Callable[[], object] = lambda: None) -> str | None:
    """What is wrong with the simplest of a number of cases of a kind in which something is; None where nothing is.

    Args:
        kind: one of `KINDS`.
        number: which cases; the same number gives the same cases.
        count: number of cases.
        before: what is called before each case.
    """

    def case(draws: Draws) -> None:
        before()
        judge_case(kind, draws)

    return find_simplest(case, zlib.crc32(f"{kind}:{number}".encode()), count)


def is_expected(warning: warnings.WarningMessage) -> bool:
    """Whether a warning is meant for the user: of pnt_gym in words, or of Gymnasium."""
    return issubclass(warning.category, UserWarning | DeprecationWarning) and "overflow" not in str(warning.message)


ENTRIES: Final = (*JUNK, 0.0, 1.0, -1.0, 1e-30, 5e-324, 1e30, 1e308, -1e308, 2.0)


@cache
def modes(env_id: str) -> tuple[str, ...]:
    """Action modes of an environment; those of a line have no name but one."""
    core = cell(env_id, None, 0).core
    return tuple(getattr(core, "action_sizes", (core.action_mode,)))


@cache
def cell(env_id: str, mode: str | None, count: int) -> Any:
    """An environment that is kept; single for a count of 0."""
    if count:
        return gym.make_vec(env_id, num_envs=count, action_mode=mode, threads=1).unwrapped
    return gym.make(env_id, action_mode=mode).unwrapped


def action_case(draws: Draws) -> str:
    """An action of any shape, type and value, and then a good action, which must throw."""
    env_id = draws.pick(pnt_gym.ENV_IDS)
    mode, count = draws.pick(modes(env_id)), draws.pick((0, 2))
    env = cell(env_id, mode, count)
    env.reset(seed=draws.integer(1000))
    action = any_action(draws, env.action_space.shape)
    subject = f"{env_id} {mode} {count} cells, action {action!r}"
    with contextlib.suppress(Refused), refusable(subject, ActionError):
        observation, reward, *_ = env.step(action)
        finite(subject, observation, reward)
    if draws.chance(0.2):
        observation, reward, *_ = env.step(np.zeros(env.action_space.shape, env.action_space.dtype))
        finite(subject, observation, reward)
    return subject


def any_action(draws: Draws, shape: tuple[int, ...]) -> Any:
    """An action of the right shape as a rule."""
    wrong_shapes = (shape[:-1], (*shape, 1), (1, *shape), (sum(shape[:1]) + 1, *shape[1:]), (0,), (), (3, 3, 3))
    chosen = shape if draws.chance(0.8) else draws.pick(wrong_shapes)
    kind = draws.pick(("numbers", "numbers", "numbers", "entries", "junk", "list"))
    if kind == "junk":
        return draws.pick(JUNK)
    if kind == "numbers":
        scale = draws.pick((1.0, 10.0, 1e10, 1e300, 1e-300))
        values = scale * draws.generator().uniform(-1.0, 1.0, chosen)
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return np.asarray(values).astype(draws.pick(("f8", "f4", "f2", "i8", "u1", "?", "c16", "O", "g", ">f8")))
    values = np.empty(chosen, dtype=object)
    for place in np.ndindex(*chosen):
        values[place] = draws.pick(ENTRIES) if draws.chance(0.4) else draws.number(-1.0, 1.0)
    return values.tolist() if kind == "list" else values


def calls_case(draws: Draws) -> str:
    """Calls in any order, some of them with anything."""
    env_id = draws.pick(pnt_gym.ENV_IDS)
    subject, calls = f"{env_id}:", list[str]()
    with contextlib.suppress(Refused), refusable(subject, TypeError):
        env, form = open_env(draws, env_id)
        subject += f" {form}"
    if "env" not in locals():
        return subject
    for _ in range(draws.integer(2, 7)):
        name = draws.pick(CALLS)
        with contextlib.suppress(Refused), refusable(f"{subject} {calls} {name}"):
            env, words = CALLS[name](draws, env)
            calls.append(f"{name}{words}")
            continue
        calls.append(f"{name} refused")
    with refusable(f"{subject} {calls} close"):
        env.close()
    return f"{subject} {calls}"


def open_env(draws: Draws, env_id: str) -> tuple[Any, str]:
    """An environment, made directly, with an argument that may be anything."""
    spec = gym.spec(env_id)
    entry = draws.pick((spec.entry_point, spec.vector_entry_point))
    form, arguments = load_env_creator(entry), dict[str, Any]()
    if draws.chance(0.3):
        names = ("level", "action_mode", "threads", "render_mode")
        names += ("num_envs",) if entry == spec.vector_entry_point else ()
        arguments[draws.pick(names)] = draws.pick(JUNK)
    return form(**arguments), f"{form.__name__}({arguments})"


def _reset(draws: Draws, env: Any) -> tuple[Any, str]:
    arguments: dict[str, Any] = {}
    if draws.chance(0.5):
        arguments["seed"] = draws.pick((*JUNK, 3, np.int64(3), np.array([1, 2]), [1, None], [1]))
    if draws.chance(0.3):
        options = (*JUNK, {}, {"reset_mask": np.array([True])}, {"reset_mask": [1]}, {"reset_mask": None}, {"a": 1})
        options += ({"item": 0}, {"item": "cork"}, {"target": 0}, {"target": draws.pick(JUNK)})
        arguments["options"] = draws.pick(options)
    observation, _ = env.reset(**arguments)
    finite("reset", observation)
    return env, f"({arguments})"


def _step(draws: Draws, env: Any) -> tuple[Any, str]:
    action = env.action_space.sample() if draws.chance(0.8) else any_action(draws, env.action_space.shape)
    observation, reward, *_ = env.step(action)
    finite("step", observation, reward)
    return env, ""


def _twice(env: Any) -> tuple[Any, str]:
    env.close()
    env.close()
    return env, ""


def _copy(draws: Draws, env: Any) -> tuple[Any, str]:
    return (copy.deepcopy(env) if draws.chance(0.5) else pickle.loads(pickle.dumps(env))), ""


CALLS: Final[dict[str, Callable[[Draws, Any], tuple[Any, str]]]] = {
    "reset": _reset,
    "step": _step,
    "step again": _step,
    "close": lambda _, env: _twice(env),
    "copy": _copy,
    "render": lambda _, env: (env if env.render_mode else env.render() or env, ""),
    "spec": lambda _, env: (env, f"{env.spec}"[:0]),
}


KINDS: Final[dict[str, Callable[[Draws], str]]] = {
    **{name: partial(changed_case, name) for name in FORMATS},
    "level": level_case,
    "action": action_case,
    "calls": calls_case,
    "line": line_case,
    "hours": hours_case,
    "file": file_case,
    "output": output_case,
    "infos": infos_case,
}
SHARES: Final = {
    "level": 0.22, "action": 0.24, "calls": 0.08, "line": 0.06, "hours": 0.02, "file": 0.06, "output": 0.01,
    "infos": 0.01, **dict.fromkeys(FORMATS, 0.30 / len(FORMATS)),
}  # fmt: skip
"""Of the cases of a whole."""
