"""Cases that nobody thought of: levels, actions, calls and command lines drawn by number, each with one right answer.

A case works, or is refused in one sentence by an error that pnt_gym or Gymnasium defines. Anything else is a find: any
other exception, a warning of the engine or of the arithmetic, a number that is none, a level that is taken and cannot
be thrown in.
"""

from __future__ import annotations

import contextlib
import copy
import json
import pickle
import warnings
import zlib
from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import gymnasium as gym
import numpy as np
import yaml

import pnt_gym
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.envs import conveyor, gripper, one_joint
from pnt_gym.errors import ActionError, PntGymError
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD
from pnt_gym.robots.gripper.geometry import PROTOTYPE
from tests.tools.fuzz_lines import tried_line

Random = np.random.Generator
CONFIGS: Final[dict[str, Any]] = {
    "PnTConveyor-v0": ConveyorConfig,
    "PnTRelease-v0": ConveyorConfig,
    "OneJointThrow-v0": OneJointConfig,
    "OneJointSort-v0": OneJointConfig,
    "OneJointAssembly-v0": OneJointConfig,
    "GripperToss-v0": GripperConfig,
}
MODES: Final = {
    "PnTConveyor-v0": ("release_point", "release_xyz", "virtual_goal"),
    "PnTRelease-v0": ("release_point", "release_xyz", "virtual_goal"),
    "OneJointThrow-v0": ("virtual_goal", "release_state"),
    "OneJointSort-v0": ("virtual_goal", "release_state"),
    "OneJointAssembly-v0": ("virtual_goal", "release_state"),
    "GripperToss-v0": ("release", "release_point"),
}
LONGEST: Final = 500
"""Characters of a sentence."""
FACTORS: Final = (
    0.0,
    -1.0,
    0.1,
    0.5,
    0.9,
    1.1,
    1.5,
    2.0,
    3.0,
    5.0,
    10.0,
    30.0,
    100.0,
    1e3,
    1e6,
    1e12,
    1e300,
    1e-3,
    1e-9,
)
JUNK: Final = (
    None, True, "", "x", "1.0", "nan", "a\nb", "x" * 300, [], {}, [1.0], [[1.0]], {"x": 1.0}, b"x", 1j, object(),
    float("nan"), float("inf"), -float("inf"), 0, 1, -1, 5, 0.5, 1e-300, 1e300, 10**400, -(10**12), 2.5e-9,
)  # fmt: skip


class Find(Exception):
    """What must not be."""


def drawn(kind: str, number: int) -> Random:
    """The generator of a case."""
    return np.random.default_rng([zlib.crc32(kind.encode()), number])


def pick(random: Random, choices: Any) -> Any:
    """One of some things, whatever they are."""
    chosen = list(choices)
    return chosen[int(random.integers(len(chosen)))]


def tried(kind: str, number: int) -> str | None:
    """What is wrong with a case; None if it works or is refused well."""
    random = drawn(kind, number)
    try:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            said = KINDS[kind](random)
        complaints = [str(w.message) for w in told if not expected(w)]
        return f"{said}: warned {complaints[0]!r}" if complaints else None
    except Find as find:
        return str(find)


def expected(warning: warnings.WarningMessage) -> bool:
    """Whether a warning is meant for the user: of pnt_gym in words, or of Gymnasium."""
    return issubclass(warning.category, UserWarning | DeprecationWarning) and "overflow" not in str(warning.message)


@contextlib.contextmanager
def refusable(what: str, *kinds: type[Exception]) -> Iterator[None]:
    """The block may be refused by an error of some kinds, in one sentence.

    Raises:
        Find: it is refused otherwise.
        Refused: it is refused well.
    """
    try:
        yield
    except (PntGymError, gym.error.Error, *kinds) as error:
        said = str(error)
        if isinstance(error.__cause__, MemoryError):
            raise Find(f"{what}: wants more memory than there is: {said}") from error
        if "\n" in said or not said or (isinstance(error, PntGymError) and len(said) > LONGEST):
            raise Find(f"{what}: {type(error).__name__} is no sentence: {said!r}") from error
        raise Refused from error
    except (Refused, Find):
        raise
    except BaseException as error:
        raise Find(f"{what}: {type(error).__name__}: {error}") from error


class Refused(Exception):
    """The right answer to what is wrong."""


def finite(what: str, *values: Any) -> None:
    """Make sure that observations and rewards are numbers."""
    for value in values:
        if not np.isfinite(np.asarray(value, dtype=np.float64)).all():
            raise Find(f"{what}: {value} is no number")


def level_case(random: Random) -> str:
    """A level one to three of whose values were changed, thrown in twice."""
    env_id = pick(random, pnt_gym.ENV_IDS)
    config = CONFIGS[env_id]
    level: dict[str, Any] = {"base": pick(random, config.level_names())}
    whole = whole_level(config, level["base"])
    for _ in range(int(random.choice([1, 1, 2, 3]))):
        change(random, whole, level)
    if "items" in whole and random.random() < 0.1:
        one = changed(random, OWN)
        level |= {"items": ["own"], "extra_items": [{**OWN, **one} if isinstance(one, dict) else one]}
    what = f"{env_id} level {level!r}"
    with contextlib.suppress(Refused), refusable(what), written(random, level) as given:
        env = gym.make_vec(env_id, num_envs=2, level=given, threads=1)
        try:
            throw_twice(what, env, random)
        except PntGymError as error:
            raise Find(f"{what}: taken, then {type(error).__name__}: {error}") from error
        finally:
            env.close()
    return what


