"""Ranges of a log's columns, relative to the item where there is one, and the units that are taken for others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import item_arrays
from pnt_gym.cells.conveyor.config import ConveyorConfig

from ..ground.cli import UsageError
from .log import COLUMNS, GROUPS, ThrowLog

UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "m": {"millimetres": 1e3, "centimetres": 1e2, "inches": 1.0 / 0.0254},
    "m/s": {"millimetres a second": 1e3, "centimetres a second": 1e2, "kilometres an hour": 3.6},
    "kg": {"grams": 1e3, "tonnes": 1e-3},
    "N": {"millinewtons": 1e3, "kilonewtons": 1e-3},
    "rad": {"degrees": 180.0 / np.pi},
    "%": {"shares of 1": 1e-2},
}
"""Other units for a column of an SI unit, and what the figure is in them for each in SI."""
TIMES: Final = 25.0
"""Factor by which a size, a mass or a seal may differ from the item's on either side; a full bottle weighs 21 empty
ones."""
ASIDE: Final = 5.0
"""Largest distance of an object's centre from the cup's axis, in longest sides of the item."""

ITEMS: Final = ("size", "mass", "seal")
"""Fields whose range is that of the item."""
BOUNDS: Final[Mapping[str, tuple[float, float, float]]] = {
    **dict.fromkeys(("pick", "release", "target", "landing"), (-5.0, 5.0, 0.15)),
    "velocity": (-20.0, 20.0, 1.5),  # robots reach 6 m/s
    "percent": (1.0, 100.0, 40.0),
    "belt_speed": (-10.0, 10.0, 0.25),
    "yaw": (-2.0 * np.pi, 2.0 * np.pi, 1.5),
    "sealed": (0.0, 1.0, 1.0),
    "lost": (0.0, 1.0, 1.0),
}
"""Least, largest and usual values of the fields that no item has."""


@final
class Span(NamedTuple):
    """Values that a column may have."""

    low: Floats
    """Least value for each throw (N,)."""
    high: Floats
    usual: Floats
    """Size of a usual value, by which units are told apart (N,)."""
    of_item: bool
    """Whether the values depend on the item."""


def check(log: ThrowLog, config: ConveyorConfig, throws: Sequence[int]) -> None:
    """Make sure that every value of a log is in the range of its column.

    Args:
        log: the log.
        config: the level, whose items a log's values are compared with.
        throws: number of each row's throw in the file, for the error.

    Raises:
        UsageError: a value is not in its range.
    """
    for field, names in GROUPS.items():
        values: Floats = getattr(log, field).reshape(len(log), -1)
        for name, column, span in zip(names, values.T, _spans(field, log, config), strict=True):
            wrong = np.flatnonzero((column < span.low) | (column > span.high))
            if wrong.size:
                row, unit = int(wrong[0]), COLUMNS[name].unit
                item = f" for item {config.items[log.kind[row]]!r}" if span.of_item else ""
                valid = f"from {span.low[row]:.3g} to {span.high[row]:.3g} {unit}{item}"
                look = _text(column[wrong], unit, *(part[wrong] for part in (span.low, span.high, span.usual)))
                raise UsageError(
                    f"throw {throws[row]} of the log: {name} is {column[row]:g} {unit}; it must be {valid}{look}"
                )


def _spans(field: str, log: ThrowLog, config: ConveyorConfig) -> list[Span]:
    """Ranges of the columns of a field of a log."""
    table, kind, columns = item_arrays(config.item_list()), log.kind, len(GROUPS[field])
    if field in ITEMS:
        own = {"size": table.size[kind].T, "mass": [table.mass[kind]], "seal": [table.seal_force[kind]]}[field]
        return [Span(part / TIMES, part * TIMES, part, True) for part in own]
    if field == "grasp":
        side = table.size[kind].max(axis=1)
        return [Span(-ASIDE * side, ASIDE * side, side / 15.0, True)] * columns
    ones = np.ones(len(log))
    low, high, usual = BOUNDS[field]
    return [Span(low * ones, high * ones, usual * ones, False)] * columns


def _text(values: Floats, unit: str, low: Floats, high: Floats, usual: Floats) -> str:
    """The other unit in which values (M,) are usual ones, as the end of a sentence; empty for none."""
    misses = {
        other: abs(np.log(np.median(np.abs(values) / factor / usual)))
        for other, factor in UNITS.get(unit, {}).items()
        if values.all() and low[0] <= values[0] / factor <= high[0]
    }
    return f"; it looks like {min(misses, key=lambda other: misses[other])}" if misses else ""
