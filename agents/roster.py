"""The controllers by name and the policies that ship: `pnt-gym controllers`, or `python -m agents.roster`."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Annotated, Any, Final

from .controllers import (
    GRASPING_NAMES,
    NAMES,
    Controller,
    Learner,
    ballistic,
    bucket_table,
    goals,
    make_controller,
    mlp,
    ridge,
)
from .dispatchers.registry import NAMES as LINE_NAMES
from .ground.cli import option, run
from .ground.environments import make_vector
from .ground.shipped import POLICIES, PREFIX, policy_place
from .ground.tables import Grid, console

EVERYWHERE: Final = "PnTAdapt-v0"
"""The environment in which every controller of throws acts."""
GRASPING: Final = "PnTGrasp-v0"
"""The environment in which controllers choose where to grasp."""
LINE: Final[Mapping[str, str]] = {
    "random": "a random choice, all equally likely",
    "fifo": "the object that leaves the window first (first in, first out)",
    "spt": "the choice with the shortest cycle",
    "value_rate": "the choice with the greatest value x chance / cycle",
    "atc": "the choice with the greatest value x chance / cycle x exp(-slack / k): among choices of equal worth the "
    "most urgent (Vepsalainen and Morton 1987)",
    "price": "as `atc`, with less value for an object that a robot downstream can take too",
    "pair": "the first of the two picks that together earn the most value a second",
    "beam": "the first pick of the robot's best plan for its next 4 s, by beam search",
    "price_beam": "as `beam`, with less value for an object that a robot downstream can take too",
    "joint_beam": "as `beam`, planned for all robots of the line at once",
    "guided_beam": "one of the four choices that a scorer (`index` or a training run) likes best: the choice with the "
    "greatest sum of its score and the value of the best plan of the next 3 s that begins with it",
    "index": "the choice with the greatest sum of the log of `atc`'s index and weighted entries, found by CMA-ES",
}
"""The choice of each controller of a line."""
DESCRIBED_IN: Final[Mapping[str, Any]] = {
    "analytic_height": ballistic.AnalyticHeight,
    "mean_lead": ballistic.MeanLead,
    "mean_shift": bucket_table.mean_shift,
    "virtual_goal": goals.virtual_goal,
    "ridge": ridge,
    "mlp": mlp,
}
"""Objects whose docstring describes a controller, where the module of the controller holds several."""
WORDS: Final[Mapping[str, str]] = {
    "static": "An MLP that was trained under the drift of `day`; it does not adapt",
    "ema": "An MLP, minus the running mean of its errors in this shift",
    "kalman": "An MLP, minus the effect of valve delay, camera and encoder on each throw, as two filters estimate it",
    "recursive_ridge": "An MLP, minus a recursive ridge regression of its errors on features of the plan",
    "in_context": "An MLP, minus the prediction of a recurrent network that was trained on simulated shifts",
    "centre": "Grasps the middle of the outline",
    "centroid": "Grasps the middle of what the picture shows of the object",
    "flattest": "Grasps where the picture is flat under the cup and around; `rule` is depth, colour or naive",
    "local_mlp": "Grasps where a network on features of the picture expects the most; it learned from tries on `grasp`",
    "fitted_q": "Grasps and throws by two networks of values, which learned on `grasp` from rewards alone",
    "fcn": "Grasps where a fully convolutional network of the picture's pixels expects the most",
    "oracle_grasp": "Cheats: grasps where the true surface holds best",
    "oracle_drift": "Cheats: an MLP, minus the effect of the true drift; draught is not corrected",
}
"""Descriptions of controllers that share a class: each names its estimate of the drift, or its place to grasp."""


@dataclass(frozen=True)
class Arguments:
    """List the controllers that commands take by name: of throws, of a line, and the policies that ship."""

    where: Annotated[str | None, option("the lists", "shipped:NAME")] = None
    """Print the folder or file of this shipped policy."""


def main(arguments: Arguments) -> None:
    """Print the lists, or the place of one shipped policy."""
    if arguments.where is not None:
        print(policy_place(f"{PREFIX}{arguments.where.removeprefix(PREFIX)}"))
        return
    for grid in (throw_grid(), grasp_grid(), line_grid(), shipped_grid()):
        console().print(grid.terminal())


def throw_grid() -> Grid:
    """The controllers of throws."""
    return _grid("controllers of throws", EVERYWHERE, [name for name in NAMES if name not in GRASPING_NAMES])


def grasp_grid() -> Grid:
    """The controllers that choose where to grasp; all of them throw alike."""
    return _grid("controllers that grasp and throw", GRASPING, GRASPING_NAMES)


def _grid(title: str, env_id: str, names: Sequence[str]) -> Grid:
    """Controllers that act in an environment."""
    with closing(make_vector(env_id, num_envs=1, threads=1)) as env:
        controllers = {name: make_controller(name, env) for name in names}
    rows = [
        (name, "yes" if isinstance(controller, Learner) else "no", describe_controller(name, controller))
        for name, controller in controllers.items()
    ]
    return Grid(title, ("controller", "learns", "what it does"), rows)


def line_grid() -> Grid:
    """The controllers of a line."""
    return Grid("controllers of a line", ("controller", "its choice"), [(name, LINE[name]) for name in LINE_NAMES])


def shipped_grid() -> Grid:
    """The policies that ship."""
    rows = [(f"{PREFIX}{name}", policy.env, policy.purpose) for name, policy in POLICIES.items()]
    return Grid("policies that ship", ("controller", "trained in", "what it does"), rows)


def describe_controller(name: str, controller: Controller) -> str:
    """The first paragraph of the docstring of a controller, or the words for it in `WORDS`."""
    text = WORDS.get(name) or inspect.getdoc(DESCRIBED_IN.get(name) or inspect.getmodule(type(controller))) or ""
    return " ".join(text.split("\n\n", 1)[0].rstrip(".").split())


if __name__ == "__main__":
    run(main, Arguments, "agents.roster")
