"""The controllers by name and the policies that ship: `pnt-gym controllers`, or `python -m agents.roster`."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Annotated, Final

from .controllers import GRASPING_NAMES, NAMES, Learner, make_controller, named
from .dispatchers.registry import CHOICES
from .dispatchers.registry import NAMES as LINE_NAMES
from .ground import shipped
from .ground.cli import option, run
from .ground.environments import make_vector
from .ground.shipped import POLICIES, PREFIX
from .ground.tables import Grid, console

EVERYWHERE: Final = "PnTAdapt-v0"
"""The environment in which every controller of throws acts."""
GRASPING: Final = "PnTGrasp-v0"
"""The environment in which controllers choose where to grasp."""
SHIFTS: Final = {GRASPING: "grasp_shift"}
"""Levels on which also controllers act that remember a shift."""


@dataclass(frozen=True)
class Arguments:
    """List the controllers that commands take by name: of throws, of a line, and the policies that ship."""

    where: Annotated[str | None, option("the lists", "shipped:NAME")] = None
    """Print the folder or file of this shipped policy."""


def main(arguments: Arguments) -> None:
    """Print the lists, or the place of one shipped policy."""
    if arguments.where is not None:
        print(shipped.place(f"{PREFIX}{arguments.where.removeprefix(PREFIX)}"))
        return
    rows = [(name, CHOICES[name]) for name in LINE_NAMES]
    policies = [(f"{PREFIX}{name}", policy.env, policy.purpose) for name, policy in POLICIES.items()]
    for grid in (
        _grid("controllers of throws", EVERYWHERE, [name for name in NAMES if name not in GRASPING_NAMES]),
        _grid("controllers that grasp and throw", GRASPING, GRASPING_NAMES),
        Grid("controllers of a line", ("controller", "its choice"), rows),
        Grid("policies that ship", ("controller", "trained in", "what it does"), policies),
    ):
        console().print(grid.terminal())


def _grid(title: str, env_id: str, names: Sequence[str]) -> Grid:
    """Controllers that act in an environment."""
    with closing(make_vector(env_id, SHIFTS.get(env_id), num_envs=1, threads=1)) as env:
        controllers = {name: make_controller(name, env) for name in names}
    rows = [
        (name, "yes" if isinstance(controller, Learner) else "no", named.describe(name, controller))
        for name, controller in controllers.items()
    ]
    return Grid(title, ("controller", "learns", "what it does"), rows)


if __name__ == "__main__":
    run(main, Arguments, "agents.roster")
