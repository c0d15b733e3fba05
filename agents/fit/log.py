"""The log of throws: one row a throw, what the cell knew before it and what came of it, as a CSV file.

World frame of the cell, SI units and radians. `COLUMNS` is the form; a column of NaN was not measured.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, join_columns
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.shift import CAMERA_ERRORS
from pnt_gym.planning.straight.plan import ReleaseBatch


class Column(NamedTuple):
    """A column of a log."""

    unit: str
    text: str
    required: bool = False
    positive: bool = False


COLUMNS: Final[dict[str, Column]] = {
    "item": Column("-", "item that the cell took the object for, by its name in the level", True),
    "pick_x": Column("m", "place of the lift along the belt: cup's tip, as commanded", True),
    "pick_y": Column("m", "the same across the belt", True),
    "pick_z": Column("m", "the same in height; empty: the belt and the object's height"),
    "release_x": Column("m", "cup's tip at the moment of the valve's command, as commanded", True),
    "release_y": Column("m", "the same across the belt", True),
    "release_z": Column("m", "the same in height", True),
    "release_vx": Column("m/s", "velocity of the cup at that moment, as commanded", True),
    "release_vy": Column("m/s", "the same across the belt", True),
    "release_vz": Column("m/s", "the same in height", True),
    "percent": Column("%", "speed setting; may be left out where the level has one", positive=True),
    "belt_speed": Column("m/s", "speed of the belt by its encoder"),
    "target_x": Column("m", "middle of the bin's opening"),
    "target_y": Column("m", "the same across the belt"),
    "length": Column("m", "measured extent of the object along its long side", positive=True),
    "width": Column("m", "the same across", positive=True),
    "height": Column("m", "the same in height", positive=True),
    "mass": Column("kg", "measured mass", positive=True),
    "seal": Column("N", "force of the vacuum before the release, by its gauge", positive=True),
    "yaw": Column("rad", "measured direction of the object's long side from the belt's travel"),
    "grasp_x": Column("m", "measured centre of the object minus cup axis, along the belt"),
    "grasp_y": Column("m", "the same across the belt"),
    "sealed": Column("0 or 1", "whether the cup held the object when the throw began; empty: not known"),
    "lost": Column("0 or 1", "whether the object left the cup before the valve's command"),
    "landing_x": Column("m", "where the object crossed the plane of the rims, by the camera over the bins", True),
    "landing_y": Column("m", "the same across the belt; empty: not seen", True),
}
"""Columns of a log by name, in the order of a written file."""
GROUPS: Final[dict[str, tuple[str, ...]]] = {
    "pick": ("pick_x", "pick_y", "pick_z"),
    "release": ("release_x", "release_y", "release_z"),
    "velocity": ("release_vx", "release_vy", "release_vz"),
    "percent": ("percent",),
    "belt_speed": ("belt_speed",),
    "target": ("target_x", "target_y"),
    "size": ("length", "width", "height"),
    "mass": ("mass",),
    "seal": ("seal",),
    "yaw": ("yaw",),
    "grasp": ("grasp_x", "grasp_y"),
    "sealed": ("sealed",),
    "lost": ("lost",),
    "landing": ("landing_x", "landing_y"),
}
"""Columns of each field of a `ThrowLog`."""


@final
@dataclass(frozen=True)
class ThrowLog:
    """N logged throws; NaN where a value is not known."""

    kind: Ints
    """Index of the item in the level's items (N,)."""
    pick: Floats
    """Lift (N, 3) [m]."""
    release: Floats
    """Cup at the valve's command (N, 3) [m]."""
    velocity: Floats
    """Its velocity (N, 3) [m/s]."""
    percent: Floats
    """Speed setting (N,) [%]; NaN for hands that move otherwise than the planner's."""
    belt_speed: Floats
    target: Floats
    """Middle of the opening (N, 2) [m]."""
    size: Floats
    """Measured extents (N, 3) [m]."""
    mass: Floats
    seal: Floats
    yaw: Floats
    grasp: Floats
    """Measured centre of the object from the cup's axis (N, 2) [m]."""
    sealed: Floats
    """1 where the cup held the object, 0 where not (N,)."""
    lost: Floats
    landing: Floats
    """Where the object crossed the plane of the rims (N, 2) [m]."""

    def __len__(self) -> int:
        return len(self.kind)

    @property
    def has_landing(self) -> Bools:
        """Which throws have a landing (N,)."""
        return np.asarray(np.isfinite(self.landing).all(axis=1))

    @property
    def has_free_motion(self) -> bool:
        """Whether the hands move otherwise than the planner's, so that the releases alone are known."""
        return bool(np.isnan(self.percent).all())

    @classmethod
    def of(cls, context: Context, plans: ReleaseBatch) -> ThrowLog:
        """What a cell knows of N coming throws; nothing hidden is read, and results are NaN."""
        measured, count = context.objects.measured, len(context.pick)
        empty = np.full(count, np.nan)
        return cls(
            kind=measured.kind.copy(), pick=context.pick.copy(), release=plans.position.copy(),
            velocity=plans.velocity.copy(), percent=context.objects.percent.copy(),
            belt_speed=context.belt_speed, target=context.target[:, :2].copy(),
            size=measured.size.copy(), mass=measured.mass.copy(), seal=measured.seal.copy(), yaw=measured.yaw.copy(),
            grasp=context.measured_grasp.copy(), sealed=empty, lost=empty.copy(),
            landing=np.full((count, 2), np.nan),
        )  # fmt: skip

    def landings(self, errors: Floats) -> Floats:
        """Landings (N, 2) [m] with errors (N, 2) [m] along each throw, from pick to target, and to its left."""
        (along, across), (ex, ey) = errors.T, self._headings.T
        return self.target + join_columns(along * ex - across * ey, along * ey + across * ex)

    def errors(self, landings: Floats, row: Ints) -> Floats:
        """Errors (M, 2) [m] of landings (M, 2) [m] of throws `row` (M,), as `landings` has them."""
        (x, y), (ex, ey) = (landings - self.target[row]).T, self._headings[row].T
        return join_columns(x * ex + y * ey, y * ex - x * ey)

    @property
    def _headings(self) -> Floats:
        """Unit vectors from picks to targets (N, 2)."""
        way = self.target - self.pick[:, :2]
        return way / np.hypot(*way.T)[:, None]

    def text(self, items: Sequence[str]) -> str:
        """The log as CSV; numbers with ten digits, and nothing where a value is not known."""
        numbers = {column: values for field, names in GROUPS.items() for column, values in self._columns(field, names)}
        output = io.StringIO()
        writer = csv.writer(output, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row, kind in enumerate(self.kind):
            writer.writerow([items[kind], *(_number(numbers[name][row]) for name in COLUMNS if name != "item")])
        return output.getvalue()

    def _columns(self, field: str, names: Sequence[str]) -> list[tuple[str, Floats]]:
        values: Floats = getattr(self, field)
        return list(zip(names, values.reshape(len(self), -1).T, strict=True))


def _number(value: float) -> str:
    return f"{value:.10g}" if np.isfinite(value) else ""


def complete(log: ThrowLog, info: Mapping[str, Any], config: ConveyorConfig, random: np.random.Generator) -> ThrowLog:
    """A log with the results of its throws, measured as `feedback` says.

    Args:
        log: what the cell knew of N throws.
        info: results of the throws by info key (N,).
        config: the cell.
        random: generator of the camera's noise; a cell with a camera over its bins has measured already.
    """
    count, sealed, lost = len(log), np.asarray(info["picked"]), np.asarray(info["dropped"])
    true = np.stack([info["landing_along"], info["landing_across"]], axis=1)
    visible = np.hypot(*true.T) <= config.feedback.view
    noise, chance = random.standard_normal((count, 2)), random.random(count)
    errors: Floats = true + config.feedback.noise * noise
    visible &= chance >= config.feedback.unseen
    if set(CAMERA_ERRORS) <= set(info):
        errors = np.stack([info[name] for name in CAMERA_ERRORS], axis=1)
        visible = np.isfinite(errors).all(axis=1)
    landing = log.landings(errors)
    landing[~(visible & sealed & ~lost)] = np.nan
    return replace(
        log,
        sealed=sealed.astype(np.float64),
        lost=np.where(sealed, lost, np.nan).astype(np.float64),
        landing=landing,
    )
