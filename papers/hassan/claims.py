"""Properties that Hassan et al. 2022 state or use, counted over many throws."""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.reproduce.finding import Row
from pnt_gym.arrays import Bools, Floats, Ints, length, take
from pnt_gym.constants import GRAVITY
from pnt_gym.planning import (
    MotionLimits,
    ReleaseBatch,
    brake_distance,
    min_time_scurve,
    plan_release_batch,
    release_at_elevation,
)

from .cases import CELLS, limits_at, scene

THROWS: Final = 2000
GRID: Final = 300
STROKES: Final = np.geomspace(1e-3, 5.0, 200)
"""Strokes P of the S-curve [m]."""
ROUNDING: Final = 1e-12
APPROACH: Final = 0.05
"""Vertical approach Z_off [m]."""
SMALL_GAIN: Final = 0.1
"""Gain of the cycle time [%] up to which the quickest release counts as the quickest cycle."""


def claim_rows() -> list[Row]:
    """Monotone S-curve, unique minimum, least distance in least time, falling hits, quickest cycle."""
    rng = np.random.default_rng(44)
    share = rng.uniform(0.1, 1.0, THROWS)
    limits = MotionLimits(6.0 * share, 120.0 * share, 3000.0 * rng.uniform(0.1, 1.0, THROWS))
    reach, nothing = rng.uniform(0.2, 1.5, THROWS), np.zeros(THROWS)
    picks, targets = np.zeros((THROWS, 3)), np.stack([reach, nothing, rng.uniform(-0.3, 0.3, THROWS)], axis=1)
    best = plan_release_batch(picks, targets, limits)
    distance, time = _profiles(picks, targets, limits)
    quicker = time.min(axis=1) < best.time * (1.0 - 1e-9)
    rising = best.velocity[:, 2] - GRAVITY * best.flight_time > 0.0
    return [
        *_scurve_rows(limits),
        _none("unique-minimum", _minima(distance) > 1, "throws whose release distance has several minima (III-E)"),
        _none("least-distance-is-least-time", quicker, "throws with a quicker release than the nearest one (III-E)"),
        _none("falling-hit", rising, "optimal throws that hit the target on their way up (Eq. 19 has both)"),
        _quickest_cycle(),
    ]


def _none(name: str, broken: Bools, note: str) -> Row:
    """A claim that no case may break."""
    return Row.compared(f"hassan/claim/{name}", 0.0, float(np.sum(broken)), "-", note=f"{note}; of {len(broken)}")


def _scurve_rows(limits: MotionLimits) -> list[Row]:
    """Section II-C: T(P) increases, V(P) does not decrease."""
    rows = np.repeat(np.arange(THROWS), STROKES.size)
    curve = min_time_scurve(np.tile(STROKES, THROWS), take(limits, rows))
    times, speeds = (values.reshape(THROWS, -1) for values in (curve.duration, curve.velocity))
    slower = np.any(np.diff(speeds, axis=1) < -ROUNDING * speeds[:, 1:], axis=1)
    return [
        _none("time-increases", np.any(np.diff(times, axis=1) <= 0.0, axis=1), "limits at which T(P) falls (II-C)"),
        _none("speed-never-falls", slower, "limits at which V(P) falls (II-C)"),
    ]


def _profiles(picks: Floats, targets: Floats, limits: MotionLimits) -> tuple[Floats, Floats]:
    """Release distance [m] and time [s] over the elevation, (N, GRID) each."""
    foot = np.arctan2(targets[:, 2], targets[:, 0])
    share = (np.arange(GRID) + 0.5) / GRID
    angles = foot[:, None] + (0.5 * np.pi - foot[:, None]) * share
    rows = np.repeat(np.arange(len(picks)), GRID)
    found = release_at_elevation(picks[rows], targets[rows], take(limits, rows), angles.ravel())
    return found.distance.reshape(-1, GRID), found.time.reshape(-1, GRID)


def _minima(values: Floats) -> Ints:
    """Number of inner points of each row below both neighbours."""
    inner = values[:, 1:-1]
    return ((inner < values[:, :-2]) & (inner < values[:, 2:])).sum(axis=1)


def _quickest_cycle() -> Row:
    """Section III-D: the quickest release gives the quickest cycle; here with a stop on the line and no ceiling."""
    gain = max(float(_gains(zone, limits_at(percent)).max()) for zone, percent in CELLS)
    return Row.compared(
        "hassan/claim/quickest-release-is-quickest-cycle",
        0.0,
        100.0 * gain,
        "%",
        within=SMALL_GAIN,
        note="largest gain of the cycle time of the table's 18 throws, without a ceiling, when any elevation may be",
    )


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
