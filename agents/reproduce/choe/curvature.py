"""The radius of curvature, after which Choe et al. 2023 choose the speed: its derivatives, and the profile it gives."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.planning.paths import EllipsePath, NodeList

from ...ground.drawings import COLOURS, Figure, dress, subplots
from ..finding import Findings, Row
from ..grids import listed
from .cases import RATE, example

FIG_3: Final = EllipsePath.with_top(0.3, 0.0, 0.05)
"""The ellipse of Fig. 3: a = 0.3 m and b = 0.05 m."""
SMOOTH: Final = 0.6
"""Looked at twice as often, the greatest jump of a curve without jumps is half as large; this share still counts."""

BUSY: Final = 5


def curvature_findings() -> Findings:
    """Is the law bounded, continuous and smooth, as the paper sees in its Figs. 3 and 5?"""
    rows = (*_over_the_angle(), *_at_the_nodes())
    figures = {"choe_curvature.svg": curvature_figure(), "choe_profile.svg": profile_figure()}
    return listed("The law of curvature and its profile (Figs. 3 and 5)", rows, figures, drop="choe/")


def derivatives(ellipse: EllipsePath, theta: Floats) -> tuple[Floats, Floats, Floats]:
    """The radius of curvature rho (N,) [m] over the polar angle [rad], and its first and second derivative by it.

    rho = q^(3/2) / (a b) with q = a^2 sin^2 + b^2 cos^2 (Eq. 51).
    """
    a, b = ellipse.semi_major, ellipse.semi_minor
    q = (a * np.sin(theta)) ** 2 + (b * np.cos(theta)) ** 2
    first = (a * a - b * b) * np.sin(2.0 * theta)
    second = 2.0 * (a * a - b * b) * np.cos(2.0 * theta)
    slope, bend = 1.5 * np.sqrt(q) * first, 1.5 * np.sqrt(q) * second + 0.75 * first**2 / np.sqrt(q)
    return ellipse.radius_of_curvature(theta), slope / (a * b), bend / (a * b)


@final
@dataclass(frozen=True, eq=False)
class Profile:
    """The motion at the knots of a node list, one period from each to the next (the paper's Fig. 5)."""

    curvature: Floats
    """Radius of curvature (n,) [m]."""
    displacement: Floats
    """Along the chords (n,) [m]."""
    velocity: Floats
    """(n - 1,) [m per period]"""
    acceleration: Floats
    """(n - 2,) [m per period^2]"""
    jerk: Floats
    """(n - 3,) [m per period^3]"""

    @classmethod
    def of(cls, ellipse: EllipsePath, nodes: NodeList) -> Profile:
        """The profile of a node list of an ellipse."""
        displacement = np.concatenate([[0.0], np.cumsum(nodes.steps)])
        differences = [np.diff(displacement, order) for order in (1, 2, 3)]
        return cls(ellipse.radius_of_curvature(nodes.theta), displacement, *differences)


def _over_the_angle() -> Iterator[Row]:
    names = ("rho", "first-derivative", "second-derivative")
    fine = derivatives(FIG_3, np.linspace(0.0, np.pi, 20_001))
    for name, values in zip(names, fine, strict=True):
        jumps = [float(np.abs(np.diff(values[::every])).max()) for every in (2, 1)]
        smooth = bool(np.isfinite(values).all() and jumps[1] < SMOOTH * jumps[0])
        note = f"a = 0.3 m, b = 0.05 m, theta from 0 to 180 deg: from {values.min():.4g} to {values.max():.4g} m"
        yield Row.compared(
            f"choe/fig-3/{name}",
            "bounded, continuous",
            "bounded, continuous" if smooth else "jumps",
            "m",
            note=note,
            least=float(values.min()),
            greatest=float(values.max()),
        )


def _at_the_nodes() -> Iterator[Row]:
    found = Profile.of(example(), example().nodes(RATE, clip=False))
    top = float(found.velocity.max())
    busiest = float(np.sort(found.velocity)[-BUSY:].sum() / found.displacement[-1])
    note = f"of the way, in {BUSY} of {found.velocity.size} periods: the law hurries over the top, in few large steps"
    yield Row.ours("choe/fig-5/way-of-the-busiest-periods", busiest, "-", note=note)
    for name, values in (("acceleration", found.acceleration), ("jerk", found.jerk)):
        note = (
            f"largest at a knot, as a share of the greatest step of {1000.0 * top:.1f} mm a period; the paper's axes "
            "have no period"
        )
        yield Row.ours(f"choe/fig-5/largest-{name}", float(np.abs(values).max()) / top, "-", note=note)
    note = (
        "the step at the first knot is a speed that the arm has to have there already: with the vertical part left "
        "open, the profile begins and ends with a jump of the acceleration"
    )
    yield Row.ours("choe/fig-5/speed-at-the-first-knot", float(found.velocity[0]) / top, "-", note=note)


def curvature_figure() -> Figure:
    """The paper's Fig. 3."""
    figure, axes = subplots(1, 3, (13.5, 3.4))
    theta = np.linspace(0.0, np.pi, 721)
    titles = ("radius of curvature", "its first derivative", "its second derivative")
    for k, (ax, values, title) in enumerate(zip(axes, derivatives(FIG_3, theta), titles, strict=True)):
        ax.plot(np.degrees(theta), values, color=COLOURS[k])
        dress(ax, "θ [°]", "[m]", title)
    return figure


def profile_figure() -> Figure:
    """The paper's Fig. 5, all five panels."""
    figure, axes = subplots(1, 5, (17.0, 3.2))
    found = Profile.of(example(), example().nodes(RATE, clip=False))
    panels = (
        ("(a) curvature", "[mm]", found.curvature),
        ("(b) displacement", "[mm]", found.displacement),
        ("(c) velocity", "[mm / period]", found.velocity),
        ("(d) acceleration", "[mm / period²]", found.acceleration),
        ("(e) jerk", "[mm / period³]", found.jerk),
    )
    for ax, (title, unit, values) in zip(axes, panels, strict=True):
        ax.plot(np.arange(1, len(values) + 1), 1000.0 * values, ".-", markersize=3, linewidth=1, color=COLOURS[0])
        dress(ax, "knot", unit, title)
    return figure
