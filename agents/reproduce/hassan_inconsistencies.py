"""What in Hassan et al. 2022 does not fit together, each with the computation that shows it."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Final

import numpy as np

from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.hassan_cases import (
    INITIAL,
    PERCENTAGES,
    PROTOCOLS,
    PUBLISHED,
    TARGETS,
    cell_cycle,
    loop,
    picks_per_min,
    scene,
)
from agents.reproduce.hassan_claims import claim_rows
from agents.reproduce.hassan_example import example_rows
from agents.reproduce.hassan_formulas import formula_rows
from pnt_gym.planning import MotionLimits, PeakRatios, plan_release_batch, rest_to_rest
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.blend import begin_times, throw_move
from pnt_gym.planning.cycle import CycleRules
from pnt_gym.planning.segments import brake_distance

RULES: Final = PROTOCOLS["paper-clock"].rules
CEILING: Final = -0.75
"""Release ceiling of the table [m]: 0.10 above the picks."""
FIGURE_12_END = 3.0
"""Where the time axis of Fig. 12 ends [s]; its cycle is the one at 30 %."""


def inconsistency_findings() -> Findings:
    """The numeric example, the text, the formulas and the table against each other."""
    rows = [
        *example_rows(),
        *_percentages(),
        *_peak_rows(),
        _brake_point(),
        _twelve(),
        _jerk_scaling(),
        *_clock(),
        *formula_rows(),
        *claim_rows(),
        *_sensitivity(),
    ]
    return Findings(tuple(rows))


def _percentages() -> list[Row]:
    """Section IV-D calls three reductions of the cycle time improvements of the picks per minute."""
    place, level, throw = (
        PUBLISHED[method, "inside", 40] for method in ("pick-and-place", "horizontal-throw", "min-time-throw")
    )
    pairs = (
        ("proposed-over-pick-and-place", 57.5, throw, place),
        ("proposed-over-existing", 37.0, throw, level),
        ("existing-over-pick-and-place", 32.0, level, place),
    )
    return [
        Row(
            f"hassan/inconsistency/gain-{name}",
            printed,
            100.0 * (new / old - 1.0),
            "%",
            "misprint",
            f"picks/min rise from {old} to {new}; the printed figure is the fall of the cycle time, "
            f"{100.0 * (1.0 - old / new):.1f} %",
            {"cycle_time_reduction_percent": 100.0 * (1.0 - old / new)},
        )
        for name, printed, new, old in pairs
    ]


def _peak_rows() -> list[Row]:
    """Fig. 12 and section IV-C1: the peaks are exactly the limits, with phases overlapped as III-C says."""
    rows: list[Row] = []
    for protocol, word in (("paper-clock", "whole ramps"), ("jerk-overlap", "jerk phases")):
        peaks = [_peaks(protocol, method) for method in ("pick-and-place", "min-time-throw")]
        where = ("corners of pick-and-place", "turn of the proposed throw")
        for place, peak in zip(where, peaks, strict=True):
            worst = float(peak.acceleration.max())
            rows.append(
                Row(
                    f"hassan/inconsistency/peak-acceleration-{protocol}-{place.split(' ', maxsplit=1)[0]}",
                    1.0,
                    worst,
                    "A_max",
                    "reproduced" if worst <= 1.0 + 1e-9 else "differs",
                    f"at 30 % with {word} overlapped, at the {place}; jerk up to {peak.jerk.max():.2f} J",
                    {"peak_jerk_ratio": float(peak.jerk.max())},
                )
            )
    return rows


def _peaks(protocol: str, method: str) -> PeakRatios:
    return cell_cycle(protocol, method, "inside", 30).peak_ratios(MotionLimits.t3kr(30))


def _brake_point() -> Row:
    """Section III-D gives the throw's stroke as P = 2 P_r, III-C lets the hand stop after the release."""
    shares: list[float] = []
    radii: list[float] = []
    for percent in PERCENTAGES["outside"]:
        picks, targets, _ = scene("outside")
        release = plan_release_batch(picks, targets, MotionLimits.t3kr(percent), CEILING, RULES.tolerance)
        end = picks + 2.0 * (release.position - picks)
        shares += list(np.hypot(*(end - picks)[:, :2].T) / np.hypot(*(targets - picks)[:, :2].T))
        radii += list(np.hypot(end[:, 0], end[:, 1]))
    target = math.hypot(*TARGETS["outside"][:2])
    return Row(
        "hassan/inconsistency/stroke-twice-the-release",
        "inside the workspace",
        max(shares),
        "of the way to the target",
        "misprint",
        f"a hand that runs the whole stroke 2 P_r stops {100 * (min(shares) - 1):.0f} to {100 * (max(shares) - 1):.0f} "
        f"% beyond the outside target, {min(radii):.2f} to {max(radii):.2f} m from the axis (target {target:.2f} m)",
        {"least_share": min(shares), "radii_m": [float(r) for r in radii]},
    )


