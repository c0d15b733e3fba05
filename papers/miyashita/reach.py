"""Search for goals that a release of the one-joint thrower reaches: a scan of simulated releases, then refinement."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.cells.one_joint.config import LOWEST_GOAL, OneJointConfig
from pnt_gym.cells.one_joint.hidden import Hidden, expected_hidden
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.one_joint import ThrowPlans, plan_releases

from .cases import ARM, BLOCK, feasible_goals, make_plant, misses, simulate_flights

WITHIN: Final = (0.005, 2.0)
"""Tolerances within which a goal is reached: position [m] and angle [deg]."""
SCALES: Final = {"position": 1.0, "angle": 0.14, "speed": 0.0}
"""Weights T of the state errors: 5 mm and 2 deg weigh the same, and any vertical speed is allowed."""
LOW: Final = np.array([ARM.angle[0], 3.0, 0.06])
"""Lower ends of the range of releases: theta_t [rad], omega_t [rad/s] and l_t [m]."""
HIGH: Final = np.array([ARM.angle[1], ARM.speed, np.hypot(ARM.largest_radius(BLOCK), BLOCK.half_height)])
"""Upper ends of the range of releases."""
FLIGHT: Final = 0.45
"""Simulated time of each flight [s]."""
SPACING: Final = 0.004
"""Time between two states along a flight [s]."""
SCANNED: Final = 1024
"""Number of releases in the scan."""
STARTS: Final = 3
"""Greatest number of releases from which a goal's search begins; any two differ by `APART`."""
APART: Final = 0.08
"""Least difference of two starts, in shares of the range."""
HOPELESS: Final = 12.0
"""Miss of the scan's best release, as a multiple of the tolerances, above which a goal is not searched for."""
ENOUGH: Final = 0.3
"""Miss, as a multiple of the tolerances, below which a release is not refined further."""
ROUNDS: Final = 4
"""Rounds of refinement, each with new simulated throws."""
NEIGHBOURS: Final = 30
"""Number of simulated releases between which the flight of a new release is interpolated."""
WIDTH: Final = 0.2
"""Width of the interpolation's kernel, in shares of the range."""
SMOOTHING: Final = 1e-4
"""Term on the diagonal of the interpolation's matrix, as releases may coincide."""
ITERATIONS: Final = 10
"""Gauss-Newton steps on the interpolated flights in each round."""
STEP: Final = 0.08
"""Largest Gauss-Newton step, in shares of the range."""
NUDGE: Final = 0.002
"""Finite difference for the slopes, in shares of the range."""
TOGETHER: Final = 256
"""Number of throws in one simulated batch."""


@final
@dataclass(frozen=True)
class BestReleases:
    """Best releases for N goals.

    Attributes:
        share: the releases in shares of the range `LOW` to `HIGH` (N, 3).
        miss: miss of each release as a multiple of the tolerances `WITHIN` (N,).
    """

    share: Floats
    miss: Floats

    def improve(self, goal_rows: Ints, share: Floats, miss: Floats) -> BestReleases:
        """The best of these and of S further releases (S, 3), which miss goals ``goal_rows`` (S,) by ``miss`` (S,)."""
        order = np.argsort(-miss)  # a goal's best release comes last and overwrites the others
        better = order[miss[order] < self.miss[goal_rows[order]]]
        best, least = self.share.copy(), self.miss.copy()
        best[goal_rows[better]], least[goal_rows[better]] = share[better], miss[better]
        return BestReleases(best, least)


def size(error: Floats) -> Floats:
    """Errors (..., 4) as multiples of the tolerances `WITHIN` (...,): the larger of position and angle."""
    norms = misses(error)
    return np.maximum(norms.position / WITHIN[0], norms.angle / WITHIN[1])


def goals_above_arm(count: int) -> Floats:
    """Random goals (count, 4) that have a feasible throw and lie above the upper side of the stopped arm.

    To a goal below, the block would have to pass through the arm or fall on the arm. Goals lower than a level's lowest
    goal are left out.
    """
    goals, plans = feasible_goals(3 * count + 16)
    stop = plans.motion.stop_angle
    # Height of the goal over the arm's surface: the goal turned by -stop about the pivot.
    height = np.cos(stop) * goals[:, 1] - np.sin(stop) * goals[:, 0]
    clear = float(np.hypot(BLOCK.half_length, BLOCK.half_height))
    return goals[(height >= clear) & (goals[:, 1] >= LOWEST_GOAL)][:count]


