"""Which of several candidates a robot takes next: index rules, for one robot and for robots along one belt.

A rule is an index of each candidate; the robot takes the greatest. With the value v of a candidate, the time t that the
robot gives to it and the slack s that it has left:

* `first`: the one that leaves first, first in, first out. What most lines do, and the weakest where the belt is dense.
* `soonest`: 1 / t, the shortest cycle.
* `value_rate`: v / t.
* `atc`: (v / t) exp(-s / k), the apparent tardiness cost of Vepsalainen and Morton 1987: among those of like worth the
  one that cannot wait.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, Literal, final

import numpy as np

from pnt_gym.arrays import Bools, Floats

Rule = Literal["first", "soonest", "value_rate", "atc"]


@final
@dataclass(frozen=True)
class Candidates:
    """Objects that robots could take next, any leading shape S + (K,); K of them for each decision."""

    value: Floats
    """What each is worth."""
    time: Floats
    """From now until the robot is free again if it takes this one [s]."""
    start: Floats
    """From now until it would take it [s]."""
    leave: Floats
    """From now until it can no longer be taken [s]."""
    possible: Bools
    """Which can be taken at all; the numbers of others mean nothing."""


RULES: Final[Mapping[Rule, Callable[[Candidates, float], Floats]]] = {
    "first": lambda among, _: -among.leave,
    "soonest": lambda among, _: 1.0 / among.time,
    "value_rate": lambda among, _: among.value / among.time,
    "atc": lambda among, patience: among.value / among.time * np.exp((among.start - among.leave) / patience),
}


def index(rule: Rule, among: Candidates, patience: float) -> Floats:
    """The rule's index of each candidate S + (K,); minus infinity for what cannot be taken.

    Args:
        rule: one of `RULES`.
        among: the candidates.
        patience: k of `atc` [s]: a candidate that can wait so long counts e times less.
    """
    # What cannot be taken may hold any number, NaN included.
    with np.errstate(all="ignore"):
        return np.where(among.possible, RULES[rule](among, patience), -np.inf)
