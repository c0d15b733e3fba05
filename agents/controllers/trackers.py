"""What a shift does to the landing, learned from one throw after the other: an estimate of it for every row.

All are told `z`: how much further along and left of a throw its object came down than the static policy foresees. All
answer with how much of that they expect of another throw. Lengths in m, the throw's own frame; N rows, and throws as
observations without what they tell of the throw before.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import partial
from typing import Any, Final, Protocol, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.conveyor.observation import FEATURES, TABLE

from .ballistic import later_release
from .filters import BIN_CAMERA, NOISE, SURPRISE, Filters, landing
from .protocol import State

TURNING: Final = 0.02
"""Chance from pick to pick that what was constant begins to wander, or the other way round."""

Four: TypeAlias = tuple[float, float, float, float]


class Tracker(Protocol):
    """Estimates the effect of a shift in N rows."""

    def begin(self, rows: Bools) -> None:
        """Shifts begin in some rows (N,); where the number of rows is another than before, in all."""

    def learn(self, throws: Floats, z: Floats, rows: Bools) -> None:
        """Throws (N, D), of which some rows count, came down by z (N, 2) other than foreseen."""

    def study(self, throws: Floats, z: Floats, seed: int) -> None:
        """Practice is over: M throws (M, D), and z of each (M, 2)."""

    def state(self) -> State:
        """What was studied, as named arrays."""
        return {}

    def restore(self, state: State) -> None:
        """Take over what another one has studied."""

    @abstractmethod
    def effect(self, throws: Floats) -> Floats:
        """What is expected of coming throws (N, D): (N, 2)."""
        ...


@final
class Nothing(Tracker):
    """Expects nothing."""

    def effect(self, throws: Floats) -> Floats:
        """Zero (N, 2)."""
        return np.zeros((len(throws), 2))


@final
class RunningMean(Tracker):
    """The MLP minus the running mean of its errors in this shift; later throws count more.

    Args:
        rate: least weight of a new throw.
        prior: throws that the zero before the first one counts for.
    """

    def __init__(self, rate: float = 0.08, prior: float = 2.0) -> None:
        self._rate, self._prior = rate, prior
        self._mean, self._count = np.zeros((0, 2)), np.zeros(0)

    def begin(self, rows: Bools) -> None:
        """Forget."""
        if len(rows) != len(self._count):
            self._mean, self._count = np.zeros((len(rows), 2)), np.zeros(len(rows))
        self._mean[rows], self._count[rows] = 0.0, 0.0

    def learn(self, throws: Floats, z: Floats, rows: Bools) -> None:
        """Move towards z, a throw far off no further than one `SURPRISE` off."""
        self._count[rows] += 1.0
        weight = np.maximum(1.0 / (self._count + self._prior), self._rate)
        most = SURPRISE * np.array(NOISE)
        step = np.clip(z - self._mean, -most, most) * weight[:, None]
        self._mean = np.where(rows[:, None], self._mean + step, self._mean)

    def effect(self, throws: Floats) -> Floats:
        """The mean (N, 2)."""
        return self._mean.copy()


def lateness(plan: dict[str, Floats]) -> Floats:
    """How much further a release 1 s later comes down by decoded observations, to first order (N,) [m]."""
    little = 1e-3
    return later_release(plan, little) / little


def effects(throws: Floats, camera_x: float) -> Floats:
    """What a release 1 s later, a camera off by 1 m along x and y, and an encoder off by 1 do to landings (N, 2, 4).

    In closed form, to first order: a release that much later on the throw line; a grasp that is off takes the object's
    whole flight with it; an encoder's error has grown from the camera on. None is fitted to anything.

    Args:
        throws: observations (N, D).
        camera_x: where the camera sees objects [m].
    """
    seen = TABLE.decode(throws)
    far_x, far_y = seen["target_x"] - seen["pick_x"], seen["target_y"] - seen["pick_y"]
    size = np.maximum(np.hypot(far_x, far_y), 1e-9)
    ex, ey = far_x / size, far_y / size
    late = lateness(seen)
    way = seen["pick_x"] - camera_x
    along = np.stack([late, ex, ey, way * ex], axis=-1)
    across = np.stack([np.zeros_like(ex), -ey, ex, -way * ey], axis=-1)
    return np.stack([along, across], axis=1)


@final
class Kalman(Tracker):
    """The MLP minus the effect of valve delay, camera and encoder on this throw, which two Kalman filters estimate.

    The state is valve delay, camera x, camera y and encoder. One filter assumes constants, the other slow drift.

    Args:
        camera_x: where the camera sees objects [m].
        prior: standard deviations at the beginning of a shift, of delay [s], camera x and y [m] and encoder.
        walk: standard deviations of their change from pick to pick, where they wander.
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
        self._of = partial(Filters, priors=priors, beliefs=(0.5, 0.5), walks=walks, turning=TURNING, camera=noise)
        self._filters = self._of((0,))

    def begin(self, rows: Bools) -> None:
        """Back to the prior."""
        if len(rows) != len(self._filters.state):
            self._filters = self._of((len(rows),))
        self._filters.begin(np.flatnonzero(rows))

    def learn(self, throws: Floats, z: Floats, rows: Bools) -> None:
        """An update of both, where something is known; time passes everywhere."""
        here = np.flatnonzero(rows)
        self._filters.learn(here, effects(throws[here], self._camera_x), z[here])
        self._filters.wander()

    def effect(self, throws: Floats) -> Floats:
        """By the present estimate (N, 2)."""
        return landing(effects(throws, self._camera_x), self._filters.estimate(np.arange(len(throws))))


