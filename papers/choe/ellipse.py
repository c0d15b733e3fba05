"""The ellipse of Choe et al. 2023: the published example, its length, and the rule that chooses the angle."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final, cast

import numpy as np
from scipy.optimize import brentq

from agents.ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row, printed
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats
from pnt_gym.planning.paths import EllipsePath, approximate_half_circumference, half_circumference

from .cases import HALF_RISE, HALF_WIDTH, SHORT_LIFT, example, example_at

CRITICAL: Final = math.degrees(math.atan(HALF_RISE / HALF_WIDTH))
"""Angle of the line from T1 to T2 in the example [deg]: the least angle of an ellipse's major axis."""
CHORD: Final = 2.0 * math.hypot(HALF_WIDTH, HALF_RISE)
"""Straight distance from T1 to T2 [m]."""
ROUNDING: Final = 1e-9
"""Greatest value that counts as zero, in SI units."""


def example_findings() -> Findings:
    """Every printed number of the example, and the paper's claims about the example."""
    rows = (*_example_rows(), _numbering_row(), *_tangent_rows())
    return table_findings("The published example", rows, {"choe_ellipse.svg": ellipse_figure()}, drop="choe/")


def _example_rows() -> list[Row]:
    """Rows with every printed number of the example; a wrong number comes with the slip that explains it."""
    e = example()
    first, last = math.degrees(e.theta_t1), math.degrees(e.theta_t2)
    swapped = "Eqs. 41 and 42; the results print the two values with their names exchanged"
    # Eq. 38 counts the top's height from the centre, and the arctangent may give the lowest point instead.
    low = abs(_equation_37(e)[1])
    short = 100.0 * (1.0 - e.approximate_length / e.length)
    exact = f"complete elliptic integral; what is printed is Eq. 27, {short:.2f} % short"
    above = "Eq. 38 as printed gives the top above the centre; the printed height needs + h"
    figures = (
        ("example/angle", 10.0, math.degrees(e.angle), "deg", 0, None, f"{CRITICAL:.4f} deg rounded up"),
        ("example/semi-major", 0.15219, e.semi_major, "m", 5, None, ""),
        ("example/semi-minor", 0.03511, e.semi_minor, "m", 5, None, ""),
        ("example/length-eq-27", 0.32058, e.approximate_length, "m", 5, None, "the paper's approximation"),
        ("example/top-x", 0.08617, e.top[0], "m", 5, None, ""),
        ("example/top-y", 0.04352, e.top[1], "m", 5, None, ""),
        ("example/height", 0.06852, e.height, "m", 5, None, "top above T1: y of the top plus h"),
        ("example/theta-t1", -2.329, first, "deg", 3, last, swapped),
        ("example/theta-t2", 177.671, last, "deg", 3, first, swapped),
        ("example/length", 0.32058, e.length, "m", 5, e.approximate_length, exact),
        ("misprint/eq-38", 0.06852, low, "m", 5, low + HALF_RISE, above),
    )
    return [
        Row.compared(f"choe/{name}", published, value, unit, within=printed(digits), note=note).explain(slip)
        for name, published, value, unit, digits, slip, note in figures
    ]


def _numbering_row() -> Row:
    e = example()
    numbers = "37, 38" if math.dist(_equation_37(e), e.top) < ROUNDING else "24, 25"
    return Row.compared(
        "choe/misprint/equation-numbers",
        "(24), (25)",
        numbers,
        "-",
        note="equations that give the top; the text has another numbering. Evaluated, Eq. 37 gives it, and Eq. 24 is "
        f"the ellipse itself, A x^2 + B x y + C y^2 = {_equation_24(e, *e.top):.3f}",
        cited_and_meant=CITED,
    ).explain(next((cited for cited, number in CITED.items() if number == numbers), None))


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
"""Numbers of equations: as the text cites them, and as the equations are numbered."""


def _coefficients(e: EllipsePath) -> tuple[float, float, float]:
    """Coefficients A, B, C of the ellipse A x^2 + B x y + C y^2 = 1 (Eqs. 24 and 25)."""
    a, b, phi = e.semi_major, e.semi_minor, e.angle
    cos, sin = math.cos(phi), math.sin(phi)
    return (
        # x and y turned by -phi into the frame of the axes, then (x / a)^2 + (y / b)^2 = 1.
        (cos / a) ** 2 + (sin / b) ** 2,
        math.sin(2.0 * phi) * (1.0 / a**2 - 1.0 / b**2),
        (sin / a) ** 2 + (cos / b) ** 2,
    )


