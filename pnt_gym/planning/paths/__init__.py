"""Paths of the hand as curves, without time: the ellipse of Choe et al. 2023 and the ones it is compared with."""

from pnt_gym.planning.paths.curves import (
    CurvePoints,
    Derivatives,
    EllipseArc,
    LameCorner,
    Line,
    MeasuredCurve,
    PlaneCurve,
)
from pnt_gym.planning.paths.ellipse import (
    EllipsePath,
    NodeList,
    approximate_half_circumference,
    half_circumference,
)
from pnt_gym.planning.paths.plane import Joint, PlanePath, SpacePath, lame_path, line_ellipse_line, rectangle

__all__ = [
    "CurvePoints",
    "Derivatives",
    "EllipseArc",
    "EllipsePath",
    "Joint",
    "LameCorner",
    "Line",
    "MeasuredCurve",
    "NodeList",
    "PlaneCurve",
    "PlanePath",
    "SpacePath",
    "approximate_half_circumference",
    "half_circumference",
    "lame_path",
    "line_ellipse_line",
    "rectangle",
]
