"""Runs of a benchmark's learners compared, over seeds and levels: profiles, and probabilities of improvement.

Scores are of runs (R,), or of runs on several levels (R, T). Every score is better when it is smaller, as landing
errors are. Intervals are of the stratified bootstrap: the runs of each learner are resampled on each level by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats

from ..ground.drawings import WIDTH, Figure, dress, subplots
from ..ground.looks import colours
from ..ground.metrics import Interval
from ..ground.tables import Grid
from ..judging.throws import kept_rows
from .tables import name_of

DRAWS = 2000
"""Bootstrap resamples of an interval."""
ENDS = (2.5, 97.5)
"""Percentiles at the ends of an interval."""


def probability_of_improvement(scores: ArrayLike, others: ArrayLike) -> float:
    """Probability that a run has a smaller score than a run of another learner on the same level; ties count half.

    This is the statistic U of Mann and Whitney over the number of pairs, averaged over the levels.
    """
    return float(_improvement(_by_level(scores), _by_level(others)))


def interval(scores: ArrayLike, others: ArrayLike, seed: int = 0) -> Interval:
    """The probability of improvement with a 95 % interval."""
    random, first, second = np.random.default_rng(seed), _by_level(scores), _by_level(others)
    drawn = _improvement(_sample(random, first), _sample(random, second))
    low, high = np.percentile(drawn, ENDS)
    return Interval(probability_of_improvement(scores, others), float(low), float(high))


def text(scores: ArrayLike, others: ArrayLike) -> str:
    """The probability of improvement with its interval, in whole percent."""
    part = interval(scores, others)
    return f"{100 * part.value:.0f} % ({100 * part.low:.0f}..{100 * part.high:.0f})"


def profile(scores: ArrayLike, bounds: ArrayLike) -> Floats:
    """Share of the runs, on all levels, whose score is below each bound (B,)."""
    return (_by_level(scores)[..., None] < np.asarray(bounds, dtype=np.float64)).mean(axis=(-3, -2))


def profile_band(scores: ArrayLike, bounds: ArrayLike, seed: int = 0) -> tuple[Floats, Floats]:
    """Ends (B,) of the 95 % intervals of a performance profile, at each bound by itself."""
    resampled = _sample(np.random.default_rng(seed), _by_level(scores))
    low, high = np.percentile(
        (resampled[..., None] < np.asarray(bounds, dtype=np.float64)).mean(axis=(-3, -2)), ENDS, axis=0
    )
    return low, high


def _by_level(scores: ArrayLike) -> Floats:
    """Scores as runs by levels (R, T)."""
    array = np.asarray(scores, dtype=np.float64)
    return array.reshape(len(array), -1)


def _improvement(scores: Floats, others: Floats) -> Floats:
    """Probabilities of improvement (...) of runs (..., R, T) over runs (..., Q, T)."""
    first, second = scores[..., :, None, :], others[..., None, :, :]
    return ((first < second) + 0.5 * (first == second)).mean(axis=(-3, -2, -1))


def _sample(random: np.random.Generator, scores: Floats) -> Floats:
    """Runs drawn with replacement, on each level by themselves (DRAWS, R, T)."""
    rows = random.integers(len(scores), size=(DRAWS, *scores.shape))
    return scores[rows, np.arange(scores.shape[1])]


Data = Mapping[str, Any]
POINTS: Final = 121
"""Bounds at which a profile is drawn."""
FEWEST: Final = 3
"""Runs that a learner must have for its intervals to say anything."""


def errors(data: Data) -> dict[str, Floats]:
    """Mean landing errors of runs by levels (R, T) [m], by learner, each after the most throws that it learned from."""
    return _scores(data, lambda result: float(np.nanmean(kept_rows(result["columns"])["error_m"])))


def failures(data: Data) -> dict[str, Floats]:
    """Shares of the throws that failed, of runs by levels (R, T), by learner, as `errors`."""
    return _scores(data, lambda result: 1.0 - float(kept_rows(result["columns"])["success"].mean()))


def profiles_figure(data: Data) -> Figure:
    """Share of the runs that err less, and that fail less, than each bound, with 95 % intervals."""
    figure, panels = subplots(2, 1, (WIDTH, 6.4))
    shown = ((errors(data), 1000.0, "landing error [mm]"), (failures(data), 100.0, "throws that fail [%]"))
    for axes, (scores, factor, text) in zip(panels, shown, strict=True):
        every = np.concatenate([runs.ravel() for runs in scores.values()])
        bounds = np.linspace(0.95 * every.min(), 1.05 * every.max(), POINTS)
        colour = colours(scores)
        for name, runs in scores.items():
            axes.plot(factor * bounds, 100.0 * profile(runs, bounds), color=colour[name], label=name)
            low, high = profile_band(runs, bounds)
            axes.fill_between(factor * bounds, 100.0 * low, 100.0 * high, color=colour[name], alpha=0.2)
        dress(axes, text, "runs below [%]")
    names = panels[0].get_legend_handles_labels()
    figure.legend(*names, fontsize=8, loc="outside lower center", ncols=3)
    return figure


def grids(data: Data) -> list[Grid]:
    """Probability that a run of each learner is better than a run of each other one; none without two learners."""
    shown = (("errs", errors(data)), ("fails", failures(data)))
    return [_grid(data, verb, scores) for verb, scores in shown if len(scores) > 1]


def _grid(data: Data, verb: str, scores: Mapping[str, Floats]) -> Grid:
    rows = [
        [name, *("-" if name == other else text(runs, scores[other]) for other in scores)]
        for name, runs in scores.items()
    ]
    levels, runs = data["plan"]["levels"], next(iter(scores.values()))
    note = (
        f"Probability that a run of the learner on the left {verb} less than a run of the one above, on the same "
        f"level; ties count half. {len(runs)} runs of each on {' and '.join(levels)}, {data['plan']['picks']} held-out "
        "throws a run, with 95 % intervals over runs that are resampled on each level (Agarwal et al. 2021)."
    )
    return Grid(f"Probability that a run {verb} less", ["learner", *scores], rows, note)


def _scores(data: Data, score: Callable[[Data], float]) -> dict[str, Floats]:
    """Scores of runs by levels (R, T) of learners that have several runs on all levels of the plan."""
    levels: list[str] = list(data["plan"]["levels"])
    last = {row["label"]: row for row in sorted(data["table"], key=lambda row: row["throws"])}
    scores: dict[str, Floats] = {}
    for label, row in last.items():
        runs = [r for r in data["results"] if (r["label"], r["throws"]) == (label, row["throws"])]
        by_level = [[score(r) for r in runs if r["level"] == level] for level in levels]
        if row["throws"] and {*map(len, by_level)} == {len(by_level[0])} and len(by_level[0]) >= FEWEST:
            scores[name_of(row)] = np.array(by_level).T
    return scores
