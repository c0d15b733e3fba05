"""Newton's method on the shift, for cells whose errors do not follow the shift one to one.

The virtual goal of iterative learning, z_hat += K (z_d - z), takes the error to change by what the shift changes. Where
it changes by less, by more or the other way, that update crawls, swings or runs away: a block that a stopper pushes
while it leaves the arm turns no faster, and then more slowly, the faster the arm is. Here each cell of the table keeps
its throws and learns from them how the error depends on the shift. What it has not learned yet is one to one, so that
the first step is that of the virtual goal with K = 1.

The map from shift to error is a straight one plus what bends it, both with Gaussian priors (Bayesian least squares, in
the form of a Gaussian process). It has a Jacobian at every shift, averages the scatter of the throws, and knows how far
to trust itself: from the second throw on, Newton's step has to compete with other shifts, and the one is thrown that
has the best chance to beat the best throw so far.
"""

from __future__ import annotations

import importlib
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from agents.cli import UsageError
from agents.controllers.protocol import Actions, Observation, Outcome, State
from agents.controllers.shift import instructive, to_action
from pnt_gym.correction import Correction
from pnt_gym.planning.arrays import Bools, Floats

MEMORY: Final = 160
"""Throws that a cell keeps, the latest ones; a fit to more takes longer than a throw."""
SLOPE: Final = 1.0
"""Deviation, as known before the first throw, of the Jacobian's entries from the one-to-one map's."""
OFFSET: Final = 10.0
"""Deviation of the error of an uncorrected throw, in actions."""
NOISE: Final = (0.003, 0.01, 0.03, 0.1, 0.3)
"""Standard deviations of what the map does not explain that are tried, in actions."""
BENDS: Final = ((0.0, 1.0), (0.1, 0.3), (0.1, 0.8), (0.4, 0.3), (0.4, 0.8), (1.5, 0.8))
"""Sizes and lengths of the bends of the map that are tried, in actions."""
REPEATABLE: Final = (0.5, 0.0, 0.95)
"""Shares of the unexplained that come back when a shift is thrown again; the first one while no shift was."""
ITERATIONS: Final = 12
"""Gauss-Newton steps on the learned map for one step of the shift."""
LEAST_DAMPING: Final = 1e-6
MORE_DAMPING: Final = 1e-3
"""Added to the squares of the Jacobian's singular values: at least, and once a step has led to larger errors."""
LARGEST: Final = 3.0
"""Errors beyond count as this, in actions: an object thrown off is no lesson in metres."""
SPREAD: Final = 0.15
"""Deviation of the shifts in the first batch of practice from one another, in actions."""
NEAR: Final = 0.03
"""Deviation from Newton's of shifts that may be tried, in actions."""
AROUND: Final = (0.02, 0.06, 0.2, 0.5)
"""Deviations from the best one of shifts that may be tried, in actions."""
OPTIONS: Final = 64
"""Shifts looked at for each deviation."""
ROWS: Final = 32
"""Different shifts of one batch at most, after the first."""


@final
@dataclass(frozen=True)
class _Kernel:
    """Covariance of one error over shifts, in actions."""

    noise: float
    bend: float
    length: float
    repeats: float

    def smooth(self, a: Floats, b: Floats) -> Floats:
        """Of the map (A, B) at shifts (A, E) and (B, E)."""
        return OFFSET**2 + SLOPE**2 * (a @ b.T) + self._bent(a, b)

    def slope(self, a: Floats, b: Floats) -> Floats:
        """Derivative of `smooth` by the one shift `a` (E,): (E, B)."""
        pull = (b - a) / self.length**2
        return SLOPE**2 * b.T + (self._bent(a[None], b)[0][:, None] * pull).T

    def rough(self, a: Floats, b: Floats) -> Floats:
        """What `smooth` misses and yet comes back at the same shift (A, B)."""
        same = (a[:, None] == b).all(axis=2)
        return np.where(same, self.repeats * self.noise**2, 0.0)

    def observed(self, a: Floats) -> Floats:
        """Of errors measured at shifts (A, E): (A, A)."""
        rest = (1.0 - self.repeats) * self.noise**2
        return self.smooth(a, a) + self.rough(a, a) + rest * np.eye(len(a))

    def variance(self, a: Floats) -> Floats:
        """Of the error of one throw, before anything is known (A,)."""
        return OFFSET**2 + SLOPE**2 * (a**2).sum(axis=1) + self.bend**2 + self.noise**2

    def _bent(self, a: Floats, b: Floats) -> Floats:
        square = ((a[:, None] - b) ** 2).sum(axis=2)
        return self.bend**2 * np.exp(-0.5 * square / self.length**2)


