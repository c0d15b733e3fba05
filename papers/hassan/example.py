"""The numeric example of Hassan et al. 2022 (section IV-B3): three throws at 30 %, checked by the paper's own model."""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.reproduce.finding import Row, printed
from pnt_gym.arrays import Floats, Point
from pnt_gym.planning import landing_point, plan_release, plan_release_batch

from .cases import CEILING, PICKS, TARGETS, WORKSPACE, limits_at
from .nlp import method_2

RELEASES: Final = ((0.09, 0.13, -0.75), (0.15, 0.17, -0.75), (0.12, 0.17, -0.75))
"""Published release points P_throw of the three picks [m]; the paper states no bound of their height."""
SPEED: Final = 1.8
"""Published release speed of all three throws [m/s]."""
TOLERANCE: Final = 0.005
"""Delta [m] (section III-D): greatest distance of a landing from the target along x and along y."""
TARGET: Final = np.array(TARGETS["inside"])
LIMITS: Final = limits_at(30)
STEPS: Final = 21
"""Offsets per axis in the search over release points and speeds with the same printed digits."""
CEILINGS: Final = 41
"""Ceilings that print as the published height of the release points, in steps of 0.25 mm."""


def example_rows() -> list[Row]:
    """Rows with landings of the published throws, optimal release points, and bounds of the release height."""
    rows: list[Row] = []
    for k, release in enumerate(RELEASES):
        rows += [_landing_row(k, np.array(release)), _optimum_row(k, np.array(release))]
    return [*rows, _height_bound_row(), _method_2_row()]


def landing_error(pick: Floats, release: Floats, speed: float = SPEED) -> Floats:
    """Landing less target in the target's plane (..., 2) [m] for release points (..., 3) [m] and a speed [m/s].

    The release velocity has the direction from the pick to the release point.
    """
    way = release - pick
    velocity = speed * way / np.linalg.norm(way, axis=-1, keepdims=True)
    return (landing_point(release, velocity, TARGET[2]) - TARGET)[..., :2]


def best_under_rounding(pick: Floats, release: Floats) -> float:
    """Least landing error on the worse axis [m] over all release points and speeds with the same printed digits."""
    offsets = np.linspace(-printed(2), printed(2), STEPS)
    grid = np.stack(np.meshgrid(offsets, offsets, offsets, indexing="ij"), axis=-1).reshape(-1, 3)
    speeds = SPEED + np.linspace(-printed(1), printed(1), STEPS)
    return min(float(np.abs(landing_error(pick, release + grid, v)).max(axis=1).min()) for v in speeds)


def _landing_row(k: int, release: Floats) -> Row:
    pick = np.array(PICKS[k])
    error = landing_error(pick, release)
    line = (TARGET - pick)[:2] / np.linalg.norm((TARGET - pick)[:2])
    return Row.ours(
        f"hassan/example/throw-{k + 1}-landing",
        best_under_rounding(pick, release),
        "m",
        note="landing from the target on the worse axis, the least that any release point and speed with the printed "
        f"digits give; delta allows 5 mm. As printed the throw lands {1000 * np.hypot(*error):.1f} mm off",
        printed_point_m=float(np.hypot(*error)),
        along_m=float(error @ line),
        across_m=float(error @ np.array([-line[1], line[0]])),
    )


def _optimum_row(k: int, release: Floats) -> Row:
    """Row with the quickest throw, under the ceiling that leads nearest to the published point.

    The paper gives no ceiling. The published points have one height, so ceilings that print as it are tried.
    """
    ceilings = CEILING + np.linspace(-printed(2), printed(2), CEILINGS)
    optima = [plan_release(PICKS[k], TARGET, LIMITS, ceiling=float(z), tolerance=TOLERANCE) for z in ceilings]
    apart = [float(np.linalg.norm(optimum.position - release)) for optimum in optima]
    same = [_digits(optimum.position) == _digits(release) for optimum in optima]
    best = min(range(CEILINGS), key=lambda c: (not same[c], apart[c]))
    optimum, ceiling = optima[best], float(ceilings[best])
    return Row.compared(
        f"hassan/example/throw-{k + 1}-point",
        _digits(release),
        _digits(optimum.position),
        "m",
        note=f"quickest throw below z = {ceiling:.4f} m within delta, to the printed digits, "
        f"{1000 * apart[best]:.0f} mm from the published point; "
        f"{sum(same)} of {CEILINGS} ceilings that print as {CEILING} m give these digits",
        point_m=optimum.position.tolist(),
        apart_m=apart[best],
        ceiling_m=ceiling,
        release_time_s=optimum.time,
        angle_rad=optimum.angle,
    )


def _digits(point: Point) -> str:
    return ", ".join(f"{x:.2f}" for x in np.asarray(point))


def _height_bound_row() -> Row:
    """Row with the release height's bound of section III-D: where the line to the target leaves the workspace."""
    picks = np.array(PICKS)
    way = TARGET - picks
    azimuth = np.arctan2(way[:, 1], way[:, 0])
    bounds = WORKSPACE.line_bounds(picks, np.cos(azimuth), np.sin(azimuth))
    heights = picks[:, 2] + bounds.far / np.hypot(way[:, 0], way[:, 1]) * way[:, 2]
    throws = int(plan_release_batch(picks, np.tile(TARGET, (3, 1)), LIMITS, heights, TOLERANCE).feasible.sum())
    return Row.compared(
        "hassan/statement/greatest-height",
        max(point[2] for point in RELEASES),
        float(heights.max()),
        "m",
        within=printed(2),
        note="Z_rmax as defined, where the line from pick to target leaves the workspace, is the height of the pick: "
        f"{throws} of 3 throws exist below it; the example's points lie at the published value, stated nowhere",
        throws=throws,
    )


def _method_2_row() -> Row:
    heights = [float(method_2(pick, TARGET, LIMITS).position[2]) for pick in PICKS]
    return Row.compared(
        "hassan/statement/method-2-heights",
        _digits([point[2] for point in RELEASES]),
        _digits(heights),
        "m",
        note="release heights of the example by method 2 as printed, which knows no bound of the height",
        heights_m=heights,
    )
