"""The experiments of Hassan et al. 2022: points, percentages, the published Table I, and our protocols for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.errors import PlanningError
from pnt_gym.names import unknown_name
from pnt_gym.planning import EllipticWorkspace, MotionLimits

from .planning.cycle import Cycle, CycleRules, CycleTask, horizontal_throw, min_time_throw, pick_and_place

PICKS: Final = ((-0.2, -0.25, -0.85), (-0.2, -0.35, -0.85), (-0.3, -0.35, -0.85))
"""The three picks [m], visited in this order and again from the first (section IV-B1)."""

INITIAL: Final = (0.0, -0.77, 0.0)
"""First and last point of the experiments, P_initial [m] (section IV-B1)."""

TARGETS: Final = {"inside": (0.3, 0.4, -0.85), "outside": (0.45, 0.65, -0.85)}
"""Targets inside and outside the workspace [m] (sections IV-B1 and IV-C3)."""

PERCENTAGES: Final = {"inside": (15, 30, 40), "outside": (35, 40, 45)}

CELLS: Final = tuple((zone, percent) for zone, percents in PERCENTAGES.items() for percent in percents)
"""Columns of Table I."""

METHODS: Final[dict[str, Callable[[CycleTask], Cycle]]] = {
    "pick-and-place": pick_and_place,
    "horizontal-throw": horizontal_throw,
    "min-time-throw": min_time_throw,
}
"""Standard pick-and-place, the existing throw and the proposed throw (sections IV-B1 to IV-B3)."""

TITLES: Final = {
    "pick-and-place": "pick-and-place",
    "horizontal-throw": "horizontal throw",
    "min-time-throw": "minimum-time throw",
}
"""Names of the methods for people."""

Key = tuple[str, str, int]
"""Method, zone and percentage: one cell of Table I."""

ByCell: TypeAlias = Mapping[Key, float]
"""One figure for every cell of Table I."""

PUBLISHED: Final[dict[Key, int]] = {
    (method, zone, percent): picks
    for method, zone, line in (
        ("pick-and-place", "inside", (24, 42, 51)),
        ("horizontal-throw", "inside", (29, 56, 75)),
        ("min-time-throw", "inside", (30, 68, 120)),
        ("horizontal-throw", "outside", (54, 60, 65)),
        ("min-time-throw", "outside", (62, 71, 81)),
    )
    for percent, picks in zip(PERCENTAGES[zone], line, strict=True)
}
"""Table I [picks/min]."""

FOLD: Final[Key] = ("min-time-throw", "inside", 40)
"""The cell at whose first throw the feasible elevations jump from a flat to a steep branch."""

CLOSE, CLOSE_FOLD = 0.06, 0.10
"""Relative difference up to which a cell counts as reproduced: any cell, and `FOLD`, which jumps for small causes."""

WORKSPACE: Final = EllipticWorkspace()

RISE: Final = 0.10
"""Greatest height of a release above its pick [m]: the height of the published release points (section IV-B3)."""

CEILING: Final = PICKS[0][2] + RISE
"""Greatest absolute height of a release [m]; all picks lie at one height."""

JERK: Final = 3000.0
"""Largest jerk of the robot [m/s3] (section IV-B3)."""

LIMIT_TOLERANCE: Final = 1e-6
"""Relative excess over a limit that counts as rounding or as the solver's tolerance."""


@final
@dataclass(frozen=True)
class Protocol:
    """Rules by which the cycle times of all cells of Table I are computed.

    Attributes:
        label: name for tables and drawings.
        rules: rules by which the cycles are planned.
        note: the rules in one sentence.
        constant_jerk: whether the jerk limit is 3000 m/s3 at every percentage, instead of scaled like other limits.
        reading: whether the protocol may be the paper's, so that its figures get verdicts; a protocol that is no
            reading shows the effect of a single rule.
        fitted: whether the rules were chosen by Table I itself; such a protocol proves nothing about the table, nor do
            the peaks of its motions.
    """

    label: str
    rules: CycleRules
    note: str
    constant_jerk: bool = False
    reading: bool = False
    fitted: bool = False

    def limits(self, percent: float) -> MotionLimits:
        """The robot's limits at a percentage in (0, 100]."""
        return limits_at(percent, constant_jerk=self.constant_jerk)