_TABLES: Final = ("shift", "error", "refused", "next")
"""Arrays of a cell, one row per throw."""
_CHOSEN: Final = ("best", "kept")
"""Shifts of a cell."""
_KERNELS: Final = tuple(_Kernel(n, *bend, share) for n in NOISE for bend in BENDS for share in REPEATABLE)


def _solved(factor: Floats, right: Floats, *, transposed: bool = False) -> Floats:
    """The solution x of L x = right, or of L^T x = right, for a lower triangle L."""
    scipy = importlib.import_module("scipy.linalg")  # at first use, because it takes a while
    return np.asarray(scipy.solve_triangular(factor, right, lower=True, trans=int(transposed), check_finite=False))


@final
class Response:
    """How the error depends on the shift, learned from throws; both in actions, one to one where nothing is known.

    Args:
        shift: of each throw (M, E), M at least 1.
        error: of each throw (M, E).
    """

    def __init__(self, shift: Floats, error: Floats) -> None:
        self._shift = shift
        surprise = error - shift
        repeated = len(np.unique(shift, axis=0)) < len(shift)
        kernels = [k for k in _KERNELS if repeated or k.repeats == REPEATABLE[0]]
        factors: list[Floats] = [np.asarray(np.linalg.cholesky(k.observed(shift)), np.float64) for k in kernels]
        whitened = [_solved(factor, surprise) for factor in factors]
        # Logarithm of the likelihood of each error under each kernel, but for a constant.
        fits = [-0.5 * (w**2).sum(axis=0) - np.log(f.diagonal()).sum() for w, f in zip(whitened, factors, strict=True)]
        best: list[int] = np.array(fits).argmax(axis=0).tolist()
        self._kernels = [kernels[i] for i in best]
        self._factors = [factors[i] for i in best]
        self._weights = [_solved(factors[i], whitened[i][:, e], transposed=True) for e, i in enumerate(best)]

    def error(self, shift: Floats) -> Floats:
        """Smooth part of the error (N, E) expected at shifts (N, E)."""
        parts = [k.smooth(shift, self._shift) @ w for k, w in zip(self._kernels, self._weights, strict=True)]
        return shift + np.stack(parts, axis=1)

    def error_again(self, shift: Floats) -> Floats:
        """The error (N, E) expected where shifts (N, E) are thrown that were thrown before."""
        parts = [k.rough(shift, self._shift) @ w for k, w in zip(self._kernels, self._weights, strict=True)]
        return self.error(shift) + np.stack(parts, axis=1)

    def doubt(self, shift: Floats) -> Floats:
        """Standard deviation (N, E) of the errors of throws with new shifts (N, E), scatter included."""
        parts: list[Floats] = []
        for kernel, factor in zip(self._kernels, self._factors, strict=True):
            known = _solved(factor, kernel.smooth(self._shift, shift))
            parts.append(kernel.variance(shift) - (known**2).sum(axis=0))
        return np.sqrt(np.maximum(np.stack(parts, axis=1), 1e-12))

    def jacobian(self, shift: Floats) -> Floats:
        """Derivative (E, E) of the error by the one shift (E,)."""
        rows = [k.slope(shift, self._shift) @ w for k, w in zip(self._kernels, self._weights, strict=True)]
        return np.eye(len(shift)) + np.stack(rows)


def gauss_newton(response: Response, weight: Floats, start: Floats) -> Floats:
    """The shift (E,) within [-1, 1] to which Gauss-Newton steps lead from `start` (E,).

    Args:
        response: what is known of the errors.
        weight: of each error (E,).
        start: a shift.
    """
    best, damping = start, LEAST_DAMPING
    error, jacobian = _weighted(response, weight, best)
    for _ in range(ITERATIONS):
        square = jacobian.T @ jacobian + damping * np.eye(len(start))
        trial = np.clip(best - np.linalg.solve(square, jacobian.T @ error), -1.0, 1.0)
        found, slope = _weighted(response, weight, trial)
        if found @ found < error @ error:
            best, error, jacobian = trial, found, slope
            damping = max(0.1 * damping, LEAST_DAMPING)
        else:
            damping = 10.0 * max(damping, MORE_DAMPING)
    return best


