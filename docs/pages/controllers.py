"""The controllers of the registry: what each does, whether it learns, and where it can act."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from functools import cache
from typing import Any, Final

import pnt_gym
from agents.controllers import (
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
from agents.dispatchers.registry import NAMES as line_names
from agents.dispatchers.registry import line_controller, line_core
from agents.ground.cli import UsageError
from agents.ground.environments import config_of, make_vector

from .marks import table

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
    "oracle_drift": "Cheats: an MLP, minus the effect of the true drift; draught is not corrected",
}
"""Descriptions of the adaptive controllers, whose docstrings describe the estimate of the drift alone."""


@cache
def _open_cells(env_id: str) -> Any:
    return make_vector(env_id, num_envs=1, threads=1)


def _controller(name: str, env_id: str) -> Controller | None:
    try:
        return make_controller(name, _open_cells(env_id))
    except UsageError:
        return None


def description(name: str, controller: Controller) -> str:
    """The first paragraph of the docstring of a controller, or the words for it in `WORDS`."""
    text = WORDS.get(name) or inspect.getdoc(DESCRIBED_IN.get(name) or inspect.getmodule(type(controller))) or ""
    return text.split("\n\n", 1)[0].rstrip(".")


def _environment_names(ids: list[str]) -> str:
    """Names of the environments in which a controller acts, shortened where it acts in all that throw."""
    throwing = [i for i in pnt_gym.ENV_IDS if config_of(i).trial == "throws"]
    return "all that throw" if ids == throwing else ", ".join(f"`{i}`" for i in ids)


def controller_table(_: str) -> str:
    """A table of all controllers of throws."""
    rows: list[tuple[str, str, str, str]] = []
    for name in NAMES:
        usable = {i: controller for i in pnt_gym.ENV_IDS if (controller := _controller(name, i)) is not None}
        first = next(iter(usable.values()))
        learns = "yes" if isinstance(first, Learner) else "no"
        rows.append((f"`{name}`", learns, _environment_names([*usable]), description(name, first)))
    return table(("controller", "learns", "environments", "what it does"), rows)


def line_controller_table(_: str) -> str:
    """A table of the controllers of a line."""
    core = line_core(make_vector("PnTLine-v0", num_envs=1, threads=1))
    rows = [(f"`{name}`", LINE[name]) for name in line_names if line_controller(name, core).name == name]
    return table(("controller", "its choice"), rows)
