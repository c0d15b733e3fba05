"""The accessible space: which poses a throw can reach with a given vertical speed (Miyashita et al. 2010, Fig. 8)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.planning.arrays import Floats, Ints
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.planning.one_joint._flight import land
from pnt_gym.planning.one_joint.batch import plan_releases
from pnt_gym.planning.one_joint.grasp import acceleration_window
from pnt_gym.planning.one_joint.parameters import Arm, Block

CELL: Final = (0.02, 0.02, float(np.deg2rad(5.0)))
"""Size of a cell in x, y [m] and phi [rad] (section 4.5)."""
SAMPLES: Final = (320, 240, 120)
"""Releases sampled: angles, speeds and radii. Twice as many of each find a few per cent more cells at the rim."""
SPAN: Final = 1 << 20
"""More cells than there are in any direction."""


@final
@dataclass(frozen=True, eq=False)
class AccessibleSpace:
    """The cells of a grid that throws reach; cell (i, j, k) begins at i, j, k times the cell's size.

    Attributes:
        kinematic: cells within the arm's geometry and largest speed (K, 3).
        grasp: those of them with a release whose acceleration window is open (K, 3).
        cells: those of them to which a motion from rest was planned (K, 3).
        u: a release for each of ``cells`` (K, 4).
        size: of a cell in x, y [m] and phi [rad].
    """

    kinematic: Ints
    grasp: Ints
    cells: Ints
    u: Floats
    size: tuple[float, float, float]

    @property
    def centres(self) -> Floats:
        """Middle of each reachable cell (K, 3) [m, m, rad]."""
        return np.asarray((self.cells + 0.5) * np.array(self.size), dtype=np.float64)


class _Samples(NamedTuple):
    """Releases (K, 4), the cell each lands in (K,), and how much of the arm's run-up it needs (K,)."""

    u: Floats
    key: Ints
    effort: Floats

    def easiest(self) -> _Samples:
        """The one release of each cell that needs the least effort."""
        order = np.lexsort((self.effort, self.key))
        first = order[np.concatenate([[True], np.diff(self.key[order]) > 0])] if order.size else order
        return _Samples(self.u[first], self.key[first], self.effort[first])


def accessible_space(
    dy: float = 0.0,
    *,
    arm: Arm | None = None,
    block: Block | None = None,
    size: tuple[float, float, float] = CELL,
    samples: tuple[int, int, int] = SAMPLES,
) -> AccessibleSpace:
    """Return the cells (x, y, phi) that throws reach with the vertical speed ``dy`` [m/s].

    A cell counts when one of the sampled releases lands in it and, of those the motor can hold, the one that asks for
    the least run-up has a plan from rest. A lower rating of the motor is a lower ``arm.torque``.

    Args:
        dy: vertical speed at the goal [m/s].
        arm: the paper's when not given.
        block: the paper's when not given.
        size: of a cell in x, y [m] and phi [rad].
        samples: angles, speeds and radii of the sampled releases.

    Raises:
        ValueError: dy is not finite, or a size or number of samples is not positive.
    """
    if not np.isfinite(dy):
        raise ValueError(f"dy is {dy}; it must be finite [m/s]")
    if min(size) <= 0.0 or min(samples) < 1:
        raise ValueError(f"sizes and samples must be positive, got {size} and {samples}")
    arm, block = arm or Arm(), block or Block()
    kinematic: list[Ints] = []
    held: list[_Samples] = []
    for every in _landings(dy, arm, block, size, samples):
        kinematic.append(np.unique(every.key))
        open_window = np.isfinite(every.effort)
        held.append(_Samples(every.u[open_window], every.key[open_window], every.effort[open_window]).easiest())
    best = _Samples(
        np.concatenate([part.u for part in held]),
        np.concatenate([part.key for part in held]),
        np.concatenate([part.effort for part in held]),
    ).easiest()
    good = plan_releases(best.u, arm=arm, block=block).feasible
    return AccessibleSpace(
        _cells(np.unique(np.concatenate(kinematic))), _cells(best.key), _cells(best.key[good]), best.u[good], size
    )


def _landings(
    dy: float, arm: Arm, block: Block, size: tuple[float, float, float], samples: tuple[int, int, int]
) -> Iterator[_Samples]:
    """The releases at each sampled angle; the effort is infinite where no acceleration window is open."""
    angles, speeds, radii = (
        low + (high - low) * (np.arange(count) + 0.5) / count
        for (low, high), count in zip(
            (arm.angle, (0.0, arm.speed), (0.0, arm.largest_radius(block))), samples, strict=True
        )
    )
    speed, radius = (axis.ravel() for axis in np.meshgrid(speeds, radii, indexing="ij"))
    for angle in angles:
        cosine, sine = float(np.cos(angle)), float(np.sin(angle))
        time = ((radius * cosine - block.half_height * sine) * speed - dy) / GRAVITY
        flies = time > 0.0
        w, r, t = speed[flies], radius[flies], time[flies]
        u = np.stack([np.full(w.shape, angle), w, np.hypot(r, block.half_height), t], axis=1)
        window = acceleration_window(u[:, 0], w, r, arm, block)
        # Share of the way from the lower end of the range that the strongest motion from rest takes.
        effort = w * w / (2.0 * np.maximum(window.high, 1e-9) * (angle - arm.angle[0]))
        yield _Samples(u, _key(land(u, block.half_height), size), np.where(window.is_open, effort, np.inf))


def _key(z: Floats, size: tuple[float, float, float]) -> Ints:
    """One number for the cell of each landing state (K, 4); indices may be negative."""
    cell = np.floor(z[:, :3] / np.array(size)).astype(np.int64) + SPAN // 2
    return (cell[:, 0] * SPAN + cell[:, 1]) * SPAN + cell[:, 2]


def _cells(key: Ints) -> Ints:
    return np.stack([key // SPAN**2, key // SPAN % SPAN, key % SPAN], axis=1) - SPAN // 2
