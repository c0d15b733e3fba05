"""How far upstream objects have to move so that none lies on another. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

from pnt_gym.arrays import Floats
from pnt_gym.compiled import compiled


@compiled("float64[::1](float64[::1], float64[::1], float64[::1], float64[::1], float64)")
def apart(x: Floats, y: Floats, along: Floats, across: Floats, gap: float) -> Floats:
    """Where objects lie that come in at x, the first one most downstream; each gives way to those before it.

    Args:
        x: where each would lie along the belt, which runs to greater x; not increasing (M,) [m].
        y: where each lies across it (M,) [m].
        along: half its extent along the belt (M,) [m].
        across: half its extent across it (M,) [m].
        gap: least distance of the rectangles around two objects, along or across [m].
    """
    lies = x.copy()
    first, farthest = 0, 2.0 * along.max() + gap
    for i in range(len(x)):
        # Those that lie far downstream of this one do so of all that follow.
        while lies[first] > x[i] + farthest:
            first += 1
        # Who gives way to one may come to lie on another, so all are asked again until nobody is in the way.
        moved = True
        while moved:
            moved = False
            for j in range(first, i):
                free = along[i] + along[j] + gap
                if abs(y[i] - y[j]) < across[i] + across[j] + gap and abs(lies[j] - lies[i]) < free * (1.0 - 1e-12):
                    lies[i] = lies[j] - free
                    moved = True
    return lies
