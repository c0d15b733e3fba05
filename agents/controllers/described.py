"""Descriptions of the controllers of throws, for lists."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any, Final

from . import goals, mlp, ridge
from .protocol import Controller

DESCRIBED_IN: Final[Mapping[str, Any]] = {
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
    "oracle_grasp": "Cheats: grasps where a try is worth most by the true surface, without the error of the cup",
    "oracle_drift": "Cheats: an MLP, minus the effect of the true drift; draught is not corrected",
}
"""Descriptions of controllers that share a class: each names its estimate of the drift, or its place to grasp."""


def describe_controller(name: str, controller: Controller) -> str:
    """The first paragraph of the docstring of a controller, or the words for it in `WORDS`."""
    text = WORDS.get(name) or inspect.getdoc(DESCRIBED_IN.get(name) or inspect.getmodule(type(controller))) or ""
    return " ".join(text.split("\n\n", 1)[0].rstrip(".").split())
