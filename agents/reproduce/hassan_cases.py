"""The experiments of Hassan et al. 2022: points, percentages, the published Table I, and our protocols for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Final, final

import numpy as np

from pnt_gym.planning import EllipticWorkspace, MotionLimits
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.cycle import Cycle, CycleRules, horizontal_throw, min_time_throw, pick_and_place

PICKS: Final = ((-0.2, -0.25, -0.85), (-0.2, -0.35, -0.85), (-0.3, -0.35, -0.85))
"""The three picks [m], visited in this order and again from the first (section IV-B1)."""

INITIAL: Final = (0.0, -0.77, 0.0)
"""Where the experiments start and end, P_initial [m] (section IV-B1)."""

TARGETS: Final = {"inside": (0.3, 0.4, -0.85), "outside": (0.45, 0.65, -0.85)}
"""Targets inside and outside the workspace [m] (sections IV-B1 and IV-C3)."""

PERCENTAGES: Final = {"inside": (15, 30, 40), "outside": (35, 40, 45)}

METHODS: Final[dict[str, Callable[..., Cycle]]] = {
    "pick-and-place": pick_and_place,
    "horizontal-throw": horizontal_throw,
    "min-time-throw": min_time_throw,
}
"""Standard pick-and-place, the existing throw and the proposed throw (sections IV-B1 to IV-B3)."""

Key = tuple[str, str, int]
"""Method, zone and percentage: one cell of the table."""

PUBLISHED: Final[dict[Key, int]] = {
    ("pick-and-place", "inside", 15): 24,
    ("pick-and-place", "inside", 30): 42,
    ("pick-and-place", "inside", 40): 51,
    ("horizontal-throw", "inside", 15): 29,
    ("horizontal-throw", "inside", 30): 56,
    ("horizontal-throw", "inside", 40): 75,
    ("min-time-throw", "inside", 15): 30,
    ("min-time-throw", "inside", 30): 68,
    ("min-time-throw", "inside", 40): 120,
    ("horizontal-throw", "outside", 35): 54,
    ("horizontal-throw", "outside", 40): 60,
    ("horizontal-throw", "outside", 45): 65,
    ("min-time-throw", "outside", 35): 62,
    ("min-time-throw", "outside", 40): 71,
    ("min-time-throw", "outside", 45): 81,
}
"""Table I [picks/min]."""

FOLD: Final[Key] = ("min-time-throw", "inside", 40)
"""The cell whose first throw lies where the feasible elevations jump from a flat to a steep branch."""

WORKSPACE: Final = EllipticWorkspace()


@final
@dataclass(frozen=True)
class Protocol:
    """One way to clock all cells alike.

    Attributes:
        rules: how the cycles are made.
        note: the rules in one sentence.
    """

    rules: CycleRules
    note: str


PROTOCOLS: Final = {
    "paper-clock": Protocol(
        CycleRules(),
        "closed loop over the three picks, every move a minimum-time S-curve, moves overlap by whole ramps",
    ),
    "limits-respected": Protocol(
        CycleRules(overlap="none", returning="fastest"),
        "closed loop within the limits: straight S-curves with a stop at every corner up to the release or place, "
        "then the fastest motion found",
    ),
    "jerk-overlap": Protocol(
        CycleRules(overlap="jerk"), "as paper-clock, but moves overlap by their outermost jerk phase only"
    ),
    "no-overlap": Protocol(CycleRules(overlap="none"), "as paper-clock, but every move ends before the next begins"),
}


@cache
def cell_cycle(protocol: str, method: str, zone: str, percent: float) -> Cycle:
    """The cycles of one cell: three rows, one per pick of the loop, the last one back to the first pick.

    Raises:
        ValueError: if the protocol, method or zone is unknown or the percentage lies outside (0, 100].
    """
    known: tuple[tuple[str, str, tuple[str, ...]], ...] = (
        ("protocol", protocol, tuple(PROTOCOLS)),
        ("method", method, tuple(METHODS)),
        ("zone", zone, tuple(TARGETS)),
    )
    for name, value, choices in known:
        if value not in choices:
            raise ValueError(f"{name} must be one of {', '.join(choices)}, got {value!r}")
    return loop(method, zone, MotionLimits.t3kr(percent), PROTOCOLS[protocol].rules)


def loop(
    method: str,
    zone: str,
    limits: MotionLimits,
    rules: CycleRules,
    workspace: EllipticWorkspace | None = WORKSPACE,
) -> Cycle:
    """The three cycles of the loop under any limits and rules."""
    picks, targets, following = scene(zone)
    return METHODS[method](picks, targets, following, limits, rules, workspace)


def scene(zone: str) -> tuple[Floats, Floats, Floats]:
    """Picks, targets and next picks of the loop, each (3, 3) [m]."""
    picks = np.array(PICKS)
    return picks, np.tile(TARGETS[zone], (len(picks), 1)), np.roll(picks, -1, axis=0)


def picks_per_min(cycle: Cycle, dwell: float = 0.0) -> float:
    """Picks per minute of a loop whose gripper waits ``dwell`` [s] at every pick.

    Raises:
        InfeasibleThrow: if a cycle of the loop has no plan.
    """
    return 60.0 * len(cycle) / float((cycle.require().duration + dwell).sum())
