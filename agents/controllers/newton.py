"""Newton's method on the offset, for cells whose errors do not follow the offset one to one.

The virtual goal of iterative learning, z_hat += K (z_d - z), assumes that the error changes by the offset. If the error
changes by less, by more or in the other direction, that update is slow, oscillates or diverges: a block that a stopper
pushes while leaving the arm turns no faster, and then more slowly, the faster the arm is. Here each bucket of the table
keeps its throws and learns how the error depends on the offset. The prior is one to one, so the first step equals that
of the virtual goal with K = 1.

The map from offset to error (`Response`) estimates its own uncertainty: from the second throw on, Newton's step
competes with other offsets, and the offset with the best chance to beat the best throw so far is thrown. Offsets
without a plan, by the correction, are never thrown.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from functools import partial
from typing import Final, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.action import Correction

from .protocol import Actions, Learner, Observation, Outcome, State
from .response import Response, gauss_newton, log_chance
from .shift import check_width, is_instructive, to_action

MEMORY: Final = 160
"""Throws that a bucket keeps, the latest ones; fitting more would take longer than a throw."""
LARGEST: Final = 3.0
"""Largest error that counts, in actions; a deflected object gives no measurement in metres."""
SPREAD: Final = 0.15
"""Standard deviation of the offsets in the first batch of practice, in actions."""
NEAR: Final = 0.03
"""Standard deviation of candidates around Newton's offset, in actions."""
AROUND: Final = (0.02, 0.06, 0.2, 0.5)
"""Standard deviations of candidates around the best offset, in actions."""
OPTIONS: Final = 64
"""Candidate offsets for each standard deviation."""
ROWS: Final = 32
"""Different offsets of one batch at most, after the first."""
_Possible: TypeAlias = Callable[[Floats], Bools]
_TABLES: Final = ("shift", "error", "refused", "next")
"""Array attributes of a bucket with one row per throw."""
_CHOSEN: Final = ("best", "kept")
"""Offset attributes of a bucket."""


@final
class _Bucket:
    """Throws of one item to one place, and the offsets of the next throws, in actions.

    Args:
        weight: weight of each error (E,).
    """

    def __init__(self, weight: Floats) -> None:
        count = len(weight)
        self._weight = weight
        self.shift, self.error = np.zeros((0, count)), np.zeros((0, count))
        self.refused = np.zeros((0, count))
        self.best, self.kept = np.zeros(count), np.zeros(count)
        self.next = np.zeros((1, count))

    def add(self, shift: Floats, error: Floats, refused: Floats) -> None:
        """Add the throws (M, E) of one batch, and the offsets (K, E) of refused throws."""
        self.refused = np.concatenate([self.refused, refused])[-MEMORY:]
        self.shift, self.error = np.concatenate([self.shift, shift]), np.concatenate([self.error, error])
        # The newest throw with the best offset is always kept.
        last = np.flatnonzero((self.shift == self.best).all(axis=1))[-1:]
        rows = np.union1d(np.arange(len(self.shift))[-MEMORY:], last)
        self.shift, self.error = self.shift[rows], self.error[rows]

    def choose(self, random: np.random.Generator, possible: _Possible) -> None:
        """Choose the best offset thrown, the offset to keep, and the offsets of the next throws.

        Args:
            random: generator of the candidates.
            possible: whether offsets (N, E) have a plan (N,).
        """
        if len(self.shift) == 0:
            return
        response = Response(self.shift, self.error)
        offsets = np.unique(self.shift, axis=0)
        sizes = ((self._weight * response.error_again(offsets)) ** 2).sum(axis=1)
        self.best = offsets[sizes.argmin()]
        newton = gauss_newton(response, self._weight, self.best)
        risk = np.hypot(response.error(newton[None]), response.doubt(newton[None]))[0]
        is_better = ((self._weight * risk) ** 2).sum() < sizes.min()
        planned = possible(newton[None])[0]
        self.kept = newton if is_better and planned and self._is_attainable(newton[None])[0] else self.best
        if len(offsets) == 1 and len(self.refused) == 0 and planned:
            self.next = newton[None]
            return
        options = self._options(newton, random, possible)
        bound = np.sqrt(sizes.min() / len(self.best)) / self._weight
        chance = log_chance(response.error(options), response.doubt(options), bound)
        # The most likely improvement first; further ones are drawn by their chances (Gumbel's trick).
        score = chance + random.gumbel(size=len(chance))
        score[chance.argmax()] = np.inf
        self.next = options[np.argsort(-score)[:ROWS]]

    def _options(self, newton: Floats, random: np.random.Generator, possible: _Possible) -> Floats:
        """Candidate offsets: Newton's, some near it and some around the best; none near refused throws."""
        near = newton + NEAR * random.standard_normal((OPTIONS, len(newton)))
        size = np.repeat(AROUND, OPTIONS)[:, None]
        around = self.best + size * random.standard_normal((len(size), len(newton)))
        options = np.clip(np.concatenate([newton[None], near, around]), -1.0, 1.0)
        good = options[self._is_attainable(options)]
        good = good[possible(good)]
        return good if len(good) > 0 else self.best[None]

    def _is_attainable(self, shift: Floats) -> Bools:
        """Whether offsets (N, E) are nearer to a measured throw than to a refused one (N,)."""
        if len(self.refused) == 0:
            return np.full(len(shift), True)
        to_thrown, to_refused = (_nearest_distance(shift, reference) for reference in (self.shift, self.refused))
        return to_thrown <= to_refused


