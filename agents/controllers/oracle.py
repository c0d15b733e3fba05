"""Reference controllers: without corrections, with random ones, and with a simulation of each throw before it.

The oracle lacks only the scatter of the release, which is drawn in the throw itself, and offsets beyond the range of an
action. It aims at the target, so it bounds no figure but the landing error, and that only where its search succeeds.

In the conveyor's mode `fixed_throw` an action of zero is one throw for all picks, and the controller has that name.
"""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.action import FIXED_THROW

from .protocol import Actions, Controller, Observation

ENOUGH: Final = 2e-3
"""Error below which a throw needs no further preview, in actions."""
PATIENCE: Final = 8
"""Previews in a row without an improvement, after which the best action of a throw is used."""
LEAST_DAMPING: Final = 1e-6
MORE_DAMPING: Final = 1e-2
MOST_DAMPING: Final = 1e3
"""Damping, added to the squares of the Jacobian's singular values: the least, the least after a failure, and the value
above which it restarts."""
TRUST: Final = 0.02
"""Weight of the one-to-one map against one preview, in the fit of the Jacobian."""
JUMPS: Final = (0.01, 0.03, 0.1)
"""Standard deviations of random offsets that are tried where Newton's steps do not help, in actions."""


@final
class Oracle(Controller):
    """Oracle controller: simulates each throw with its hidden values before the throw.

    Damped Newton steps on the simulated outcome of each throw, with a Jacobian from all of its previews.

    The first step is a fixed point iteration with gain 1, action <- action - error / scale. Each later step uses the
    Jacobian estimated from the previous previews (a secant method in several dimensions), damped after Levenberg and
    Marquardt. A throw without improvement tries, in turns, offsets of other throws of its bucket and random ones.

    Args:
        core: core that simulates the coming throws.
        correction: meaning of an action.
        previews: simulations of a throw at most; fewer if all throws succeed earlier.
    """

    name = "oracle"

    def __init__(self, core: Core, correction: Correction, previews: int = 25) -> None:
        self._core = core
        self._correction = correction
        self._previews = previews
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Reseed the random offsets."""
        self._random = np.random.default_rng(seed)

    def act(self, observation: Observation) -> Actions:
        """Best action found for each throw, (N, E)."""
        weight = self._correction.scale / self._correction.tolerance
        buckets = self._correction.buckets(observation.features, observation.kind)
        search = _Search(weight / weight.max(), np.unique(buckets, axis=0, return_inverse=True)[1].reshape(-1))
        trial = search.best
        for _ in range(self._previews):
            search.learn(trial, self._error(trial))
            if search.over.all():
                break
            trial = search.propose(self._random)
        return search.best.astype(np.float32)

    def _error(self, action: Floats) -> Floats:
        """Errors of previewed actions, in actions (N, E); NaN where a throw was not measured."""
        outcome = self._core.preview(action.astype(np.float32), jitter=False)
        return np.stack([getattr(outcome, name) for name in self._correction.errors], axis=-1) / self._correction.scale


@final
class _Search:
    """Previews of N throws, and the search for better offsets; all in actions.

    Args:
        weight: weight of each error (E,), the largest 1.
        bucket: bucket of each throw (N,).
    """

    def __init__(self, weight: Floats, bucket: np.ndarray) -> None:
        count, size = len(bucket), len(weight)
        self._weight, self._bucket = weight, bucket
        self._shifts = self._errors = np.zeros((count, 0, size))
        self.best, self._error = np.zeros((count, size)), np.zeros((count, size))
        self._smallest = np.full(count, np.inf)
        self._damping = np.full(count, LEAST_DAMPING)
        self._failures = np.zeros(count, dtype=np.int64)
        self._jumped = np.full(count, False)

    @property
    def over(self) -> Bools:
        """Whether each throw needs no further preview (N,)."""
        return (self._smallest <= ENOUGH) | (self._failures >= PATIENCE)

    def learn(self, shift: Floats, error: Floats) -> None:
        """Add a preview of all throws, (N, E) each; an unmeasured throw is no improvement."""
        size = np.nan_to_num(np.hypot.reduce(self._weight * error, axis=1), nan=np.inf)
        is_better = size < self._smallest
        self._shifts = np.concatenate([self._shifts, shift[:, None]], axis=1)
        self._errors = np.concatenate([self._errors, error[:, None]], axis=1)
        self.best = np.where(is_better[:, None], shift, self.best)
        self._error = np.where(is_better[:, None], error, self._error)
        self._smallest = np.where(is_better, size, self._smallest)
        self._failures = np.where(is_better, 0, self._failures + 1)
        increased = np.where(self._jumped, self._damping, 10.0 * np.maximum(self._damping, 0.1 * MORE_DAMPING))
        damping = np.where(is_better, np.maximum(0.1 * self._damping, LEAST_DAMPING), increased)
        self._damping = np.where(damping > MOST_DAMPING, MORE_DAMPING, damping)

    def propose(self, random: np.random.Generator) -> Floats:
        """Offsets (N, E) of the next preview, the best one where a throw is over."""
        jumps = self._failures >= 2
        self._jumped = jumps & (self._failures % 2 == 0)
        # Random offsets near the best offset of a throw of the same bucket with no larger error, itself included.
        order = np.lexsort((self._smallest, self._bucket))
        ranked = self._bucket[order]
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order)) - np.searchsorted(ranked, ranked)
        donor = order[np.searchsorted(ranked, self._bucket) + random.integers(rank + 1)]
        jump = random.choice(JUMPS, size=(len(order), 1)) * random.standard_normal(self.best.shape)
        trial = np.where(self._jumped[:, None], self.best[donor] + jump, self._newton())
        return np.where(self.over[:, None], self.best, np.clip(trial, -1.0, 1.0))

    def _newton(self) -> Floats:
        """Best offsets after one damped Newton step, with the Jacobian (N, E, E) of the error by the offset there."""
        offset_changes, error_changes = self._shifts - self.best[:, None], self._errors - self._error[:, None]
        distance = (offset_changes**2).sum(axis=2)
        is_valid = (distance > 0.0) & np.isfinite(error_changes).all(axis=2)
        # Weighted least squares of the errors' differences, near previews with more weight, shrunk towards one to one.
        weight = np.where(is_valid, 1.0 / np.where(is_valid, distance, 1.0), 0.0)
        error_changes = np.where(is_valid[..., None], error_changes, 0.0)
        spread = np.einsum("nm,nmi,nmj->nij", weight, offset_changes, offset_changes) + TRUST * np.eye(
            self.best.shape[1]
        )
        surprise = np.einsum(
            "nm,nmi,nmj->nij",
            weight,
            offset_changes,
            error_changes - np.where(is_valid[..., None], offset_changes, 0.0),
        )
        jacobian = np.eye(self.best.shape[1]) + np.linalg.solve(spread, surprise).transpose(0, 2, 1)
        square = self._weight**2
        # (J^T W J + damping I) step = J^T W error, per throw.
        normal = np.einsum("nki,k,nkj->nij", jacobian, square, jacobian)
        normal += self._damping[:, None, None] * np.eye(len(square))
        slope = np.einsum("nki,k,nk->ni", jacobian, square, self._error)
        return self.best - np.linalg.solve(normal, slope[..., None])[..., 0]


@final
class Analytic(Controller):
    """The uncorrected analytic planner: the object is a point at the cup, without drag and without delay."""

    def __init__(self, actions: int, mode: str | None = None) -> None:
        self.name = mode if mode == FIXED_THROW else "analytic"
        self._actions = actions

    def act(self, observation: Observation) -> Actions:
        """Zeros (N, A)."""
        return np.zeros((len(observation.kind), self._actions), dtype=np.float32)


@final
class Random(Controller):
    """Uniform random corrections: what every controller should beat."""

    name = "random"

    def __init__(self, actions: int) -> None:
        self._actions = actions
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Reseed the generator."""
        self._random = np.random.default_rng(seed)

    def act(self, observation: Observation) -> Actions:
        """Random actions (N, A), uniform in [-1, 1]."""
        return self._random.uniform(-1.0, 1.0, (len(observation.kind), self._actions)).astype(np.float32)
