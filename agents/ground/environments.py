"""Opening an environment, alike for every command, with a clear error for a wrong name.

An environment in your own package works as ours do if its `core` is a `pnt_gym.cells.base.core.Core`:
`my_package:MyCell-v0` imports `my_package`, which registers `MyCell-v0` with Gymnasium. An installed package that
declares its module as an entry point of the group `pnt_gym.envs` needs no prefix.
"""

from __future__ import annotations

import importlib
import inspect
import sys
import warnings
import zlib
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, Final, Literal, TypeAlias

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec, load_env_creator
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv

import pnt_gym
from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.cells.base.core import Core
from pnt_gym.errors import one_sentence
from pnt_gym.names import unknown_name

from .cli import UsageError, user_code

Role = Literal["train", "practice", "evaluate", "dataset", "compare"]
Env: TypeAlias = VectorEnv[Any, Any, Any]
PLUGINS: Final = "pnt_gym.envs"
"""Group of entry points that name modules which register environments."""
OPTIONS: Final = ("level", "num_envs", "threads", "action_mode")
"""Options of `make_vector`."""


def import_user_module(name: str) -> ModuleType:
    """Import a user's module, installed or in the working folder.

    Raises:
        UsageError: the module does not exist, its import fails, or the module ends the interpreter.
    """
    folder = str(Path.cwd())
    if folder not in sys.path:
        sys.path.insert(0, folder)
    try:
        with user_code(f"module {name!r}"):
            return importlib.import_module(name)
    except UsageError:
        raise
    except Exception as error:
        reason = f"{type(error).__name__}: {one_sentence(error)}"
        raise UsageError(f"module {name!r} cannot be imported: {reason}") from error


def find(env_id: str) -> EnvSpec:
    """Gymnasium's spec of an environment; for MODULE:ID the module is imported first.

    Raises:
        UsageError: there is no such module or environment.
    """
    module, _, name = env_id.rpartition(":")
    if module:
        import_user_module(module)
    elif name not in gym.registry:
        for plugin in entry_points(group=PLUGINS):
            import_user_module(plugin.module)
    if name in gym.registry:
        return gym.registry[name]
    if module:
        own: list[str] = []
        for key, spec in gym.registry.items():
            point = spec.entry_point
            place = point.partition(":")[0] if isinstance(point, str) else getattr(point, "__module__", "")
            own += [key] if place == module else []
        raise UsageError(f"module {module!r}: {unknown_name('environment', name, own, ', registered with Gymnasium')}")
    further = ", and MODULE:ID for one that MODULE registers"
    raise UsageError(unknown_name("environment", name, pnt_gym.ENV_IDS, further))


def make_vector(
    env_id: str,
    level: str | Path | LevelConfig | Mapping[str, Any] | None = None,
    num_envs: int = 16,
    threads: int = 2,
    action_mode: str | None = None,
) -> Env:
    """Open a vector environment; an environment that is registered in its single form only is stepped row by row.

    Args:
        env_id: id of the environment, or MODULE:ID.
        level: name of a level of the environment, or a YAML file, a mapping or a config for its cell; None for the
            default.
        num_envs: cells simulated side by side.
        threads: threads of the simulation.
        action_mode: one of the environment's action modes; None for the default.

    Raises:
        UsageError: there is no such environment, it has no core, or it takes no level or action mode.
        ConfigError: there is no such level or action mode, or the level describes no working cell.
    """
    spec = find(env_id)
    entry = spec.vector_entry_point or spec.entry_point
    settings = _settings(spec, entry, {"level": level, "action_mode": action_mode, "threads": threads})
    if level is not None and "level" not in settings:
        raise UsageError(f"environment {env_id!r} takes no level")
    options: dict[str, Any] = {}
    if spec.vector_entry_point is None:
        options = {"vectorization_mode": "sync", "vector_kwargs": {"autoreset_mode": AutoresetMode.SAME_STEP}}
    with _translate_errors(env_id):
        env = gym.make_vec(spec, num_envs=num_envs, **settings, **options)
    if action_mode not in (None, _check(env, env_id).action_mode):
        raise UsageError(f"environment {env_id!r} takes no action mode but its own")
    return env


def make_single(env_id: str, level: str | Mapping[str, Any], action_mode: str | None) -> gym.Env[Any, Any]:
    """Open the single form of an environment that `make_vector` has opened.

    Raises:
        UsageError: the environment has no single form.
    """
    spec = find(env_id)
    if spec.entry_point is None:
        raise UsageError(f"environment {env_id!r} has no single form")
    with _translate_errors(env_id):
        return gym.make(spec, **_settings(spec, spec.entry_point, {"level": level, "action_mode": action_mode}))


