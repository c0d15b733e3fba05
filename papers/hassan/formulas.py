"""Formulas of Hassan et al. 2022 that need more words or constraints than the paper prints, each on an example.

Further rows count over many throws how often a claimed property of the throw or of the S-curve is violated.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Final

import numpy as np

from agents.reproduce.finding import Row
from pnt_gym.arrays import Bools, Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.planning import brake_distance, landing_point, plan_release, plan_release_batch

from .cases import CEILING, CELLS, FOLD, INITIAL, PICKS, PROTOCOLS, TARGETS, WORKSPACE, cell_cycle, limits_at, scene
from .nlp import method_1

FOLD_CASE: Final = ((-0.389, -0.443, -0.85), (0.209, 0.2, -0.79), 45)
"""A throw with a flat and a steep branch below the ceiling: pick, target [m] and percentage."""
LOW_BIN: Final = 0.2
"""Depth of a bin below the belt [m], with which the two definitions of theta_r differ."""
HIGH_BIN: Final = 0.2
"""Height of a bin above the ceiling that no slow throw reaches [m]."""
SEMI_AXES: Final = np.arange(0.300, 1.200, 0.005)
"""Semi-axes of the ellipses that may be the paper's workspace, along x and along y [m]."""
RULES: Final = PROTOCOLS["paper-clock"].rules
PICK, TARGET = np.array(PICKS[0]), np.array(TARGETS["inside"])


def formula_rows() -> list[Row]:
    """Rows on branches below a ceiling, on single formulas, and on the paper's statements about throws outside."""
    return [
        _branch_row(),
        _fold_row(),
        _root_row(),
        _bound_order_row(),
        _angle_row(),
        *_outside_rows(),
        _elevation_row(),
    ]


def _branch_row() -> Row:
    """Row of a throw whose feasible elevations below a ceiling form two branches, unlike III-E's "unique minimum"."""
    pick, target, percent = FOLD_CASE
    limits = limits_at(percent)
    exact, local = plan_release(pick, target, limits, ceiling=CEILING), method_1(pick, target, limits, ceiling=CEILING)
    return Row.ours(
        "hassan/inconsistency/two-branches",
        local.time,
        "s",
        note=f"release time by method 1 (SLSQP, success reported: {local.success}) where the optimum takes "
        f"{exact.time:.4f} s, from {pick} to {target} at {percent} % below z = {CEILING} m; the unique minimum of "
        "III-E is without a ceiling",
        optimum_s=exact.time,
        ratio=local.time / exact.time,
        optimal_angle_rad=exact.angle,
    )


def _fold_row() -> Row:
    """Row on the jump of the release distance with the ceiling, which makes the cell `FOLD` sensitive."""
    heights = (-0.7550, -0.7475)
    low, high = (plan_release(PICK, TARGET, limits_at(FOLD[2]), ceiling=height) for height in heights)
    flat, steep = (math.degrees(release.angle) for release in (low, high))
    return Row.ours(
        "hassan/inconsistency/fold",
        high.distance,
        "m",
        note=f"release distance of the first throw of {'/'.join(map(str, FOLD))} with the ceiling 7.5 mm higher, "
        f"instead of {low.distance:.3f} m: the elevation jumps from {flat:.0f} to {steep:.0f} degrees, which is why "
        "this cell reads 120",
        low_distance_m=low.distance,
        ceilings_m=list(heights),
    )


def _root_row() -> Row:
    """Row on the root's argument in Eq. 18, (V sin / g)^2 + 2 (z - Z_f) / g, which Eqs. 14-17 let become negative."""
    rise = limits_at(5).numbers()[0] / GRAVITY
    greatest = rise * rise - 2.0 * HIGH_BIN / GRAVITY
    return Row.ours(
        "hassan/inconsistency/root-of-equation-18",
        greatest,
        "s2",
        beside="a real t_f",
        note=f"greatest argument at 5 % with a bin {HIGH_BIN} m above the ceiling: negative for every admissible x, so "
        "t_f is complex; the paper has no such bin, in which the target's height needs a constraint of its own",
    )


def _bound_order_row() -> Row:
    """Row on section III-D's bounds X_0 <= x_3 <= X_rmax, which are in order only for targets in +x."""
    mirror = np.array([-1.0, 1.0, 1.0])
    pick, target = PICK * mirror, TARGET * mirror
    azimuth = np.arctan2(*(target - pick)[1::-1])
    bounds = WORKSPACE.line_bounds(pick[None], np.cos([azimuth]), np.sin([azimuth]))
    width = float(bounds.far[0] * math.cos(azimuth))
    return Row.ours(
        "hassan/inconsistency/order-of-bounds",
        width,
        "m",
        beside="X_0 <= X_rmax",
        note="X_rmax - X_0 of the first throw mirrored to -x, where no target of the paper stands: no point lies "
        "between the printed bounds of x_3",
    )


