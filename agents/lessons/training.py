"""What training asks of a line: settings that its rules were tuned to, and a comparison over whole shifts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from ..controllers.between import PLANNER
from ..dispatchers.registry import ENV, line_controller, line_of, the_line
from ..dispatchers.scored import run_scores
from ..dispatchers.settings import rate, settings
from ..ground.cli import UsageError
from ..ground.environments import Env
from ..ground.tables import console, shifts_comparison
from ..judging.work_shifts import judged
from ..learning.hyperparameters import checked
from ..learning.runs import CHOOSING

DEFAULTS: Final[Mapping[str, Mapping[str, Any]]] = {ENV: {"algo": CHOOSING[-1], "checkpoint_every": 125_000}}
"""By environment what training does there unless it is told otherwise."""
PEERS: Final = ("fifo", "atc")
"""Rules that what was learned is compared with."""


def line_settings(asked: Mapping[str, Any], given: Mapping[str, Any], cell: Env) -> dict[str, Any]:
    """Hyperparameters of a training with those that depend on the line: what the tuned ATC rule is and brings there.

    `gamma` and `gae_lambda` are of one robot's decisions; among those of R robots they are the R-th roots.

    Args:
        asked: arguments of the training.
        given: hyperparameters.
        cell: where it learns.

    Raises:
        UsageError: an algorithm for lines elsewhere, or another one, or something else that is for throws, on a line.
    """
    core, algo = line_of(cell), asked["algo"]
    if core is None:
        if algo in CHOOSING:
            raise UsageError(f"--algo {algo} chooses what is thrown next; it is for a line, such as PnTLine-v0")
        return dict(given)
    if algo not in CHOOSING:
        raise UsageError(f"--algo {algo} corrects throws; on a line there are {', '.join(CHOOSING)}")
    if (asked["stack"], asked["over"], asked["fidelity"]) != (1, PLANNER, "full"):
        raise UsageError("--stack, --over and --fidelity go with throws, and not with a line")
    name, own, robots = core.config.name, dict(given), len(core.config.robots)
    checked(own)
    own |= {key: round(own[key] ** (1.0 / robots), 6) for key in ("gamma", "gae_lambda") if key in own}
    if algo == "residual_ppo":
        own.setdefault("patience", settings(name, "atc")["patience"])
    found = rate(name)
    own.setdefault("price_of_time", core.config.price_of_time if found is None else found)
    return own


def more_price(given: Mapping[str, Any], cell: Env) -> float:
    """How much more a second costs in training than in the reward of the environment [1/s]; nothing but on a line.

    Raises:
        UsageError: the hyperparameters say something that is no price.
    """
    core = line_of(cell)
    if core is None:
        return 0.0
    checked(given)
    return float(given.get("price_of_time", core.config.price_of_time)) - core.config.price_of_time


def compare_shifts(folder: Path, learned_from: int, env: Env, shifts: int, seed: int) -> list[dict[str, Any]]:
    """Rules and what was learned on the same held-out shifts, in a table; returns its rows as JSON has them."""
    core = the_line(env)
    rows: list[tuple[str, int, dict[str, Any]]] = []
    for controller in [*(line_controller(name, core) for name in PEERS), run_scores(folder)]:
        controller.reset(seed)
        count = 0 if controller.name in PEERS else learned_from
        rows.append((controller.name, count, judged(controller, env, shifts, seed)))
    title = f"{shifts} held-out shifts each, level {core.config.name}; run folder {folder}"
    console().print(shifts_comparison(title, rows, PEERS[-1]))
    return [{"controller": n, "throws": t, **{k: v for k, v in s.items() if k != "throws"}} for n, t, s in rows]