def config_of(env_id: str, level: str | Path | LevelConfig | Mapping[str, Any] | None = None) -> Any:
    """Config of a level of an environment; the environment is opened only if its class has no `load_config`.

    Raises:
        UsageError: there is no such environment, or it has no core.
        ConfigError: there is no such level.
    """
    spec = find(env_id)
    with _translate_errors(env_id):
        kind: Any = load_env_creator(spec.entry_point) if isinstance(spec.entry_point, str) else spec.entry_point
    if hasattr(kind, "load_config"):
        return kind.load_config(spec.kwargs.get("level", "nominal") if level is None else level)
    env = make_vector(env_id, level, 1, 1)
    try:
        return core_of(env).config
    finally:
        env.close()


@contextmanager
def _translate_errors(env_id: str) -> Generator[None, None, None]:
    """Turn errors of Gymnasium in the block, which makes an environment, into a `UsageError`.

    Raises:
        UsageError: the environment cannot be made.
    """
    try:
        with warnings.catch_warnings():
            # Gymnasium warns of Box bounds and precision that are intended here.
            warnings.filterwarnings("ignore", category=UserWarning, module="gymnasium")
            with user_code(f"environment {env_id!r}"):
                yield
    except (gym.error.Error, TypeError, ImportError, AttributeError) as error:
        raise UsageError(f"environment {env_id!r} cannot be made: {one_sentence(error)}") from error


def _settings(spec: EnvSpec, entry: Any, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings that are not None and that the environment's entry point accepts."""
    names = _parameters(spec, entry)
    return {name: v for name, v in settings.items() if v is not None and (names is None or name in names)}


def _parameters(spec: EnvSpec, entry: Any) -> set[str] | None:
    """Names of the parameters of an environment's entry point; None if it takes any keyword."""
    try:
        creator: Any = load_env_creator(entry) if isinstance(entry, str) else entry
    except (ImportError, AttributeError) as error:
        raise UsageError(f"environment {spec.id!r} cannot be loaded: {one_sentence(error)}") from error
    parameters = inspect.signature(creator).parameters
    open_ended = any(p.kind is inspect.Parameter.VAR_KEYWORD for p in parameters.values())
    return None if open_ended else set(parameters)


def as_vector(env: gym.Env[Any, Any] | Env) -> Env:
    """A single environment as a vector of one row; a vector environment as it is.

    Raises:
        UsageError: there is no environment, or the environment has no core, or is a vector environment with another
            autoreset mode than SAME_STEP.
    """
    if isinstance(env, gym.Env):
        return as_vector(SyncVectorEnv([lambda: env], autoreset_mode=AutoresetMode.SAME_STEP))
    if not isinstance(env, VectorEnv):
        raise UsageError(f"env is {one_sentence(repr(env), 80)}; it must be an id or an environment")
    check(env)
    _check(env, type(env.unwrapped).__name__ if env.spec is None else env.spec.id)
    return env


def check(env: Env) -> None:
    """Make sure that every step of a vector environment is a throw in every row, as SAME_STEP autoreset guarantees.

    Raises:
        UsageError: the environment has another autoreset mode.
    """
    mode = env.metadata.get("autoreset_mode")
    if mode is not AutoresetMode.SAME_STEP:
        raise UsageError(f"a vector environment needs SAME_STEP autoreset here, got {mode}")


def core_of(env: Env) -> Core:
    """Core behind an environment; the core of the first row where every row has its own core."""
    return cores_of(env)[0]


def cores_of(env: Env) -> list[Core]:
    """All cores behind an environment: one for all rows, or one of each row."""
    whole: Any = env.unwrapped
    return [single.unwrapped.core for single in whole.envs] if hasattr(whole, "envs") else [whole.core]


def _check(env: Env, name: str) -> Core:
    try:
        return core_of(env)
    except AttributeError:
        raise UsageError(f"environment {name!r} has no core; this needs an environment on a cell of pnt_gym") from None


def stream_seed(role: Role, seed: int, start: int = 0) -> int:
    """Environment seed of a role; different roles with the same `seed`, at least 0, never see the same throws.

    With `start` throws already done, a resumed stream continues with other throws instead of repeating the first.
    """
    entropy = [seed, zlib.crc32(role.encode()), start]
    # 30 bits leave room below 2**31 for the rows of a vector environment, which add their index.
    return int(np.random.SeedSequence(entropy).generate_state(1)[0] >> 2)
