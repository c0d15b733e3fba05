"""Statistics of runs that learn anew, in the field's form (Agarwal et al. 2021, arXiv 2108.13264; the library rliable).

Every score here is better when it is smaller, as landing errors are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats

from ..ground.metrics import Interval

DRAWS = 2000
"""Bootstrap resamples of an interval."""


def probability_of_improvement(scores: ArrayLike, others: ArrayLike) -> float:
    """Probability that a run has a smaller score than a run of another learner; ties count half.

    This is the statistic U of Mann and Whitney over the number of pairs.
    """
    mine, theirs = np.asarray(scores, dtype=np.float64)[:, None], np.asarray(others, dtype=np.float64)
    return float(((mine < theirs) + 0.5 * (mine == theirs)).mean())


def improvement_interval(scores: ArrayLike, others: ArrayLike, seed: int = 0) -> Interval:
    """The probability of improvement with a 95 % interval; the runs of each learner are resampled."""
    random, mine, theirs = np.random.default_rng(seed), np.ravel(scores), np.ravel(others)
    drawn = [
        probability_of_improvement(random.choice(mine, len(mine)), random.choice(theirs, len(theirs)))
        for _ in range(DRAWS)
    ]
    low, high = np.percentile(drawn, [2.5, 97.5])
    return Interval(probability_of_improvement(scores, others), float(low), float(high))


def performance_profile(scores: ArrayLike, bounds: ArrayLike) -> Floats:
    """Share of the runs whose score is below each bound."""
    return (np.asarray(scores, dtype=np.float64)[:, None] < np.asarray(bounds, dtype=np.float64)).mean(axis=0)
