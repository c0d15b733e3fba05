"""Claims of Hassan et al. 2022 on the S-curve, the release and the throws of Table I, each counted or measured."""

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

from . import cases

RULES: Final = cases.PROTOCOLS["paper-clock"].rules
THROWS: Final = 2000
GRID: Final = 300
STROKES: Final = np.geomspace(1e-3, 5.0, 200)
"""Strokes P of the S-curve [m]."""
ROUNDING: Final = 1e-12
SMALL_GAIN: Final = 0.1
"""Gain of the cycle time [%] up to which the quickest release counts as the quickest cycle."""
DOUBLE_S: Final = 20_000
"""Number of random strokes and limits at which Algorithm 1 is compared with the double S."""
BY_THROW: Final = tuple(name for name in cases.METHODS if name.endswith("throw"))
"""The two methods that throw."""
CONSTANT_J: Final = "constant-jerk-overlap"


def claim_rows() -> list[Row]:
    """Rows that count violations: monotone S-curve, unique minimum, least distance in least time, falling hits."""
    rng = np.random.default_rng(44)
    share = rng.uniform(0.1, 1.0, THROWS)
    limits = MotionLimits(6.0 * share, 120.0 * share, 3000.0 * rng.uniform(0.1, 1.0, THROWS))
    reach, zero = rng.uniform(0.2, 1.5, THROWS), np.zeros(THROWS)
    picks, targets = np.zeros((THROWS, 3)), np.stack([reach, zero, rng.uniform(-0.3, 0.3, THROWS)], axis=1)
    best = plan_release_batch(picks, targets, limits)
    distance, time = _release_profiles(picks, targets, limits)
    quicker = time.min(axis=1) < best.time * (1.0 - 1e-9)
    rising = best.velocity[:, 2] - GRAVITY * best.flight_time > 0.0
    return [
        *_scurve_rows(limits),
        _double_s_row(),
        _zero_count_row(
            "unique-minimum", _count_minima(distance) > 1, "throws whose release distance has several minima (III-E)"
        ),
        _zero_count_row(
            "least-distance-is-least-time", quicker, "throws with a quicker release than the nearest one (III-E)"
        ),
        Row.ours(
            "hassan/claim/falling-hit",
            float(np.sum(rising)),
            "-",
            note=f"optimal throws that hit the target on their way up, which Eq. 19 allows; of {THROWS}",
        ),
        _quickest_cycle_row(),
        _one_minimum_row(),
        *_attained_rows(),
        *_closer_release_rows(),
    ]


def _zero_count_row(name: str, violations: Bools, note: str) -> Row:
    """Row of a claim whose number of violations must be zero."""
    return Row.compared(
        f"hassan/claim/{name}", 0.0, float(np.sum(violations)), "-", note=f"{note}; of {len(violations)}"
    )


def _scurve_rows(limits: MotionLimits) -> list[Row]:
    """Rows on section II-C's claims that T(P) increases and V(P) does not decrease."""
    rows = np.repeat(np.arange(THROWS), STROKES.size)
    curve = min_time_scurve(np.tile(STROKES, THROWS), take(limits, rows))
    times, speeds = (values.reshape(THROWS, -1) for values in (curve.duration, curve.velocity))
    slower = np.any(np.diff(speeds, axis=1) < -ROUNDING * speeds[:, 1:], axis=1)
    return [
        _zero_count_row(
            "time-increases", np.any(np.diff(times, axis=1) <= 0.0, axis=1), "limits at which T(P) falls (II-C)"
        ),
        _zero_count_row("speed-never-falls", slower, "limits at which V(P) falls (II-C)"),
    ]


def _release_profiles(picks: Floats, targets: Floats, limits: MotionLimits) -> tuple[Floats, Floats]:
    """Release distance [m] and time [s] over the elevation from the line to the target up to 90 deg, (N, GRID) each."""
    foot = np.arctan2(targets[:, 2], targets[:, 0])
    share = (np.arange(GRID) + 0.5) / GRID
    angles = foot[:, None] + (0.5 * np.pi - foot[:, None]) * share
    rows = np.repeat(np.arange(len(picks)), GRID)
    releases = release_at_elevation(picks[rows], targets[rows], take(limits, rows), angles.ravel())
    return releases.distance.reshape(-1, GRID), releases.time.reshape(-1, GRID)