def _angle_row() -> Row:
    """Row on theta_r, an angle from P0-Pf in the words of III-A and from the horizontal in the formulas of III-D."""
    target = TARGET - np.array([0.0, 0.0, LOW_BIN])
    level = (target - PICK)[:2] / np.hypot(*(target - PICK)[:2])
    release = plan_release(PICK, target, limits_at(30), ceiling=CEILING)
    fall = math.atan2(target[2] - PICK[2], np.hypot(*(target - PICK)[:2]))
    readings = {"from the line P0-Pf": release.angle - fall, "from the horizontal": release.angle}
    misses: dict[str, float] = {}
    for name, theta in readings.items():
        velocity = release.speed * np.array([*(math.cos(theta) * level), math.sin(theta)])
        misses[name] = float(np.hypot(*(landing_point(release.position, velocity, target[2]) - target)[:2]))
    wrong = readings["from the line P0-Pf"]
    return Row.ours(
        "hassan/inconsistency/definition-of-angle",
        min(misses, key=lambda name: misses[name]),
        "-",
        beside="from the line P0-Pf",
        note="theta_r in the words of III-A beside what Eq. 18 needs to hit, as III-D has it; the paper's own targets "
        f"lie at the height of the picks, where both agree. The first throw at 30 % into a bin {LOW_BIN} m "
        f"below the belt rises at {math.degrees(release.angle):.1f} degrees, not at "
        f"{math.degrees(wrong):.1f}",
        landing_errors_m=misses,
    )


def _outside_rows() -> list[Row]:
    """Rows on section IV-C3's statement that below 35 % the speed does not suffice to throw outside."""
    rows: list[Row] = []
    for name, method in (("proposed", "min-time-throw"), ("horizontal", "horizontal-throw")):
        throws = [cell_cycle(protocol, method, "outside", 30) for protocol in ("paper-clock", "constant-jerk-overlap")]
        stops = _stops(method, 30)
        share = _share_of_ellipses_against(stops)
        row = Row.compared(
            f"hassan/inconsistency/outside-30-{name}",
            0.0,
            float(min(batch.feasible.sum() for batch in throws)),
            "throws",
            note="throws to the outside target at 30 %, J scaled or constant, with the hand stopping inside our "
            f"workspace, at most {np.hypot(stops[:, 0], stops[:, 1]).max():.3f} m from the axis; the paper gives no "
            f"size of its ellipse, and {100.0 * share:.0f} % of the ellipses that agree with its other statements "
            "forbid such a throw",
            share_of_ellipses=share,
        )
        rows.append(replace(row, conditions="unpublished") if share > 0.0 else row)
    return rows


def _stops(method: str, percent: int) -> Floats:
    """Places at which the hand stops after throws to the outside target, by straight braking (3, 3) [m]."""
    cycle = cell_cycle("paper-clock", method, "outside", percent)
    speed = np.linalg.norm(cycle.release_velocity, axis=1)
    reach = (brake_distance(speed, limits_at(percent)) / speed)[:, None]
    return cycle.release_position + reach * cycle.release_velocity


def _share_of_ellipses_against(stops: Floats) -> float:
    """Share of the ellipses that agree with the paper's other statements in which a hand cannot stop at some places.

    The statements: picks, P_initial and the inside target lie inside, the outside target outside, and both throws to it
    exist at 35 %.
    """
    semi = np.stack(np.meshgrid(SEMI_AXES, SEMI_AXES, indexing="ij"), axis=-1).reshape(-1, 1, 2)

    def holds(points: Floats) -> Bools:
        return (((points[:, :2] / semi) ** 2).sum(axis=2) <= 1.0).all(axis=1)

    at_35 = [_stops(method, 35) for method in ("min-time-throw", "horizontal-throw")]
    inside = np.concatenate([[*PICKS, INITIAL, TARGETS["inside"]], *at_35])
    agrees = holds(inside) & ~holds(np.array([TARGETS["outside"]]))
    return float((agrees & ~holds(stops)).sum() / agrees.sum())


def _elevation_row() -> Row:
    """Row on the flattest elevations of Table I's throws: the proposed throw leaves the belt without a lift."""
    angles: list[float] = []
    for zone, percent in CELLS:
        picks, targets, _ = scene(zone)
        release = plan_release_batch(picks, targets, limits_at(percent), CEILING, RULES.tolerance)
        angles += np.degrees(release.angle).tolist()
    angles.sort()
    rise = 100.0 * math.sin(math.radians(angles[-2]))
    return Row.ours(
        "hassan/inconsistency/no-lift",
        angles[0],
        "deg",
        note=f"flattest of the 18 throws of the table; all but one ({angles[-1]:.0f} deg) stay below {angles[-2]:.0f} "
        f"deg, so in the first 100 mm the object rises at most {rise:.0f} mm above the belt and its neighbours",
        angles_deg=angles,
    )
