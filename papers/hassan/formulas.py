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
from pnt_gym.planning import brake_distance, plan_release_batch

from .cases import CEILING, CELLS, INITIAL, PICKS, PROTOCOLS, TARGETS, cell_cycle, limits_at, scene

SEMI_AXES: Final = np.arange(0.300, 1.200, 0.005)
"""Semi-axes of the ellipses that may be the paper's workspace, along x and along y [m]."""
RULES: Final = PROTOCOLS["paper-clock"].rules
PICK, TARGET = np.array(PICKS[0]), np.array(TARGETS["inside"])


def formula_rows() -> list[Row]:
    """Rows on branches below a ceiling, on single formulas, and on the paper's statements about throws outside."""
    return [
        *_outside_rows(),
        _elevation_row(),
    ]


def _outside_rows() -> list[Row]:
    """Rows on section IV-C3's statement that below 35 % the speed does not suffice to throw outside."""
    rows: list[Row] = []
    for name, method in (("proposed", "min-time-throw"), ("horizontal", "horizontal-throw")):
        throws = [cell_cycle(protocol, method, "outside", 30) for protocol in ("paper-clock", "constant-jerk-overlap")]
        stops = _stops(method, 30)
        share = _share_of_ellipses_against(stops)
        row = Row.compared(
            f"hassan/statement/outside-30-{name}",
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
        "hassan/statement/no-lift",
        angles[0],
        "deg",
        note=f"flattest of the 18 throws of the table; all but one ({angles[-1]:.0f} deg) stay below {angles[-2]:.0f} "
        f"deg, so in the first 100 mm the object rises at most {rise:.0f} mm above the belt and its neighbours",
        angles_deg=angles,
    )