FOLLOWED: Final = ("release_speed", "elevation", "flight_time", "distance", "pick_x", "target_x")
"""Of the plan, what `RecursiveRidge` takes the effect to be linear in; with a constant."""
_COLUMNS: Final = [[one.name for one in FEATURES].index(name) for name in FOLLOWED]


@final
class RecursiveRidge(Tracker):
    """The MLP minus a recursive ridge regression of its errors on features of the plan.

    Args:
        forget: weight of a throw against the one after it.
        penalty: of the coefficients against the noise of a throw, in throws.
    """

    def __init__(self, forget: float = 0.98, penalty: float = 5.0) -> None:
        self._forget, self._penalty = forget, penalty
        self._left, self._right = np.zeros((0, 0, 0)), np.zeros((0, 0, 2))

    def begin(self, rows: Bools) -> None:
        """Forget all."""
        size = len(FOLLOWED) + 1
        if len(rows) != len(self._left):
            self._left, self._right = np.zeros((len(rows), size, size)), np.zeros((len(rows), size, 2))
        self._left[rows], self._right[rows] = 0.0, 0.0

    def learn(self, throws: Floats, z: Floats, rows: Bools) -> None:
        """Add a throw to the normal equations."""
        one, most = _regressors(throws), 3.0 * SURPRISE * np.array(NOISE)
        z = np.clip(z, -most, most)
        left = self._forget * self._left + one[:, :, None] * one[:, None, :]
        right = self._forget * self._right + one[:, :, None] * z[:, None, :]
        self._left = np.where(rows[:, None, None], left, self._left)
        self._right = np.where(rows[:, None, None], right, self._right)

    def effect(self, throws: Floats) -> Floats:
        """By the present fit (N, 2)."""
        one = _regressors(throws)
        weights = np.linalg.solve(self._left + self._penalty * np.eye(one.shape[1]), self._right)
        return np.einsum("nf,nfe->ne", one, weights)


def _regressors(throws: Floats) -> Floats:
    """A constant and what is `FOLLOWED`, as observations have it, (N, F)."""
    return np.concatenate([np.ones((len(throws), 1)), throws[:, _COLUMNS]], axis=1)


@final
class Known(Tracker):
    """Cheats: reads the hidden drift, and corrects its effect as `kalman` does. It does not correct draught.

    Args:
        core: the cells.
    """

    def __init__(self, core: Core) -> None:
        self._core: Any = core

    def effect(self, throws: Floats) -> Floats:
        """By what is so (N, 2)."""
        drift = self._core.context.drift
        state = np.concatenate([drift.delay[:, None], drift.camera, drift.encoder[:, None]], axis=1)
        return landing(effects(throws, self._core.config.belt.camera_x), state)
