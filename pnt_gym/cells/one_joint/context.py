"""Coming throws of the one-joint thrower, before they are carried out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.one_joint.hidden import Hidden
from pnt_gym.planning.one_joint import ThrowPlans


@final
@dataclass(frozen=True)
class Context:
    """N coming throws."""

    kind: Ints
    """Index into the job's targets (N,)."""
    part: Ints
    """Index of the part on the arm (N,)."""
    goal: Floats
    """Goal x, y [m], phi [rad], dy [m/s] (N, 4)."""
    nominal: Floats
    """Goal of each throw's kind (N, 4); meaningless where goals are drawn from a region."""
    plans: ThrowPlans
    """Plans of the throws to the goals."""
    lying: Floats
    """Poses x, y, phi of the parts already in the pallet (N, P, 3); NaN for parts that are not there."""
    hidden: Hidden
    """Values of these throws that the planner does not know."""