def _count_minima(values: Floats) -> Ints:
    """Number of inner points of each row below both neighbours."""
    inner = values[:, 1:-1]
    return ((inner < values[:, :-2]) & (inner < values[:, 2:])).sum(axis=1)


def _quickest_cycle_row() -> Row:
    """Row on section III-D's claim that the quickest release gives the quickest cycle.

    The hand stops on the line, and there is no ceiling.
    """
    gain = max(float(_time_gains(zone, cases.limits_at(percent)).max()) for zone, percent in cases.CELLS)
    return Row.compared(
        "hassan/claim/quickest-release-is-quickest-cycle",
        0.0,
        100.0 * gain,
        "%",
        within=SMALL_GAIN,
        note="largest gain of the cycle time of the table's 18 throws, without a ceiling, when any elevation may be",
    )


def _time_gains(zone: str, limits: MotionLimits) -> Floats:
    """Share of the cycle time (3,) that the best elevation saves over the elevation of the quickest release."""
    picks, targets, following = cases.scene(zone)
    best = plan_release_batch(picks, targets, limits)
    angles = (best.angle[:, None] + np.linspace(-0.15, 0.15, 2 * GRID + 1)).ravel()
    rows = np.repeat(np.arange(len(picks)), 2 * GRID + 1)
    releases = release_at_elevation(picks[rows], targets[rows], limits, angles)
    times = _cycle_time(releases, following[rows], limits).reshape(len(picks), -1)
    return 1.0 - times.min(axis=1) / _cycle_time(best, following, limits)


def _cycle_time(release: ReleaseBatch, following: Floats, limits: MotionLimits) -> Floats:
    """Time (N,) [s] to throw, brake, return straight to above the next pick and go down, with no overlap of moves."""
    way = brake_distance(release.speed, limits)
    stop = release.position + way[:, None] * release.direction
    back = length(following + np.array([0.0, 0.0, RULES.approach]) - stop)
    down = np.full(len(back), RULES.approach)
    # The speed falls symmetrically in time, so its mean while braking is half the release speed.
    moves = min_time_scurve(back, limits).duration + min_time_scurve(down, limits).duration
    return release.time + 2.0 * way / release.speed + moves


def _double_s_row() -> Row:
    """Row on II-B's statement that Algorithm 1 is equivalent to [29], the double S of Biagiotti and Melchiorri."""
    rng = np.random.default_rng(29)
    stroke = np.exp(rng.uniform(np.log(1e-3), np.log(5.0), DOUBLE_S))
    shares = rng.uniform(0.1, 1.0, (3, DOUBLE_S))
    limits = MotionLimits(6.0 * shares[0], 120.0 * shares[1], 3000.0 * shares[2])
    ours, theirs = min_time_scurve(stroke, limits).duration, double_s_time(stroke, limits)
    return Row.compared(
        "hassan/claim/equivalent-to-the-double-s",
        0.0,
        float(np.abs(ours / theirs - 1.0).max()),
        "-",
        within=ROUNDING,
        note=f"largest relative difference of the time by Algorithm 1 from the double S of Biagiotti and Melchiorri, "
        f"written anew from its own cases, at {DOUBLE_S:,} random strokes and limits",
    )


def double_s_time(stroke: Floats, limits: MotionLimits) -> Floats:
    """Time (N,) [s] of the double S from rest to rest (Biagiotti and Melchiorri 2008, section 3.4)."""
    speed, acceleration, jerk = limits.arrays(len(stroke))
    is_short = speed * jerk < acceleration**2
    jerk_time = np.where(is_short, np.sqrt(speed / jerk), acceleration / jerk)
    ramp = np.where(is_short, 2.0 * jerk_time, jerk_time + speed / acceleration)
    cruise = stroke / speed - ramp
    # Without a cruise the speed limit is not reached, and without a constant acceleration that limit neither.
    half = 0.5 * acceleration / jerk
    slower = np.where(
        stroke >= 2.0 * acceleration**3 / jerk**2,
        half + np.sqrt(half**2 + stroke / acceleration),
        2.0 * np.cbrt(stroke / (2.0 * jerk)),
    )
    return np.where(cruise > 0.0, 2.0 * ramp + cruise, 2.0 * slower)


