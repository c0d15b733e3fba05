"""The platform manipulability index of Leveziel et al. (Eq. 10, Fig. 6) and the transmission ratios made of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.leveziel_cases import CENTRE, CLOSED, HOME_THETA, OPEN, PAPER_STEP, held, lowest, posed, reduced
from pnt_gym.planning.arrays import Floats
from pnt_gym.robots.gripper4 import PUBLISHED_TAU_SCALE, TauHull, folding_speed, singularity, tau, tau_hull

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RATIOS: Final = (3.4, 10.3)
"""Published ends of 1/tau in the reduced workspace (section VII)."""
OVER: Final = 0.1
"""Published bound of tau at -45 deg and from -60 to -30 deg."""
GRIPPING: Final = 31
"""Angles looked at from closed to open, one per degree."""


def index_findings(step: float = PAPER_STEP) -> Findings:
    """Platform index over theta at the centre, its hull, the ratios 1/tau, and the folding at a fixed position."""
    positions = reduced(step).positions
    hull = tau_hull(positions)
    gripping = tau_hull(positions, np.linspace(CLOSED, OPEN, GRIPPING))
    centre = tau(np.column_stack([np.tile(CENTRE, (hull.theta.size, 1)), hull.theta]))
    rows = [*_figure_rows(positions, hull, centre), *_bounds(positions, gripping)]
    rows += [*_ratios(gripping), _fixed(step)]
    lists = {"theta": hull.theta, "low": hull.low, "high": hull.high, "count": hull.count, "centre": centre}
    data = {name: values.tolist() for name, values in lists.items()}
    drawing = svg(tau_figure(hull, centre, gripping))
    return Findings(tuple(rows), {"leveziel_tau": data}, {"leveziel_tau.svg": drawing})


def _figure_rows(positions: Floats, hull: TauHull, centre: Floats) -> list[Row]:
    degrees = np.rad2deg(hull.theta)
    best, peak = int(np.nanargmax(hull.low)), int(centre.argmax())
    step = float(degrees[1] - degrees[0])
    dead = float(np.rad2deg(first_dead(positions, hull.theta)))
    home = float(tau([*CENTRE, HOME_THETA]))
    return [
        Row(
            "leveziel/fig-6/first-zero",
            "near 45 deg",
            dead,
            "deg",
            "reproduced",
            f"first of the {degrees.size} angles at which det J_x, and with it tau, is zero or past it at one of the "
            f"{len(positions):,} positions, strokes kept",
            {"theta_step_deg": step},
        ),
        Row(
            "leveziel/fig-6/most-convenient-angle",
            "around -45 deg",
            float(degrees[best]),
            "deg",
            "reproduced" if abs(degrees[best] + 45.0) < 5.0 else "differs",
            f"angle at which the smallest tau of all positions, {hull.low[best]:.4f}, is largest; "
            f"at the centre tau is largest at {degrees[peak]:.1f} deg",
        ),
        Row(
            "leveziel/fig-6/centre-at-home",
            None,
            home,
            "-",
            "ours",
            f"tau at x = y = 0, z = -200 mm and -45 deg by Eq. 10; {centre[peak]:.4f} at its largest, "
            f"{home / PUBLISHED_TAU_SCALE:.4f} divided by {PUBLISHED_TAU_SCALE}",
            {"largest": float(centre[peak])},
        ),
    ]


def first_dead(positions: Floats, theta: Floats) -> float:
    """The smallest of rising positive angles (T,) at which a position within the strokes is singular [rad]."""
    for angle in theta[theta > 0.0]:
        poses = posed(positions, float(angle))
        if (singularity(poses).mask & held(poses)).any():
            return float(angle)
    return float("nan")


def _bounds(positions: Floats, gripping: TauHull) -> list[Row]:
    home, least = tau(posed(positions, HOME_THETA)), float(gripping.low.min())
    at = float(np.rad2deg(gripping.theta[int(gripping.low.argmin())]))
    return [
        Row(
            "leveziel/fig-6/smallest-at-home",
            f"> {OVER:g}",
            float(home.min()),
            "-",
            "reproduced",
            f"tau by Eq. 10 at -45 deg over {home.size:,} positions, so true but far from tight; "
            f"{home.min() / PUBLISHED_TAU_SCALE:.3f} divided by {PUBLISHED_TAU_SCALE}",
            {"largest": float(home.max()), "scaled": float(home.min()) / PUBLISHED_TAU_SCALE},
        ),
        Row(
            "leveziel/fig-6/smallest-while-gripping",
            f"> {OVER:g}",
            least,
            "-",
            "reproduced",
            f"tau by Eq. 10 from -60 to -30 deg, {GRIPPING} angles, reached at {at:.0f} deg; "
            f"{least / PUBLISHED_TAU_SCALE:.3f} divided by {PUBLISHED_TAU_SCALE}",
            {"scaled": least / PUBLISHED_TAU_SCALE},
        ),
    ]


def extreme(theta: float, sign: float) -> float:
    """The smallest (sign 1) or largest (-1) tau of the reduced workspace at an angle."""
    return sign * lowest(lambda poses: sign * tau(poses), theta)[1]


def _ratios(gripping: TauHull) -> list[Row]:
    lean, steep = (float(gripping.theta[i]) for i in (gripping.high.argmax(), gripping.low.argmin()))
    low, high = 1.0 / extreme(lean, -1.0), 1.0 / extreme(steep, 1.0)
    scaled = PUBLISHED_TAU_SCALE * low, PUBLISHED_TAU_SCALE * high
    published = f"{RATIOS[0]:g} to {RATIOS[1]:g}"
    angles = f"{np.rad2deg(lean):.0f} and {np.rad2deg(steep):.0f} deg"
    return [
        Row(
            "leveziel/inconsistency/transmission-ratios",
            published,
            f"{low:.2f} to {high:.2f}",
            "-",
            "differs",
            f"1/tau by Eq. 10 as printed, in the reduced workspace from -60 to -30 deg, ends at {angles}: how far the "
            "platform folds at most per motion of the motors",
            {"low": low, "high": high},
        ),
        Row(
            "leveziel/inconsistency/transmission-ratios-scaled",
            published,
            f"{scaled[0]:.2f} to {scaled[1]:.2f}",
            "-",
            "differs",
            f"1/tau with |H| times {PUBLISHED_TAU_SCALE}, which is w in centimetres: the upper end, and tau over 0.1, "
            "come out as if column 4 of J_x had been computed without its factor w and lengths in cm; a hypothesis, "
            f"and the lower end, on a thin ridge at the strokes' edge, stays "
            f"{100.0 * (scaled[0] / RATIOS[0] - 1.0):.0f} % off. kappa does not depend on it",
            {"low": scaled[0], "high": scaled[1], "scale": PUBLISHED_TAU_SCALE},
        ),
    ]


def _fixed(step: float) -> Row:
    poses = reduced(step).poses
    fold, free = folding_speed(poses), tau(poses)
    more = 1.0 / (free * fold)
    return Row(
        "leveziel/inconsistency/tau-lets-the-platform-drift",
        "folding at a given position",
        f"{fold.min():.2f} to {fold.max():.2f}",
        "-",
        "differs",
        f"1 / |J_q^-1 J_x e_4|, how far the platform folds per motion of the motors while it stays in place; "
        f"-45 deg, {len(fold):,} positions. Row 4 of J in Eq. 10 lets it drift as well, and 1/tau is {more.min():.1f} "
        f"to {more.max():.1f} times as much",
        {"low": float(fold.min()), "high": float(fold.max())},
    )


def tau_figure(hull: TauHull, centre: Floats, gripping: TauHull) -> Figure:
    """Platform index over theta with its hull (Fig. 6), and 1/tau where the prototype grips, as printed and scaled."""
    figure, (index, ratio) = subplots(1, 2, (11.5, 4.4))
    degrees = np.rad2deg(hull.theta)
    index.axvspan(np.rad2deg(CLOSED), np.rad2deg(OPEN), color=COLOURS[8], alpha=0.3, label="the prototype's range")
    index.fill_between(degrees, hull.low, hull.high, color="#9fe3ec", label="hull over the reduced workspace")
    index.plot(degrees, centre, color=COLOURS[3], label="x = y = 0, z = -200 mm")
    index.axhline(OVER, color="black", linewidth=0.8, linestyle=":", label="published bound, 0.1")
    index.axvline(45.0, color="black", linewidth=0.8, linestyle="--", label="published zero, near 45°")
    index.set_xlabel("angle of the platform's halves θ [°]")
    index.set_ylabel("platform manipulability index τ")
    index.set_xticks(range(-90, 91, 30))
    index.set_ylim(0.0, 0.9)
    index.set_title("Eq. 10 as printed", fontsize=10)
    index.legend(fontsize=8, loc="upper right")
    degrees = np.rad2deg(gripping.theta)
    names = ("Eq. 10 as printed", f"with |H| times {PUBLISHED_TAU_SCALE}")
    for colour, scale, name in zip(COLOURS, (1.0, PUBLISHED_TAU_SCALE), names, strict=False):
        ratio.fill_between(degrees, scale / gripping.high, scale / gripping.low, color=colour, alpha=0.45, label=name)
    for value in RATIOS:
        ratio.axhline(value, color="black", linewidth=0.9, linestyle="--")
    ratio.plot([], [], "--", color="black", label="published, 3.4 to 10.3")
    ratio.set_xlabel("θ [°]")
    ratio.set_ylabel("1/τ")
    ratio.set_ylim(0.0, 13.0)
    ratio.set_title("range over the positions of the reduced workspace", fontsize=10)
    ratio.legend(fontsize=8, loc="upper right")
    for panel in (index, ratio):
        panel.grid(alpha=0.3)
    return figure


PARTS = (Part("indices", index_findings),)
