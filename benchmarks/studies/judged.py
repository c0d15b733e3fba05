"""What `agents.evaluate` says of a controller at the belt, in cells that tell classes wrong and fill their bins."""

from __future__ import annotations

from typing import Any

from agents.ground.places import at
from agents.judging.evaluation import evaluate
from agents.results.study import Amount, Figures, Settings
from pnt_gym.cells.conveyor.config import ConveyorConfig


def confusion(materials: dict[str, list[str]], wrong: float) -> dict[str, dict[str, float]]:
    """Shares in which each kind is seen as another one: evenly as all kinds of other materials."""
    shares: dict[str, dict[str, float]] = {}
    for items in materials.values():
        strangers = [item for kinds in materials.values() if kinds is not items for item in kinds]
        for item in items:
            shares[item] = {item: 1.0 - wrong, **dict.fromkeys(strangers, wrong / len(strangers))}
    return shares


def figures(settings: Settings, amount: Amount) -> Figures:
    """Figures of a controller.

    Args:
        settings: `env`, `level`, `controller` and the names of `figures`; with `wrong`, the share of every kind that is
            seen as one of another of the `materials`.
        amount: throws.
    """
    level: dict[str, Any] = dict(settings["level"])
    if "wrong" in settings:
        level["classifier"] = {"confusion": confusion(settings["materials"], settings["wrong"])}
    name = settings["controller"]
    controller = str(at(name)) if "/" in name else name
    config = ConveyorConfig.load(level)
    report = evaluate(controller, settings["env"], amount.throws, amount.seed, level=config, threads=1)
    return {name: report[name] for name in settings["figures"] if name in report}
