"""Shapes of the arm's acceleration over time, with their integrals: the families of motions that `batch` plans from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats

INTERVALS: Final = 10
"""n of the spline (Miyashita et al., section 4.5)."""


@final
@dataclass(frozen=True, eq=False)
class Shapes:
    """K shapes over a unit of time, linear between the borders of n intervals.

    Attributes:
        values: accelerations at the borders (K, n + 1).
        per_interval: samples in each interval; the end of the last interval is a sample too.
        accelerations: accelerations at the M samples (K, M).
        speeds: first integral at the samples (K, M).
        angles: second integral at the samples (K, M).
    """

    values: Floats
    per_interval: int = 1
    accelerations: Floats = field(init=False)
    speeds: Floats = field(init=False)
    angles: Floats = field(init=False)

    def __post_init__(self) -> None:
        intervals = self.values.shape[1] - 1
        step = 1.0 / intervals
        before, rise = self.values[:, :-1], np.diff(self.values, axis=1)
        # Exact integrals of an acceleration that is linear in an interval.
        speed = _running_sum(step * (before + 0.5 * rise))
        angle = _running_sum(step * (speed[:, :-1] + step * (0.5 * before + rise / 6.0)))
        share = np.arange(self.per_interval) / self.per_interval
        s, t = share, share * step
        b, r = before[..., None], rise[..., None]
        v, w = speed[:, :-1, None], angle[:, :-1, None]
        inner = (
            (b + s * r, self.values),
            (v + t * (b + 0.5 * s * r), speed),
            (w + t * (v + t * (0.5 * b + s * r / 6.0)), angle),
        )
        for name, (samples, borders) in zip(("accelerations", "speeds", "angles"), inner, strict=True):
            whole = np.concatenate([samples.reshape(samples.shape[0], -1), borders[:, -1:]], axis=1)
            # The class is frozen; fields that follow from others are set here once.
            object.__setattr__(self, name, whole)

    @property
    def last(self) -> Floats:
        """Acceleration at the end (K,)."""
        return self.values[:, -1]

    @property
    def gain(self) -> Floats:
        """Speed at the end (K,)."""
        return self.speeds[:, -1]

    @property
    def way(self) -> Floats:
        """Angle at the end (K,)."""
        return self.angles[:, -1]

    def with_samples(self, per_interval: int) -> Shapes:
        """Return the same shapes with more samples."""
        return Shapes(self.values, per_interval)


def _running_sum(increments: Floats) -> Floats:
    return np.concatenate([np.zeros_like(increments[:, :1]), np.cumsum(increments, axis=1)], axis=1)


@final
@dataclass(frozen=True, eq=False)
class Family:
    """K families of motions: the acceleration is ``base`` [rad/s2] plus a multiple of ``lift``.

    Attributes:
        lift: K shapes, scaled to reach the speed of the release.
        base: K shapes, added without scaling; None for no base.
    """

    lift: Shapes
    base: Shapes | None = None

    @property
    def size(self) -> int:
        """The number K."""
        return self.lift.values.shape[0]

    def with_samples(self, per_interval: int) -> Family:
        """Return the same family with more samples."""
        return Family(self.lift.with_samples(per_interval), self.base.with_samples(per_interval) if self.base else None)


HELD: Final = tuple((1.0,) * (INTERVALS - 1) + tail for tail in ((1.0, 0.75), (0.9, 0.7), (0.8, 0.5)))
"""Constant shapes that fall at the end, where the torque limit falls with the speed."""
SWINGS: Final = (
    (-20.0, -24.0, -31.0, -48.0, -17.0, 12.0, 33.0, 42.0, 46.0),
    (-30.0, -33.0, -40.0, -25.0, -8.0, 7.0, 18.0, 24.0, 28.0),
    (-15.0, -17.0, -21.0, -32.0, -40.0, -18.0, 26.0, 42.0, 46.0),
    (-11.0, -13.0, -19.0, -30.0, -48.0, -45.0, 12.0, 50.0, 60.0),
)
"""Swings back [rad/s2] up to the last border but two: down as fast as the grasp allows, then a gentle turn upwards.

Rounded from optima of the nonlinear programme for low releases with the paper's arm."""
STRENGTHS: Final = (0.5, 0.7, 0.85, 1.0, 1.2, 1.5)
BURSTS: Final = ((1.0, 1.0), (1.0, 0.5), (0.5, 1.0), (0.2, 1.0), (0.0, 1.0), (0.5, 1.0, 0.9), (1.0, 1.0, 1.0, 1.0))
RAMPS: Final = (0.0, 1.0, 3.0)
"""Intervals in which a shape rises from zero to a straight line; a ramp of 0 starts at full height."""
TILTS: Final = (-0.6, 0.0, 0.6, 1.2)
"""Gains of these straight lines from the start to the end."""
_TIMES: Final = np.arange(INTERVALS + 1.0)
RISES: Final = Family(
    Shapes(
        np.array(
            [
                *(
                    # The bound of the ramp only avoids 0 / 0.
                    np.where(ramp > _TIMES, _TIMES / max(ramp, 1.0), 1.0) * (1.0 + tilt * (_TIMES / INTERVALS - 0.5))
                    for ramp in RAMPS
                    for tilt in TILTS
                ),
                *HELD,
            ]
        )
    )
)
_BACKSWINGS: Final = [(swing, strength, burst) for swing in SWINGS for strength in STRENGTHS for burst in BURSTS]
BACKSWINGS: Final = Family(
    lift=Shapes(np.array([[*[0.0] * (INTERVALS + 1 - len(burst)), *burst] for _, _, burst in _BACKSWINGS])),
    base=Shapes(np.array([strength * np.array([*swing, swing[-1], swing[-1]]) for swing, strength, _ in _BACKSWINGS])),
)
"""Each swing back at each strength as base, and each burst at the last borders as lift."""
