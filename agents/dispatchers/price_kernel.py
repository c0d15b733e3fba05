"""The best way of every robot through its moments, where each object has a price. Compiled."""

from __future__ import annotations

from typing import Final, NamedTuple

from pnt_gym.cells.line.links import EMPTY, THROWN, Links
from pnt_gym.cells.line.moments import Moment, Passage
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Bools1, Floats1, Floats2, Ints2, Row, Rows1, field

NOTHING: Final = -1
"""Row of a moment that does not exist."""
IMPOSSIBLE: Final = -1e30
"""Worth of a way through a moment from which no throw is possible."""


class Visit(Row):
    """A moment as the search for ways reads it."""

    row: int = field("-", "row of the moment")
    step: int = field("-", "its step")
    robot: int = field("-", "index of its robot")
    index: int = field("-", "index of its object")
    seal: float = field("-", "chance that the cup seals")
    failures: int = field("-", "attempts that have to fail before one seals")
    worth: float = field("-", "largest value that a sealed attempt brings")
    can_throw: bool = field("-", "whether a throw is possible")
    is_first: bool = field("-", "whether it is the first moment of its passage")
    is_last: bool = field("-", "whether it is the last moment of its passage")


class Network(NamedTuple):
    """Moments of a shift and what may follow each of them."""

    passages: Rows1[Passage]
    moments: Rows1[Moment]
    """All moments, passage by passage (N,)."""
    visits: Rows1[Visit]
    """The same in the order of their steps, the last one first (N,)."""
    links: Links
    """What may follow each moment."""


class Prices(NamedTuple):
    """Prices of M objects."""

    taken: Floats1
    """What a robot pays for an object that it lifts (M,)."""
    failed: Floats1
    """What a robot gets for an attempt that has to fail before another one seals, and then pays (M,)."""


class Ways(NamedTuple):
    """The best ways of R robots from each of N moments to the end of the shift."""

    worth: Floats1
    """What the way from a moment on brings, less the prices, where the hand may wait for a later one (N,)."""
    waits: Bools1
    """Whether the way waits for the next moment (N,)."""
    after: Floats2
    """What the way brings after each end of a moment (2, N)."""
    following: Ints2
    """The moment that follows each end of a moment; -1 for none (2, N)."""
    later: Floats2
    """What the best way brings whose first passage begins in a step or later (R, steps + 1)."""
    first: Ints2
    """The first moment of that way; -1 for none (R, steps + 1)."""


@kernel_part
def _carry_back(later: Floats2, first: Ints2, begin: int, end: int) -> None:
    """Carry the best ways of later steps back, from step `begin` - 1 to step `end`."""
    for step in range(begin - 1, end - 1, -1):
        for robot in range(len(later)):
            if later[robot, step + 1] > later[robot, step]:
                later[robot, step], first[robot, step] = later[robot, step + 1], first[robot, step + 1]


@kernel
def find_ways(network: Network, prices: Prices, ways: Ways) -> None:
    """Find the best ways of all robots.

    Args:
        network: the moments.
        prices: the prices of their objects.
        ways: written.
    """
    # Arrays are taken out of their tuples once: compiled code counts references each time, and in calls.
    begins, targets, fars = network.links
    worth, waits, after, following, later, first = ways
    waits[:], after[:], later[:], following[:], first[:] = False, 0.0, 0.0, NOTHING, NOTHING
    known = later.shape[1] - 1
    for visit in network.visits:
        n, robot, step = visit.row, visit.robot, visit.step
        _carry_back(later, first, known, step + 1)
        known = min(known, step + 1)
        for end in range(2):
            # Nothing is always possible, and brings nothing.
            best, row, far = 0.0, NOTHING, fars[end, n]
            for k in range(begins[end, n], begins[end, n + 1]):
                if worth[targets[k]] > best:
                    best, row = worth[targets[k]], targets[k]
            if 0 <= far < later.shape[1] and later[robot, far] > best:
                best, row = later[robot, far], first[robot, far]
            after[end, n], following[end, n] = best, row
        worth[n] = IMPOSSIBLE
        if visit.can_throw:
            failed = prices.failed[visit.index]
            sealed = visit.worth - prices.taken[visit.index] - visit.failures * failed + after[THROWN, n]
            worth[n] = visit.seal * sealed + (1.0 - visit.seal) * (failed + after[EMPTY, n])
        # The hand may wait for a later moment of the same passage.
        if not visit.is_last and worth[n + 1] > worth[n]:
            worth[n], waits[n] = worth[n + 1], True
        if visit.is_first and worth[n] > later[robot, step]:
            later[robot, step], first[robot, step] = worth[n], n
    _carry_back(later, first, known, 0)


@kernel
def count_uses(network: Network, ways: Ways, mass: Floats1, taken: Floats1, failed: Floats1) -> None:
    """Count how often the best ways take each object, and fail to, as expected numbers.

    Args:
        network: the moments.
        ways: the best ways.
        mass: written, chance that a way comes to each moment (N,).
        taken: written, attempts that seal for each object (M,).
        failed: written, attempts that do not (M,).
    """
    mass[:] = 0.0
    taken[:] = 0.0
    failed[:] = 0.0
    for robot in range(ways.first.shape[0]):
        if ways.first[robot, 0] >= 0:
            mass[ways.first[robot, 0]] += 1.0
    for visit in network.visits[::-1]:
        n = visit.row
        if mass[n] == 0.0:
            continue
        if ways.waits[n]:
            mass[n + 1] += mass[n]
            continue
        sealed = mass[n] * visit.seal
        taken[visit.index] += sealed
        failed[visit.index] += mass[n] - sealed
        for end in range(2):
            if ways.following[end, n] >= 0:
                mass[ways.following[end, n]] += sealed if end == THROWN else mass[n] - sealed
