"""The paths and motions of Choe et al. 2023 that several parts of its reproduction use."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.planning import MotionLimits
from pnt_gym.planning.paths import EllipsePath

from .planning.plane import PlanePath, SpacePath, line_ellipse_line
from .planning.timing import INTERVALS, JointRule, TimedPath, time_path

HALF_WIDTH: Final = 0.150
"""l of the example [m]: the path is 300 mm wide."""
HALF_RISE: Final = 0.025
"""h of the example [m]: the place lies 50 mm above the pick."""
RATE: Final = 0.77
"""Rate r of the paper's node list; the paper's figures follow only with the unit rad/m."""
LIMITS: Final = MotionLimits.t3kr(30)
"""1.8 m/s, 36 m/s2, 900 m/s3; the paper states no limits."""
SHORT_LIFT: Final = 0.025
"""Length of the vertical parts that are added to the example where it is timed [m]."""
BELT: Final = -0.85
"""Height of the pick in the robot's workspace [m]."""

ASKEW: Final = (-0.09, -0.12, BELT)
"""Pick of the path whose arm angles are drawn [m]: 0.15 m from the middle of the workspace, the place opposite."""


def example() -> EllipsePath:
    """The ellipse of the paper's example."""
    return EllipsePath.paper(HALF_WIDTH, HALF_RISE)


def example_at(degrees: float) -> EllipsePath:
    """The ellipse between the example's ends whose major axis has the angle ``degrees``."""
    return EllipsePath.with_angle(HALF_WIDTH, HALF_RISE, math.radians(degrees))


def path_with_lines(ellipse: EllipsePath) -> PlanePath:
    """The path over an ellipse with vertical parts of `SHORT_LIFT` before and after it."""
    return line_ellipse_line(ellipse, SHORT_LIFT, SHORT_LIFT)


def path_askew(path: PlanePath) -> SpacePath:
    """The plane path from `ASKEW` to the opposite point: askew, so that all four arms move differently."""
    return SpacePath.between(path, ASKEW, (-ASKEW[0], -ASKEW[1], BELT + float(path.end[1] - path.start[1])))


@final
@dataclass(frozen=True, eq=False)
class Case:
    """A path that is timed."""

    path: PlanePath
    joints: JointRule = "strict"
    """Whether the hand stops where the curvature jumps ("strict") or passes ("relaxed")."""


@cache
def motion(case: Case, intervals: int | None = None) -> TimedPath:
    """The quickest motion of a case: along y, the workspace's long axis, across the middle, from the belt's height."""
    span: Floats = case.path.end - case.path.start
    pick = np.array([0.0, -0.5 * span[0], BELT])
    placed = SpacePath.between(case.path, pick, pick + np.array([0.0, span[0], span[1]]))
    return time_path(placed, LIMITS, joints=case.joints, intervals=intervals or INTERVALS)


@cache
def example_cases() -> Mapping[str, Case]:
    """The paper's ellipse, alone and with vertical parts of 25 mm, by name."""
    whole = path_with_lines(example())
    return {
        "arc": Case(line_ellipse_line(example(), 0.0, 0.0)),
        "ellipse-10deg-strict": Case(whole),
        "ellipse-10deg-relaxed": Case(whole, "relaxed"),
    }
