"""The two methods of Hassan et al. 2022 and the exact solver on the same throws: agreement, failures, time.

Times are those of the processor, so that other work on the machine changes little.
"""

from __future__ import annotations

import statistics
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple, final

import numpy as np

from agents.reproduce.findings import Findings, Part, Row
from pnt_gym.planning import InfeasibleThrow, MotionLimits, ReleaseBatch, plan_release, plan_release_batch
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.nlp import NlpRelease, method_1, method_2

PERCENTAGES = (15, 30, 45, 60, 75, 90, 100)
PAIRS = 30
"""Pick-target pairs per percentage and way to scale the jerk: 420 throws in all."""
RISE = 0.10
"""Greatest height of a release above its pick where there is a ceiling [m]."""
TRUST_CASES = 24
"""Throws given to trust-constr, which is slow."""
PRECISION = {"method-1-slsqp": 1e-6, "method-1-trust-constr": 1e-4, "method-2": 1e-6}
"""Relative difference of the release time up to which a method agrees with the exact optimum."""
BATCH = 100
"""How often the throws are repeated to time the batched solver."""
ROUNDS = 5
"""How often the exact solver runs: the median of all its single calls and the best of its batches count."""
ROUNDING = 1e-9


class Case(NamedTuple):
    """One throw."""

    pick: Floats
    target: Floats
    limits: MotionLimits


@final
@dataclass
class Tally:
    """How a method did: counts over all throws, its slowest answer over the optimum, seconds of every call."""

    agreed: int = 0
    wrong: int = 0
    failed: int = 0
    invented: int = 0
    feasible: int = 0
    infeasible: int = 0
    slowest: float = 1.0
    seconds: list[float] = field(default_factory=list[float])


def cases() -> list[Case]:
    """Throws off the belt at seven percentages, the jerk scaled with them or left at 3000 m/s3; fixed seed."""
    rng = np.random.default_rng(2022)
    return [
        Case(pick, target, MotionLimits(6.0 * share, 120.0 * share, jerk))
        for share in np.array(PERCENTAGES) / 100.0
        for jerk in (3000.0 * share, 3000.0)
        for pick, target in _pairs(rng)
    ]


def _pairs(rng: np.random.Generator) -> Iterator[tuple[Floats, Floats]]:
    for _ in range(PAIRS):
        pick = np.array([*rng.uniform((-0.35, -0.45), (0.35, 0.45)), -0.85])
        reach, azimuth = rng.uniform(0.25, 1.2), rng.uniform(-np.pi, np.pi)
        rise = rng.uniform(-0.15, 0.18)
        yield pick, pick + np.array([reach * np.cos(azimuth), reach * np.sin(azimuth), rise])


def methods_findings() -> Findings:
    """Every method with and without a ceiling, and the batch against single plans."""
    rows: list[Row] = []
    for roofed in (False, True):
        rows += _compared(cases(), roofed=roofed)
    return Findings((*rows, _claim(rows)))


