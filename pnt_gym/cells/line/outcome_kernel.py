"""Fates of the objects of a work shift, counted in machine code; see `pnt_gym.compiled`."""

from __future__ import annotations

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.line.state import Fate
from pnt_gym.compiled import compile_for

RIDES, HELD, SORTED, MISPLACED, FLOOR = map(int, Fate)
# Rows of the counts: in a bin that takes the item, in another bin, on the floor, past the last window, and those of the
# latter that a robot has tried; and rows of the values: sorted, arrived, past the last window.
IN_RIGHT, IN_WRONG, ON_FLOOR, PASSED, TRIED = range(5)
VALUE, ARRIVED_VALUE, PASSED_VALUE = range(3)


@compile_for(
    "void(i8[:], f8[::1], f8, f8[:, :], f8[:, :], i8[:, :], i8[:, :], i8[:, :], i8[:, :], i8[:, :, ::1], i8[:, ::1],"
    "f8[:, :, ::1])"
)
def count_fates(
    rows: Ints,
    way: Floats,
    border: float,
    x: Floats,
    worth: Floats,
    kinds: Ints,
    fate: Ints,
    taker: Ints,
    attempts: Ints,
    fates: Ints,
    picks: Ints,
    worths: Floats,
) -> None:
    """Count the objects of the work shifts of some lines by fate and item, and by robot.

    Args:
        rows: indices of the lines (K,).
        way: ways of the belts in the shifts (K,) [m].
        border: downstream end of the last window [m].
        x: positions of the objects when the shift begins (N, M) [m].
        worth: values of the objects (N, M).
        kinds: items of the objects (N, M).
        fate: fates of the objects (N, M).
        taker: robots that took the objects, negative for none (N, M).
        attempts: numbers of attempts to pick the objects (N, M).
        fates: written to zeros, numbers of objects by the rows above (5, K, items).
        picks: written to zeros, objects that each robot took and does not hold (K, R).
        worths: written to zeros, values of the objects by the rows above, 0 for the other objects (3, K, M).
    """
    for k in range(len(rows)):
        for i in range(x.shape[1]):
            line = rows[k]
            state, kind = fate[line, i], kinds[line, i]
            if taker[line, i] >= 0 and state != HELD:
                picks[k, taker[line, i]] += 1
            if state == HELD or (state == RIDES and not x[line, i] + way[k] > border):
                continue
            worths[ARRIVED_VALUE, k, i] = worth[line, i]
            if state == SORTED:
                fates[IN_RIGHT, k, kind] += 1
                worths[VALUE, k, i] = worth[line, i]
            elif state == MISPLACED:
                fates[IN_WRONG, k, kind] += 1
            elif state == FLOOR:
                fates[ON_FLOOR, k, kind] += 1
            else:
                fates[PASSED, k, kind] += 1
                worths[PASSED_VALUE, k, i] = worth[line, i]
                fates[TRIED, k, kind] += attempts[line, i] > 0
