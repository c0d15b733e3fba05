"""Claims of Choe et al. 2023 on height, acceleration, the rate r and real time, each computed on the example."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Final, cast

import numpy as np
from scipy.optimize import brentq

from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats
from pnt_gym.errors import PlanningError
from pnt_gym.planning import EllipticWorkspace
from pnt_gym.planning.paths import EllipsePath

from .cases import BELT, HALF_RISE, HALF_WIDTH, LIMITS, RATE, example, example_at
from .lengths import CREST
from .speed import Profile

FLATTER: Final = (9.5, 9.6)
"""Angles of flatter ellipses between the example's ends [deg]."""
PERIOD: Final = 0.001
"""Assumed control period [s]; the paper gives none."""
RATES: Final = (4e-3, 0.1)
"""Range in which the rate r is sought for `PERIOD` [rad/m]."""
CALLS: Final = 20
PAIRS, SEED = 2000, 0
"""Number of random pairs of pick and place, and the seed that draws them."""
HEIGHT_RANGE: Final = 0.15
"""Greatest height of a random point above the belt [m]."""
COARSEST: Final = 1e4
"""Largest rate r that is tried for a flat ellipse [rad/m]."""


def claim_findings() -> Findings:
    """Whether the top is lowest, acceleration follows the radius, r follows from a limit, and the list is real-time."""
    rows = (*_height_rows(), _radius_row(), _rate_row(), _real_time_row(), *_random_rows())
    return table_findings("Claims about height, acceleration, r and real time", rows, drop="choe/claim/")


def _height_rows() -> Iterator[Row]:
    """Rows on conclusion 1, by which the height of the top is smallest."""
    top = example().top_height - HALF_RISE
    yield Row.compared(
        "choe/claim/smallest-height/fig-8",
        "smallest",
        1000.0 * top,
        "mm",
        holds=top < CREST,
        statement="choe/claim/smallest-height",
        note=f"height of the proposed curve above T2, against e = {1000.0 * CREST:g} mm of the curves of Fig. 8",
    )
    flatter = {f"{degrees:g} deg": 1000.0 * (example_at(degrees).top_height - HALF_RISE) for degrees in FLATTER}
    listed = ", ".join(f"{height:.1f} mm at {angle}" for angle, height in flatter.items())
    yield Row.compared(
        "choe/claim/smallest-height/own-family",
        "smallest",
        1000.0 * top,
        "mm",
        holds=1000.0 * top <= min(flatter.values()),
        statement="choe/claim/smallest-height",
        note=f"against other ellipses of the paper's own family, which are lower: {listed}",
        heights_mm=flatter,
    )


def _radius_row() -> Row:
    """Row on Figs. 4 to 6: a larger radius of curvature leads to a larger displacement, velocity and acceleration."""
    profile = Profile.of(example(), example().nodes(RATE, clip=False))
    widest = int(profile.curvature.argmax())
    # The knot lies between two steps, whose difference is the acceleration there.
    size = np.abs(profile.acceleration)
    share = 100.0 * float(size[widest - 1] / size.max())
    steps = profile.velocity
    return Row.compared(
        "choe/claim/larger-radius-larger-acceleration",
        "larger",
        share,
        "%",
        holds=int(size.argmax()) == widest - 1,
        note="acceleration at the knot of the largest radius, as a share of its peak: a step grows with the radius, so "
        "the acceleration grows with the radius's slope. Displacement and velocity do follow the radius "
        f"(the longest step lies {abs(int(steps.argmax()) - widest)} knots from the largest radius)",
    )


def _peak_acceleration(rate: float) -> float:
    """Largest acceleration [m/s2] of the node list with the rate r [rad/m] at `PERIOD`."""
    profile = Profile.of(example(), example().nodes(rate, clip=False))
    return float(np.abs(profile.acceleration).max()) / PERIOD**2