def _weighted(response: Response, weight: Floats, shift: Floats) -> tuple[Floats, Floats]:
    return weight * response.error(shift[None])[0], weight[:, None] * response.jacobian(shift)


def log_chance(error: Floats, doubt: Floats, bound: Floats | float) -> Floats:
    """Logarithm of the chance (N,) that all errors (N, E), known up to `doubt` (N, E), come out within +-bound."""
    log_ndtr: Callable[[Floats], Floats] = importlib.import_module("scipy.special").log_ndtr
    # Mirrored to the lower tail, where the logarithm keeps its digits however unlikely the interval is.
    low, high = (-bound - np.abs(error)) / doubt, (bound - np.abs(error)) / doubt
    upper, lower = log_ndtr(high), log_ndtr(low)
    return (upper + np.log1p(-np.exp(np.minimum(lower - upper, -1e-12)))).sum(axis=1)


@final
class _Cell:
    """One thing thrown to one place: its throws, and the shifts of the next ones, in actions.

    Args:
        weight: of each error (E,).
    """

    def __init__(self, weight: Floats) -> None:
        count = len(weight)
        self._weight = weight
        self.shift, self.error = np.zeros((0, count)), np.zeros((0, count))
        self.refused = np.zeros((0, count))
        self.best, self.kept = np.zeros(count), np.zeros(count)
        self.next = np.zeros((1, count))

    def add(self, shift: Floats, error: Floats, refused: Floats) -> None:
        """Take in the throws (M, E) of one batch, and the shifts (K, E) that were not to be had."""
        self.refused = np.concatenate([self.refused, refused])[-MEMORY:]
        self.shift, self.error = np.concatenate([self.shift, shift]), np.concatenate([self.error, error])
        # Of the best shift the newest throw is never forgotten, however long ago it was.
        last = np.flatnonzero((self.shift == self.best).all(axis=1))[-1:]
        kept = np.union1d(np.arange(len(self.shift))[-MEMORY:], last)
        self.shift, self.error = self.shift[kept], self.error[kept]

    def choose(self, random: np.random.Generator) -> None:
        """Find the best shift seen, the one to keep to, and the ones to try next."""
        if len(self.shift) == 0:
            return
        response = Response(self.shift, self.error)
        known = np.unique(self.shift, axis=0)
        size = ((self._weight * response.error_again(known)) ** 2).sum(axis=1)
        self.best = known[size.argmin()]
        newton = gauss_newton(response, self._weight, self.best)
        risk = np.hypot(response.error(newton[None]), response.doubt(newton[None]))[0]
        better = ((self._weight * risk) ** 2).sum() < size.min()
        self.kept = newton if better and self._to_be_had(newton[None])[0] else self.best
        if len(known) == 1 and len(self.refused) == 0:
            self.next = newton[None]
            return
        options = self._options(newton, random)
        bound = np.sqrt(size.min() / len(self.best)) / self._weight
        chance = log_chance(response.error(options), response.doubt(options), bound)
        # The most likely improvement first; the others are drawn by their chances (Gumbel's trick).
        score = chance + random.gumbel(size=len(chance))
        score[chance.argmax()] = np.inf
        self.next = options[np.argsort(-score)[:ROWS]]

    def _options(self, newton: Floats, random: np.random.Generator) -> Floats:
        """Shifts that may be tried: Newton's, some near it, some around the best; none of where throws are refused."""
        near = newton + NEAR * random.standard_normal((OPTIONS, len(newton)))
        size = np.repeat(AROUND, OPTIONS)[:, None]
        around = self.best + size * random.standard_normal((len(size), len(newton)))
        options = np.clip(np.concatenate([newton[None], near, around]), -1.0, 1.0)
        good = options[self._to_be_had(options)]
        return good if len(good) > 0 else self.best[None]

    def _to_be_had(self, shift: Floats) -> Bools:
        """Which shifts (N, E) are nearer to one that was thrown than to one that was refused (N,)."""
        if len(self.refused) == 0:
            return np.full(len(shift), True)
        thrown, refused = (_nearest(shift, seen) for seen in (self.shift, self.refused))
        return thrown <= refused


def _nearest(shift: Floats, seen: Floats) -> Floats:
    return ((shift[:, None] - seen) ** 2).sum(axis=2).min(axis=1)