def _equation_24(e: EllipsePath, x: float, y: float) -> float:
    first, second, third = _coefficients(e)
    return first * x * x + second * x * y + third * y * y


def _equation_37(e: EllipsePath) -> tuple[float, float]:
    """The ellipse's top (x, y) by Eqs. 36 and 37 as printed [m]; y is Eq. 38."""
    a, b, phi = e.semi_major, e.semi_minor, e.angle
    first, second, _ = _coefficients(e)
    cos, sin = math.cos(phi), math.sin(phi)
    # At the top the ellipse is level: 2 A x + B y = 0 for the point at the polar angle theta.
    theta = math.atan((2.0 * first * a * cos + second * a * sin) / (2.0 * first * b * sin - second * b * cos))
    along, across = a * math.cos(theta), b * math.sin(theta)
    return along * cos - across * sin, along * sin + across * cos


def _tangent_rows() -> Iterator[Row]:
    e = example()
    _, second, third = _coefficients(e)
    # The derivative of Eq. 24 by y vanishes at T2 = (l, h), where the tangent is vertical.
    slope = abs(second * HALF_WIDTH + 2.0 * third * HALF_RISE)
    on = abs(_equation_24(e, HALF_WIDTH, HALF_RISE) - 1.0)
    # x = l cos t, y = h cos t + w sin t has at T2 (t = 0) the curvature l w / w^3.
    jump = HALF_WIDTH / e.half_chord**2
    note = f"B l + 2 C h, zero but for rounding; T2 is on the ellipse to {on:.0e}"
    yield Row.compared("choe/claim/vertical-tangents", 0.0, slope, "1/m", within=ROUNDING, note=note)
    note = (
        "the curvature jumps by this, from 0 on the line to l / w^2 on the ellipse: the normal acceleration is "
        "continuous at T1 and T2 only when the hand stops there"
    )
    yield Row.compared(
        "choe/claim/continuous-at-the-tangent-points", "continuous", jump, "1/m", holds=jump < ROUNDING, note=note
    )


def length_findings() -> Findings:
    """Length over the angle, the approximation of Eq. 27, and the effect of the rule of whole degrees."""
    rows = (*_approximation_rows(), *_optimum_rows(), *_clearance_rows(), *_infeasible_rows())
    headline = "Length over the angle, and the rule of whole degrees"
    return table_findings(headline, rows, {"choe_length.svg": length_figure()}, drop="choe/")


def _approximation_rows() -> Iterator[Row]:
    """Rows with the error of Eq. 27 against the exact length, over all pairs of whole numbers in the paper's range."""
    a, b = np.meshgrid(np.arange(5.0, 21.0), np.arange(2.0, 21.0), indexing="ij")
    exact = np.vectorize(half_circumference)(a, b)
    error = np.abs(approximate_half_circumference(a, b) - exact)
    # A semi-minor axis near 0 stands for the limit of a flat ellipse, whose exact half circumference is 2 a.
    thin = 1.0 - float(approximate_half_circumference(1.0, 1e-9)) / half_circumference(1.0, 1e-9)
    yield _bounds_row(a, b, exact)
    note = (
        "a from 5 to 20 and b from 2 to 20, all pairs; the paper's step is not given, here it is 1. Equal within a "
        "whole unit of the last digit, as the printed figures may be cut instead of rounded"
    )
    mean, relative, largest = error.mean(), 100.0 * (error / exact).mean(), 100.0 * (error / exact).max()
    yield Row.compared("choe/eq-27/mean-absolute-error", 0.078, float(mean), "-", within=1e-3, note=note)
    yield Row.compared("choe/eq-27/mean-relative-error", 0.231, float(relative), "%", within=1e-3, note=note)
    note = f"at b / a = 0.1; {100.0 * thin:.1f} % as b goes to 0, which is where the paper's rule leads"
    yield Row.ours("choe/eq-27/largest-relative-error", float(largest), "%", note=note)


