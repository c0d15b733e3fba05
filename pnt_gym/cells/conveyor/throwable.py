"""Rules which objects may be thrown, by their measurements: air carries some away, the cup loses others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.items import ItemTable
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.hold import measured_hold
from pnt_gym.cells.conveyor.sections import Throwable
from pnt_gym.planning.motion.ballistics import drag_shift


def drag_area(context: Context, table: ItemTable) -> Floats:
    """Cd A / m of picks (N,) [m2/kg]: the class's drag coefficient on the measured outline, over the measured mass."""
    size, kind = context.objects.measured.size, context.kind
    return table.drag[kind] * size[:, 0] * size[:, 1] / context.objects.measured.mass


def drag_offset(context: Context, table: ItemTable) -> Floats:
    """Predicted displacement of landings by air drag, to first order (N,) [m]; infinite where there is no plan."""
    plan = context.plan
    offset = drag_shift(plan.position, plan.velocity, context.target[:, 2], drag_area(context, table))
    return np.nan_to_num(np.hypot(offset[:, 0], offset[:, 1]), nan=np.inf)


_FIGURES: Final[dict[str, tuple[Callable[[Context, ItemTable], Floats], float]]] = {
    "drag_area": (drag_area, 1.0),
    "drag_shift": (drag_offset, 1.0),
    # Measured holding force over load at the throws' largest acceleration in the worst direction (N,).
    "margin": (
        lambda context, table: measured_hold(context.objects, context.belt_shift).least_margin(
            context.throw_limits.acceleration
        ),
        -1.0,
    ),
}
"""Figure that each key of `Throwable` bounds, and whether from above (1) or below (-1)."""


def is_throwable(context: Context, rule: Throwable, table: ItemTable) -> Bools:
    """Which picks the rule allows to throw (N,)."""
    good = np.full(len(context.kind), True)
    for key, (figure, sign) in _FIGURES.items():
        bound: float | None = getattr(rule, key)
        if bound is not None:
            good &= sign * figure(context, table) <= sign * bound
    return good
