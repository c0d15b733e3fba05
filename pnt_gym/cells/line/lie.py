"""Places of objects along belts: how far upstream each object gives way.

Compiled; see `pnt_gym.compiled`.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import compile_for
from pnt_gym.errors import ConfigError

PIECE: Final = 256
"""Objects that are placed in one call of compiled code, which Ctrl-C cannot interrupt: some milliseconds."""
MOST_IN_THE_WAY: Final = 2000
"""Objects to which one object may have to give way; with more, an endless belt would jam."""


@final
class Jam(ConfigError):
    """Objects come faster than they find room.

    Args:
        room: objects on a metre of the belt where the belt is jammed [1/m].
    """

    def __init__(self, room: float) -> None:
        super().__init__(f"objects come faster than they find room; the belt holds {room:.3g} objects on a metre")
        self.room = room


def separate(x: Floats, y: Floats, along: Floats, across: Floats, gap: float) -> Floats:
    """Places of objects that come in at x, most downstream first; each object gives way to earlier ones.

    No two objects lie closer than the gap, apart from rounding: 1e-12 of the distance of their middles, or half a unit
    in the last place of their positions, whichever is larger (1e-11 m at 100 km).

    Args:
        x: where each object would lie along the belt, which runs to greater x; not increasing (M,) [m].
        y: position of each object across the belt (M,) [m].
        along: half the object's extent along the belt (M,) [m].
        across: half the object's extent across the belt (M,) [m].
        gap: least distance of the rectangles around two objects, along or across [m].

    Raises:
        Jam: an object has more than `MOST_IN_THE_WAY` objects in its way.
    """
    places, first, farthest = np.array(x, dtype=np.float64), 0, 2.0 * float(np.max(along, initial=0.0)) + gap
    y, along, across = (np.ascontiguousarray(extent) for extent in (y, along, across))
    for begin in range(0, len(places), PIECE):
        end = min(begin + PIECE, len(places))
        first, reached = _settle(places, y, along, across, gap, farthest, first, begin, end, MOST_IN_THE_WAY)
        if reached < end:
            raise Jam((reached - first) / max(float(np.ptp(places[first:reached])), farthest))
    return places


@compile_for(
    "UniTuple(int64, 2)(float64[::1], float64[::1], float64[::1], float64[::1], float64, float64, int64, int64, int64,"
    "int64)"
)
def _settle(
    places: Floats,
    y: Floats,
    along: Floats,
    across: Floats,
    gap: float,
    farthest: float,
    first: int,
    begin: int,
    end: int,
    limit: int,
) -> tuple[int, int]:
    """Move the objects from `begin` to `end` to their places, in place.

    Args:
        places: places of all objects before `begin`, and arrivals of the later ones (M,) [m].
        y: see `separate`.
        along: see `separate`.
        across: see `separate`.
        gap: see `separate`.
        farthest: distance along the belt from which on no object is in the way of another [m].
        first: the first object that may be in the way of the objects from `begin` on.
        begin: the first object that moves.
        end: the index after the last object that moves.
        limit: number of objects that may be in the way of one object.

    Returns:
        The first object that may be in the way of the objects from `end` on, and `end`; or the object that has too many
        objects in its way.
    """
    for i in range(begin, end):
        arrival = places[i]
        # Objects far downstream of object i are far downstream of all later objects too.
        while first < i and places[first] > arrival + farthest:
            first += 1
        if i - first > limit:
            return first, i
        # An object that gives way to one object may come to lie on another, so all are checked again until none is in
        # the way. Moves within rounding are skipped. Every other move goes upstream to one of i - first places, so the
        # loop ends.
        moved = True
        while moved:
            moved = False
            for j in range(first, i):
                spacing = along[i] + along[j] + gap
                if abs(y[i] - y[j]) < across[i] + across[j] + gap and abs(places[j] - places[i]) < spacing * (
                    1.0 - 1e-12
                ):
                    place = places[j] - spacing
                    if place < places[i]:
                        places[i] = place
                        moved = True
    return first, end
