"""Whoever acts in an environment, by name, whether it corrects throws or decides on a line."""

from __future__ import annotations

from typing import Final

from pnt_gym.cells.line.core import LineCore

from ..controllers import make_controller
from ..controllers.own import own_controller
from ..controllers.protocol import Controller
from ..dispatchers.registry import GUIDED, line_controller, line_of
from ..ground.cli import UsageError
from ..ground.environments import Env, core_of
from ..ground.places import POLICY

EXPERTS: Final = dict.fromkeys(("PnTConveyor-v0", "PnTRelease-v0"), str(POLICY))
"""Policies that ship, by the environment in which each is the expert."""


def expert_for(env_id: str, env: Env) -> str:
    """Name of the expert in an environment: its shipped policy, on a line the guided planner, elsewhere the oracle."""
    return EXPERTS.get(env_id, GUIDED if isinstance(core_of(env), LineCore) else "oracle")


def controller_for(name: str, env: Env, *, trust: bool = False) -> Controller:
    """The controller of a name, fitted to an environment of any kind.

    Args:
        name: as `make_controller` takes it; on a line as `line_controller` does, or MODULE:CLASS.
        env: the environment in which it acts.
        trust: load what runs code, see `make_controller`.

    Raises:
        UsageError: there is no such controller, or it cannot act in this environment.
    """
    if not isinstance(core_of(env), LineCore):
        return make_controller(name, env, trust=trust)
    if ":" in name:
        return own_controller(name, env)
    return line_controller(name, _lines(env))


def _lines(env: Env) -> LineCore:
    """The lines behind an environment.

    Raises:
        UsageError: there are several, each with a core of its own, where planners see one line only.
    """
    line, first = line_of(env), core_of(env)
    if line is not None:
        return line
    if env.num_envs > 1:
        raise UsageError(
            f"this environment steps {env.num_envs} lines one by one, and a controller of a line sees all at once; use "
            "1 line (--num-envs 1)"
        )
    assert isinstance(first, LineCore)
    return first
