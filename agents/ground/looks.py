"""How drawings show controllers: a name that a reader knows beside the identifier, and one colour everywhere."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, NamedTuple

from .drawings import COLOURS

BLUE, ORANGE, GREEN, RED, VIOLET, BROWN, PINK, GREY, YELLOW, CYAN, PINE, BLACK = COLOURS


class Look(NamedTuple):
    """How a controller is shown.

    Attributes:
        colour: of its lines and bars.
        name: in words, empty where the identifier is a word already.
    """

    colour: str
    name: str = ""


LOOKS: Final = {
    # Throws. Blue is where learning begins, black who knows what is hidden.
    "analytic": Look(BLUE, "planner"),
    "random": Look(BROWN),
    "fitted_planner": Look(PINE),
    "virtual_goal": Look(GREEN, "iterative learning"),
    "ridge": Look(ORANGE, "ridge regression"),
    "mlp": Look(RED, "neural network"),
    "sac": Look(VIOLET, "SAC"),
    "sac_without_a_planner": Look(VIOLET),
    "td3": Look(CYAN),
    "tqc": Look(BROWN),
    "ppo": Look(PINK),
    "gaussian_process": Look(YELLOW),
    "cma-es": Look(GREY),
    "floor": Look(GREY),
    "floor_unseen": Look(GREY),
    "oracle": Look(BLACK),
    # Drift.
    "static": Look(BLUE, "does not adapt"),
    "ema": Look(GREEN, "running mean"),
    "kalman": Look(RED, "Kalman filter"),
    "recursive_ridge": Look(ORANGE, "recursive regression"),
    "in_context": Look(VIOLET, "recurrent network"),
    "recurrent_ppo": Look(PINK, "PPO with a memory"),
    "posterior": Look(PINE, "knows the physics"),
    "oracle_drift": Look(BLACK, "is told the drift"),
    # Lines.
    "fifo": Look(BLUE, "first in, first out"),
    "spt": Look(YELLOW, "shortest cycle"),
    "value_rate": Look(CYAN, "value a second"),
    "atc": Look(GREEN, "most urgent"),
    "price": Look(ORANGE, "prices"),
    "price_beam": Look(BROWN, "beam with prices"),
    "beam": Look(RED, "beam search"),
    "guided_beam": Look(PINE),
    "index": Look(VIOLET, "searched index"),
    "index_searched": Look(VIOLET, "searched anew"),
    "residual_ppo": Look(PINK, "PPO over a rule"),
    "residual_ppo_long": Look(PINK, "the same, longer"),
    "maskable_ppo": Look(GREY, "PPO"),
    "clairvoyant": Look(BLACK),
    # Grasps.
    "centre": Look(BLUE, "middle"),
    "centroid": Look(CYAN, "middle of the picture"),
    "flattest": Look(GREEN, "flattest place"),
    "local_mlp": Look(RED, "network of places"),
    "fitted_q": Look(VIOLET, "from rewards"),
    "true_surface": Look(YELLOW, "sees the surface"),
    "oracle_grasp": Look(BLACK, "oracle"),
    # Ways to the bin.
    "straight": Look(BLUE, "straight throw"),
    "free_direction": Look(VIOLET, "free direction"),
    "horizontal": Look(GREEN, "level throw"),
    "pick_and_place": Look(ORANGE, "pick-and-place"),
    "ellipse": Look(RED, "ellipse"),
}


ALIASES: Final = {
    "planner": "analytic",
    "analytic_planner": "analytic",
    "shipped_policy": "sac",
    "waste-sac": "sac",
}
"""Further names of some controllers in results, as `look` spells labels."""


def look(label: str) -> Look | None:
    """How a controller is shown whose label may say what it learned from: `SAC (10,000)`; None for an unknown one."""
    name = label.partition(" (")[0].partition(", ")[0].lower().replace(" ", "_")
    return LOOKS.get(ALIASES.get(name, name))


def colours(labels: Iterable[str]) -> dict[str, str]:
    """A colour for each label: of a known controller its own, of others those that are left, in their order."""
    unique = list(dict.fromkeys(labels))
    known = {label: own.colour for label in unique if (own := look(label)) is not None}
    # Blue and black would be read as the planner and as one who knows what is hidden.
    free = [colour for colour in COLOURS if colour not in (BLUE, BLACK, *known.values())] or list(COLOURS)
    others = [label for label in unique if label not in known]
    return known | {label: free[k % len(free)] for k, label in enumerate(others)}


def reader_name(label: str) -> str:
    """The name of a controller that a reader knows; empty where there is none beside the identifier."""
    own = look(label)
    return "" if own is None else own.name


def said(label: str) -> str:
    """The identifier of a controller, with the name that a reader knows."""
    name = reader_name(label)
    return f"{label}: {name}" if name else label