@final
class NewtonGoal:
    """Shift (E,) per thing thrown and place, from a map of the errors that is learned as well.

    In practice the rows of one batch that share a cell throw different shifts, which shows the Jacobian at once;
    without practice they throw the same one. After practice the best shift seen is kept, or Newton's where that
    promises less error though it was never thrown.

    Args:
        correction: what an action means, and which cell a throw belongs to.
    """

    name = "newton_goal"

    def __init__(self, correction: Correction) -> None:
        self._correction = correction
        weight = correction.scale / correction.tolerance
        self._weight: Floats = weight / np.sqrt(np.mean(weight**2))
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget every cell, reseed the spread of practice."""
        self._random = np.random.default_rng(seed)
        self._cells: dict[str, _Cell] = {}
        self._exploring, self._settled = False, False

    def begin_practice(self, throws: int) -> None:
        """Explore: throw where an improvement is likely, and different shifts in the rows of a batch."""
        self._exploring, self._settled = True, False

    def end_practice(self) -> None:
        """Keep to the best shifts that are known."""
        self._exploring, self._settled = False, True
        for cell in self._cells.values():
            cell.next = cell.kept[None]

    def act(self, observation: Observation) -> Actions:
        """The next shift of each throw's cell, zero where none was thrown yet: (N, E)."""
        action = np.zeros((len(observation.kind), self._correction.count))
        for name, rows in self._rows(observation).items():
            action[rows] = self._next(name, len(rows))
        return to_action(action * self._correction.scale, self._correction)

    def learn(self, outcome: Outcome) -> None:
        """Take in the throws, cell by cell; throws that were shortened or not measured teach where not to go."""
        usable = instructive(outcome)
        shift = outcome.action.astype(np.float64)
        error = np.clip(outcome.error / self._correction.scale, -LARGEST, LARGEST)
        for name, rows in self._rows(outcome.observation).items():
            cell = self._cells.setdefault(name, _Cell(self._weight))
            good = [row for row in rows if usable[row]]
            cell.add(shift[good], error[good], shift[[row for row in rows if not usable[row]]])
            cell.choose(self._random)
            if self._settled:
                cell.next = cell.kept[None]

    def state(self) -> State:
        """Names, throws and shifts of the cells."""
        cells = list(self._cells.values())
        none = np.zeros((0, self._correction.count))
        state: dict[str, np.ndarray] = {"cells": np.array(list(self._cells), dtype=np.str_)}
        for key in _TABLES:
            parts = [getattr(cell, key) for cell in cells]
            state[key] = np.concatenate([none, *parts])
            state[f"{key}_count"] = np.array([len(part) for part in parts], dtype=np.int64)
        for key in _CHOSEN:
            state[key] = np.array([getattr(cell, key) for cell in cells]).reshape(-1, self._correction.count)
        return state | {"settled": np.array(self._settled)}

    def restore(self, state: State) -> None:
        """Take over cells.

        Raises:
            UsageError: their shifts have another number of coordinates.
        """
        found, needed = state["shift"].shape[1], self._correction.count
        if found != needed:
            raise UsageError(f"what {self.name!r} learned are shifts of {found} numbers; here they have {needed}")
        self.reset(0)
        self._settled = bool(state["settled"])
        self._cells = {str(name): _Cell(self._weight) for name in state["cells"]}
        for key in _TABLES:
            rows, ends = np.asarray(state[key], dtype=np.float64), np.cumsum(state[f"{key}_count"])
            for cell, end, count in zip(self._cells.values(), ends, state[f"{key}_count"], strict=True):
                setattr(cell, key, rows[end - count : end])
        for key in _CHOSEN:
            for cell, shift in zip(self._cells.values(), np.asarray(state[key], dtype=np.float64), strict=True):
                setattr(cell, key, shift)

    def _rows(self, observation: Observation) -> dict[str, list[int]]:
        """Rows of each cell."""
        rows: dict[str, list[int]] = defaultdict(list)
        for row, (item, place) in enumerate(self._correction.cells(observation.features, observation.kind)):
            rows[f"{item}|{place}"].append(row)
        return rows

    def _next(self, name: str, count: int) -> Floats:
        """Shifts (count, E) of throws in one cell."""
        cell = self._cells.get(name)
        if cell is not None:
            return cell.next[np.arange(count) % len(cell.next) if self._exploring else np.zeros(count, dtype=int)]
        shift = np.zeros((count, self._correction.count))
        if self._exploring:
            shift[1:] = SPREAD * self._random.standard_normal((count - 1, self._correction.count))
        return shift
