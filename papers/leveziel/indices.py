"""The platform manipulability index of Leveziel et al. (Eq. 10, Fig. 6) and the transmission ratios 1 / tau."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper import PUBLISHED_TAU_SCALE, folding_speed, singularity, tau

from .cases import AROUND, CENTRE, CLOSED, HOME_THETA, OPEN, PAPER_STEP, is_reachable, lowest_pose, poses_at, reduced
from .scan import TauHull, tau_hull

RATIOS: Final = (3.4, 10.3)
"""Published ends of 1/tau in the reduced workspace (section VII)."""
OVER: Final = 0.1
"""Published bound of tau at -45 deg and from -60 to -30 deg."""
BOUND: Final = f"> {OVER:g}"
ALIKE: Final = 0.01
"""Relative difference within which two measures of the folding agree."""
GRIPPING: Final = 31
"""Number of angles from closed to open, one per degree."""


def index_findings(step: float = PAPER_STEP) -> Findings:
    """Platform index tau over theta at the centre, its hull, the ratios 1/tau, and the folding at a fixed position."""
    positions = reduced(step).positions
    hull = tau_hull(positions)
    gripping = tau_hull(positions, np.linspace(CLOSED, OPEN, GRIPPING))
    centre = tau(np.column_stack([np.tile(CENTRE, (hull.theta.size, 1)), hull.theta]))
    rows = (
        *_figure_rows(positions, hull, centre),
        *_bound_rows(positions, gripping),
        *_ratio_rows(gripping),
        _folding_row(step),
    )
    lists = {"theta": hull.theta, "low": hull.low, "high": hull.high, "count": hull.count, "centre": centre}
    data = {name: values.tolist() for name, values in lists.items()}
    figures = {"leveziel_tau.svg": tau_figure(hull, centre, gripping)}
    headline = "Platform index and transmission ratios"
    return table_findings(headline, rows, figures, {"leveziel_tau": data}, drop="leveziel/")


def _figure_rows(positions: Floats, hull: TauHull, centre: Floats) -> Iterator[Row]:
    degrees = np.rad2deg(hull.theta)
    best, peak = int(np.nanargmax(hull.low)), int(centre.argmax())
    dead = float(np.rad2deg(first_singular_angle(positions, hull.theta)))
    home, step = float(tau([*CENTRE, HOME_THETA])), float(degrees[1] - degrees[0])
    note = (
        f"first of the {degrees.size} angles at which det J_x, and with it tau, is zero or past it at one of the "
        f"{len(positions):,} positions, strokes kept; the paper says near 45 deg"
    )
    yield Row.compared("leveziel/fig-6/first-zero", 45.0, dead, "deg", within=AROUND, note=note, theta_step_deg=step)
    note = (
        f"angle at which the smallest tau of all positions, {hull.low[best]:.4f}, is largest, by the paper around -45 "
        f"deg; at the centre tau is largest at {degrees[peak]:.1f} deg"
    )
    yield Row.compared(
        "leveziel/fig-6/most-convenient-angle", -45.0, float(degrees[best]), "deg", within=AROUND, note=note
    )
    note = (
        f"tau at x = y = 0, z = -200 mm and -45 deg by Eq. 10; {centre[peak]:.4f} at its largest, "
        f"{home / PUBLISHED_TAU_SCALE:.4f} divided by {PUBLISHED_TAU_SCALE}"
    )
    yield Row.ours("leveziel/fig-6/centre-at-home", home, "-", note=note, largest=float(centre[peak]))


def first_singular_angle(positions: Floats, theta: Floats) -> float:
    """The smallest of rising positive angles (T,) [rad] at which a pose within the strokes is singular; NaN if none."""
    for angle in theta[theta > 0.0]:
        poses = poses_at(positions, float(angle))
        if (singularity(poses).mask & is_reachable(poses)).any():
            return float(angle)
    return float("nan")


def _bound_rows(positions: Floats, gripping: TauHull) -> Iterator[Row]:
    home, least = tau(poses_at(positions, HOME_THETA)), float(gripping.low.min())
    scaled = least / PUBLISHED_TAU_SCALE
    angle = float(np.rad2deg(gripping.theta[int(gripping.low.argmin())]))
    note = (
        f"tau by Eq. 10 at -45 deg over {home.size:,} positions, so true but far from tight; "
        f"{home.min() / PUBLISHED_TAU_SCALE:.3f} divided by {PUBLISHED_TAU_SCALE}"
    )
    low = float(home.min())
    details: dict[str, Any] = {"largest": float(home.max()), "scaled": low / PUBLISHED_TAU_SCALE}
    yield Row.compared("leveziel/fig-6/smallest-at-home", BOUND, low, "-", holds=low > OVER, note=note, **details)
    note = (
        f"tau by Eq. 10 from -60 to -30 deg, {GRIPPING} angles, reached at {angle:.0f} deg; "
        f"{scaled:.3f} divided by {PUBLISHED_TAU_SCALE}"
    )
    yield Row.compared(
        "leveziel/fig-6/smallest-while-gripping", BOUND, least, "-", holds=least > OVER, note=note, scaled=scaled
    )


def _ratio_rows(gripping: TauHull) -> Iterator[Row]:
    """Rows with both ends of 1/tau in the digits of the paper, by Eq. 10 as printed and with a slip of units."""
    lean, steep = (float(gripping.theta[i]) for i in (gripping.high.argmax(), gripping.low.argmin()))
    low, high = -1.0 / lowest_pose(lambda poses: -tau(poses), lean)[1], 1.0 / lowest_pose(tau, steep)[1]
    scaled = PUBLISHED_TAU_SCALE * low, PUBLISHED_TAU_SCALE * high
    deviation = 100.0 * (scaled[0] / RATIOS[0] - 1.0)
    yield Row.compared(
        "leveziel/statement/transmission-ratios",
        _format_range(*RATIOS),
        _format_range(low, high),
        "-",
        note=f"1/tau by Eq. 10 as printed, {low:.2f} to {high:.2f} in the reduced workspace from -60 to -30 deg, ends "
        f"at {np.rad2deg(lean):.0f} and {np.rad2deg(steep):.0f} deg: how far the platform folds at most per motion of "
        "the motors",
        low=low,
        high=high,
    ).explain(_format_range(*scaled))
    yield Row.ours(
        "leveziel/statement/transmission-ratios-scaled",
        _format_range(*scaled),
        "-",
        beside=_format_range(*RATIOS),
        note=f"a hypothesis: 1/tau with |H| times {PUBLISHED_TAU_SCALE}, which is w in centimetres. The upper end, and "
        "tau over 0.1, come out as if column 4 of J_x had been computed without its factor w and lengths in cm; the "
        f"lower end, on a thin ridge at the strokes' edge, stays {deviation:.0f} % off. kappa is free of it",
        low=scaled[0],
        high=scaled[1],
        scale=PUBLISHED_TAU_SCALE,
    )


def _format_range(low: float, high: float) -> str:
    return f"{low:.1f} to {high:.1f}"


def _folding_row(step: float) -> Row:
    poses = reduced(step).poses
    fold = folding_speed(poses)
    ratio = 1.0 / (tau(poses) * fold)
    return Row.compared(
        "leveziel/statement/tau-lets-the-platform-drift",
        "folding at a given position",
        f"{fold.min():.2f} to {fold.max():.2f}",
        "-",
        holds=bool((np.abs(ratio - 1.0) < ALIKE).all()),
        note="1 / |J_q^-1 J_x e_4|, how far the platform folds per motion of the motors while it stays in place; -45 "
        f"deg, {len(fold):,} positions. Row 4 of J in Eq. 10 lets it drift as well, and 1/tau is {ratio.min():.1f} to "
        f"{ratio.max():.1f} times as much",
        low=float(fold.min()),
        high=float(fold.max()),
    )


def tau_figure(hull: TauHull, centre: Floats, gripping: TauHull) -> Figure:
    """Drawing of the platform index over theta with its hull (Fig. 6), and of 1/tau where the prototype grips."""
    figure, (index, ratio) = subplots(2, 1, (WIDTH, 8.0))
    degrees = np.rad2deg(hull.theta)
    index.axvspan(np.rad2deg(CLOSED), np.rad2deg(OPEN), color=COLOURS[8], alpha=0.3, label="the prototype's range")
    index.fill_between(degrees, hull.low, hull.high, color="#9fe3ec", label="hull over the reduced workspace")
    index.plot(degrees, centre, color=COLOURS[3], label="x = y = 0, z = -200 mm")
    index.axhline(OVER, color="black", linewidth=0.8, linestyle=":", label="published bound, 0.1")
    index.axvline(45.0, color="black", linewidth=0.8, linestyle="--", label="published zero, near 45°")
    across, up = "angle of the platform's halves θ [°]", "platform manipulability index τ"
    limits = {"xticks": range(-90, 91, 30), "ylim": (0.0, 0.9)}
    dress(index, across, up, "Eq. 10 as printed", legend="upper right", **limits)
    degrees = np.rad2deg(gripping.theta)
    names = ("Eq. 10 as printed", f"with |H| times {PUBLISHED_TAU_SCALE}")
    for colour, scale, name in zip(COLOURS, (1.0, PUBLISHED_TAU_SCALE), names, strict=False):
        ratio.fill_between(degrees, scale / gripping.high, scale / gripping.low, color=colour, alpha=0.45, label=name)
    for value in RATIOS:
        ratio.axhline(value, color="black", linewidth=0.9, linestyle="--")
    ratio.plot([], [], "--", color="black", label="published, 3.4 to 10.3")
    title = "range over the positions of the reduced workspace"
    dress(ratio, "θ [°]", "1/τ", title, legend="upper right", ylim=(0.0, 13.0))
    return figure