def _bounds_row(a: Floats, b: Floats, exact: Floats) -> Row:
    """Row on Eq. 26, by which the half circumference lies between two bounds; all semi-axes in the paper's range."""
    lower, upper = np.pi * (a + b) / 2.0, np.pi / np.sqrt(2.0) * np.hypot(a, b)
    between, alike = (lower < exact) & (exact < upper), a == b
    # All three are the half circle's length there, so that rounding alone decides which one is greater.
    equal = np.maximum(np.abs(lower - exact), np.abs(upper - exact))[alike].max()
    short = approximate_half_circumference(a, b)[~alike] < exact[~alike]
    return Row.compared(
        "choe/eq-26/bounds",
        "L_l < L < L_u",
        f"in {int(between[~alike].sum())} of {int((~alike).sum())} pairs with a and b different",
        "-",
        holds=bool(between[~alike].all()),
        note=f"a from 5 to 20 and b from 2 to 20, {a.size} pairs; in the {int(alike.sum())} with a = b both bounds are "
        f"the length but for rounding, {equal:.0e} at most, so there the inequality is not strict. Eq. 27, the middle "
        f"of the bounds, is too short in {int(short.sum())} of the {short.size} others",
        largest_difference_of_circles=float(equal),
    )


def _optimum_rows() -> Iterator[Row]:
    """Rows on the optimal angle: the length falls down to the critical angle, and 10 deg is only a step of the grid."""
    angles = np.linspace(CRITICAL + 1e-3, 89.9, 2000)
    lengths = np.array([example_at(float(angle)).length for angle in angles])
    rising = "yes" if (np.diff(lengths) > 0.0).all() else "no"
    flatter = {angle: example_at(angle).length for angle in (9.5, 9.6)}
    note = "from the critical angle to 90 deg; a^2 = l^2 + l h tan(phi) and b^2 = l^2 - l h cot(phi) both rise"
    yield Row.compared("choe/claim/length-rises-with-the-angle", "yes", rising, "-", note=note)
    yield Row.compared(
        "choe/claim/optimal-angle",
        10.0,
        CRITICAL,
        "deg",
        holds=example().length <= min(flatter.values()),
        note="ellipses of 9.5 and 9.6 deg are shorter than that of 10 deg, which is the step of the plot; the shortest "
        f"length is the limit, the chord of {CHORD:.5f} m with b = 0",
        lengths_m={f"{angle:g} deg": length for angle, length in flatter.items()},
    )
    note = "below this angle Eq. 27 gives the ellipse a length below the straight line between its ends"
    # An arc cannot be shorter than its chord; the root is the angle at which Eq. 27 begins to claim it.
    limit = cast(float, brentq(lambda angle: example_at(angle).approximate_length - CHORD, CRITICAL + 1e-6, 10.0))
    yield Row.ours("choe/eq-27/shorter-than-the-chord-below", limit, "deg", note=note)


def _clearance_rows() -> Iterator[Row]:
    """Rows with the clearance above T2 under the rule of whole degrees."""
    for millimetres, description in ((26.4, "just below a whole degree"), (26.5, "just above"), (1.0, "a small rise")):
        e = EllipsePath.paper(HALF_WIDTH, millimetres / 1000.0)
        longer = e.length / (2.0 * math.hypot(HALF_WIDTH, e.half_rise)) - 1.0
        name = f"choe/whole-degrees/clearance-h-{millimetres:g}mm"
        note = f"top above T2, {description}: {100.0 * longer:.0f} % longer than the chord"
        yield Row.ours(name, e.top_height - e.half_rise, "m", note=note)


def _infeasible_rows() -> Iterator[Row]:
    """Rows for half rises at which the rule of whole degrees has no ellipse."""
    whole = HALF_WIDTH * math.tan(math.radians(10))
    for name, rise in (("level", 0.0), ("falling", -HALF_RISE), ("whole-degree", whole)):
        quantity = f"choe/whole-degrees/{name}"
        try:
            e = EllipsePath.paper(HALF_WIDTH, rise)
        except ValueError as error:
            yield Row.ours(quantity, "no ellipse", "m", note=str(error))
        else:
            yield Row.ours(quantity, e.length, "m", note=f"the rule gives {math.degrees(e.angle):.0f} deg")