def throw_twice(what: str, env: Any, random: Random) -> None:
    """Two throws in every cell, with numbers for results."""
    finite(what, env.reset(seed=int(random.integers(1000)))[0])
    for scale in (0.3, 1.5):
        action = scale * random.uniform(-1.0, 1.0, env.action_space.shape)
        observation, reward, *_ = env.step(action)
        finite(what, observation, reward)


@contextlib.contextmanager
def written(random: Random, level: dict[str, Any]) -> Iterator[Any]:
    """A level as it is, or in a file of YAML, which may have been torn."""
    if random.random() < 0.7:
        yield level
        return
    try:
        text = yaml.safe_dump(level, allow_unicode=True)
    except yaml.YAMLError:
        yield level
        return
    if random.random() < 0.3:
        at = int(random.integers(len(text)))
        text = text[:at] + pick(random, ("", ":", "\t", "- ", "{", "!!int ", "&a ", "\0", "é", "#")) + text[at + 1 :]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "level.yaml"
        path.write_text(text, encoding="utf-8")
        yield path


@cache
def whole_level(config: Any, name: str) -> dict[str, Any]:
    """Every value of a shipped level, and those that it leaves to the prototype."""
    level = config.load(name).model_dump(mode="json")
    if config is GripperConfig:
        parts = {"dimensions": PROTOTYPE, "servo": PROTOTYPE_BUILD.servo, "claws": PROTOTYPE_BUILD.claws}
        level["robot"] |= {part: json.loads(json.dumps(asdict(own))) for part, own in parts.items()}
        level["robot"]["masses"] = {field: 0.02 for field in ("arm_mass", "rod_mass", "platform_mass", "half_mass")}
    return level


def change(random: Random, whole: dict[str, Any], level: dict[str, Any]) -> None:
    """Change one value anywhere in a level: a number by a factor, or anything for anything else."""
    key = pick(random, [k for k in whole if k != "name"])
    if random.random() < 0.03:
        level[pick(random, ("gravity", "", "BINS", 5, key + "s"))] = 1.0
    level[key] = changed(random, whole[key])


def changed(random: Random, value: Any) -> Any:
    """A value that is a little or altogether another."""
    if isinstance(value, dict) and value and random.random() < 0.95:
        key = pick(random, value)
        new = {key: changed(random, value[key])}
        return {**new, "typo": 1.0} if random.random() < 0.03 else new
    if isinstance(value, list) and value and random.random() < 0.9:
        place = int(random.integers(len(value)))
        kept = [*value[:place], changed(random, value[place]), *value[place + 1 :]]
        return pick(random, (kept, kept, kept, kept[:-1], [*kept, kept[0]], kept[::-1]))
    if isinstance(value, int | float) and not isinstance(value, bool) and random.random() < 0.85:
        by = pick(random, FACTORS)
        return value * by if value else by
    return pick(random, JUNK)


OWN: Final = {
    "name": "own", "shape": "box", "size": [0.05, 0.03, 0.03], "mass": 0.01, "drag": 0.9, "seal_force": 10.0,
    "com_depth": 0.5, "friction": 0.5, "rolling_friction": 1e-4, "restitution": 0.3, "opening_delay": 0.01,
    "source": "ours",
}  # fmt: skip
"""An item of a user's."""
ENTRIES: Final = (*JUNK, 0.0, 1.0, -1.0, 1e-30, 5e-324, 1e30, 1e308, -1e308, 2.0)


@cache
def cell(env_id: str, mode: str, count: int) -> Any:
    """An environment that is kept; single for a count of 0."""
    if count:
        return gym.make_vec(env_id, num_envs=count, action_mode=mode, threads=1).unwrapped
    return gym.make(env_id, action_mode=mode).unwrapped


def action_case(random: Random) -> str:
    """An action of any shape, type and value; whatever it was, the next one is thrown."""
    env_id = pick(random, pnt_gym.ENV_IDS)
    mode, count = pick(random, MODES[env_id]), int(random.choice([0, 2]))
    env = cell(env_id, mode, count)
    env.reset(seed=int(random.integers(1000)))
    action = any_action(random, env.action_space.shape)
    what = f"{env_id} {mode} {count} cells, action {action!r}"
    with contextlib.suppress(Refused), refusable(what, ActionError):
        observation, reward, *_ = env.step(action)
        finite(what, observation, reward)
    if random.random() < 0.2:
        observation, reward, *_ = env.step(np.zeros(env.action_space.shape))
        finite(what, observation, reward)
    return what


