"""The numeric example of Hassan et al. 2022 (section IV-B3): three throws at 30 %, checked against their own model."""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.reproduce.findings import Row
from agents.reproduce.hassan_cases import PICKS, TARGETS, WORKSPACE
from pnt_gym.planning import InfeasibleThrow, MotionLimits, landing_point, plan_release
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.nlp import method_2

RELEASES: Final = ((0.09, 0.13, -0.75), (0.15, 0.17, -0.75), (0.12, 0.17, -0.75))
"""Published release points P_throw of the three picks [m]."""
SPEED: Final = 1.8
"""Published release speed of all three [m/s]."""
TOLERANCE: Final = 0.005
"""Delta [m] (section III-D)."""
CEILING: Final = -0.75
"""Height of all three published release points [m]; the paper states no such bound."""
DIGITS: Final = 0.005
"""Half of the last printed digit [m]."""
LIMITS: Final = MotionLimits.t3kr(30)
STEPS = 21


def example_rows() -> list[Row]:
    """Where the published throws land, where the optima lie, and what bounded them."""
    rows: list[Row] = []
    for k, published in enumerate(RELEASES):
        rows += [_landing(k, published), _optimum(k, published)]
    return [*rows, _bound_rule(), _method_2_heights()]


def landing_error(pick: Floats, release: Floats, speed: float = SPEED) -> Floats:
    """Landing less target in the target's plane (..., 2) [m] for releases (..., 3) on a line from the pick."""
    target = np.array(TARGETS["inside"])
    way = release - pick
    velocity = speed * way / np.linalg.norm(way, axis=-1, keepdims=True)
    return (landing_point(release, velocity, target[2]) - target)[..., :2]


def best_under_rounding(pick: Floats, release: Floats) -> float:
    """The least error on the worse axis [m] that any point with the same printed digits gives."""
    shift = np.linspace(-DIGITS, DIGITS, STEPS)
    grid = np.stack(np.meshgrid(shift, shift, shift, indexing="ij"), axis=-1).reshape(-1, 3)
    return float(np.abs(landing_error(pick, release + grid)).max(axis=1).min())


def _landing(k: int, published: tuple[float, float, float]) -> Row:
    pick, release, target = np.array(PICKS[k]), np.array(published), np.array(TARGETS["inside"])
    error = landing_error(pick, release)
    line = (target - pick)[:2] / np.linalg.norm((target - pick)[:2])
    best = best_under_rounding(pick, release)
    along, across = float(error @ line), float(error @ np.array([-line[1], line[0]]))
    details = {"along_m": along, "across_m": across, "best_under_rounding_m": best}
    return Row(
        f"hassan/inconsistency/throw-{k + 1}-landing",
        TOLERANCE,
        float(np.hypot(*error)),
        "m",
        "reproduced" if best <= TOLERANCE else "not reproducible",
        f"distance of the published throw's landing from its target; rounding leaves at least {1000 * best:.1f} mm "
        "on the worse axis, delta allows 5 mm on each",
        details,
    )


def _optimum(k: int, published: tuple[float, float, float]) -> Row:
    found = plan_release(PICKS[k], TARGETS["inside"], LIMITS, ceiling=CEILING, tolerance=TOLERANCE)
    apart = float(np.linalg.norm(found.position - np.array(published)))
    # Each printed coordinate may be off by half a digit.
    near = apart <= np.sqrt(3.0) * DIGITS
    return Row(
        f"hassan/inconsistency/throw-{k + 1}-point",
        ", ".join(f"{x:.2f}" for x in published),
        ", ".join(f"{x:.4f}" for x in found.position),
        "m",
        "reproduced" if near else "not reproducible",
        f"quickest throw below z = {CEILING} m within delta: {1000 * apart:.0f} mm from the published point",
        {"apart_m": apart, "release_time_s": found.time, "angle_rad": found.angle},
    )


def _bound_rule() -> Row:
    """The bound of the release height as section III-D states it."""
    picks, target = np.array(PICKS), np.array(TARGETS["inside"])
    way = target - picks
    azimuth = np.arctan2(way[:, 1], way[:, 0])
    bounds = WORKSPACE.line_bounds(picks, np.cos(azimuth), np.sin(azimuth))
    # Where the line from pick to target leaves the workspace, which is a cylinder.
    share = bounds.far / np.hypot(way[:, 0], way[:, 1])
    heights = picks[:, 2] + share * way[:, 2]
    thrown = 0
    for pick, height in zip(PICKS, heights, strict=True):
        try:
            plan_release(pick, TARGETS["inside"], LIMITS, ceiling=float(height), tolerance=TOLERANCE)
        except InfeasibleThrow:
            continue
        thrown += 1
    return Row(
        "hassan/inconsistency/greatest-height",
        CEILING,
        float(heights.max()),
        "m",
        "misprint",
        "Z_rmax as defined, where the line from pick to target leaves the workspace, is the height of the pick: "
        f"{thrown} of 3 throws exist below it; the example's points lie at the published value, stated nowhere",
        {"throws": thrown},
    )


def _method_2_heights() -> Row:
    heights = [method_2(pick, TARGETS["inside"], LIMITS).position[2] for pick in PICKS]
    return Row(
        "hassan/inconsistency/method-2-heights",
        ", ".join(f"{point[2]:.2f}" for point in RELEASES),
        ", ".join(f"{z:.2f}" for z in heights),
        "m",
        "not reproducible",
        "release heights of the example by method 2 as printed, which knows no bound of the height",
        {"heights_m": [float(z) for z in heights]},
    )