def _nearest_distance(shift: Floats, reference: Floats) -> Floats:
    return ((shift[:, None] - reference) ** 2).sum(axis=2).min(axis=1)


@final
class NewtonGoal(Learner):
    """Offset (E,) per item and place, from a learned map of the errors.

    In practice the rows of one batch that share a bucket throw different offsets, which shows the Jacobian at once;
    without practice they throw the same offset. After practice the best offset thrown is kept, or Newton's if the map
    predicts a smaller error for it.

    Args:
        correction: meaning of an action, and bucket of each throw.
    """

    name = "newton_goal"

    def __init__(self, correction: Correction) -> None:
        self._correction = correction
        weight = correction.scale / correction.tolerance
        self._weight: Floats = weight / np.sqrt(np.mean(weight**2))
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget every bucket and reseed the exploration."""
        self._random = np.random.default_rng(seed)
        self._buckets: dict[str, _Bucket] = {}
        self._exploring, self._settled = False, False

    def begin_practice(self, throws: int) -> None:
        """Explore: throw offsets with a likely improvement, different ones in the rows of a batch."""
        self._exploring, self._settled = True, False

    def end_practice(self) -> None:
        """Keep the best known offset of each bucket."""
        self._exploring, self._settled = False, True
        for bucket in self._buckets.values():
            bucket.next = bucket.kept[None]

    def act(self, observation: Observation) -> Actions:
        """Next offset of each throw's bucket as an action, zero without throws: (N, E)."""
        action = np.zeros((len(observation.kind), self._correction.count))
        for name, rows in self._rows(observation).items():
            action[rows] = self._next_offsets(name, len(rows), self._possible(observation, rows[0]))
        return to_action(action * self._correction.scale, self._correction)

    def learn(self, outcome: Outcome) -> None:
        """Add the throws to their buckets; throws that were shortened or not measured count as refused."""
        usable = is_instructive(outcome)
        shift = outcome.action.astype(np.float64)
        error = np.clip(outcome.error / self._correction.scale, -LARGEST, LARGEST)
        for name, rows in self._rows(outcome.observation).items():
            bucket = self._buckets.setdefault(name, _Bucket(self._weight))
            good = [row for row in rows if usable[row]]
            bucket.add(shift[good], error[good], shift[[row for row in rows if not usable[row]]])
            bucket.choose(self._random, self._possible(outcome.observation, rows[-1]))
            if self._settled:
                bucket.next = bucket.kept[None]

    def state(self) -> State:
        """Names, throws and offsets of the buckets."""
        buckets = list(self._buckets.values())
        empty = np.zeros((0, self._correction.count))
        state: dict[str, np.ndarray] = {"buckets": np.array(list(self._buckets), dtype=np.str_)}
        for key in _TABLES:
            parts = [getattr(bucket, key) for bucket in buckets]
            state[key] = np.concatenate([empty, *parts])
            state[f"{key}_count"] = np.array([len(part) for part in parts], dtype=np.int64)
        for key in _CHOSEN:
            state[key] = np.array([getattr(bucket, key) for bucket in buckets]).reshape(-1, self._correction.count)
        return state | {"settled": np.array(self._settled)}

    def restore(self, state: State) -> None:
        """Load buckets.

        Raises:
            UsageError: the offsets have another number of coordinates.
        """
        check_width(state["shift"], self._correction, self.name)
        self.reset(0)
        self._settled = bool(state["settled"])
        self._buckets = {str(name): _Bucket(self._weight) for name in state["buckets"]}
        for key in _TABLES:
            rows, ends = np.asarray(state[key], dtype=np.float64), np.cumsum(state[f"{key}_count"])
            for bucket, end, count in zip(self._buckets.values(), ends, state[f"{key}_count"], strict=True):
                setattr(bucket, key, rows[end - count : end])
        for key in _CHOSEN:
            for bucket, shift in zip(self._buckets.values(), np.asarray(state[key], dtype=np.float64), strict=True):
                setattr(bucket, key, shift)

    def _rows(self, observation: Observation) -> dict[str, list[int]]:
        """Rows of each bucket."""
        rows: dict[str, list[int]] = defaultdict(list)
        for row, (item, place) in enumerate(self._correction.buckets(observation.features, observation.kind)):
            rows[f"{item}|{place}"].append(row)
        return rows

    def _possible(self, observation: Observation, row: int) -> _Possible:
        """Test of which offsets of one throw have a plan; always true without such a test in the correction."""
        test = self._correction.possible
        if test is None:
            return lambda shift: np.full(len(shift), True)
        return partial(test, observation.features[row], int(observation.kind[row]))

    def _next_offsets(self, name: str, count: int, possible: _Possible) -> Floats:
        """Offsets (count, E) of the next throws in one bucket."""
        bucket = self._buckets.get(name)
        if bucket is not None:
            return bucket.next[np.arange(count) % len(bucket.next) if self._exploring else np.zeros(count, dtype=int)]
        shift = np.zeros((count, self._correction.count))
        if self._exploring and count > 1:
            options = SPREAD * self._random.standard_normal((ROWS * (count - 1), self._correction.count))
            good = options[possible(options)][: count - 1]
            shift[1 : 1 + len(good)] = good
        return shift
