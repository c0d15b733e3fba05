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

from .planning.plane import PlanePath, SpacePath, lame_path, line_ellipse_line, rectangle
from .planning.timing import INTERVALS, JointRule, TimedPath, time_path

HALF_WIDTH: Final = 0.150
"""l of the example [m]: the path is 300 mm wide."""
HALF_RISE: Final = 0.025
"""h of the example [m]: the place lies 50 mm above the pick."""
RATE: Final = 0.77
"""Rate r of the paper's node list; the paper's figures follow only with the unit rad/m."""
LIMITS: Final = MotionLimits.t3kr(30)
"""1.8 m/s, 36 m/s2, 900 m/s3; the paper states no limits."""
SPAN: Final = 0.82
"""Width of the long pick and place of the comparison of times [m]."""
LIFT: Final = 0.10
"""Height of the long path above both ends [m]."""
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


def level_ellipse(vertical: float) -> PlanePath:
    """A path over `SPAN`: vertical parts of ``vertical`` [m] and a symmetric ellipse up to `LIFT`."""
    return line_ellipse_line(EllipsePath.with_top(0.5 * SPAN, 0.0, LIFT - vertical), vertical, vertical)


def level_lame(vertical: float, width: float, height: float, exponent: float = 3.0) -> PlanePath:
    """A path over `SPAN`: vertical parts of ``vertical`` and Lamé corners of ``width`` by ``height`` [m]."""
    return lame_path(SPAN, vertical, vertical, (width, height), exponent)


@final
@dataclass(frozen=True, eq=False)
class Case:
    """A path that is timed."""

    name: str
    """Last part of the quantity's name in rows."""
    label: str
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
def long_cases() -> Mapping[str, Case]:
    """Paths of the pick and place over 0.82 m, by name."""
    low, high = level_ellipse(0.05), level_ellipse(0.02)
    corners = [
        Case(f"lame-50mm-d{round(1000 * width)}", f"Lamé m = 3, d = {width:.2f} m", level_lame(0.05, width, 0.05))
        for width in (0.05, 0.10, 0.20, 0.41)
    ]
    return _cases_by_name(
        Case("rectangle", "rectangle", rectangle(SPAN, LIFT, LIFT)),
        Case("ellipse-50mm-strict", "ellipse, strict", low),
        Case("ellipse-50mm-relaxed", "ellipse, relaxed", low, "relaxed"),
        *corners,
        Case("lame-50mm-level", "Lamé m = 3.5, d = 0.12 m", level_lame(0.05, 0.12, 0.05, 3.5)),
        Case("lame-50mm-tall", "Lamé m = 3, d = 0.16 m, 0.15 m high", level_lame(0.05, 0.16, 0.10)),
        Case("ellipse-20mm-strict", "ellipse, strict", high),
        Case("ellipse-20mm-relaxed", "ellipse, relaxed", high, "relaxed"),
        Case("lame-20mm-d200", "Lamé m = 3, d = 0.20 m", level_lame(0.02, 0.20, 0.08)),
        Case("ellipse-0mm", "half ellipse alone", level_ellipse(0.0)),
    )


@cache
def example_cases() -> Mapping[str, Case]:
    """The paper's ellipse, alone and with vertical parts of 25 mm, and its neighbours, by name."""
    whole = path_with_lines(example())
    top = SHORT_LIFT + example().height
    neighbours = [
        Case(
            f"ellipse-{degrees:g}deg-relaxed",
            f"ellipse of {degrees:g}°",
            path_with_lines(example_at(degrees)),
            "relaxed",
        )
        for degrees in (9.5, 12.0, 15.0)
    ]
    return _cases_by_name(
        Case("arc", "ellipse of 10° alone", line_ellipse_line(example(), 0.0, 0.0)),
        Case("rectangle", "rectangle", rectangle(2.0 * HALF_WIDTH, top, top - 2.0 * HALF_RISE)),
        Case("ellipse-10deg-strict", "ellipse of 10°, strict", whole),
        Case("ellipse-10deg-relaxed", "ellipse of 10°", whole, "relaxed"),
        *neighbours,
    )


def _cases_by_name(*cases: Case) -> dict[str, Case]:
    return {case.name: case for case in cases}
