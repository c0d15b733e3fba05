"""Statistics of runs that learn anew, in the field's form (Agarwal et al. 2021, arXiv 2108.13264; the library rliable).

Scores are of runs (R,), or of runs on several levels (R, T). Every score is better when it is smaller, as landing
errors are. Intervals are of the stratified bootstrap: the runs of each learner are resampled on each level by itself.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats

from ..ground.metrics import Interval

DRAWS = 2000
"""Bootstrap resamples of an interval."""
ENDS = (2.5, 97.5)
"""Percentiles at the ends of an interval."""


def probability_of_improvement(scores: ArrayLike, others: ArrayLike) -> float:
    """Probability that a run has a smaller score than a run of another learner on the same level; ties count half.

    This is the statistic U of Mann and Whitney over the number of pairs, averaged over the levels.
    """
    return float(_improvement(_by_level(scores), _by_level(others)))


def improvement_interval(scores: ArrayLike, others: ArrayLike, seed: int = 0) -> Interval:
    """The probability of improvement with a 95 % interval."""
    random, first, second = np.random.default_rng(seed), _by_level(scores), _by_level(others)
    drawn = _improvement(_resampled(random, first), _resampled(random, second))
    low, high = np.percentile(drawn, ENDS)
    return Interval(probability_of_improvement(scores, others), float(low), float(high))


def improvement_text(scores: ArrayLike, others: ArrayLike) -> str:
    """The probability of improvement with its interval, in whole percent."""
    interval = improvement_interval(scores, others)
    return f"{100 * interval.value:.0f} % ({100 * interval.low:.0f}..{100 * interval.high:.0f})"


def performance_profile(scores: ArrayLike, bounds: ArrayLike) -> Floats:
    """Share of the runs, on all levels, whose score is below each bound (B,)."""
    return _share_below(_by_level(scores), np.asarray(bounds, dtype=np.float64))


def profile_band(scores: ArrayLike, bounds: ArrayLike, seed: int = 0) -> tuple[Floats, Floats]:
    """Ends (B,) of the 95 % intervals of a performance profile, at each bound by itself."""
    resampled = _resampled(np.random.default_rng(seed), _by_level(scores))
    low, high = np.percentile(_share_below(resampled, np.asarray(bounds, dtype=np.float64)), ENDS, axis=0)
    return low, high


def _by_level(scores: ArrayLike) -> Floats:
    """Scores as runs by levels (R, T)."""
    array = np.asarray(scores, dtype=np.float64)
    return array.reshape(len(array), -1)


def _improvement(scores: Floats, others: Floats) -> Floats:
    """Probabilities of improvement (...) of runs (..., R, T) over runs (..., Q, T)."""
    first, second = scores[..., :, None, :], others[..., None, :, :]
    return ((first < second) + 0.5 * (first == second)).mean(axis=(-3, -2, -1))


def _share_below(scores: Floats, bounds: Floats) -> Floats:
    """Shares (..., B) of the scores (..., R, T) below bounds (B,)."""
    return (scores[..., None] < bounds).mean(axis=(-3, -2))


def _resampled(random: np.random.Generator, scores: Floats) -> Floats:
    """Runs drawn with replacement, on each level by themselves (DRAWS, R, T)."""
    rows = random.integers(len(scores), size=(DRAWS, *scores.shape))
    return scores[rows, np.arange(scores.shape[1])]