def paths(config: OneJointConfig, share: Floats, seed: int | None = None) -> Floats:
    """States (N, T, 4) of simulated flights every `SPACING` from the release on; each release needs a motion.

    Args:
        config: configuration of the cell with all unmodelled effects.
        share: releases in shares of the range (N, 3).
        seed: seed of the placement's scatter; None for no scatter.
    """
    count, hidden = len(share), expected_hidden(len(share), config)
    if seed is not None:
        spread = config.mismatch * config.errors.placement
        hidden = replace(hidden, radius=hidden.radius + spread * np.random.default_rng(seed).standard_normal(count))
    plans = plan_releases(_release_states(share))
    chunks = (slice(first, first + TOGETHER) for first in range(0, count, TOGETHER))
    return np.concatenate([_simulate_paths(config, take(plans, rows), take(hidden, rows)) for rows in chunks])


def _simulate_paths(config: OneJointConfig, plans: ThrowPlans, hidden: Hidden) -> Floats:
    rows = np.arange(len(plans.u))
    flight = simulate_flights(make_plant(config, len(rows)), plans, hidden)
    later = np.round(np.arange(1, round(FLIGHT / SPACING) + 1) * SPACING / flight.step).astype(np.int64)
    sample = flight.clock.release_step[:, None] + later
    # The engine's speed is the mean over the step, so half a step of gravity leads to its end.
    rate = flight.velocity[rows[:, None], sample][..., 1:2] - 0.5 * flight.step * GRAVITY
    return np.concatenate([flight.pose[rows[:, None], sample], rate], axis=2)


def errors(path: Floats, goal: Floats) -> Floats:
    """Errors (N, 4) of flights (N, T, 4) at the state nearest to the goal (N, 4), by a parabola of three states."""
    difference = path - goal[:, None]
    distance = ((difference * np.array([SCALES["position"], SCALES["position"], SCALES["angle"], 0.0])) ** 2).sum(
        axis=2
    )
    rows, best = np.arange(len(path)), np.clip(distance.argmin(axis=1), 1, path.shape[1] - 2)
    left, middle, right = (distance[rows, best + i] for i in (-1, 0, 1))
    bend = left - 2.0 * middle + right
    part = np.clip(0.5 * (left - right) / np.where(bend > 0.0, bend, np.inf), -1.0, 1.0)[:, None]
    a, b, c = (difference[rows, best + i] for i in (-1, 0, 1))
    return b + 0.5 * part * (c - a) + 0.5 * part**2 * (a - 2.0 * b + c)


