"""The two methods of Hassan et al. 2022 and the exact solver on the same throws: agreement, failures, time.

All times are processor times, which other work on the machine changes little.
"""

from __future__ import annotations

import statistics
import time
import warnings
from collections.abc import Callable, Iterator
from typing import Final, NamedTuple, TypeVar

import numpy as np

from agents.ground.tables import Grid
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import NONE, by_quantity, value
from pnt_gym.arrays import Floats
from pnt_gym.planning import InfeasibleThrow, MotionLimits, plan_release, plan_release_batch

from .cases import RISE
from .nlp import NlpRelease, method_1, method_2

T = TypeVar("T")
PERCENTAGES = (15, 30, 45, 60, 75, 90, 100)
PAIRS = 30
"""Pick-target pairs per percentage and way to scale the jerk: 420 throws in all."""
TRUST_CASES = 24
"""Number of throws that trust-constr solves, because trust-constr is slow."""
BATCH = 100
"""Number of repetitions of the throws in the batch whose time is measured."""
ROUNDS = 5
"""Number of runs of the exact solver: the median time of all single calls and the best time of a batch count."""
ROUNDING = 1e-9
"""Excess of a release point over the ceiling that counts as rounding [m]."""
BOUNDS: Final = {"no-ceiling": "no ceiling", "ceiling": "under a ceiling"}
FORMS: Final = {
    "agreements": "{:.0f}",
    "wrong-answers": "{:.0f}",
    "failures": "{:.0f}",
    "invented": "{:.0f}",
    "slowest-answer": "{:.3g}",
    "median-time": "{:,.0f} us",
    "time-ratio": "{:.0f}",
}
"""Columns of the table of methods, and the format of their figures."""


class Case(NamedTuple):
    """A throw to plan: pick and target (3,) [m], limits, and greatest height of the release [m] (None: no bound)."""

    pick: Floats
    target: Floats
    limits: MotionLimits
    ceiling: float | None


class Method(NamedTuple):
    """A solver for the release of a throw, with its name for people.

    An answer agrees with the exact optimum if the release times differ by at most `precision`, relative.
    """

    label: str
    precision: float
    solve: Callable[[Case], NlpRelease]


def _solve_by_trust_constr(case: Case) -> NlpRelease:
    with warnings.catch_warnings():
        # trust-constr warns of constraints that look linear or dependent; the caller checks every answer.
        warnings.simplefilter("ignore", UserWarning)
        return method_1(case.pick, case.target, case.limits, ceiling=case.ceiling, solver="trust-constr")


METHODS: Final = {
    "method-1-slsqp": Method(
        "Method 1 (SLSQP)", 1e-6, lambda case: method_1(case.pick, case.target, case.limits, ceiling=case.ceiling)
    ),
    "method-1-trust-constr": Method("Method 1 (trust-constr)", 1e-4, _solve_by_trust_constr),
    "method-2": Method("Method 2", 1e-6, lambda case: method_2(case.pick, case.target, case.limits)),
}


