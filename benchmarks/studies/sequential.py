"""How often a sequential comparison errs, and how many throws it takes: on recorded and on drawn differences."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import cache
from statistics import NormalDist
from typing import Any, Final

import numpy as np

from agents.ground import metrics
from agents.ground.places import SHIPPED, at
from agents.judging.comparison import compare
from agents.judging.figures import Figure
from agents.judging.sequential import FRACTIONS, WEIGHTS
from agents.judging.throw_record import ThrowRecord
from agents.judging.throws import kept_rows
from agents.judging.trials import open_trial
from agents.results.content import read_form
from agents.results.study import Amount, Figures, Settings
from pnt_gym.arrays import Floats, Ints

CHUNK: Final = 250
"""Comparisons that are computed together."""
ROWS: Final = 16
"""Throws between two looks at the intervals: one of every row."""
MEASURES: Final = ThrowRecord.measures()
"""Figures of throws as comparisons take them."""
POWER: Final = 0.8
"""Probability with which a test of fixed size shall find the difference."""


@cache
def benchmark() -> Any:
    """The committed benchmark."""
    return read_form(SHIPPED / "results" / "benchmark.json").data


def columns(result: Mapping[str, Any]) -> dict[str, Floats]:
    """Figures of each throw of a result of the benchmark."""
    rows = kept_rows(result["columns"])
    success, rate = rows["success"].astype(np.float64), rows["sorted"] * (60.0 / rows["cycle_s"])
    return {"landing_error_m": rows["error_m"], "success": success, "sorted_per_min": rate}


def recorded(choice: Mapping[str, Any], level: str) -> list[dict[str, Floats]]:
    """Figures of each throw of a controller of the benchmark, for each seed of its learning."""
    wanted = (choice["label"], choice["throws"], level)
    return [columns(r) for r in benchmark()["results"] if (r["label"], r["throws"], r["level"]) == wanted]


def pairs() -> Iterator[tuple[Mapping[str, Any], list[dict[str, Floats]]]]:
    """The published comparisons, and the differences of each figure between their controllers, seed by seed."""
    for comparison in benchmark()["comparisons"]:
        if comparison["learned"] == comparison["reference"]:
            continue
        sides = [recorded(comparison[side], comparison["level"]) for side in ("learned", "reference")]
        count = max(map(len, sides))
        both = zip(*(side * (count // len(side)) for side in sides), strict=True)  # a planner has one seed for all
        yield comparison, [{name: a[name] - b[name] for name in a} for a, b in both]


def bounded(measure: Figure, difference: Floats) -> Floats:
    """Differences up to the measure's cap; 0, on which no capital is bet, where a figure was not measured."""
    return np.nan_to_num(np.clip(difference, -measure.bound, measure.bound))


def log_capital_path(values: Floats, bound: float) -> Floats:
    """Logarithm of the capital against "the mean is at most 0", after each of the values (..., N)."""
    path = np.full(values.shape, -np.inf)
    for fraction, weight in zip(FRACTIONS, WEIGHTS, strict=True):
        path = np.logaddexp(path, np.log(weight) + np.cumsum(np.log1p(fraction * values / bound), axis=-1))
    return path


def first_crossing(values: Floats, bound: float, alpha: float, looks: int = 1) -> Floats:
    """Number of observations of (C, N) after which the interval first leaves out 0; infinite where it never does."""
    goal = np.log(2.0 / alpha)
    crossed = np.zeros(values.shape, dtype=bool)
    for side in (1.0, -1.0):
        crossed |= log_capital_path(side * values, bound) >= goal
    crossed = crossed[:, looks - 1 :: looks]
    return np.where(crossed.any(axis=1), (crossed.argmax(axis=1) + 1.0) * looks, np.inf)


