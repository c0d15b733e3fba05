"""Coming throws of the gripper robot, before they are carried out."""

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
    """Observed place of the object on the table; on a belt, the expected place when the claws begin to close (N, 2)
    [m]."""
    measured: Floats
    """Extents along the object's axes as a camera measures them (N, 3) [m]."""
    plans: TossPlans
    """Plans of the throws."""
    hidden: Hidden
    """True objects, and the other values that the planner does not know."""

    @property
    def target(self) -> Floats:
        """Middle of the compartment's opening (N, 3) [m]."""
        return self.plans.target
