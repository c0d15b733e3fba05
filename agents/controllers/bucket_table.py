"""Tables of corrections per item and place, as the virtual goal uses them.

A table uses only item and place; differences from throw to throw (seal, mass, speed, grasp) act as noise. Buckets are
named, so a table learned on one level serves another level with the same items.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.action import Correction

from . import protocol
from .protocol import Actions, Learner, Observation, Outcome, State, ideal_offsets, is_instructive, to_action

ANY = "*"


@final
class BucketTable(Learner):
    """Offset (E,) per item and place, with coarser buckets as a fallback.

    Args:
        name: name of the controller.
        correction: meaning of an action, and bucket of each throw.
        step: weight of the newest throw, one number or (E,).
        threshold: size of an error, relative to the tolerances of the correction, below which a bucket stops learning;
            None: never.
    """

    def __init__(self, name: str, correction: Correction, step: float | Floats, threshold: float | None = None) -> None:
        self.name = name
        self._threshold = threshold
        self._correction = correction
        self._step = step
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget every bucket."""
        self._shift: dict[str, Floats] = {}
        self._count: dict[str, int] = {}
        self._learned: set[str] = set()

    def act(self, observation: Observation) -> Actions:
        """Action of each throw's bucket, else of its item, else zero: (N, E)."""
        return to_action(self.offsets(observation), self._correction)

    def offsets(self, observation: Observation) -> Floats:
        """Offset of each throw (N, E), as `act` uses it."""
        buckets = self._correction.buckets(observation.features, observation.kind)
        rows = [self._find(self._chain(*bucket)) for bucket in buckets]
        return np.array(rows).reshape(-1, self._correction.count)

    def learn(self, outcome: Outcome) -> None:
        """Move each throw's bucket, and the coarser buckets around it, towards the ideal offset.

        A batch gives the same update as its throws one after another: with the offset s in force, s + K (d - z) = s + K
        (ideal - s).
        """
        offsets = ideal_offsets(outcome, self._correction)
        usable = is_instructive(outcome)
        observation = outcome.observation
        for row, bucket in enumerate(self._correction.buckets(observation.features, observation.kind)):
            if not usable[row]:
                continue
            chain, error = self._chain(*bucket), outcome.error[row] / self._correction.tolerance
            # A bucket is learned once its error is below the threshold, by this throw or by an earlier one.
            if self._threshold is not None and np.linalg.norm(error) < self._threshold:
                self._learned.add(chain[0])
            if chain[0] not in self._learned:
                self._update(chain, offsets[row])

    def state(self) -> State:
        """Names, offsets and counts of the buckets."""
        names = list(self._shift)
        ended = {"learned": np.array([n in self._learned for n in names], dtype=np.bool_)}
        return {
            **(ended if self._threshold is not None else {}),
            "buckets": np.array(names, dtype=np.str_),
            "shift": np.array([self._shift[n] for n in names]).reshape(-1, self._correction.count),
            "count": np.array([self._count[n] for n in names], dtype=np.int64),
        }

    def restore(self, state: State) -> None:
        """Load buckets.

        Raises:
            UsageError: the offsets have another number of coordinates.
        """
        protocol.check(state["shift"], self._correction, self.name)
        names = [str(n) for n in state["buckets"]]
        self._shift = {n: np.asarray(s, dtype=np.float64) for n, s in zip(names, state["shift"], strict=True)}
        self._count = {n: int(c) for n, c in zip(names, state["count"], strict=True)}
        learned = state.get("learned", np.zeros(len(names), dtype=np.bool_))
        self._learned = {n for n, done in zip(names, learned, strict=True) if done}

    def _chain(self, item: str, place: str) -> list[str]:
        """Names of the buckets of a throw, from fine to coarse."""
        return [f"{item}|{place}", f"{item}|{ANY}"]

    def _find(self, chain: Sequence[str]) -> Floats:
        return next((self._shift[name] for name in chain if name in self._shift), np.zeros(self._correction.count))

    def _update(self, chain: Sequence[str], ideal: Floats) -> None:
        for depth, bucket in enumerate(chain):
            # A new bucket starts from the coarser bucket that would have been used.
            before = self._find(chain[depth:])
            self._count[bucket] = self._count.get(bucket, 0) + 1
            self._shift[bucket] = before + self._step * (ideal - before)