@final
class Search:
    """A search for releases that reach goals, by simulated throws; each search reuses the throws of earlier searches.

    Args:
        config: configuration of the cell.
        scanned: number of releases all over the range in the first scan.
    """

    def __init__(self, config: OneJointConfig, scanned: int = SCANNED) -> None:
        from scipy.stats import qmc  # noqa: PLC0415 - heavy, needed for this search only

        self._config = config
        drawn: Floats = qmc.Sobol(3, seed=9).random(scanned)  # pyright: ignore[reportCallIssue] - the name in scipy 1.14
        self._share = drawn[has_motion(drawn)]
        self._path = paths(config, self._share)

    def __len__(self) -> int:
        return len(self._share)

    def reach(self, goal: Floats) -> BestReleases:
        """The best releases for goals (N, 4), of all simulated releases and of rounds of Gauss-Newton steps."""
        missed = np.stack([size(errors(self._path, np.tile(row, (len(self), 1)))) for row in goal])
        best = BestReleases(self._share[missed.argmin(axis=1)], missed.min(axis=1))
        chosen = [self._choose_starts(row) for row in missed]
        start, goal_rows = (
            self._share[np.concatenate(chosen)],
            np.repeat(np.arange(len(goal)), [len(c) for c in chosen]),
        )
        for _ in range(ROUNDS):
            unsolved = best.miss[goal_rows] > ENOUGH
            start, goal_rows = start[unsolved], goal_rows[unsolved]
            if len(start) == 0:
                break
            start = self._improve(start, goal[goal_rows])
            path = paths(self._config, start)
            self._share, self._path = np.concatenate([self._share, start]), np.concatenate([self._path, path])
            best = best.improve(goal_rows, start, size(errors(path, goal[goal_rows])))
        return best

    def _choose_starts(self, missed: Floats) -> Ints:
        """Indices of starts for a goal that the releases miss by ``missed`` (M,): the nearest that differ enough."""
        starts: list[int] = []
        for row in missed.argsort():
            if missed[row] >= HOPELESS or len(starts) == STARTS:
                break
            if all(np.abs(self._share[row] - self._share[start]).max() > APART for start in starts):
                starts.append(int(row))
        return np.array(starts, dtype=np.int64)

    def _improve(self, share: Floats, goal: Floats) -> Floats:
        """Releases (N, 3) after damped Gauss-Newton steps on interpolated flights, unchanged where no motion exists."""
        residual = self._residual(goal)
        current, damping = share, np.full(len(share), 1e-2)
        error = residual(current)
        for _ in range(ITERATIONS):
            # Forward differences on the interpolated flights, which cost no simulation.
            slopes = np.stack([(residual(current + way) - error) / NUDGE for way in NUDGE * np.eye(3)], axis=2)
            trial = np.clip(current + _gauss_newton_step(error, slopes, damping), 1e-3, 1.0 - 1e-3)
            trial_error = residual(trial)
            is_better = (trial_error**2).sum(axis=1) < (error**2).sum(axis=1)
            current, error = (
                np.where(is_better[:, None], trial, current),
                np.where(is_better[:, None], trial_error, error),
            )
            # Levenberg and Marquardt: less damping after a success, much more after a failure.
            damping = np.clip(np.where(is_better, 0.3, 6.0) * damping, 1e-7, 1e4)
        return np.where(has_motion(current)[:, None], current, share)

    def _residual(self, goal: Floats) -> Callable[[Floats], Floats]:
        """Function from releases (N, 3) to errors of interpolated flights (N, 3), as multiples of the tolerances."""
        from scipy.interpolate import RBFInterpolator  # noqa: PLC0415 - heavy, needed for this search only

        # This kernel needs no plane through the neighbours, which may all lie at the same limit of the arm.
        model = RBFInterpolator(
            self._share,
            self._path.reshape(len(self), -1),
            neighbors=min(NEIGHBOURS, len(self)),
            kernel="multiquadric",
            epsilon=1.0 / WIDTH,
            degree=0,
            smoothing=SMOOTHING,
        )

        def residual(releases: Floats) -> Floats:
            error = errors(model(releases).reshape(len(releases), *self._path.shape[1:]), goal)[:, :3]
            return error / np.array([WITHIN[0], WITHIN[0], np.deg2rad(WITHIN[1])])

        return residual


def has_motion(share: Floats) -> Bools:
    """Whether each of the releases (N, 3) has a motion from rest (N,)."""
    return plan_releases(_release_states(share)).feasible


def _release_states(share: Floats) -> Floats:
    return np.column_stack([LOW + (HIGH - LOW) * share, np.full(len(share), FLIGHT)])


def _gauss_newton_step(error: Floats, slopes: Floats, damping: Floats) -> Floats:
    """Damped Gauss-Newton steps (N, 3), -(J^T J + D)^-1 J^T r, shortened to `STEP`."""
    square = np.einsum("nij,nik->njk", slopes, slopes)
    # The damping is relative to the mean of the diagonal of J^T J, so that its strength does not depend on units.
    damping_matrix = (damping * np.einsum("nii->n", square) / 3.0 + 1e-9)[:, None, None] * np.eye(3)
    step = -np.linalg.solve(square + damping_matrix, np.einsum("nij,ni->nj", slopes, error)[..., None])[..., 0]
    return step * np.minimum(1.0, STEP / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