def random_cases(*, roofed: bool) -> list[Case]:
    """Random throws off the belt at seven percentages, the jerk limit scaled or left at 3000 m/s3; fixed seed."""
    rng = np.random.default_rng(2022)
    return [
        Case(pick, target, MotionLimits(6.0 * share, 120.0 * share, jerk), float(pick[2]) + RISE if roofed else None)
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
    """Agreement, failures and times of every method with and without a ceiling, and of the batched exact solver."""
    rows = [
        row
        for name in BOUNDS
        for row in _comparison_rows(f"hassan/methods/{name}", random_cases(roofed=name == "ceiling"))
    ]
    return Findings((*rows, _claim_row(rows)), grids=(_grid(rows),))


def _comparison_rows(folder: str, throws: list[Case]) -> list[Row]:
    exact, seconds = _solve_exactly(throws)
    reference = statistics.median(seconds)
    rows = [Row.ours(f"{folder}/exact/median-time", 1e6 * reference, "us", note="one plan at a time")]
    rows += _batch_rows(folder, throws, exact, reference)
    sample = slice(None, None, max(1, len(throws) // TRUST_CASES))
    for name, method in METHODS.items():
        part = sample if name == "method-1-trust-constr" else slice(None)
        rows += _method_rows(f"{folder}/{name}", method, throws[part], exact[part], reference)
    return rows


def time_call(run: Callable[[], T]) -> tuple[T, float]:
    """Return value of a call, and the call's processor time [s]."""
    begin = time.thread_time()
    result = run()
    return result, time.thread_time() - begin


def _solve_exactly(throws: list[Case]) -> tuple[list[float | None], list[float]]:
    """Exact release times [s] (None: infeasible), and the processor time of each plan in every round [s]."""
    results = [time_call(lambda case=case: _exact_time(case)) for _ in range(ROUNDS) for case in throws]
    times, seconds = zip(*results, strict=True)
    return list(times[: len(throws)]), list(seconds)


def _exact_time(case: Case) -> float | None:
    try:
        return plan_release(case.pick, case.target, case.limits, ceiling=case.ceiling).time
    except InfeasibleThrow:
        return None


def _method_rows(
    name: str, method: Method, throws: list[Case], exact: list[float | None], reference: float
) -> list[Row]:
    """Rows of one method: counts over all throws, the slowest answer over the optimum, and the time of a call."""
    # The first call loads the solver.
    method.solve(throws[0])
    answers = [time_call(lambda case=case: method.solve(case)) for case in throws]
    median = statistics.median(seconds for _, seconds in answers)
    attempts = [(case, result, best) for case, (result, _), best in zip(throws, answers, exact, strict=True)]
    invented = [result.success for _, result, best in attempts if best is None]
    feasible = [(case, result, result.time / best) for case, result, best in attempts if best is not None]
    successes = [
        (bool(case.ceiling is None or result.position[2] <= case.ceiling + ROUNDING), ratio)
        for case, result, ratio in feasible
        if result.success
    ]
    agreements = sum(below_ceiling and abs(ratio - 1.0) <= method.precision for below_ceiling, ratio in successes)
    total = f"of {len(feasible)} throws that exist"
    result = {
        "agreements": (agreements, "throws", f"{total}: release time within {method.precision:g} of the exact optimum"),
        "wrong-answers": (
            len(successes) - agreements,
            "throws",
            f"{total}: success, but slower than the optimum or above the ceiling",
        ),
        "failures": (len(feasible) - len(successes), "throws", f"{total}: no success reported"),
        "invented": (sum(invented), "throws", f"of {len(invented)} throws that do not exist: success reported"),
        "slowest-answer": (
            max([1.0, *(ratio for _, ratio in successes)]),
            "-",
            "largest release time of an answer over that of the optimum",
        ),
        "median-time": (1e6 * median, "us", f"median of {len(answers)} calls"),
        "time-ratio": (median / reference, "-", "median time over that of the exact solver"),
    }
    return [
        Row.ours(f"{name}/{quantity}", float(figure), unit, note=note)
        for quantity, (figure, unit, note) in result.items()
    ]


def _batch_rows(folder: str, throws: list[Case], exact: list[float | None], reference: float) -> list[Row]:
    picks, targets = (np.tile([getattr(case, name) for case in throws], (BATCH, 1)) for name in ("pick", "target"))
    numbers = np.array([case.limits.numbers() for case in throws])
    limits = MotionLimits(*(np.tile(column, BATCH) for column in numbers.T))
    ceiling = None if throws[0].ceiling is None else picks[:, 2] + RISE
    rounds = [time_call(lambda: plan_release_batch(picks, targets, limits, ceiling=ceiling)) for _ in range(ROUNDS + 1)]
    batch, plan_time = rounds[0][0], min(seconds for _, seconds in rounds[1:]) / len(picks)
    single_times = np.array([np.nan if value is None else value for value in exact])
    batch_times = batch.time[: len(throws)]
    same_feasibility = np.isnan(single_times) == np.isnan(batch_times)
    difference = np.abs(batch_times / single_times - 1.0)
    worst = float(np.nanmax(difference)) if same_feasibility.all() else "not the same throws are feasible"
    unfit = f"of {len(throws)}: no release exists below the ceiling"
    difference_note = "largest relative difference of the release time between the batch and single plans"
    ratio_note = "time per plan over the median of single plans"
    batched = f"{folder}/exact-batch"
    return [
        Row.ours(f"{folder}/exact/infeasible", float(np.isnan(single_times).sum()), "throws", note=unfit),
        Row.ours(f"{batched}/difference", worst, "-", note=difference_note),
        Row.ours(f"{batched}/plans-per-second", 1.0 / plan_time, "1/s", note=f"best batch of {len(picks)}"),
        Row.ours(f"{batched}/time-ratio", plan_time / reference, "-", note=ratio_note),
    ]


def _claim_row(rows: list[Row]) -> Row:
    """Row on section III-E's claim that the simplified method takes less time than the nonlinear programme."""
    times = {row.quantity: row.reproduced for row in rows if isinstance(row.reproduced, float)}
    first, second = (times[f"hassan/methods/no-ceiling/{name}/median-time"] for name in ("method-1-slsqp", "method-2"))
    return Row.compared(
        "hassan/methods/simplification-gain",
        "less time",
        first / second,
        "-",
        holds=second < first,
        note="median time of method 1 (SLSQP) over that of method 2; the paper gives no numbers",
    )


def _grid(rows: list[Row]) -> Grid:
    """Table of the paper's methods and of the exact solver on the same throws."""
    rows_by_quantity = by_quantity(rows)
    lines: list[list[str]] = []
    for folder, bound in BOUNDS.items():
        base = f"hassan/methods/{folder}"
        exact = value(rows_by_quantity, f"{base}/exact/median-time", FORMS["median-time"])
        rate = value(rows_by_quantity, f"{base}/exact-batch/plans-per-second", "{:,.0f} per s")
        ratio = value(rows_by_quantity, f"{base}/exact-batch/time-ratio", "{:.2f}")
        lines.append([f"exact, {bound}", *[NONE] * 5, exact, "1"])
        lines.append([f"exact in batches, {bound}", *[NONE] * 5, rate, ratio])
        for name, method in METHODS.items():
            figures = [value(rows_by_quantity, f"{base}/{name}/{quantity}", form) for quantity, form in FORMS.items()]
            lines.append([f"{method.label}, {bound}", *figures])
    header = ["method", "agree", "wrong", "failed", "invented", "slowest answer", "median", "over exact"]
    return Grid("Ways to find the release, on the same throws", header, lines)