def _rate_row() -> Row:
    """Row on r, which is to be chosen so that the largest acceleration satisfies its allowable value."""
    speed, acceleration, _ = LIMITS.numbers()
    rate = cast(float, brentq(lambda r: _peak_acceleration(r) - acceleration, *RATES))
    nodes = example().nodes(rate, clip=False)
    fastest = float(nodes.steps.max()) / PERIOD
    return Row.ours(
        "choe/claim/r-from-the-allowed-acceleration",
        rate,
        "rad/m",
        beside=RATE,
        note=f"r at which the list's largest acceleration is {acceleration:g} m/s2 with an assumed period of "
        f"{1000.0 * PERIOD:g} ms; the paper gives neither. The path then takes {PERIOD * (nodes.theta.size - 1):.2f} "
        f"s, at up to {fastest:.2f} m/s where {speed:g} m/s are allowed: the speed limit has to choose r here",
        nodes=int(nodes.theta.size),
        largest_speed=fastest,
    )


def _real_time_row() -> Row:
    """Row on the claim that the method works in real time: processor time of the whole example."""
    seconds: list[float] = []
    for _ in range(CALLS):
        began = time.process_time()
        EllipsePath.paper(HALF_WIDTH, HALF_RISE).nodes(RATE)
        seconds.append(time.process_time() - began)
    nodes = example().nodes(RATE)
    median = float(np.median(seconds))
    shortest = float(nodes.steps.max()) / LIMITS.numbers()[0]
    return Row.compared(
        "choe/claim/real-time",
        "real-time",
        1000.0 * median,
        "ms",
        holds=median < shortest,
        note=f"median processor time for ellipse and {nodes.theta.size} nodes, shorter than the "
        f"{1000.0 * shortest:.0f} ms of one period in which the list keeps our speed limit",
    )


def _random_rows() -> Iterator[Row]:
    """Rows on the aim that both points may change randomly in the workspace, by three readings of the rule."""
    half_width, half_rise = random_pairs()
    for name, rises, rates, reading in (
        ("as-printed", half_rise, (RATE,), "the ellipse leads from pick to place"),
        ("falling-reversed", np.abs(half_rise), (RATE,), "a falling path is a rising one run backwards"),
        (
            "any-rate",
            np.abs(half_rise),
            (RATE, COARSEST),
            f"the same, with r up to {COARSEST:g} rad/m",
        ),
    ):
        began = time.process_time()
        counts = [_node_count(*pair, rates) for pair in zip(half_width.tolist(), rises.tolist(), strict=True)]
        share = 100.0 * float(np.mean([count > 0 for count in counts]))
        planned = np.array([count for count in counts if count > 0])
        yield Row.compared(
            f"choe/claim/random-points/{name}",
            "randomly in the workspace",
            share,
            "%",
            holds=share == 100.0,
            statement="choe/claim/random-points",
            note=f"pairs of {PAIRS:,} random ones in our workspace, up to {HEIGHT_RANGE:g} m above the belt, that the "
            f"rule of whole degrees gives a node list; {reading}. The lists have {planned.min()} "
            f"to {planned.max():,} nodes",
            milliseconds_a_path=1000.0 * (time.process_time() - began) / PAIRS,
        )


def random_pairs(count: int = PAIRS, seed: int = SEED) -> tuple[Floats, Floats]:
    """Half widths and half rises (N,) [m] between picks and places that are uniform in the workspace."""
    rng, region = np.random.default_rng(seed), EllipticWorkspace()
    radius, turn = np.sqrt(rng.random((count, 2))), 2.0 * np.pi * rng.random((count, 2))
    x, y = region.semi_x * radius * np.cos(turn), region.semi_y * radius * np.sin(turn)
    z = BELT + HEIGHT_RANGE * rng.random((count, 2))
    return 0.5 * np.hypot(x[:, 1] - x[:, 0], y[:, 1] - y[:, 0]), 0.5 * (z[:, 1] - z[:, 0])


def _node_count(half_width: float, half_rise: float, rates: tuple[float, ...]) -> int:
    """Number of nodes of the paper's ellipse at the first rate that gives a list; 0 where there is none."""
    for rate in rates:
        try:
            return int(EllipsePath.paper(half_width, half_rise).nodes(rate).theta.size)
        except PlanningError:
            continue
    return 0
