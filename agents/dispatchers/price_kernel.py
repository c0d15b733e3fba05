"""The best way of every robot through its moments, where each object has a price. Compiled."""

from __future__ import annotations

from typing import Final, NamedTuple

from pnt_gym.cells.line.links import Links
from pnt_gym.cells.line.moments import Moment, Passage
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Bools1, Floats1, Floats2, Ints1, Ints2, Rows1

NOTHING: Final = -1
"""Row of a moment that does not exist."""
IMPOSSIBLE: Final = -1e30
"""Worth of a way through a moment from which no throw is possible."""


class Network(NamedTuple):
    """Moments of a shift and what may follow each of them."""

    passages: Rows1[Passage]
    moments: Rows1[Moment]
    """All moments, passage by passage (N,)."""
    passage_of: Ints1
    """Row of each moment's passage (N,)."""
    step_of: Ints1
    """Step of each moment (N,)."""
    latest_first: Ints1
    """Rows of the moments in the order of their steps, the last one first (N,)."""
    thrown: Links
    """What may follow a throw."""
    empty: Links
    """What may follow an attempt whose cup did not seal."""


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
    after_throw: Floats1
    """What the way brings after a throw (N,)."""
    after_empty: Floats1
    """What the way brings after an attempt whose cup did not seal (N,)."""
    next_thrown: Ints1
    """The moment that follows a throw; -1 for none (N,)."""
    next_empty: Ints1
    """The moment that follows an attempt whose cup did not seal; -1 for none (N,)."""
    later: Floats2
    """What the best way brings whose first passage begins in a step or later (R, steps + 1)."""
    first: Ints2
    """The first moment of that way; -1 for none (R, steps + 1)."""


@kernel_part
def _best_follower(links: Links, n: int, robot: int, ways: Ways) -> tuple[float, int]:
    """What the best moment after moment n brings, and its row; nothing is always possible."""
    best, row = 0.0, NOTHING
    for k in range(links.first[n], links.first[n + 1]):
        if ways.worth[links.target[k]] > best:
            row = int(links.target[k])
            best = float(ways.worth[row])
    far = links.far[n]
    if 0 <= far < ways.later.shape[1] and ways.later[robot, far] > best:
        best, row = float(ways.later[robot, far]), int(ways.first[robot, far])
    return best, row


@kernel_part
def _carry_back(ways: Ways, begin: int, end: int) -> None:
    """Carry the best ways of later steps back, from step `begin` - 1 to step `end`."""
    for step in range(begin - 1, end - 1, -1):
        for robot in range(ways.later.shape[0]):
            if ways.later[robot, step + 1] > ways.later[robot, step]:
                ways.later[robot, step] = ways.later[robot, step + 1]
                ways.first[robot, step] = ways.first[robot, step + 1]


@kernel_part
def _value_moment(network: Network, prices: Prices, n: int, ways: Ways) -> None:
    """Write the best way from a moment on; those of later steps are known."""
    passage, moment = network.passages[network.passage_of[n]], network.moments[n]
    ways.worth[n], ways.waits[n] = IMPOSSIBLE, False
    ways.after_throw[n], ways.next_thrown[n] = _best_follower(network.thrown, n, passage.robot, ways)
    ways.after_empty[n], ways.next_empty[n] = _best_follower(network.empty, n, passage.robot, ways)
    if moment.can_throw:
        failed = prices.failed[passage.index]
        sealed = moment.worth - prices.taken[passage.index] - passage.failures * failed + ways.after_throw[n]
        ways.worth[n] = passage.seal * sealed + (1.0 - passage.seal) * (failed + ways.after_empty[n])
    is_last = n + 1 == passage.first_row + passage.count
    if not is_last and ways.worth[n + 1] > ways.worth[n]:
        ways.worth[n], ways.waits[n] = ways.worth[n + 1], True


@kernel
def find_ways(network: Network, prices: Prices, ways: Ways) -> None:
    """Find the best ways of all robots.

    Args:
        network: the moments.
        prices: the prices of their objects.
        ways: written.
    """
    ways.later[:] = 0.0
    ways.first[:] = NOTHING
    known = ways.later.shape[1] - 1
    for n in network.latest_first:
        step = int(network.step_of[n])
        _carry_back(ways, known, step + 1)
        known = min(known, step + 1)
        _value_moment(network, prices, n, ways)
        passage = network.passages[network.passage_of[n]]
        if n == passage.first_row and ways.worth[n] > ways.later[passage.robot, step]:
            ways.later[passage.robot, step], ways.first[passage.robot, step] = ways.worth[n], n
    _carry_back(ways, known, 0)


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
    for n in network.latest_first[::-1]:
        if mass[n] == 0.0:
            continue
        if ways.waits[n]:
            mass[n + 1] += mass[n]
            continue
        passage = network.passages[network.passage_of[n]]
        sealed = mass[n] * passage.seal
        taken[passage.index] += sealed
        failed[passage.index] += mass[n] - sealed
        if ways.next_thrown[n] >= 0:
            mass[ways.next_thrown[n]] += sealed
        if ways.next_empty[n] >= 0:
            mass[ways.next_empty[n]] += mass[n] - sealed
