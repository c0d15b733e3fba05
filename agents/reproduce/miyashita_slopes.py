"""Why a gain of the iterative learning of Miyashita et al. 2010 is too small or too large: slopes of its map."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from agents.reproduce.findings import Row
from agents.reproduce.miyashita_cases import TRIALS, Thrower, has_plan, listed, misses
from pnt_gym.cells.pallet.config import load
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.one_joint import plan_throws

NUDGE: Final = np.array([0.002, 0.002, 0.01, 0.01])
"""Differences in x, y [m], phi [rad] and dy [m/s] for the slopes."""


class Slopes(NamedTuple):
    """By how much the passed state moves with the virtual goal, at N goals without scatter."""

    three: Floats
    """Across the flight, in rising order (N, 3); along it nothing moves, for the state nearest to the goal counts."""
    first: Floats
    """Position error of the first throw (N,) [m]."""


def measured_slopes(delay: float, goal: Floats, virtual: Floats) -> Slopes:
    """Slopes at virtual goals (N, 4) that were learned for goals (N, 4), where all the nudges have a throw.

    Args:
        delay: how late the block comes free [s].
        goal: what is to be reached.
        virtual: what is planned for.
    """
    quiet = load(
        "nominal",
        errors={"delay": delay, "placement": 0.0, "timing": 0.0},
        camera={"position": 0.0, "angle_deg": 0.0},
    )
    moved = [virtual + sign * way for way in np.diag(NUDGE) for sign in (1.0, -1.0)]
    rows = np.logical_and.reduce([has_plan(one) for one in moved])
    thrower = Thrower(quiet, range(int(rows.sum())))
    ends = [thrower.throw(plan_throws(one[rows]), goal[rows]).measured for one in moved]
    slopes = np.stack([(ends[2 * k] - ends[2 * k + 1]) / (2.0 * NUDGE[k]) for k in range(4)], axis=2)
    first = thrower.throw(plan_throws(goal[rows]), goal[rows]).measured - goal[rows]
    # The least eigenvalue is the zero of the way along the flight.
    return Slopes(np.sort(np.linalg.eigvals(slopes).real, axis=1)[:, 1:], misses(first).position)


def gain_note(slopes: Slopes, gain: float) -> str:
    """What a constant gain does to the errors and to the scatter, in words."""
    left = 1.0 - gain * slopes.three[:, 0]
    rest = 1e3 * float(np.median(slopes.first * np.abs(left) ** (TRIALS - 1)))
    rate = gain * float(np.median(slopes.three[:, 2]))
    grown = np.sqrt(1.0 + rate / (2.0 - rate))
    return (
        f"Where the state follows the virtual goal least, {100.0 * float(np.median(left)):.0f} % of the error is left "
        f"by each throw, {rest:.1f} mm at throw {TRIALS} (medians, no scatter); where most, the scatter of the "
        f"measured state grows to {grown:.1f} times that of a throw"
    )


def slope_rows(delay: float, slopes: Slopes) -> list[Row]:
    """The least and the largest slope, which bound what any constant gain can do.

    Between its planned and its true release the block loses the same speed whatever was planned, so its state does not
    follow the plan one to one, the less so the later it comes free.
    """
    names, low, high = ("least", "largest"), slopes.three[:, 0], slopes.three[:, 2]
    notes = (
        "a gain K leaves 1 - K times this of the error in that direction",
        "what is learned from a throw's scatter grows with K times this",
    )
    return [
        Row(
            f"miyashita/slopes/delay-{1000.0 * delay:.0f}ms/{name}",
            None,
            float(np.median(values)),
            "-",
            "ours",
            f"{name} slope of the passed state against the virtual goal across the flight, median of {len(low)} random "
            f"goals without scatter, at the virtual goals that were learned; the paper's update takes it to be 1; "
            f"{note}",
            {"quantiles_10_50_90": listed(np.quantile(values, (0.1, 0.5, 0.9)), 4)},
        )
        for name, values, note in zip(names, (low, high), notes, strict=True)
    ]
