"""Paths of the hand as curves without time: the ellipse of Choe et al. 2023."""

from typing import TYPE_CHECKING

from pnt_gym.deferred import defer
from pnt_gym.errors import refuse_moved_names
from pnt_gym.planning.paths.ellipse import (
    Derivatives,
    EllipseArc,
    EllipsePath,
    NodeList,
    approximate_half_circumference,
    half_circumference,
)

__all__ = [
    "Derivatives",
    "EllipseArc",
    "EllipsePath",
    "NodeList",
    "approximate_half_circumference",
    "half_circumference",
]

defer(__name__, "arc_kernel")

if not TYPE_CHECKING:
    _CURVES = ("CurvePoints", "LameCorner", "Line", "MeasuredCurve", "PlaneCurve")
    _PLANE = ("Joint", "PlanePath", "SpacePath", "lame_path", "line_ellipse_line", "rectangle")
    __getattr__ = refuse_moved_names(
        __name__,
        {
            **dict.fromkeys(_CURVES, "papers.choe.planning.curves"),
            **dict.fromkeys(_PLANE, "papers.choe.planning.plane"),
        },
    )
