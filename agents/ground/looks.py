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


def colours(labels: Iterable[str]) -> dict[str, str]:
    """A colour for each label: of a known controller its own, of others those that are left, in their order."""
    unique = list(dict.fromkeys(labels))
    taken = {LOOKS[label].colour for label in unique if label in LOOKS}
    free = [colour for colour in COLOURS if colour not in taken] or list(COLOURS)
    others = [label for label in unique if label not in LOOKS]
    spare = {label: free[k % len(free)] for k, label in enumerate(others)}
    return {label: LOOKS[label].colour if label in LOOKS else spare[label] for label in unique}


def said(label: str) -> str:
    """The identifier of a controller, with the name that a reader knows."""
    name = LOOKS[label].name if label in LOOKS else ""
    return f"{label} ({name})" if name else label
