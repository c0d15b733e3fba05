"""Where objects lie along belts: how far upstream each gives way, and which are in sight.

Compiled; see `pnt_gym.compiled`.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compiled
from pnt_gym.errors import ConfigError

PIECE: Final = 256
"""Objects that find their places in one call of machine code, which no Ctrl-C interrupts: some milliseconds."""
MOST_IN_THE_WAY: Final = 2000
"""Objects that one may have to give way to; where there are more, a belt without end would jam."""


@final
class Jam(ConfigError):
    """Objects come faster than they find room.

    Args:
        room: objects that lie on a metre of the belt where it is jammed [1/m].
    """

    def __init__(self, room: float) -> None:
        super().__init__(f"objects come faster than they find room; the belt holds {room:.3g} objects on a metre")
        self.room = room


def apart(x: Floats, y: Floats, along: Floats, across: Floats, gap: float) -> Floats:
    """Where objects lie that come in at x, the first one most downstream; each gives way to those before it.

    No two objects lie closer than the gap, but for 1e-12 of the distance of their middles or half a unit in the last
    place of where they lie, whichever is more: 1e-11 m at 100 km.

    Args:
        x: where each would lie along the belt, which runs to greater x; not increasing (M,) [m].
        y: where each lies across it (M,) [m].
        along: half its extent along the belt (M,) [m].
        across: half its extent across it (M,) [m].
        gap: least distance of the rectangles around two objects, along or across [m].

    Raises:
        Jam: one of them has more than `MOST_IN_THE_WAY` others in its way.
    """
    lies, first, farthest = np.array(x, dtype=np.float64), 0, 2.0 * float(np.max(along, initial=0.0)) + gap
    y, along, across = (np.ascontiguousarray(one) for one in (y, along, across))
    for begin in range(0, len(lies), PIECE):
        end = min(begin + PIECE, len(lies))
        first, reached = _settle(lies, y, along, across, gap, farthest, first, begin, end, MOST_IN_THE_WAY)
        if reached < end:
            raise Jam((reached - first) / max(float(np.ptp(lies[first:reached])), farthest))
    return lies


@compiled(
    "UniTuple(int64, 2)(float64[::1], float64[::1], float64[::1], float64[::1], float64, float64, int64, int64, int64,"
    "int64)"
)
def _settle(
    lies: Floats,
    y: Floats,
    along: Floats,
    across: Floats,
    gap: float,
    farthest: float,
    first: int,
    begin: int,
    end: int,
    most: int,
) -> tuple[int, int]:
    """Move objects from `begin` to `end` to where they lie, in place.

    Args:
        lies: where all before `begin` lie, and where the others come in (M,) [m].
        y: see `apart`.
        along: see `apart`.
        across: see `apart`.
        gap: see `apart`.
        farthest: the distance along the belt from which on nobody is in anybody's way [m].
        first: the first object that may be in the way of those from `begin` on.
        begin: the first object that moves.
        end: behind the last one.
        most: objects that may be in the way of one.

    Returns:
        The first object that may be in the way of those from `end` on, and `end`; or the object that has too many
        others in its way.
    """
    for i in range(begin, end):
        come = lies[i]
        # Those that lie far downstream of this one do so of all that follow.
        while first < i and lies[first] > come + farthest:
            first += 1
        if i - first > most:
            return first, i
        # Who gives way to one may come to lie on another, so all are asked again until nobody is in the way. A move
        # that rounding eats is none: each one goes upstream to one of i - first places, so there are no more moves.
        moved = True
        while moved:
            moved = False
            for j in range(first, i):
                free = along[i] + along[j] + gap
                if abs(y[i] - y[j]) < across[i] + across[j] + gap and abs(lies[j] - lies[i]) < free * (1.0 - 1e-12):
                    place = lies[j] - free
                    if place < lies[i]:
                        lies[i] = place
                        moved = True
    return first, end


@compiled("void(float64[:, :], int64[::1], float64[::1], float64, float64, int64[:, ::1])")
def in_sight(x: Floats, lines: Ints, ride: Floats, low: float, high: float, ends: Ints) -> None:
    """Which objects lie between two places of some belts, by halving.

    Args:
        x: where the objects of N belts lay at first, not increasing (N, M) [m].
        lines: which belts (K,).
        ride: how far each of these has run since (K,) [m].
        low: the place upstream [m].
        high: the place downstream [m].
        ends: filled with the first object, and the one behind the last (K, 2).
    """
    for k in range(len(lines)):
        for side in range(2):
            begin, end = 0, x.shape[1]
            while begin < end:
                middle = (begin + end) // 2
                place = x[lines[k], middle] + ride[k]
                if place > high or (side == 1 and place >= low):
                    begin = middle + 1
                else:
                    end = middle
            ends[k, side] = begin