def _throw_distances(protocol: str, method: str, zone: str, percent: int) -> Floats:
    """Ways (3,) [m] from the start of the throw to its release: from the pick, or from the lifted hand."""
    cycle = cases.cell_cycle(protocol, method, zone, percent)
    lift = np.array([0.0, 0.0, RULES.lift if method == "horizontal-throw" else 0.0])
    return length(cycle.release_position - cases.scene(zone)[0] - lift)


def _attained_rows() -> list[Row]:
    """Rows on section IV-C1: speeds and accelerations of all throws attain their limits."""
    shares: dict[str, list[Floats]] = {"velocity": [], "acceleration": []}
    for protocol in ("paper-clock", CONSTANT_J):
        for method in BY_THROW:
            for cell in cases.CELLS:
                limits = cases.PROTOCOLS[protocol].limits(cell[1])
                # A throw is the first half of the S-curve over 2 P_r (III-D).
                curve = min_time_scurve(2.0 * _throw_distances(protocol, method, *cell), limits)
                for name, values, bound in zip(
                    shares, (curve.velocity, curve.acceleration), limits.numbers(), strict=False
                ):
                    shares[name].append(values / bound)
    return [
        Row.compared(
            f"hassan/claim/every-throw-attains-its-{name}",
            1.0,
            float(np.min(values)),
            "-",
            within=cases.LIMIT_TOLERANCE,
            statement=f"table1/peak-{name}",
            note=f"least {name} as a share of its limit over {np.size(values) // 2} throws of Table I, "
            f"{len(cases.CELLS) * 3} of each method, with J scaled and with J constant",
        )
        for name, values in shares.items()
    ]


def _closer_release_rows() -> list[Row]:
    """Rows on section IV-C3: with the acceleration the release point comes closer to the pick."""
    rows: list[Row] = []
    for method in BY_THROW:
        ways = [float(_throw_distances("paper-clock", method, "outside", p)[0]) for p in cases.PERCENTAGES["outside"]]
        rows.append(
            Row.compared(
                f"hassan/claim/release-comes-closer/{method}",
                "closer",
                ", ".join(f"{way:.3f}" for way in ways),
                "m",
                holds=all(np.diff(ways) < 0.0),
                statement="hassan/claim/release-comes-closer",
                note="way of the first throw to its release, outside at "
                f"{', '.join(map(str, cases.PERCENTAGES['outside']))} % of the limits",
                ways_m=ways,
            )
        )
    return rows


def _one_minimum_row() -> Row:
    """Row on Eq. 21: P_r at the largest speed has one minimum over theta, where the S-curve reaches that speed.

    The paper then needs Eq. 22 only where theta_m and theta* differ. In its own experiments they agree.
    """
    slower, minima = list[float](), list[int]()
    for percent in cases.PERCENTAGES["inside"]:
        picks, targets, _ = cases.scene("inside")
        for constant in (False, True):
            limits = cases.limits_at(percent, constant_jerk=constant)
            way = _distances_at_top_speed(picks, targets, limits.numbers()[0])
            minima += _count_minima(way).tolist()
            slower += (plan_release_batch(picks, targets, limits).speed / limits.numbers()[0]).tolist()
    return Row.compared(
        "hassan/claim/eq-21-has-one-minimum",
        "one minimum",
        f"{min(minima)} to {max(minima)}" if min(minima) != max(minima) else f"{minima[0]}",
        "-",
        holds=set(minima) == {1},
        note=f"minima over theta of P_r by Eq. 20 at the speed limit, {len(minima)} throws inside at 15, 30 and 40 %, "
        f"J scaled and constant; the quickest releases have {min(slower):.3f} of the speed limit and more, so theta_m "
        "= theta* and Eq. 22 is never needed in the paper's experiments",
        least_speed_share=min(slower),
    )


def _distances_at_top_speed(picks: Floats, targets: Floats, speed: float) -> Floats:
    """P_r (N, GRID) [m] by Eq. 20 at one speed, over the elevations from level to upright."""
    angle = np.linspace(0.0, 0.5 * np.pi, GRID + 2)[1:-1]
    way = targets - picks
    across, rise = np.hypot(way[:, :1], way[:, 1:2]), way[:, 2:]
    line = across / np.cos(angle)
    return line - speed * np.sqrt(2.0 * (across * np.tan(angle) - rise) / GRAVITY)
