"""Kinds of trials by name, and the trial of an environment."""

from __future__ import annotations

import inspect
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, Final

from pnt_gym.cells.base.config import LevelConfig
from pnt_gym.errors import PntGymError, one_sentence
from pnt_gym.names import unknown_name

from ..controllers.protocol import Controller
from ..ground.cli import NUM_ENVS, UsageError
from ..ground.environments import Env, config_of, core_of, import_user_module, make_vector
from ..ground.places import module_name
from .shift_trial import ShiftTrial
from .throw_trial import ThrowTrial
from .trial import Trial

TRIALS: Final[Mapping[str, type[Trial]]] = {"throws": ThrowTrial, "work_shifts": ShiftTrial}
"""Kinds of trials that ship, by the `trial` of a config."""


def find(config: Any) -> type[Trial]:
    """The kind of trial by which controllers are evaluated on a level.

    Args:
        config: config of the level; without a `trial` the trial is by throws.

    Raises:
        UsageError: there is no such kind of trial.
    """
    name = str(getattr(config, "trial", "throws"))
    return TRIALS[name] if name in TRIALS else user_trial(name, TRIALS)


def user_trial(name: str, known: Collection[str] = ()) -> type[Trial]:
    """A user's kind of trial, from MODULE:CLASS; the module is imported.

    Args:
        name: name of module and class.
        known: other names that would do, for the error.

    Raises:
        UsageError: there is no such module, or no such subclass of `Trial` in it.
    """
    module, _, attribute = name.partition(":")
    kind = getattr(import_user_module(module), attribute, None) if attribute else None
    if not (inspect.isclass(kind) and issubclass(kind, Trial)):
        further = f", or MODULE:CLASS of a subclass of {module_name('agents.judging.trial')}.Trial"
        if known:
            raise UsageError(unknown_name("trial", name, known, further))
        raise UsageError(f"--trial is {name!r}; it must be{further.removeprefix(', or')}")
    return kind


def of(env: Env, kind: type[Trial] | None = None) -> Trial:
    """The trial of an open vector environment: of a kind, by default of that which its levels name."""
    return (kind or find(core_of(env).config))(env)


def open_trial(
    env_id: str,
    level: str | Path | LevelConfig | Mapping[str, Any] | None = None,
    num_envs: int = NUM_ENVS,
    threads: int = 2,
    action_mode: str | None = None,
    throws: str | None = None,
    trial: str | None = None,
) -> Trial:
    """Open an environment as `make_vector` does, with its throws computed as asked for, and return its trial.

    Args:
        env_id: id of the environment, or MODULE:ID.
        level: as `make_vector` takes it.
        num_envs: number of rows side by side.
        threads: threads of the simulation.
        action_mode: one of the environment's action modes; None for the default.
        throws: how throws are computed, for levels that leave the choice; None for the level's own setting.
        trial: MODULE:CLASS of another kind of trial, whose module is imported; None for that which the level names.

    Raises:
        UsageError: there is no such environment or trial, or `throws` is given where levels leave no choice.
        ConfigError: there is no such level.
    """
    kind = None if trial is None else user_trial(trial)
    if throws is not None:
        config = config_of(env_id, level)
        level = (kind or find(config)).with_throws(config, throws)
    env = make_vector(env_id, level, num_envs, threads, action_mode)
    try:
        return of(env, kind)
    except BaseException:
        env.close()
        raise


def controller(trial: Trial, policy: Any, settings: Mapping[str, Any], *, trust: bool = False) -> Controller:
    """Controller of a trial, as `Trial.controller` makes it, with settings.

    Raises:
        UsageError: there is no such controller, or it has no such settings, or a setting has an impossible value.
    """
    try:
        return trial.controller(policy, trust=trust, **settings)
    except (TypeError, ValueError, AttributeError) as error:
        if not settings or isinstance(error, PntGymError):
            raise
        values = ", ".join(f"{name}={one_sentence(repr(value), 80)}" for name, value in settings.items())
        raise UsageError(f"controller {policy!r} cannot have {values}: {one_sentence(error)}") from None


def check(trial: Trial | type[Trial], options: Mapping[str, Any], env_id: str, dashes: str = "--") -> None:
    """Make sure that no option was given that only other kinds of trials use.

    Args:
        trial: trial of the environment.
        options: options by name; an option that was not given is None or False.
        env_id: name of the environment, for the error.
        dashes: text before an option's name in the error.

    Raises:
        UsageError: an option was given that this kind of trial does not use.
    """
    for kind in TRIALS.values():
        for name in sorted(kind.options - trial.options):
            if options.get(name) not in (None, False):
                option = name.replace("_", "-") if dashes else name
                raise UsageError(f"{dashes}{option} goes with {kind.unit}; {env_id} is judged by {trial.unit}")
