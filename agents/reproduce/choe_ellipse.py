"""The ellipse of Choe et al. 2023: the published example, its length, and the rule that chooses the angle."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.reproduce.choe_cases import HALF_RISE, HALF_WIDTH, SHORT_LIFT, example, example_at
from agents.reproduce.findings import Findings, Part, Row
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.paths import EllipsePath, approximate_half_circumference, half_circumference

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CRITICAL: Final = math.degrees(math.atan(HALF_RISE / HALF_WIDTH))
"""Critical angle of the example [deg]."""
CHORD: Final = 2.0 * math.hypot(HALF_WIDTH, HALF_RISE)
"""From T1 to T2 on a straight line [m]."""


def example_findings() -> Findings:
    """Every printed number of the example, and the claims about it."""
    rows = [*_printed(), *_corrected(), *_claims()]
    return Findings(tuple(rows), figures={"choe_ellipse.svg": svg(ellipse_figure())})


def _printed() -> list[Row]:
    e = example()
    name = "choe/example"
    return [
        Row(f"{name}/angle", 10.0, math.degrees(e.angle), "deg", "reproduced", f"{CRITICAL:.4f} deg rounded up"),
        Row(f"{name}/semi-major", 0.15219, e.semi_major, "m", "reproduced"),
        Row(f"{name}/semi-minor", 0.03511, e.semi_minor, "m", "reproduced"),
        Row(f"{name}/length-eq-27", 0.32058, e.approximate_length, "m", "reproduced", "the paper's approximation"),
        Row(f"{name}/top-x", 0.08617, e.top[0], "m", "reproduced"),
        Row(f"{name}/top-y", 0.04352, e.top[1], "m", "reproduced"),
        Row(f"{name}/height", 0.06852, e.height, "m", "reproduced", "top above T1: y of the top plus h"),
    ]


def _corrected() -> list[Row]:
    e = example()
    first, last = math.degrees(e.theta_t1), math.degrees(e.theta_t2)
    note = "Eqs. 41 and 42; the results print the two values with their names exchanged"
    return [
        Row("choe/example/theta-t1", -2.329, first, "deg", "misprint", note),
        Row("choe/example/theta-t2", 177.671, last, "deg", "misprint", note),
        Row(
            "choe/example/length",
            0.32058,
            e.length,
            "m",
            "misprint",
            f"complete elliptic integral; what is printed is Eq. 27, "
            f"{100.0 * (1.0 - e.approximate_length / e.length):.2f} % short",
        ),
        Row(
            "choe/misprint/eq-38",
            0.06852,
            _height_as_printed(e),
            "m",
            "misprint",
            "Eq. 38 as printed gives the top above the centre; the printed height needs + h",
        ),
        Row(
            "choe/misprint/equation-numbers",
            "(24), (25): top point",
            "Eqs. 37, 38",
            "-",
            "misprint",
            f"the text cites another numbering; evaluated, Eq. 24 is the ellipse itself, A x^2 + B x y + C y^2 = "
            f"{_equation_24(e):.3f} at the top, and Eq. 37 gives the top",
            {"cited_and_meant": CITED},
        ),
    ]


CITED: Final = {
    "(16)": "27",
    "(17)": "28",
    "(18)": "29",
    "(18)-(20)": "29-31",
    "(21)": "33",
    "(24), (25)": "37, 38",
    "(26), (27)": "41, 42",
    "(29)": "44 (34 in the derivation)",
    "(30), (31)": "45, 46",
    "(32)": "47",
    "(34)": "50, 51",
}
"""Equations as the text cites them and as they are numbered."""


def _coefficients(e: EllipsePath) -> tuple[float, float, float]:
    """A, B, C of Eq. 25."""
    a, b, phi = e.semi_major, e.semi_minor, e.angle
    cos, sin = math.cos(phi), math.sin(phi)
    return (
        (cos / a) ** 2 + (sin / b) ** 2,
        math.sin(2.0 * phi) * (1.0 / a**2 - 1.0 / b**2),
        (sin / a) ** 2 + (cos / b) ** 2,
    )


def _equation_24(e: EllipsePath) -> float:
    coefficients, (x, y) = _coefficients(e), e.top
    return coefficients[0] * x * x + coefficients[1] * x * y + coefficients[2] * y * y


def _height_as_printed(e: EllipsePath) -> float:
    """Eqs. 36 and 38 as printed."""
    a, b, phi = e.semi_major, e.semi_minor, e.angle
    first, second, _ = _coefficients(e)
    cos, sin = math.cos(phi), math.sin(phi)
    theta = math.atan((2.0 * first * a * cos + second * a * sin) / (2.0 * first * b * sin - second * b * cos))
    return abs(a * sin * math.cos(theta) + b * cos * math.sin(theta))


def _claims() -> list[Row]:
    e = example()
    first, second, third = _coefficients(e)
    slope = second * HALF_WIDTH + 2.0 * third * HALF_RISE
    on = first * HALF_WIDTH**2 + second * HALF_WIDTH * HALF_RISE + third * HALF_RISE**2 - 1.0
    jump = HALF_WIDTH / e.half_chord**2
    return [
        Row(
            "choe/claim/vertical-tangents",
            0.0,
            abs(slope),
            "1/m",
            "reproduced",
            f"B l + 2 C h; T2 is on the ellipse to {abs(on):.0e}",
        ),
        Row(
            "choe/claim/continuous-at-the-tangent-points",
            "continuous",
            jump,
            "1/m",
            "differs",
            "the curvature jumps by this, from 0 on the line to l / w^2 on the ellipse: the normal acceleration is "
            "continuous at T1 and T2 only when the hand stops there",
        ),
    ]


def length_findings() -> Findings:
    """Length over angle, the approximation, and what the rule of whole degrees does."""
    rows = [*_approximation(), *_optimum(), *_rule()]
    return Findings(tuple(rows), figures={"choe_length.svg": svg(length_figure())})


def _approximation() -> list[Row]:
    """Eq. 27 against the exact length over the paper's range, all pairs of whole numbers."""
    a, b = np.meshgrid(np.arange(5.0, 21.0), np.arange(2.0, 21.0), indexing="ij")
    exact = np.vectorize(half_circumference)(a, b)
    error = np.abs(approximate_half_circumference(a, b) - exact)
    thin = 1.0 - float(approximate_half_circumference(1.0, 1e-9)) / half_circumference(1.0, 1e-9)
    note = "a from 5 to 20 and b from 2 to 20 in steps of 1, all pairs"
    return [
        Row("choe/eq-27/mean-absolute-error", 0.078, float(error.mean()), "-", "reproduced", note),
        Row("choe/eq-27/mean-relative-error", 0.231, 100.0 * float((error / exact).mean()), "%", "reproduced", note),
        Row(
            "choe/eq-27/largest-relative-error",
            None,
            100.0 * float((error / exact).max()),
            "%",
            "ours",
            f"at b / a = 0.1; {100.0 * thin:.1f} % as b goes to 0, which is where the paper's rule leads",
        ),
    ]