def _twelve() -> Row:
    """Section IV-B3 prints A_max = 12 m/s2, section IV-A 12 G = 120 m/s2."""
    published = PUBLISHED["min-time-throw", "inside", 30]
    low, full = (
        picks_per_min(loop("min-time-throw", "inside", MotionLimits(1.8, 0.3 * peak, 900.0), RULES, None))
        for peak in (12.0, 120.0)
    )
    return Row(
        "hassan/inconsistency/greatest-acceleration",
        12.0,
        120.0,
        "m/s2",
        "misprint",
        f"30 % of 12 m/s2 gives {low:.1f} picks/min, 30 % of 12 G gives {full:.1f}; the table has {published}",
        {"picks_per_min_12": low, "picks_per_min_120": full},
    )


def _jerk_scaling() -> Row:
    """Section IV-B3 scales the jerk with the percentage, section IV-C names speed and acceleration only."""
    scaled, kept = (_mean_difference(RULES, jerk_scaled=flag) for flag in (True, False))
    return Row(
        "hassan/inconsistency/jerk-scaling",
        "scaled once, else not mentioned",
        100.0 * scaled,
        "%",
        "ours",
        f"mean difference to the table with the jerk scaled; left at 3000 m/s3 it is {100 * kept:.1f} %",
        {"mean_difference_constant_jerk_percent": 100.0 * kept},
    )


def _mean_difference(rules: CycleRules, *, jerk_scaled: bool = True) -> float:
    return float(np.mean(_differences(rules, jerk_scaled=jerk_scaled)))


def _differences(rules: CycleRules, *, jerk_scaled: bool = True) -> list[float]:
    found: list[float] = []
    for (method, zone, percent), published in PUBLISHED.items():
        jerk = 3000.0 * percent / 100.0 if jerk_scaled else 3000.0
        limits = MotionLimits(0.06 * percent, 1.2 * percent, jerk)
        found.append(abs(picks_per_min(loop(method, zone, limits, rules, None)) / published - 1.0))
    return found


def _sensitivity() -> list[Row]:
    """What the paper leaves open and what the table makes of it: one rule changed at a time."""
    variants = {
        "lift-0.08": replace(RULES, lift=0.08),
        "approach-0.02": replace(RULES, approach=0.02),
        "no-tolerance": replace(RULES, tolerance=0.0),
        "no-ceiling": replace(RULES, rise=None),
    }
    rows: list[Row] = []
    for name, rules in variants.items():
        found = _differences(rules)
        rows.append(
            Row(
                f"hassan/sensitivity/{name}",
                None,
                100.0 * float(np.mean(found)),
                "%",
                "ours",
                f"mean difference to Table I, paper-clock with only this changed; worst cell {100 * max(found):.1f} %",
                {"worst_difference_percent": 100.0 * max(found)},
            )
        )
    return rows


def _clock() -> list[Row]:
    """Runs start and end at P_initial (section IV-B); neither Table I nor Fig. 12 can include those legs."""
    closed = float(cell_cycle("paper-clock", "min-time-throw", "inside", 30).duration.sum())
    run = _whole_run()
    published = PUBLISHED["min-time-throw", "inside", 30]
    return [
        Row(
            "hassan/inconsistency/clock-picks",
            float(published),
            180.0 / run,
            "picks/min",
            "not reproducible",
            f"three picks at 30 % with the ways from and to P_initial; the closed loop gives {180.0 / closed:.1f}",
            {"run_s": run, "loop_s": closed},
        ),
        Row(
            "hassan/inconsistency/clock-figure-12",
            FIGURE_12_END,
            run,
            "s",
            "not reproducible",
            f"the run from P_initial to P_initial is longer than the axis of Fig. 12; the closed loop takes "
            f"{closed:.2f} s",
        ),
    ]


def _whole_run() -> float:
    """Time of P_initial, three throws at 30 %, P_initial [s], moves overlapped as in the table."""
    limits = MotionLimits.t3kr(30)
    picks, targets, _ = scene("inside")
    release = plan_release_batch(picks, targets, limits, CEILING, RULES.tolerance)
    stop = (release.position + brake_distance(release.speed, limits)[:, None] * release.direction)[2:]
    down, home = np.array([[0.0, 0.0, RULES.approach]]), np.array([INITIAL])
    first = _time([home, picks[:1] + down, picks[:1]], limits)
    throw = throw_move(release.direction[2:], release.distance[2:], limits)
    back = rest_to_rest(home - stop, limits)
    last = float(begin_times([throw, back], RULES.overlap)[0, 1] + back.durations.sum())
    middle = cell_cycle("paper-clock", "min-time-throw", "inside", 30).duration[:2].sum()
    return first + float(middle) + last


def _time(points: list[Floats], limits: MotionLimits) -> float:
    moves = [rest_to_rest(b - a, limits) for a, b in pairwise(points)]
    return float(begin_times(moves, RULES.overlap)[0, -1] + moves[-1].durations.sum())


PARTS = (Part("inconsistencies", inconsistency_findings),)