def _compared(throws: list[Case], *, roofed: bool) -> list[Row]:
    folder = f"hassan/methods/{'ceiling' if roofed else 'no-ceiling'}"
    exact, seconds = _exact(throws, roofed=roofed)
    reference = statistics.median(seconds)
    rows = [Row(f"{folder}/exact/median-time", None, 1e6 * reference, "us", "ours", "one plan at a time")]
    rows += _batch_rows(folder, throws, exact, reference, roofed=roofed)
    few = slice(None, None, max(1, len(throws) // TRUST_CASES))
    for name, solve in _solvers(roofed=roofed).items():
        part = few if name == "method-1-trust-constr" else slice(None)
        tally = _tally(name, solve, throws[part], exact[part], roofed=roofed)
        rows += _tally_rows(f"{folder}/{name}", tally, reference)
    return rows


def _solvers(*, roofed: bool) -> dict[str, Callable[[Case], NlpRelease]]:
    def ceiling(case: Case) -> float | None:
        return _ceiling(case, roofed=roofed)

    return {
        "method-1-slsqp": lambda c: method_1(c.pick, c.target, c.limits, ceiling=ceiling(c)),
        "method-1-trust-constr": lambda c: method_1(
            c.pick, c.target, c.limits, ceiling=ceiling(c), solver="trust-constr"
        ),
        "method-2": lambda c: method_2(c.pick, c.target, c.limits),
    }


def _ceiling(case: Case, *, roofed: bool) -> float | None:
    return float(case.pick[2]) + RISE if roofed else None


def _exact(throws: list[Case], *, roofed: bool) -> tuple[list[float | None], list[float]]:
    """Release times, None where there is no throw, and how long each plan took [s]."""
    times: list[float | None] = []
    seconds: list[float] = []
    for _ in range(ROUNDS):
        times.clear()
        for case in throws:
            begin = time.thread_time()
            try:
                found = plan_release(case.pick, case.target, case.limits, ceiling=_ceiling(case, roofed=roofed)).time
            except InfeasibleThrow:
                found = None
            seconds.append(time.thread_time() - begin)
            times.append(found)
    return times, seconds


def _tally(
    name: str, solve: Callable[[Case], NlpRelease], throws: list[Case], exact: list[float | None], *, roofed: bool
) -> Tally:
    tally = Tally()
    # The first call loads the solver.
    _solved(solve, throws[0])
    for case, best in zip(throws, exact, strict=True):
        begin = time.thread_time()
        found = _solved(solve, case)
        tally.seconds.append(time.thread_time() - begin)
        if best is None:
            tally.infeasible += 1
            tally.invented += found.success
            continue
        tally.feasible += 1
        ceiling = _ceiling(case, roofed=roofed)
        kept = ceiling is None or found.position[2] <= ceiling + ROUNDING
        good = kept and abs(found.time / best - 1.0) <= PRECISION[name]
        tally.agreed += found.success and good
        tally.wrong += found.success and not good
        tally.slowest = max(tally.slowest, found.time / best if found.success else 1.0)
        tally.failed += not found.success
    return tally


def _solved(solve: Callable[[Case], NlpRelease], case: Case) -> NlpRelease:
    with warnings.catch_warnings():
        # trust-constr warns of constraints that look linear or dependent; its answers are judged by the caller.
        warnings.simplefilter("ignore", UserWarning)
        return solve(case)


def _tally_rows(name: str, tally: Tally, reference: float) -> list[Row]:
    median = statistics.median(tally.seconds)
    of = f"of {tally.feasible} throws that exist"
    precision = PRECISION[name.rsplit("/", 1)[1]]
    counts = (
        ("agreements", tally.agreed, f"{of}: release time within {precision:g} of the exact optimum"),
        ("wrong-answers", tally.wrong, f"{of}: success reported, but slower than the optimum or above the ceiling"),
        ("failures", tally.failed, f"{of}: no success reported"),
        ("invented", tally.invented, f"of {tally.infeasible} throws that do not exist: success reported"),
    )
    rows = [Row(f"{name}/{what}", None, float(count), "throws", "ours", note) for what, count, note in counts]
    slow = "largest release time of an answer over that of the optimum"
    return [
        *rows,
        Row(f"{name}/slowest-answer", None, tally.slowest, "-", "ours", slow),
        Row(f"{name}/median-time", None, 1e6 * median, "us", "ours", f"median of {len(tally.seconds)} calls"),
        Row(f"{name}/time-ratio", None, median / reference, "-", "ours", "median time over that of the exact solver"),
    ]


def _batch_rows(
    folder: str, throws: list[Case], exact: list[float | None], reference: float, *, roofed: bool
) -> list[Row]:
    picks, targets = (np.tile([getattr(case, name) for case in throws], (BATCH, 1)) for name in ("pick", "target"))
    numbers = np.array([case.limits.numbers() for case in throws])
    limits = MotionLimits(*(np.tile(column, BATCH) for column in numbers.T))
    ceiling = picks[:, 2] + RISE if roofed else None
    batch, each = _timed_batch(picks, targets, limits, ceiling)
    single = np.array([np.nan if value is None else value for value in exact])
    together = batch.time[: len(throws)]
    same = np.isnan(single) == np.isnan(together)
    apart = np.abs(together / single - 1.0)
    worst = float(np.nanmax(apart)) if same.all() else float("inf")
    return [
        Row(
            f"{folder}/exact/infeasible",
            None,
            float(np.isnan(single).sum()),
            "throws",
            "ours",
            f"of {len(throws)}: no release exists below the ceiling",
        ),
        Row(
            f"{folder}/exact-batch/difference",
            None,
            worst if np.isfinite(worst) else "not the same throws are feasible",
            "-",
            "ours",
            "largest relative difference of the release time between the batch and single plans",
        ),
        Row(f"{folder}/exact-batch/plans-per-second", None, 1.0 / each, "1/s", "ours", f"best batch of {len(picks)}"),
        Row(
            f"{folder}/exact-batch/time-ratio",
            None,
            each / reference,
            "-",
            "ours",
            "time per plan over the median of single plans",
        ),
    ]


def _timed_batch(
    picks: Floats, targets: Floats, limits: MotionLimits, ceiling: Floats | None
) -> tuple[ReleaseBatch, float]:
    """The plans, and the least time per plan of a few runs [s]."""
    seconds: list[float] = []
    batch = plan_release_batch(picks, targets, limits, ceiling=ceiling)
    for _ in range(ROUNDS):
        begin = time.thread_time()
        plan_release_batch(picks, targets, limits, ceiling=ceiling)
        seconds.append((time.thread_time() - begin) / len(picks))
    return batch, min(seconds)


def _claim(rows: list[Row]) -> Row:
    """Section III-E: the simplified method takes less time than the nonlinear programme."""
    times = {row.quantity: row.reproduced for row in rows if isinstance(row.reproduced, float)}
    first, second = (times[f"hassan/methods/no-ceiling/{name}/median-time"] for name in ("method-1-slsqp", "method-2"))
    return Row(
        "hassan/methods/simplification-gain",
        "less time",
        first / second,
        "-",
        "reproduced" if second < first else "differs",
        "median time of method 1 (SLSQP) over that of method 2; the paper gives no numbers",
    )


PARTS = (Part("methods", methods_findings),)