def _optimum() -> list[Row]:
    """The length falls with the angle down to the critical one: 10 deg is the grid, not the optimum."""
    angles = np.linspace(CRITICAL + 1e-3, 89.9, 2000)
    lengths = np.array([example_at(float(angle)).length for angle in angles])
    rising = bool((np.diff(lengths) > 0.0).all())
    return [
        Row(
            "choe/claim/length-rises-with-the-angle",
            "yes",
            "yes" if rising else "no",
            "-",
            "reproduced" if rising else "differs",
            "from the critical angle to 90 deg; a^2 = l^2 + l h tan(phi) and b^2 = l^2 - l h cot(phi) both rise",
        ),
        Row(
            "choe/claim/optimal-angle",
            10.0,
            CRITICAL,
            "deg",
            "differs",
            f"the shortest length is the limit, the chord of {CHORD:.5f} m with b = 0; 10 deg is the step of the plot",
            {"length_9.5deg_m": example_at(9.5).length, "length_9.6deg_m": example_at(9.6).length},
        ),
        Row(
            "choe/eq-27/shorter-than-the-chord-below",
            None,
            _shorter_than_chord(),
            "deg",
            "ours",
            "below this angle Eq. 27 gives the ellipse a length below the straight line between its ends",
        ),
    ]


def _shorter_than_chord() -> float:
    low, high = CRITICAL + 1e-6, 10.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if example_at(middle).approximate_length < CHORD else (low, middle)
    return high


def _rule() -> list[Row]:
    """The rule of whole degrees over the rise."""
    rows: list[Row] = []
    for millimetres, note in ((26.4, "just below a whole degree"), (26.5, "just above"), (1.0, "a small rise")):
        e = EllipsePath.paper(HALF_WIDTH, millimetres / 1000.0)
        longer = e.length / (2.0 * math.hypot(HALF_WIDTH, e.half_rise)) - 1.0
        rows.append(
            Row(
                f"choe/whole-degrees/clearance-h-{millimetres:g}mm",
                None,
                e.top_height - e.half_rise,
                "m",
                "ours",
                f"top above T2, {note}: {100.0 * longer:.0f} % longer than the chord",
            )
        )
    for name, rise in (
        ("level", 0.0),
        ("falling", -HALF_RISE),
        ("whole-degree", HALF_WIDTH * math.tan(math.radians(10))),
    ):
        rows.append(Row(f"choe/whole-degrees/{name}", None, None, "m", "infeasible", _refusal(rise)))
    return rows


def _refusal(rise: float) -> str:
    try:
        e = EllipsePath.paper(HALF_WIDTH, rise)
    except ValueError as error:
        return str(error)
    return f"the rule gives {math.degrees(e.angle):.0f} deg"