PROTOCOLS: Final = {
    "paper-clock": Protocol(
        "paper clock",
        CycleRules(rise=RISE),
        "closed loop over the three picks, every move a minimum-time S-curve, moves overlap by whole ramps; jerk "
        "scaled with the percentage",
        reading=True,
        fitted=True,
    ),
    "constant-jerk-overlap": Protocol(
        "paper's path, speed and acceleration kept, J constant",
        CycleRules(rise=RISE, overlap="jerk"),
        f"as paper-clock, but moves overlap by their outermost jerk phase only; J = {JERK:g} m/s3 at every percentage",
        constant_jerk=True,
        reading=True,
    ),
    "constant-jerk-stops": Protocol(
        "paper's path, every limit kept, J constant",
        CycleRules(rise=RISE, overlap="none"),
        "as paper-clock, but every move ends before the next begins, while III-C blends the corners; "
        f"J = {JERK:g} m/s3 at every percentage",
        constant_jerk=True,
    ),
    "jerk-overlap": Protocol(
        "jerk phases overlap, J scaled",
        CycleRules(rise=RISE, overlap="jerk"),
        "as paper-clock, but moves overlap by their outermost jerk phase only",
    ),
}
CHOSEN: Final = "overlap, clock, lift and vertical approach were chosen by this table, so that it judges no cell"
"""Sentence about the rules of the paper clock."""
SHOWN: Final = ("constant-jerk-overlap", "paper-clock", "constant-jerk-stops")
"""Protocols by which Table I is computed, the paper's own path first; all keep that path."""


def limits_at(percent: float, *, constant_jerk: bool = False) -> MotionLimits:
    """The robot's limits at a percentage; the jerk limit is scaled like speed and acceleration, or left at 3000 m/s3.

    Section IV-C scales speed and acceleration only, the numeric example of section IV-B3 the jerk as well.

    Raises:
        ValueError: the percentage lies outside (0, 100].
    """
    velocity, acceleration, jerk = MotionLimits.t3kr(percent).numbers()
    return MotionLimits(velocity, acceleration, JERK if constant_jerk else jerk)


@cache
def cell_cycle(protocol: str, method: str, zone: str, percent: float) -> Cycle:
    """The cycles of one cell of Table I: three rows, one per pick of the loop; the last row returns to the first pick.

    Raises:
        ValueError: if the protocol, method or zone is unknown or the percentage lies outside (0, 100].
    """
    arguments = (("protocol", protocol, PROTOCOLS), ("method", method, METHODS), ("zone", zone, TARGETS))
    for name, value, choices in arguments:
        if value not in choices:
            raise PlanningError(unknown_name(name, value, choices))
    return loop(method, zone, PROTOCOLS[protocol].limits(percent), PROTOCOLS[protocol].rules)


def loop(
    method: str,
    zone: str,
    limits: MotionLimits,
    rules: CycleRules,
    workspace: EllipticWorkspace | None = WORKSPACE,
) -> Cycle:
    """The three cycles of the loop over the paper's picks, by a method under any limits and rules."""
    picks, targets, following = scene(zone)
    return METHODS[method](CycleTask.of(picks, targets, following, limits, rules, workspace))


def scene(zone: str) -> tuple[Floats, Floats, Floats]:
    """Picks, targets and next picks of the loop, each (3, 3) [m]."""
    picks = np.array(PICKS)
    return picks, np.tile(TARGETS[zone], (len(picks), 1)), np.roll(picks, -1, axis=0)


def picks_per_min(cycle: Cycle) -> float:
    """Picks per minute of a loop.

    Raises:
        InfeasibleThrow: if a cycle of the loop is infeasible.
    """
    return 60.0 * len(cycle) / float(cycle.require().duration.sum())


def cycle_details(cycle: Cycle) -> dict[str, Any]:
    """Entries of a loop's row: cycle and release times."""
    return {"cycle_times_s": cycle.duration.tolist(), "release_times_s": cycle.release_time.tolist()}


def differences(values: ByCell) -> dict[Key, float]:
    """Absolute relative difference of each cell's picks per minute to the published picks per minute."""
    return {cell: abs(picks / PUBLISHED[cell] - 1.0) for cell, picks in values.items()}
