"""The virtual goal of iterative learning (Miyashita et al., section 5) per item and place, and the choice of K."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.action import Correction
from pnt_gym.errors import PntGymError

from .bucket_table import BucketTable
from .protocol import Actions, Learner, Observation, Outcome, State, ideal_offsets, is_instructive

NAME: Final = "virtual_goal"
GAINS: Final = (0.05, 0.1, 0.2, 0.5, 1.0)
"""Gains K among which practice chooses."""
FIRST: Final = 0.5
"""Gain of a controller that has not thrown yet."""


def virtual_goal(correction: Correction, gain: ArrayLike | None = None, threshold: float | None = None) -> Learner:
    """Iterative learning (Miyashita et al.): the virtual goal moves by K times the error, per item and place.

    Args:
        correction: meaning of an action.
        gain: diagonal of K, one number or one for each number of an action; None: the gain of `GAINS` that predicts the
            practice throws best.
        threshold: size of an error below which a bucket is learned and its learning ends (step 2 of section 5.2), in
            metres at the conveyor, else in shares of the cell's tolerance; None: never.

    Raises:
        PntGymError: a gain lies outside (0, 2), where the update cannot converge, there are too many or too few gains,
            or the threshold is not positive.
    """
    if threshold is not None and not (np.isfinite(threshold) and threshold > 0.0):
        raise PntGymError(f"virtual_goal: threshold is {threshold}; it must be above 0")
    if gain is None:
        return GainChoice([_table(correction, value, threshold) for value in GAINS], correction)
    return _table(correction, gain, threshold)


def _table(correction: Correction, gain: ArrayLike, threshold: float | None) -> BucketTable:
    gains = np.asarray(gain, dtype=np.float64)
    if gains.shape not in ((), (correction.count,)):
        raise PntGymError(f"virtual_goal: gain is {gain}; it must be one number or {correction.count}")
    if not ((gains > 0.0) & (gains < 2.0)).all():
        raise PntGymError(f"virtual_goal: gain is {gain}; it must lie between 0 and 2")
    step: Floats | float = gains if gains.ndim else float(gains)
    return BucketTable(NAME, correction, step, threshold)


@final
class GainChoice(Learner):
    """Virtual goals with several gains side by side, of which the best one acts.

    Every table learns from every throw. A table's miss is the distance of its offset from the offset that would have
    brought the throw to its goal, before the table learns from the throw. The table with the smallest mean square miss
    acts, so K is small where throws scatter much and large where they repeat.

    Args:
        tables: virtual goals, one for each gain.
        correction: meaning of an action.
    """

    name = NAME

    def __init__(self, tables: Sequence[BucketTable], correction: Correction) -> None:
        self._tables, self._correction = tables, correction
        self.reset(0)

    @property
    def gain(self) -> float:
        """The gain that acts now."""
        return GAINS[self._best]

    def reset(self, seed: int) -> None:
        """Forget every bucket, and the choice of the gain."""
        for table in self._tables:
            table.reset(seed)
        self._misses = np.zeros(len(self._tables))
        self._best = GAINS.index(FIRST)

    def act(self, observation: Observation) -> Actions:
        """Action of the best table: (N, E)."""
        return self._tables[self._best].act(observation)

    def learn(self, outcome: Outcome) -> None:
        """Let every table learn, and choose the one that would have missed least so far."""
        ideal, usable = ideal_offsets(outcome, self._correction), is_instructive(outcome)
        for k, table in enumerate(self._tables):
            miss = (ideal - table.offsets(outcome.observation)) / self._correction.tolerance
            self._misses[k] += float((miss[usable] ** 2).sum())
            table.learn(outcome)
        if usable.any():
            self._best = int(self._misses.argmin())

    def state(self) -> State:
        """The buckets of the table that acts, and its gain."""
        return {**self._tables[self._best].state(), "gain": np.array(self.gain)}

    def restore(self, state: State) -> None:
        """Load buckets into every table; the gain that they were learned with acts on.

        Raises:
            UsageError: the offsets have another number of coordinates.
        """
        for table in self._tables:
            table.restore(state)
        gain = float(state.get("gain", np.array(FIRST)))
        self._best = int(np.abs(np.array(GAINS) - gain).argmin())
        self._misses = np.ones(len(self._tables))
        self._misses[self._best] = 0.0