def ellipse_figure() -> Figure:
    """The example with its verticals, tangent points, axes and top, and the same ends with other tops."""
    figure, (left, right) = subplots(1, 2, (11.0, 3.6))
    e = example()
    _draw_path(left, e, COLOURS[0], "the paper's ellipse, 10°")
    reach = np.array([[-1.0], [1.0]])
    for length, turn, style in ((e.semi_major, 0.0, "-."), (e.semi_minor, 0.5 * math.pi, ":")):
        axis = 1000.0 * length * reach * [math.cos(e.angle + turn), math.sin(e.angle + turn)]
        left.plot(
            axis[:, 0], axis[:, 1], style, color="gray", linewidth=1, label="major axis" if not turn else "minor axis"
        )
    marks = {"$T_1$": e.point(e.theta_t1), "$T_2$": e.point(e.theta_t2), "top": np.array(e.top)}
    shifts = {"$T_1$": (6, -12), "$T_2$": (-20, 4), "top": (-8, 6)}
    for name, point in marks.items():
        left.plot(*(1000.0 * point), "o", color=COLOURS[3], markersize=5)
        left.annotate(name, 1000.0 * point, shifts[name], textcoords="offset points")
    left.legend(fontsize=8, loc="lower right")
    for k, top in enumerate((0.0265, 0.030, example().top_height, 0.060, 0.090)):
        other = EllipsePath.with_top(HALF_WIDTH, HALF_RISE, top)
        label = f"top {1000 * top:.1f} mm, {math.degrees(other.angle):.1f}°, {1000 * other.length:.1f} mm long"
        _draw_path(right, other, COLOURS[k], label)
    right.legend(fontsize=7, loc="lower right")
    for axes, title in ((left, "Choe et al. 2023, the example"), (right, "chosen by the height of the top")):
        axes.set_aspect("equal")
        axes.set_ylim(-115.0, 100.0)
        axes.set_xlabel("x from the centre [mm]")
        axes.set_ylabel("y [mm]")
        axes.set_title(title, fontsize=10)
        axes.grid(alpha=0.3)
    return figure


def _draw_path(axes: Axes, e: EllipsePath, colour: str, label: str) -> None:
    arc = 1000.0 * e.point(np.linspace(e.theta_t1, e.theta_t2, 400))
    axes.plot(arc[:, 0], arc[:, 1], color=colour, label=label)
    for x, y in (arc[0], arc[-1]):
        axes.plot([x, x], [y, y - 1000.0 * SHORT_LIFT], color=colour)


def length_figure() -> Figure:
    """Length over the angle (the paper's Fig. 2), and the clearance that the rule of whole degrees leaves."""
    figure, (left, right) = subplots(1, 2, (11.0, 3.8))
    angles = CRITICAL + np.geomspace(1e-3, 60.0 - CRITICAL, 500)
    shapes = [example_at(float(angle)) for angle in angles]
    left.plot(angles, [1000.0 * e.length for e in shapes], color=COLOURS[0], label="exact")
    left.plot(angles, [1000.0 * e.approximate_length for e in shapes], "--", color=COLOURS[1], label="Eq. 27")
    left.axhline(1000.0 * CHORD, color="gray", linewidth=1, linestyle=":", label="chord")
    left.plot(10.0, 1000.0 * example().length, "o", color=COLOURS[3], label="the paper's choice, 10°")
    left.set_xlim(8.0, 30.0)
    left.set_ylim(280.0, 400.0)
    left.set_xlabel("angle of the major axis [°]")
    left.set_ylabel("length [mm]")
    left.set_title("length over the angle", fontsize=10)
    left.legend(fontsize=8)
    rises = np.arange(0.25, 60.0, 0.05)
    right.plot(rises, _clearances(rises), color=COLOURS[0])
    right.plot(
        1000.0 * HALF_RISE, 1000.0 * (example().top_height - HALF_RISE), "o", color=COLOURS[3], label="the example"
    )
    right.set_xlabel("half rise h [mm]")
    right.set_ylabel("top above T2 [mm]")
    right.set_title("clearance by the rule of whole degrees, l = 150 mm", fontsize=10)
    right.legend(fontsize=8)
    for axes in (left, right):
        axes.grid(alpha=0.3)
    return figure


def _clearances(rises: Floats) -> Floats:
    """Top above T2 [mm] of the paper's ellipse for half rises [mm]; NaN between two degrees, where the rule jumps."""
    values: list[float] = []
    degree = 0
    for rise in rises:
        e = EllipsePath.paper(HALF_WIDTH, float(rise) / 1000.0)
        values.append(1000.0 * e.top_height - rise if round(math.degrees(e.angle)) == degree else math.nan)
        degree = round(math.degrees(e.angle))
    return np.array(values)


PARTS = (Part("example", example_findings), Part("length", length_findings))
