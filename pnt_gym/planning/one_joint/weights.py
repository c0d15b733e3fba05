"""Weights W of the margins in the objective (Miyashita et al., Eq. 28), by name."""

from __future__ import annotations

from typing import Final, Literal, cast

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, numbers
from pnt_gym.errors import PlanningError
from pnt_gym.names import unknown_name

WeightName = Literal["balanced", "torque", "bang", "grasp", "none"]

WEIGHTS: Final[dict[str, tuple[float, ...]]] = {
    "balanced": (1e-3, 1e-3, 1e-3, 1.0, 1.0, 1.0),
    "torque": (1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1.0),
    "bang": (1.0, 1.0, 1.0, 1.0, 1.0, 1.0),
    "grasp": (1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3),
    "none": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
}
"""Diagonals of W for margins as shares (see `margins`).

The paper gives no weights. Since a convex function is maximised, the optimum lies in a corner that the weights choose:
"balanced" weighs the grasp, whose margins are many times the weight of the block, against the limits of the arm;
"torque" takes the slowest motion, "bang" and "grasp" the quickest; "none" accepts any motion that keeps its limits.
"""


def weights_of(weights: str | ArrayLike) -> Floats:
    """Return the six weights (6,) of a name, or check six given weights.

    Raises:
        ValueError: the name is not known, or the weights are not six finite numbers of at least 0.
    """
    if isinstance(weights, str):
        if weights not in WEIGHTS:
            raise PlanningError(unknown_name("weights", weights, WEIGHTS, ", or give six numbers"))
        return np.array(WEIGHTS[weights])
    values = numbers(weights, "weights")
    if values.shape != (6,) or not (np.isfinite(values).all() and (values >= 0.0).all()):
        raise PlanningError(f"weights must be six finite numbers of at least 0, got {cast('object', weights)!r}")
    return values