def any_action(random: Random, shape: tuple[int, ...]) -> Any:
    """An action of the right shape as a rule."""
    others = (shape[:-1], (*shape, 1), (1, *shape), (shape[0] + 1, *shape[1:]), (0,), (), (3, 3, 3))
    chosen = shape if random.random() < 0.8 else pick(random, others)
    kind = pick(random, ("numbers", "numbers", "numbers", "entries", "junk", "list"))
    if kind == "junk":
        return pick(random, JUNK)
    if kind == "numbers":
        scale = pick(random, (1.0, 10.0, 1e10, 1e300, 1e-300))
        values = scale * random.uniform(-1.0, 1.0, chosen)
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return np.asarray(values).astype(pick(random, ("f8", "f4", "f2", "i8", "u1", "?", "c16", "O", "g", ">f8")))
    values = np.empty(chosen, dtype=object)
    for place in np.ndindex(*chosen):
        values[place] = pick(random, ENTRIES) if random.random() < 0.4 else float(random.uniform(-1.0, 1.0))
    return values.tolist() if kind == "list" else values


def calls_case(random: Random) -> str:
    """Calls in any order, some of them with anything."""
    env_id = pick(random, pnt_gym.ENV_IDS)
    what, said = f"{env_id}:", list[str]()
    with contextlib.suppress(Refused), refusable(what, TypeError):
        env, made = made_env(random, env_id)
        what += f" {made}"
    if "env" not in locals():
        return what
    for _ in range(int(random.integers(2, 7))):
        name = pick(random, CALLS)
        with contextlib.suppress(Refused), refusable(f"{what} {said} {name}"):
            env, told = CALLS[name](random, env)
            said.append(f"{name}{told}")
            continue
        said.append(f"{name} refused")
    with refusable(f"{what} {said} close"):
        env.close()
    return f"{what} {said}"


FORMS: Final = {
    "PnTConveyor-v0": (conveyor.PnTConveyorEnv, conveyor.PnTConveyorVectorEnv),
    "PnTRelease-v0": (conveyor.PnTReleaseEnv, conveyor.PnTReleaseVectorEnv),
    "OneJointThrow-v0": (one_joint.OneJointThrowEnv, one_joint.OneJointThrowVectorEnv),
    "OneJointSort-v0": (one_joint.OneJointSortEnv, one_joint.OneJointSortVectorEnv),
    "OneJointAssembly-v0": (one_joint.OneJointAssemblyEnv, one_joint.OneJointAssemblyVectorEnv),
    "GripperToss-v0": (gripper.GripperTossEnv, gripper.GripperTossVectorEnv),
}


def made_env(random: Random, env_id: str) -> tuple[Any, str]:
    """An environment, made directly, with an argument that may be anything."""
    form = pick(random, FORMS[env_id])
    given: dict[str, Any] = {}
    if random.random() < 0.3:
        names = ("level", "action_mode", "threads", "render_mode", *(["num_envs"] if form is FORMS[env_id][1] else []))
        given[pick(random, names)] = pick(random, JUNK)
    return form(**given), f"{form.__name__}({given})"


def _reset(random: Random, env: Any) -> tuple[Any, str]:
    given: dict[str, Any] = {}
    if random.random() < 0.5:
        given["seed"] = pick(random, (*JUNK, 3, np.int64(3), np.array([1, 2]), [1, None], [1]))
    if random.random() < 0.3:
        options = (*JUNK, {}, {"reset_mask": np.array([True])}, {"reset_mask": [1]}, {"reset_mask": None}, {"a": 1})
        given["options"] = pick(random, options)
    observation, _ = env.reset(**given)
    finite("reset", observation)
    return env, f"({given})"


def _step(random: Random, env: Any) -> tuple[Any, str]:
    action = env.action_space.sample() if random.random() < 0.8 else any_action(random, env.action_space.shape)
    observation, reward, *_ = env.step(action)
    finite("step", observation, reward)
    return env, ""


def _twice(env: Any) -> tuple[Any, str]:
    env.close()
    env.close()
    return env, ""


def _assigned(random: Random, env: Any) -> tuple[Any, str]:
    return (copy.deepcopy(env) if random.random() < 0.5 else pickle.loads(pickle.dumps(env))), ""


CALLS: Final[dict[str, Callable[[Random, Any], tuple[Any, str]]]] = {
    "reset": _reset,
    "step": _step,
    "step again": _step,
    "close": lambda _, env: _twice(env),
    "copy": _assigned,
    "render": lambda _, env: (env if env.render_mode else env.render() or env, ""),
    "spec": lambda _, env: (env, f"{env.spec}"[:0]),
}


def line_case(random: Random) -> str:
    """A command line of good and bad options."""
    said = tried_line(random)
    if said.find is not None:
        raise Find(f"{said.line}: {said.find}")
    return said.line


KINDS: Final[dict[str, Callable[[Random], str]]] = {
    "level": level_case,
    "action": action_case,
    "calls": calls_case,
    "line": line_case,
}
SHARES: Final = {"level": 0.35, "action": 0.40, "calls": 0.15, "line": 0.10}
"""Of the cases of a whole."""
