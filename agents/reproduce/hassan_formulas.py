"""Formulas of Hassan et al. 2022 that need a word or a constraint more than is printed, each on an example."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from agents.reproduce.findings import Row
from agents.reproduce.hassan_cases import FOLD, PERCENTAGES, PICKS, TARGETS, WORKSPACE, cell_cycle, scene
from pnt_gym.planning import MotionLimits, Release, plan_release, plan_release_batch
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.planning.nlp import method_1
from pnt_gym.planning.segments import brake_distance

CEILING: Final = -0.75
"""Release ceiling of the table [m]: 0.10 above the picks."""
FOLD_CASE: Final = ((-0.389, -0.443, -0.85), (0.209, 0.2, -0.79), 45)
"""A throw with a flat and a steep branch below the ceiling: pick, target [m] and percentage."""
LOW_BIN: Final = 0.2
"""Depth of a bin below the belt that tells the definitions of theta_r apart [m]."""
HIGH_BIN: Final = 0.2
"""Height of a bin above the ceiling that no slow throw reaches [m]."""


def formula_rows() -> list[Row]:
    """Branches below a ceiling, then single formulas, then statements about the throws outside."""
    return [
        *_branches(),
        _root_argument(),
        _bound_order(),
        _angle(),
        _arctangent(),
        *_outside_30(),
        _elevations(),
    ]


def _branches() -> list[Row]:
    """Below a ceiling the feasible elevations can fall apart; "unique minimum" (III-E) does not cover that."""
    pick, target, percent = FOLD_CASE
    limits = MotionLimits.t3kr(percent)
    exact = plan_release(pick, target, limits, ceiling=CEILING)
    local = method_1(pick, target, limits, ceiling=CEILING)
    low, high = (_fold_release(height) for height in (-0.7550, -0.7475))
    flat, steep = (np.degrees(found.angle) for found in (low, high))
    return [
        Row(
            "hassan/inconsistency/two-branches",
            exact.time,
            local.time,
            "s",
            "differs",
            f"release time by method 1 (SLSQP, success reported: {local.success}) beside the optimum, from "
            f"{pick} to {target} at {percent} % below z = {CEILING} m",
            {"ratio": local.time / exact.time, "optimal_angle_rad": exact.angle},
        ),
        Row(
            "hassan/inconsistency/fold",
            low.distance,
            high.distance,
            "m",
            "ours",
            f"release distance of the first throw of {'/'.join(map(str, FOLD))} with the ceiling 7.5 mm higher: the "
            f"elevation jumps from {flat:.0f} to {steep:.0f} degrees, which is why this cell reads 120",
            {"low_ceiling_m": -0.7550, "high_ceiling_m": -0.7475},
        ),
    ]


def _fold_release(ceiling: float) -> Release:
    return plan_release(PICKS[0], TARGETS["inside"], MotionLimits.t3kr(FOLD[2]), ceiling=ceiling)


def _root_argument() -> Row:
    """Eq. 18 takes the root of (V sin / g)^2 + 2 (z - Z_f) / g; Eqs. 14-17 do not keep it from being negative."""
    limits = MotionLimits.t3kr(5)
    rise = limits.numbers()[0] / GRAVITY
    greatest = rise * rise - 2.0 * HIGH_BIN / GRAVITY
    return Row(
        "hassan/inconsistency/root-of-equation-18",
        "no constraint",
        greatest,
        "s2",
        "misprint",
        f"greatest argument at 5 % with a bin {HIGH_BIN} m above the ceiling: negative for every admissible x, so t_f "
        "is complex; the target's height needs a constraint of its own",
    )


def _bound_order() -> Row:
    """Section III-D bounds x_3 by X_0 <= x_3 <= X_rmax, which holds only for targets in +x."""
    pick, target = np.array(PICKS[0]), np.array(TARGETS["inside"]) * np.array([-1.0, 1.0, 1.0])
    mirrored = pick * np.array([-1.0, 1.0, 1.0])
    azimuth = np.arctan2(*(target - mirrored)[1::-1])
    bounds = WORKSPACE.line_bounds(mirrored[None], np.cos([azimuth]), np.sin([azimuth]))
    width = float(bounds.far[0] * math.cos(azimuth))
    return Row(
        "hassan/inconsistency/order-of-bounds",
        "X_0 <= x_3 <= X_rmax",
        width,
        "m",
        "misprint",
        "X_rmax - X_0 of the first throw mirrored to -x: no point lies between the printed bounds",
    )


def _angle() -> Row:
    """Theta_r is measured from P0-Pf in III-A, between the horizontal and P0-Pf in III-D, from the horizontal there."""
    pick, target = np.array(PICKS[0]), np.array(TARGETS["inside"]) - np.array([0.0, 0.0, LOW_BIN])
    found = plan_release(pick, target, MotionLimits.t3kr(30), ceiling=CEILING)
    fall = math.atan2(target[2] - pick[2], math.hypot(*(target - pick)[:2]))
    above, between = math.degrees(found.angle), math.degrees(found.angle - fall)
    return Row(
        "hassan/inconsistency/definition-of-angle",
        between,
        above,
        "deg",
        "misprint",
        f"first throw at 30 % into a bin {LOW_BIN} m below the belt: from the line P0-Pf (III-A) beside from the "
        f"horizontal, which the formulas use; the horizontal and P0-Pf (III-D) are {-math.degrees(fall):.1f} deg apart",
    )


def _arctangent() -> Row:
    """The azimuth alpha is printed as an arctangent."""
    pick, target = np.array(PICKS[0]), np.array(TARGETS["inside"])
    back = pick - target
    printed, right = math.atan(back[1] / back[0]), math.atan2(back[1], back[0])
    return Row(
        "hassan/inconsistency/arctangent",
        math.degrees(printed),
        math.degrees(right),
        "deg",
        "misprint",
        "azimuth of a throw the other way round, from the target to the first pick: the quadrant needs both arguments",
    )


def _outside_30() -> list[Row]:
    """Section IV-C3: below 35 % the speed is not sufficient to throw outside."""
    picks, targets, _ = scene("outside")
    limits = MotionLimits.t3kr(30)
    release = plan_release_batch(picks, targets, limits, CEILING, 0.005, WORKSPACE)
    cycle = cell_cycle("paper-clock", "horizontal-throw", "outside", 30)
    speed = np.linalg.norm(cycle.release_velocity, axis=1)
    stop = cycle.release_position + (brake_distance(speed, limits) / speed)[:, None] * cycle.release_velocity
    radius = float(np.hypot(stop[:, 0], stop[:, 1]).max())
    note = "throws to the outside target at 30 % with the release inside the workspace"
    return [
        Row(
            "hassan/inconsistency/outside-30-proposed",
            0.0,
            float(release.feasible.sum()),
            "throws",
            "differs",
            f"{note}; the release lies at most {np.hypot(release.position[:, 0], release.position[:, 1]).max():.2f} m "
            "from the axis",
        ),
        Row(
            "hassan/inconsistency/outside-30-horizontal",
            0.0,
            float(cycle.feasible.sum()),
            "throws",
            "differs",
            f"{note} and the hand stopping there, at most {radius:.3f} m from the axis: not the speed but the reach "
            "would have to forbid them",
            {"stop_radius_m": radius},
        ),
    ]


def _elevations() -> Row:
    """The proposed throw leaves the belt without a lift."""
    angles: list[float] = []
    for zone, percents in PERCENTAGES.items():
        for percent in percents:
            picks, targets, _ = scene(zone)
            release = plan_release_batch(picks, targets, MotionLimits.t3kr(percent), CEILING, 0.005)
            angles += np.degrees(release.angle).tolist()
    angles.sort()
    rise = 100.0 * math.sin(math.radians(angles[-2]))
    return Row(
        "hassan/inconsistency/no-lift",
        None,
        angles[0],
        "deg",
        "ours",
        f"flattest of the 18 throws of the table; all but one ({angles[-1]:.0f} deg) stay below {angles[-2]:.0f} deg, "
        f"so in the first 100 mm the object rises at most {rise:.0f} mm above the belt and its neighbours",
        {"angles_deg": angles},
    )
