"""Dispatching rules that choose a robot's next candidate, for one robot and for robots along one belt.

A rule computes an index of each candidate; the robot takes the candidate of the greatest index. With the value v of a
candidate, the time t from now until the robot is free again, and the slack s before the candidate can no longer be
taken:

* `first`: the candidate that leaves first; first in, first out. Most lines use this rule; on a dense belt it is the
  weakest.
* `soonest`: 1 / t, the shortest cycle.
* `value_rate`: v / t.
* `atc`: (v / t) exp(-s / k), the apparent tardiness cost of Vepsalainen and Morton 1987: among candidates of like
  v / t the candidate that cannot wait.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, Literal, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.errors import PlanningError
from pnt_gym.names import unknown_name

Rule = Literal["first", "soonest", "value_rate", "atc"]


@final
@dataclass(frozen=True)
class Candidates:
    """Objects that robots could take next: arrays S + (K,), with K candidates for each decision in S."""

    value: Floats
    """Value of each candidate."""
    time: Floats
    """Time from now until the robot is free again if it takes the candidate [s]."""
    start: Floats
    """Time from now until the robot would take the candidate [s]."""
    leave: Floats
    """Time from now until the candidate can no longer be taken [s]."""
    possible: Bools
    """Whether each candidate can be taken; the numbers of impossible candidates mean nothing."""


RULES: Final[Mapping[Rule, Callable[[Candidates, float], Floats]]] = {
    "first": lambda among, _: -among.leave,
    "soonest": lambda among, _: 1.0 / among.time,
    "value_rate": lambda among, _: among.value / among.time,
    "atc": lambda among, patience: among.value / among.time * np.exp((among.start - among.leave) / patience),
}


def index(rule: Rule, candidates: Candidates, patience: float) -> Floats:
    """The rule's index of each candidate S + (K,); minus infinity for candidates that cannot be taken.

    Args:
        rule: a name of `RULES`.
        candidates: the candidates.
        patience: k of `atc` [s]: a candidate that can wait for k counts e times less.

    Raises:
        PlanningError: there is no such rule.
    """
    if rule not in RULES:
        raise PlanningError(unknown_name("rule", rule, RULES))
    # Impossible candidates may hold any number, NaN included.
    with np.errstate(all="ignore"):
        return np.where(candidates.possible, RULES[rule](candidates, patience), -np.inf)
