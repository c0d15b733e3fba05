"""Properties that Hassan et al. 2022 state or use, counted over many throws."""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.reproduce.findings import Row, Verdict
from agents.reproduce.hassan_cases import PERCENTAGES, scene
from pnt_gym.planning import (
    GRAVITY,
    MotionLimits,
    ReleaseBatch,
    brake_distance,
    min_time_scurve,
    plan_release_batch,
    release_at_elevation,
)
from pnt_gym.planning.arrays import Bools, Floats, Ints, length

THROWS: Final = 2000
GRID: Final = 300
STROKES: Final = np.geomspace(1e-3, 5.0, 200)
"""Strokes P of the S-curve [m]."""
ROUNDING: Final = 1e-12
APPROACH: Final = 0.05
"""Vertical approach Z_off [m]."""
SMALL_GAIN: Final = 1e-3
"""Relative gain of the cycle time up to which the quickest release counts as the quickest cycle."""


def claim_rows() -> list[Row]:
    """Monotone S-curve, unique minimum, least distance in least time, falling hits, quickest cycle."""
    rng = np.random.default_rng(44)
    limits = _limits(rng, THROWS)
    picks, targets = _throws(rng, THROWS)
    best = plan_release_batch(picks, targets, limits)
    distance, time = _profiles(picks, targets, limits)
    return [
        *_scurve_rows(limits),
        _violations(
            "unique-minimum", _minima(distance) > 1, "throws whose release distance has several minima (III-E)"
        ),
        _violations(
            "least-distance-is-least-time",
            time.min(axis=1) < best.time * (1.0 - 1e-9),
            "throws with a quicker release than that of least distance (III-E)",
        ),
        _violations(
            "falling-hit", _rising(best), "optimal throws that hit the target on their way up (Eq. 19 has both)"
        ),
        _quickest_cycle(),
    ]


def _limits(rng: np.random.Generator, count: int) -> MotionLimits:
    share = rng.uniform(0.1, 1.0, count)
    return MotionLimits(6.0 * share, 120.0 * share, 3000.0 * rng.uniform(0.1, 1.0, count))


def _throws(rng: np.random.Generator, count: int) -> tuple[Floats, Floats]:
    reach = rng.uniform(0.2, 1.5, count)
    targets = np.stack([reach, np.zeros(count), rng.uniform(-0.3, 0.3, count)], axis=1)
    return np.zeros((count, 3)), targets


def _violations(name: str, broken: Bools, note: str) -> Row:
    count = float(np.sum(broken))
    verdict: Verdict = "reproduced" if count == 0.0 else "differs"
    return Row(f"hassan/claim/{name}", 0.0, count, "-", verdict, f"{note}; of {len(broken)}")


def _scurve_rows(limits: MotionLimits) -> list[Row]:
    """Section II-C: T(P) increases, V(P) does not decrease."""
    rows = np.repeat(np.arange(THROWS), STROKES.size)
    curve = min_time_scurve(np.tile(STROKES, THROWS), limits.take(rows))
    times, speeds = (values.reshape(THROWS, -1) for values in (curve.duration, curve.velocity))
    slower = (np.diff(speeds, axis=1) < -ROUNDING * speeds[:, 1:]).any(axis=1)
    return [
        _violations("time-increases", (np.diff(times, axis=1) <= 0.0).any(axis=1), "limits at which T(P) falls (II-C)"),
        _violations("speed-never-falls", slower, "limits at which V(P) falls (II-C)"),
    ]


def _profiles(picks: Floats, targets: Floats, limits: MotionLimits) -> tuple[Floats, Floats]:
    """Release distance [m] and time [s] over the elevation, (N, GRID) each."""
    foot = np.arctan2(targets[:, 2], targets[:, 0])
    share = (np.arange(GRID) + 0.5) / GRID
    angles = foot[:, None] + (0.5 * np.pi - foot[:, None]) * share
    rows = np.repeat(np.arange(len(picks)), GRID)
    found = release_at_elevation(picks[rows], targets[rows], limits.take(rows), angles.ravel())
    return found.distance.reshape(-1, GRID), found.time.reshape(-1, GRID)


def _minima(values: Floats) -> Ints:
    """Number of inner points of each row below both neighbours."""
    inner = values[:, 1:-1]
    return ((inner < values[:, :-2]) & (inner < values[:, 2:])).sum(axis=1)


def _rising(release: ReleaseBatch) -> Bools:
    return release.velocity[:, 2] - GRAVITY * release.flight_time > 0.0


def _quickest_cycle() -> Row:
    """Section III-D: the quickest release gives the quickest cycle; here with a stop on the line and no ceiling."""
    gains: list[float] = []
    for zone, percents in PERCENTAGES.items():
        for percent in percents:
            gains += _gains(zone, MotionLimits.t3kr(percent)).tolist()
    verdict: Verdict = "reproduced" if max(gains) <= SMALL_GAIN else "differs"
    note = "largest gain of the cycle time of the table's 18 throws, without a ceiling, when the elevation may be any"
    return Row("hassan/claim/quickest-release-is-quickest-cycle", 0.0, 100.0 * max(gains), "%", verdict, note)


def _gains(zone: str, limits: MotionLimits) -> Floats:
    picks, targets, following = scene(zone)
    best = plan_release_batch(picks, targets, limits)
    angles = (best.angle[:, None] + np.linspace(-0.15, 0.15, 2 * GRID + 1)).ravel()
    rows = np.repeat(np.arange(len(picks)), 2 * GRID + 1)
    found = release_at_elevation(picks[rows], targets[rows], limits, angles)
    times = _cycle_time(found, following[rows], limits).reshape(len(picks), -1)
    return 1.0 - times.min(axis=1) / _cycle_time(best, following, limits)


def _cycle_time(release: ReleaseBatch, following: Floats, limits: MotionLimits) -> Floats:
    """Throw, brake, straight back above the next pick, down; every move ends before the next begins [s]."""
    way = brake_distance(release.speed, limits)
    stop = release.position + way[:, None] * release.direction
    back = length(following + np.array([0.0, 0.0, APPROACH]) - stop)
    down = np.full(len(back), APPROACH)
    # The brake takes as long as twice its way at release speed.
    moves = min_time_scurve(back, limits).duration + min_time_scurve(down, limits).duration
    return release.time + 2.0 * way / release.speed + moves
