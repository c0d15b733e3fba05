"""Throws as they stand before they are carried out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.gripper.hidden import Hidden
from pnt_gym.cells.gripper.motion import TossPlans


@final
@dataclass(frozen=True)
class Context:
    """N coming throws."""

    kind: Ints
    """Index into the cell's items (N,)."""
    place: Floats
    """Where the object is seen on the table, on a belt where it is expected when the claws begin to close (N, 2)
    [m]."""
    measured: Floats
    """Extents along the object's axes as a camera measures them (N, 3) [m]."""
    plans: TossPlans
    """The planner's throws."""
    hidden: Hidden
    """The objects as they are, and what else the planner does not know."""

    @property
    def target(self) -> Floats:
        """Middle of the compartment's opening (N, 3) [m]."""
        return self.plans.target
