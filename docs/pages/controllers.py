"""The controllers of the registry: what each does, whether it learns, and where it can act."""

from __future__ import annotations

from functools import cache
from typing import Any

import pnt_gym
from agents.controllers import NAMES, Controller, Learner, make_controller, named
from agents.dispatchers import registry
from agents.dispatchers.registry import CHOICES, line_core
from agents.dispatchers.registry import NAMES as line_names
from agents.ground.cli import UsageError
from agents.ground.environments import config_of, make_vector
from agents.ground.shipped import POLICIES, PREFIX
from agents.roster import SHIFTS

from .environments import STAGED
from .marks import table


@cache
def _open_cells(env_id: str) -> Any:
    return make_vector(env_id, SHIFTS.get(env_id), num_envs=1, threads=1)


def _controller(name: str, env_id: str) -> Controller | None:
    try:
        return make_controller(name, _open_cells(env_id))
    except UsageError:
        return None


def _environment_names(ids: list[str]) -> str:
    """Names of the environments in which a controller acts, shortened where it acts in all that throw."""
    throwing = [i for i in pnt_gym.ENV_IDS if config_of(i).trial == "throws" and i not in STAGED]
    others = [f"`{i}`" for i in ids if i not in throwing]
    return ", ".join(["all that throw", *others] if set(throwing) <= set(ids) else [f"`{i}`" for i in ids])


def controller_table(_: str) -> str:
    """A table of all controllers of throws."""
    rows: list[tuple[str, str, str, str]] = []
    for name in NAMES:
        usable = {i: controller for i in pnt_gym.ENV_IDS if (controller := _controller(name, i)) is not None}
        first = next(iter(usable.values()))
        learns = "yes" if isinstance(first, Learner) else "no"
        rows.append((f"`{name}`", learns, _environment_names([*usable]), named.describe(name, first)))
    return table(("controller", "learns", "environments", "what it does"), rows)


def line_controller_table(_: str) -> str:
    """A table of the controllers of a line."""
    core = line_core(make_vector("PnTLine-v0", num_envs=1, threads=1))
    rows = [(f"`{name}`", CHOICES[name]) for name in line_names if registry.make(name, core).name == name]
    return table(("controller", "its choice"), rows)


def shipped_table(_: str) -> str:
    """A table of the policies that ship."""
    rows = [(f"`{PREFIX}{name}`", f"`{policy.env}`", policy.purpose) for name, policy in POLICIES.items()]
    return table(("controller", "trained in", "what it does"), rows)