def false_alarms(settings: Settings, amount: Amount) -> Figures:
    """Share of comparisons without any difference in which an interval ever leaves out 0, over all three figures.

    Args:
        settings: `source`, how the differences lose their mean, and the number of `comparisons`.
        amount: throws of each comparison.
    """
    random = np.random.default_rng(amount.seed)
    make = {"same controller": same_controller, "labels swapped": labels_swapped, "mean removed": mean_removed}
    sources = [source for _, by_seed in pairs() for source in by_seed]
    throws = [recorded(comparison[side], comparison["level"])[0] for comparison, _ in pairs() for side in ("learned",)]
    alarms = 0
    for _ in range(settings["comparisons"] // CHUNK):
        chosen = throws if settings["source"] == "same controller" else sources
        source = chosen[random.integers(len(chosen))]
        index = random.integers(len(source["success"]), size=(2, CHUNK, amount.throws))
        signs = random.choice([-1.0, 1.0], size=index.shape[1:])
        alarms += any_alarm(make[settings["source"]](source, index, signs))
    rate = metrics.wilson(alarms, settings["comparisons"])
    return {"false_alarms": {"value": rate.value, "low": rate.low, "high": rate.high}}


def same_controller(source: Mapping[str, Floats], index: Ints, signs: Floats) -> dict[str, Floats]:
    """Differences of two independent throws of one controller."""
    del signs
    return {name: bounded(m, source[name][index[0]] - source[name][index[1]]) for name, m in MEASURES.items()}


def labels_swapped(source: Mapping[str, Floats], index: Ints, signs: Floats) -> dict[str, Floats]:
    """Differences of two controllers on the same throws, whose names change places at random."""
    return {name: bounded(m, signs * source[name][index[0]]) for name, m in MEASURES.items()}


def mean_removed(source: Mapping[str, Floats], index: Ints, signs: Floats) -> dict[str, Floats]:
    """Differences of two controllers less their mean: as skewed as they are, and scaled into the bounds again."""
    del signs
    centred: dict[str, Floats] = {}
    for name, measure in MEASURES.items():
        values = np.clip(source[name], -measure.bound, measure.bound)
        mean = np.nanmean(values)
        centred[name] = np.nan_to_num((values - mean) / (1.0 + abs(mean) / measure.bound))[index[0]]
    return centred


def any_alarm(differences: Mapping[str, Floats]) -> int:
    """Number of comparisons (C, N) in which any figure is ever declared to differ, looked at after every throw."""
    alpha = (1.0 - metrics.CONFIDENCE) / len(MEASURES)
    crossed = [np.isfinite(first_crossing(differences[name], m.bound, alpha)) for name, m in MEASURES.items()]
    return int(np.any(crossed, axis=0).sum())


def published(settings: Settings, amount: Amount) -> list[Figures]:
    """Throws until the published differences of the benchmark are settled, by the landing error.

    Args:
        settings: number of resampled `comparisons` of each difference.
        amount: budget in throws.
    """
    random, measure = np.random.default_rng(amount.seed), MEASURES["landing_error_m"]
    rows: list[Figures] = []
    for comparison, by_seed in pairs():
        pool = np.concatenate([source["landing_error_m"] for source in by_seed])
        values = bounded(measure, pool)[random.integers(len(pool), size=(settings["comparisons"], amount.throws))]
        names = [f"{comparison[side]['label']} {comparison[side]['throws']}" for side in ("learned", "reference")]
        head = {"level": comparison["level"], "learned": names[0], "reference": names[1]}
        rows.append({**head, **needed(values, measure, float(np.isfinite(pool).mean()))})
    return rows


def drawn(settings: Settings, amount: Amount) -> Figures:
    """Throws until differences from a normal distribution are settled.

    Args:
        settings: `mean` and `deviation` of a difference [m], the number of `comparisons`, and a number of throws
            `within` which they are to be settled.
        amount: budget in throws.
    """
    random, measure = np.random.default_rng(amount.seed), MEASURES["landing_error_m"]
    shape = (settings["comparisons"], amount.throws)
    values = bounded(measure, random.normal(settings["mean"], settings["deviation"], shape))
    return {"within": settings["within"], **needed(values, measure, 1.0, settings["within"])}


def needed(values: Floats, measure: Figure, measured: float, within: float = np.inf) -> Figures:
    """Throws that comparisons (C, N) need, and that a test of fixed size would need.

    Args:
        values: differences, 0 where not measured.
        measure: the figure.
        measured: share of the throws that are measured.
        within: number of throws.
    """
    alpha = (1.0 - metrics.CONFIDENCE) / len(MEASURES)
    throws = first_crossing(values, measure.bound, alpha, ROWS)
    mean = float(values.mean()) / measured
    deviation = float(np.sqrt((values**2).mean() / measured - mean**2))
    ends = [(row, int(end)) for row, end in enumerate(throws) if np.isfinite(end)]
    stopped = [values[row, :end].mean() / measured for row, end in ends]
    quantile = NormalDist().inv_cdf
    z = quantile(0.5 + metrics.CONFIDENCE / 2.0) + quantile(POWER)
    middle, upper = (float(np.quantile(throws, share, method="higher")) for share in (0.5, POWER))
    return {
        "difference_m": mean,
        "deviation_m": deviation,
        "settled": float(np.isfinite(throws).mean()),
        "settled_mean_m": float(np.mean(stopped)) if stopped else None,
        "settled_within": float((throws <= within).mean()),
        "median_throws": int(middle) if np.isfinite(middle) else None,
        "throws_80": int(upper) if np.isfinite(upper) else None,
        "fixed_size": int(np.ceil((z * deviation / mean) ** 2 / measured)),
    }


def dependent(settings: Settings, amount: Amount) -> Figures:
    """False alarms on the belt, where throws of a row follow one another: runs of a row are resampled whole.

    Args:
        settings: `env`, `level`, the two `controllers` with their practice, the number of `blocks` that are thrown, and
            the number of `comparisons`.
        amount: throws of each comparison.
    """
    with closing(open_trial(settings["env"], settings["level"], ROWS, 1)) as trial:
        length = trial.block(10**6) // ROWS
        sides: list[dict[str, Floats]] = []
        for name, practice in settings["controllers"].items():
            controller = trial.controller(name)
            controller.reset(amount.seed)
            controller = trial.practise(controller, practice, amount.seed)
            blocks = [trial.run(controller, length * ROWS, 10**6 + k).observations() for k in range(settings["blocks"])]
            sides.append({
                name: np.concatenate([block[name].reshape(length, ROWS) for block in blocks], axis=1)
                for name in MEASURES
            })  # fmt: skip
    difference = {name: sides[0][name] - sides[1][name] for name in MEASURES}
    runs, random, alarms = difference["success"].shape[1], np.random.default_rng(amount.seed), 0
    for _ in range(settings["comparisons"] // CHUNK):
        # Blocks of whole runs, in the order in which a comparison takes throws: step by step over the rows.
        drawn_runs = random.integers(runs, size=(CHUNK, amount.throws // (length * ROWS) + 1, ROWS))
        index = np.arange(length)[:, None] * runs + drawn_runs[:, :, None, :]
        flat = index.reshape(CHUNK, -1)[:, : amount.throws]
        source = {name: values.ravel() for name, values in difference.items()}
        alarms += any_alarm(mean_removed(source, flat[None], flat[0]))
    rate = metrics.wilson(alarms, settings["comparisons"])
    return {"runs": runs, "false_alarms": {"value": rate.value, "low": rate.low, "high": rate.high}}


def speed(settings: Settings, amount: Amount) -> Figures:
    """Time until a comparison is settled, with the opening of its environment and the practice of its controllers.

    Args:
        settings: `env`, `level`, two `controllers`, and the `threads` of the simulation.
        amount: budget in throws.
    """
    a, b = (str(at(name)) if "/" in name else name for name in settings["controllers"])
    began = time.perf_counter()
    cell = {name: settings[name] for name in ("level", "threads")}
    report = compare(a, b, settings["env"], amount.seed, budget=amount.throws, **cell)
    seconds = round(time.perf_counter() - began, 1)
    (pair,) = report["pairs"]
    figure = pair["figures"]["landing_error_m"]
    difference = {name: figure[name] for name in ("value", "low", "high")}
    return {"settled": pair["settled"], "seconds": seconds, "difference_m": difference}