def ellipse_figure() -> Figure:
    """Drawing of the example with verticals, tangent points, axes and top, and of ellipses with other tops."""
    figure, (upper, lower) = subplots(2, 1, (WIDTH, 8.4))
    e = example()
    _draw_path(upper, e, COLOURS[0], "the paper's ellipse, 10°")
    reach = np.array([[-1.0], [1.0]])
    for length, turn, style in ((e.semi_major, 0.0, "-."), (e.semi_minor, 0.5 * math.pi, ":")):
        axis = 1000.0 * length * reach * [math.cos(e.angle + turn), math.sin(e.angle + turn)]
        upper.plot(
            axis[:, 0], axis[:, 1], style, color="gray", linewidth=1, label="major axis" if not turn else "minor axis"
        )
    marks = {"$T_1$": e.point(e.theta_t1), "$T_2$": e.point(e.theta_t2), "top": np.array(e.top)}
    offsets = {"$T_1$": (6, -12), "$T_2$": (-20, 4), "top": (-8, 6)}
    for name, point in marks.items():
        upper.plot(*(1000.0 * point), "o", color=COLOURS[3], markersize=5)
        upper.annotate(name, 1000.0 * point, offsets[name], textcoords="offset points")
    for k, top in enumerate((0.0265, 0.030, example().top_height, 0.060, 0.090)):
        ellipse = EllipsePath.with_top(HALF_WIDTH, HALF_RISE, top)
        label = f"top {1000 * top:.1f} mm, {math.degrees(ellipse.angle):.1f}°, {1000 * ellipse.length:.1f} mm long"
        _draw_path(lower, ellipse, COLOURS[k], label)
    for axes, title in ((upper, "Choe et al. 2023, the example"), (lower, "chosen by the height of the top")):
        limits = {"aspect": "equal", "ylim": (-115.0, 100.0)}
        dress(axes, "x from the centre [mm]", "y [mm]", title, legend="lower right", **limits)
    return figure


def _draw_path(axes: Axes, e: EllipsePath, colour: str, label: str) -> None:
    arc = 1000.0 * e.point(np.linspace(e.theta_t1, e.theta_t2, 400))
    axes.plot(arc[:, 0], arc[:, 1], color=colour, label=label)
    for x, y in (arc[0], arc[-1]):
        axes.plot([x, x], [y, y - 1000.0 * SHORT_LIFT], color=colour)


def length_figure() -> Figure:
    """Drawing of the length over the angle (the paper's Fig. 2) and of the clearance by the rule of whole degrees."""
    figure, (upper, lower) = subplots(2, 1, (WIDTH, 7.4))
    angles = CRITICAL + np.geomspace(1e-3, 60.0 - CRITICAL, 500)
    shapes = [example_at(float(angle)) for angle in angles]
    upper.plot(angles, [1000.0 * e.length for e in shapes], color=COLOURS[0], label="exact")
    upper.plot(angles, [1000.0 * e.approximate_length for e in shapes], "--", color=COLOURS[1], label="Eq. 27")
    upper.axhline(1000.0 * CHORD, color="gray", linewidth=1, linestyle=":", label="chord")
    upper.plot(10.0, 1000.0 * example().length, "o", color=COLOURS[3], label="the paper's choice, 10°")
    limits = {"xlim": (8.0, 30.0), "ylim": (280.0, 400.0)}
    dress(upper, "angle of the major axis [°]", "length [mm]", "length over the angle", legend="best", **limits)
    rises = np.arange(0.25, 60.0, 0.05)
    lower.plot(rises, _clearances(rises), color=COLOURS[0])
    lower.plot(
        1000.0 * HALF_RISE, 1000.0 * (example().top_height - HALF_RISE), "o", color=COLOURS[3], label="the example"
    )
    title = "clearance by the rule of whole degrees, l = 150 mm"
    dress(lower, "half rise h [mm]", "top above T2 [mm]", title, legend="best")
    return figure


def _clearances(rises: Floats) -> Floats:
    """Height of the top above T2 (N,) [mm] for half rises (N,) [mm]; NaN where the rule jumps to the next degree."""
    values: list[float] = []
    degree = 0
    for rise in rises:
        e = EllipsePath.paper(HALF_WIDTH, float(rise) / 1000.0)
        values.append(1000.0 * e.top_height - rise if round(math.degrees(e.angle)) == degree else math.nan)
        degree = round(math.degrees(e.angle))
    return np.array(values)
