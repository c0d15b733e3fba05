"""Places of objects along belts: how far upstream each object gives way.

Compiled; see `pnt_gym.compiled`.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel
from pnt_gym.errors import ConfigError
from pnt_gym.rows import Row, Rows1, field

PIECE: Final = 256
"""Objects that are placed in one call of compiled code, which Ctrl-C cannot interrupt: some milliseconds."""
MOST_IN_THE_WAY: Final = 2000
"""Objects to which one object may have to give way; with more, an endless belt would jam."""


@final
class LyingObject(Row):
    """An object that comes onto a belt."""

    x: float = field("m", "place along the belt")
    y: float = field("m", "place across the belt")
    along: float = field("m", "half extent along the belt")
    across: float = field("m", "half extent across the belt")


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
    objects = LyingObject.zeros(len(x), x=x, y=y, along=along, across=across)
    first, farthest = 0, 2.0 * float(np.max(along, initial=0.0)) + gap
    for begin in range(0, len(objects), PIECE):
        end = min(begin + PIECE, len(objects))
        first, reached = _settle(objects, gap, farthest, first, begin, end)
        if reached < end:
            raise Jam((reached - first) / max(float(np.ptp(objects["x"][first:reached])), farthest))
    return objects["x"].copy()


@kernel
def _settle(
    objects: Rows1[LyingObject], gap: float, farthest: float, first: int, begin: int, end: int
) -> tuple[int, int]:
    """Move the objects from `begin` to `end` to their places, in place; earlier objects lie at theirs.

    Args:
        objects: all objects (M,).
        gap: see `separate`.
        farthest: distance along the belt from which on no object is in the way of another [m].
        first: the first object that may be in the way of the objects from `begin` on.
        begin: the first object that moves.
        end: the index after the last object that moves.

    Returns:
        The first object that may be in the way of the objects from `end` on, and `end`; or the object that has too many
        objects in its way.
    """
    for i in range(begin, end):
        mover = objects[i]
        arrival = mover.x
        # Objects far downstream of object i are far downstream of all later objects too.
        while first < i and objects[first].x > arrival + farthest:
            first += 1
        if i - first > MOST_IN_THE_WAY:
            return first, i
        # An object that gives way to one object may come to lie on another, so all are checked again until none is in
        # the way. Moves within rounding are skipped. Every other move goes upstream to one of i - first places, so the
        # loop ends.
        moved = True
        while moved:
            moved = False
            for j in range(first, i):
                other = objects[j]
                spacing, aside = mover.along + other.along + gap, mover.across + other.across + gap
                if abs(mover.y - other.y) < aside and abs(other.x - mover.x) < spacing * (1.0 - 1e-12):
                    place = other.x - spacing
                    if place < mover.x:
                        mover.x = place
                        moved = True
    return first, end
