"""Trackers of drift, and corrections of unseen kinds of items: both are estimated throw by throw from landings.

A tracker receives `z`: the landing of a throw minus the landing that the static policy predicts, along and left of the
throw. It returns the expected z of other throws. Lengths in m, in the throw's own frame; N rows. Throws are
observations without the feedback of the previous throw.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import partial
from typing import Any, Final, Protocol, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.observation import FEATURES, TABLE
from pnt_gym.constants import GRAVITY

from .filters import BIN_CAMERA, NOISE, SURPRISE, Filters, landing_noise, landing_offset
from .protocol import State

TURNING: Final = 0.02
"""Probability from pick to pick that a constant state begins to wander, or the reverse."""

Four: TypeAlias = tuple[float, float, float, float]


class Tracker(Protocol):
    """Estimates the effect of a shift of picks in N rows."""

    def begin(self, rows: Bools) -> None:
        """Begin shifts in some rows (N,); in all rows if their number has changed."""

    def learn(self, throws: Floats, z: Floats, rows: Bools) -> None:
        """Learn from throws (N, D) with landing errors z (N, 2) in the selected rows (N,)."""

    def study(self, throws: Floats, z: Floats, shift: Ints, seed: int) -> None:
        """Learn from the whole practice: throws (M, D), landing errors z (M, 2), and numbers of shifts (M,)."""

    def state(self) -> State:
        """Learned values of `study`, as named arrays."""
        return {}

    def restore(self, state: State) -> None:
        """Load the state of another tracker."""

    @abstractmethod
    def effect(self, throws: Floats) -> Floats:
        """Expected landing errors of coming throws (N, D): (N, 2)."""
        ...


@final
class NoTracker(Tracker):
    """Tracker that expects no effect."""

    def effect(self, throws: Floats) -> Floats:
        """Zeros (N, 2)."""
        return np.zeros((len(throws), 2))


@final
class RunningMean(Tracker):
    """Mean of z over the shift, with more weight on later throws.

    Args:
        rate: least weight of a new throw.
        prior: number of throws for which the initial zero counts.
    """

    def __init__(self, rate: float = 0.08, prior: float = 2.0) -> None:
        self._rate, self._prior = rate, prior
        self._mean, self._count = np.zeros((0, 2)), np.zeros(0)

    def begin(self, rows: Bools) -> None:
        """Reset the mean of some rows."""
        if len(rows) != len(self._count):
            self._mean, self._count = np.zeros((len(rows), 2)), np.zeros(len(rows))
        self._mean[rows], self._count[rows] = 0.0, 0.0

    def learn(self, throws: Floats, z: Floats, rows: Bools) -> None:
        """Move the mean towards z; a far landing counts as `SURPRISE` deviations off."""
        self._count[rows] += 1.0
        weight = np.maximum(1.0 / (self._count + self._prior), self._rate)
        limit = SURPRISE * np.array(NOISE)
        step = np.clip(z - self._mean, -limit, limit) * weight[:, None]
        self._mean = np.where(rows[:, None], self._mean + step, self._mean)

    def effect(self, throws: Floats) -> Floats:
        """The mean (N, 2)."""
        return self._mean.copy()


def later_release(plan: dict[str, Floats], delay: float) -> Floats:
    """Change of the landing distance (N,) [m] for a release that is later on its line by `delay` [s], without drag.

    Args:
        plan: decoded observations; `release_speed`, `elevation` and `flight_time` are read.
        delay: delay of the release [s].
    """
    speed, angle, flight = plan["release_speed"], plan["elevation"], plan["flight_time"]
    late = speed * delay
    # Drag-free flight from height z: t = (w + sqrt(w^2 + 2 g z)) / g with the vertical velocity w.
    rise = speed * np.sin(angle)
    drop = 0.5 * GRAVITY * flight**2 - rise * flight  # release height above the rim
    # A release that never reaches the rim lands nowhere; the apex is used instead.
    heights = (drop, drop + late * np.sin(angle))
    before, after = (np.sqrt(np.maximum(rise**2 + 2.0 * GRAVITY * z, 0.0)) for z in heights)
    return late * np.cos(angle) + speed * np.cos(angle) * (after - before) / GRAVITY


def delay_effect(plan: dict[str, Floats]) -> Floats:
    """Change of the landing distance per second of release delay, to first order (N,) [m/s]."""
    little = 1e-3
    return later_release(plan, little) / little


def drift_effects(throws: Floats, camera_x: float) -> Floats:
    """Effects of 1 s delay, 1 m camera offset along x and y, and an encoder error of 1 on landings (N, 2, 4).

    In closed form, to first order: a later release on the throw line; a grasp offset shifts the whole flight; an
    encoder's error grows from the camera on. No value is fitted. The swing under soft lips is left out: in the full
    physics of `waste` an offset along y has 0.8 of this effect.

    Args:
        throws: observations (N, D).
        camera_x: place where the camera sees objects [m].
    """
    features = TABLE.decode(throws)
    throw_x, throw_y = features["target_x"] - features["pick_x"], features["target_y"] - features["pick_y"]
    size = np.maximum(np.hypot(throw_x, throw_y), 1e-9)
    ex, ey = throw_x / size, throw_y / size
    delay = delay_effect(features)
    ride = features["pick_x"] - camera_x
    along = np.stack([delay, ex, ey, ride * ex], axis=-1)
    across = np.stack([np.zeros_like(ex), -ey, ex, -ride * ey], axis=-1)
    return np.stack([along, across], axis=1)


@final
class Kalman(Tracker):
    """Kalman filters of release delay, camera along x and y, and encoder, with their physical effects on throws.

    Two filters: one assumes constant states, the other a random walk.

    Args:
        camera_x: place where the camera sees objects [m].
        prior: standard deviations at the beginning of a shift, of delay [s], camera x and y [m] and encoder.
        walk: standard deviations of the change from pick to pick in the random walk.
        noise: standard deviation of the camera over the bins, along and across, by its data sheet [m].
    """

    def __init__(
        self,
        camera_x: float,
        prior: Four = (0.004, 0.008, 0.008, 0.008),
        walk: Four = (0.0012, 0.0014, 0.0014, 0.0010),
        noise: float = BIN_CAMERA,
    ) -> None:
        priors = np.tile(np.diag(np.square(prior)), (2, 1, 1))
        walks = np.stack([np.zeros((4, 4)), np.diag(np.square(walk))])
        self._camera_x = camera_x
        self._make_filters = partial(
            Filters, priors=priors, beliefs=(0.5, 0.5), walks=walks, turning=TURNING, noise=landing_noise(noise)
        )
        self._filters = self._make_filters((0,))

    def begin(self, rows: Bools) -> None:
        """Reset some rows to the prior."""
        if len(rows) != len(self._filters.state):
            self._filters = self._make_filters((len(rows),))
        self._filters.begin(np.flatnonzero(rows))

    def learn(self, throws: Floats, z: Floats, rows: Bools) -> None:
        """Update both filters in the selected rows; the random walk advances in every row."""
        selected = np.flatnonzero(rows)
        effect = drift_effects(throws[selected], self._camera_x)
        self._filters.learn(selected, effect[:, None], z[selected, None])

    def effect(self, throws: Floats) -> Floats:
        """Effect by the present estimate (N, 2)."""
        return landing_offset(drift_effects(throws, self._camera_x), self._filters.estimate(np.arange(len(throws))))


RIDGE_FEATURES: Final = ("release_speed", "elevation", "flight_time", "distance", "pick_x", "target_x")
"""Features of the plan in which the effect of `RecursiveRidge` is linear, beside a constant."""
_COLUMNS: Final = [[feature.name for feature in FEATURES].index(name) for name in RIDGE_FEATURES]


@final
class RecursiveRidge(Tracker):
    """The MLP minus a recursive ridge regression of its errors on features of the plan.

    Args:
        forget: weight of a throw relative to the next one.
        penalty: penalty of the coefficients against the noise of a throw, in throws.
    """

    def __init__(self, forget: float = 0.98, penalty: float = 5.0) -> None:
        self._forget, self._penalty = forget, penalty
        self._left, self._right = np.zeros((0, 0, 0)), np.zeros((0, 0, 2))

    def begin(self, rows: Bools) -> None:
        """Reset the fit of some rows."""
        size = len(RIDGE_FEATURES) + 1
        if len(rows) != len(self._left):
            self._left, self._right = np.zeros((len(rows), size, size)), np.zeros((len(rows), size, 2))
        self._left[rows], self._right[rows] = 0.0, 0.0

    def learn(self, throws: Floats, z: Floats, rows: Bools) -> None:
        """Add a throw to the normal equations."""
        regressors, limit = _regressors(throws), 3.0 * SURPRISE * np.array(NOISE)
        z = np.clip(z, -limit, limit)
        left = self._forget * self._left + regressors[:, :, None] * regressors[:, None, :]
        right = self._forget * self._right + regressors[:, :, None] * z[:, None, :]
        self._left = np.where(rows[:, None, None], left, self._left)
        self._right = np.where(rows[:, None, None], right, self._right)

    def effect(self, throws: Floats) -> Floats:
        """Effect by the present fit (N, 2)."""
        regressors = _regressors(throws)
        weights = np.linalg.solve(self._left + self._penalty * np.eye(regressors.shape[1]), self._right)
        return np.einsum("nf,nfe->ne", regressors, weights)


def _regressors(throws: Floats) -> Floats:
    """A constant and the `RIDGE_FEATURES` of observations, (N, F)."""
    return np.concatenate([np.ones((len(throws), 1)), throws[:, _COLUMNS]], axis=1)


@final
class OracleTracker(Tracker):
    """Oracle tracker: reads the true drift of the cells, and predicts its effect as `Kalman` does, without draught.

    Args:
        core: core with the cells.
    """

    def __init__(self, core: Core) -> None:
        self._core: Any = core

    def effect(self, throws: Floats) -> Floats:
        """Effect of the true drift (N, 2)."""
        drift = self._core.context.drift
        state = np.concatenate([drift.delay[:, None], drift.camera, drift.encoder[:, None]], axis=1)
        return landing_offset(drift_effects(throws, self._core.config.belt.camera_x), state)


PRIOR: Final = (0.008, 0.008, 0.003)
"""Standard deviations of a kind's landing error: delay of the release [s]; offset along and across the throw for any
other reason, such as the depth of the centre of mass or drag [m]."""
LIKE_OTHERS: Final = 0.35
"""Factor on `PRIOR` for a kind that behaves like the known kinds."""
SHARE: Final = 0.2
"""Prior probability that a kind behaves like the known kinds."""


@final
class UnseenKinds:
    """Landing errors of unseen kinds, for every kind in every row; zero for known kinds.

    Args:
        is_known: whether the policy has learned each kind (K,).
    """

    def __init__(self, is_known: Bools) -> None:
        self._is_known = is_known
        self._begin(0)

    def is_unseen(self, kind: Ints) -> Bools:
        """Whether objects (N,) are of an unseen kind."""
        return ~self._is_known[kind]

    def learn(self, kind: Ints, throws: Floats, z: Floats, rows: Bools) -> None:
        """Update by throws (N, D) of kinds (N,) with landing errors z (N, 2) [m], in the rows that are selected."""
        if len(self._filters.state) != len(kind):
            self._begin(len(kind))
        selected = np.flatnonzero(rows & self.is_unseen(kind))
        effect = _effects(throws[selected])
        self._filters.learn((selected, kind[selected]), effect[:, None], z[selected, None])

    def effect(self, kind: Ints, throws: Floats) -> Floats:
        """Expected landing errors of throws (N, D) of kinds (N,): (N, 2) [m]."""
        if len(self._filters.state) != len(kind):
            self._begin(len(kind))
        return landing_offset(_effects(throws), self._filters.estimate((np.arange(len(kind)), kind)))

    def _begin(self, count: int) -> None:
        variances = np.square(PRIOR)
        priors = np.stack([np.diag(LIKE_OTHERS**2 * variances), np.diag(variances)])
        self._filters = Filters(
            (count, len(self._is_known)), priors, (SHARE, 1.0 - SHARE), noise=landing_noise(BIN_CAMERA)
        )


def _effects(throws: Floats) -> Floats:
    """Effects of a release 1 s later, and 1 m further along and across, on landings (N, 2, 3)."""
    effects_array = np.zeros((len(throws), 2, 3))
    effects_array[:, 0, 0], effects_array[:, 0, 1], effects_array[:, 1, 2] = (
        delay_effect(TABLE.decode(throws)),
        1.0,
        1.0,
    )
    return effects_array
