"""Reads a user's log: every mistake is one sentence, and what is odd but usable is a warning."""

from __future__ import annotations

import csv
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.errors import one_sentence
from pnt_gym.names import closest_name, list_names, unknown_name
from pnt_gym.planning.motion.ballistics import landing_point
from pnt_gym.reading import ReadError, lines_of

from ..ground.cli import UsageError
from . import ranges
from .log import COLUMNS, GROUPS, ThrowLog

FEWEST: Final = 10
"""Fewest landings of a fit."""
FEW: Final = 25
"""Landings below which a warning says that intervals are wide."""
MOST: Final = 400
"""Throws of a fit; of a longer log so many are drawn by chance."""
MOST_BYTES, MOST_LINES = 2**30, 4_000_000
"""Size of a log's file; a throw has some 250 bytes."""
MARGIN: Final = 0.15
"""Distance beyond the belt's lanes and window at which a pick is none of this cell [m]."""
ASTRAY: Final = 0.35
"""Median distance of landings from the drag-free ones beyond which something else was logged [m]."""
SEPARATORS: Final = (",", ";", "\t", "|")
"""Separators of columns; numbers of a file with another one than a comma may have decimal commas."""
MISSPELLED: Final = 0.8
"""Likeness, from 0 to 1, from which on a column that is not known is a misspelled one and no further one."""
SPEED_SHARE: Final = 0.02
"""Relative difference of a logged belt speed from the level's that does not matter."""


def read(path: Path, config: ConveyorConfig, free_motion: bool = False) -> ThrowLog:
    """The log in a CSV file, checked against the level.

    Args:
        path: the file.
        config: the level.
        free_motion: whether the hands moved otherwise than the planner's, so that the log has no speed setting.

    Raises:
        UsageError: the file is no log of this cell's throws, with the reason.
    """
    try:
        header, body = _rows(path)
    except (ReadError, csv.Error) as error:
        raise UsageError(f"cannot read log {str(path)!r}: {one_sentence(error)}") from None
    names = _names(header, path)
    if not body:
        raise UsageError(f"log {str(path)!r} has no throws below its header")
    kinds: list[int] = []
    table = {name: np.full(len(body), np.nan) for name in COLUMNS if name != "item"}
    for index, (number, row) in enumerate(body.items()):
        if len(row) != len(names):
            raise UsageError(f"throw {number} of the log has {len(row)} values for {len(names)} columns")
        for name, text in zip(names, row, strict=True):
            if name == "item":
                kinds.append(_kind(text.strip(), number, config))
            elif name in table:
                table[name][index] = _number(text.strip(), name, number)
    fields = {field: _join([table[name] for name in columns]) for field, columns in GROUPS.items()}
    log = ThrowLog(kind=np.array(kinds, dtype=np.int64), **fields)
    ranges.check(log, config, list(body))
    # Throws that repeat the landing of another one, and all else, count once.
    whole = np.column_stack([log.kind, *(getattr(log, field).reshape(len(log), -1) for field in GROUPS)])
    _, first = np.unique(np.nan_to_num(whole, nan=-1e9), axis=0, return_index=True)
    # Two picks alike may both fail; two landings alike are one that was written twice.
    rows = np.union1d(first, np.flatnonzero(~log.has_landing))
    if len(rows) < len(log):
        warnings.warn(f"{len(log) - len(rows)} of {len(log)} throws repeat another one, and count once", stacklevel=2)
    return check(take(log, rows), config, free_motion)


def _names(header: Sequence[str], path: Path) -> list[str]:
    """Names of the columns.

    Raises:
        UsageError: there are none, a needed one is missing, or one stands twice.
    """
    if not header:
        raise UsageError(f"log {str(path)!r} is empty; its first line must name the columns")
    names = [name.strip() for name in header]
    if twice := [name for name in COLUMNS if names.count(name) > 1]:
        raise UsageError(f"log {str(path)!r} has more than one column {list_names(twice)}; leave one of each")
    unknown = [name for name in names if name and name not in COLUMNS]
    _check(path, names, unknown)
    missing = [name for name, column in COLUMNS.items() if column.required and name not in names]
    if missing:
        raise UsageError(f"log {str(path)!r} lacks the columns {list_names(missing)}; `docs/fit.md` lists all")
    unknown = [name for name in names if name and name not in COLUMNS]
    _check(path, names, unknown)
    if unknown:
        warnings.warn(f"columns {list_names(unknown)} of the log are not read", stacklevel=3)
    return names


def _check(path: Path, names: Sequence[str], unknown: Sequence[str]) -> None:
    """Make sure that no unknown column is a misspelled one that the log lacks; other columns are not read.

    Raises:
        UsageError: one is.
    """
    absent = [name for name in COLUMNS if name not in names]
    for name in unknown:
        if closest_name(name, absent, MISSPELLED) is not None:
            raise UsageError(f"log {str(path)!r}: {unknown_name('column', name, absent)}; rename the column or drop it")


def _rows(path: Path) -> tuple[list[str], dict[int, list[str]]]:
    """The header of a file, and at most `MOST` rows by the number of their throw; all empty for an empty file.

    Raises:
        ReadError: the file cannot be read.
        csv.Error: the file is no table.
    """
    count = sum(1 for _ in _lines(path)) - 1
    numbers = range(1, count + 1)
    if count > MOST:
        warnings.warn(f"{MOST} of the log's {count:,} throws are used, drawn by chance", stacklevel=3)
        drawn = np.random.default_rng(0).choice(count, MOST, replace=False)
        numbers = sorted(1 + int(index) for index in drawn)
    chosen = {0, *numbers}
    first = next(_lines(path), "")
    mark = max(SEPARATORS, key=first.count)
    rows = csv.reader((line for number, line in enumerate(_lines(path)) if number in chosen), delimiter=mark)
    header = next(rows, [])
    if mark != ",":
        rows = ([text.replace(",", ".") for text in row] for row in rows)
    return header, dict(zip(numbers, rows, strict=False))  # a line break in quotes joins two lines to one row


def _lines(path: Path) -> Iterator[str]:
    """The lines of a log that are not empty."""
    return (line for line in lines_of(path, MOST_BYTES, MOST_LINES) if line.strip())


def _join(columns: Sequence[Floats]) -> Floats:
    return columns[0] if len(columns) == 1 else np.stack(columns, axis=1)


def _kind(name: str, throw: int, config: ConveyorConfig) -> int:
    if name not in config.items:
        raise UsageError(f"throw {throw} of the log: {unknown_name('item', name, config.items)}")
    return config.items.index(name)


def _number(text: str, name: str, throw: int) -> float:
    """A number of a row; empty text and nan are NaN, where the column may be unknown."""
    if text.lower() in ("", "nan", "none", "null"):
        if COLUMNS[name].required and not name.startswith("landing"):
            raise UsageError(f"throw {throw} of the log has no {name}; only measured values may be missing")
        return np.nan
    words = {"true": 1.0, "false": 0.0}
    try:
        value = words[text.lower()] if text.lower() in words else float(text)
    except ValueError:
        raise UsageError(f"throw {throw} of the log: {name} is {one_sentence(text, 40)!r}, no number") from None
    if not np.isfinite(value):
        raise UsageError(f"throw {throw} of the log: {name} is {one_sentence(text, 40)}; it must be finite")
    if COLUMNS[name].unit == "0 or 1" and value not in (0.0, 1.0):
        raise UsageError(f"throw {throw} of the log: {name} is {one_sentence(text, 40)}; it must be 0 or 1")
    if COLUMNS[name].positive and value <= 0.0:
        raise UsageError(f"throw {throw} of the log: {name} is {one_sentence(text, 40)}; it must be above 0")
    return value


def check(log: ThrowLog, config: ConveyorConfig, free_motion: bool) -> ThrowLog:
    """A log whose units, axes and results make sense in a cell, with what the level knows filled in.

    Raises:
        UsageError: they do not, with the reason.
    """
    _check_picks(log, config)
    log = _fill(log, config, free_motion)
    landed = log.has_landing
    count = int(landed.sum())
    if count == 0:
        raise UsageError("the log has no landings: landing_x and landing_y are empty, and a fit lives on them")
    if count < FEWEST:
        raise UsageError(f"the log has {count} landings; a fit needs at least {FEWEST}, and 40 are usual")
    if bool((landed & ((log.sealed == 0.0) | (log.lost == 1.0))).any()):
        raise UsageError("the log has landings of objects that were not sealed or were lost; leave these empty")
    _check_landings(log, config, landed)
    if count < FEW:
        warnings.warn(f"the log has {count} landings; with 40 intervals are about half as wide", stacklevel=3)
    if len(np.unique(log.kind[landed])) == 1:
        name = config.items[int(log.kind[np.argmax(landed)])]
        warnings.warn(
            f"all landings are of {name}: one item does not tell the valve from the vacuum's decay, nor the lip's "
            "stiffness; throw other items too",
            stacklevel=3,
        )
    return log


def _check_picks(log: ThrowLog, config: ConveyorConfig) -> None:
    def inside(x: Floats, y: Floats) -> float:
        window, lane = config.belt.pick_x, config.belt.lane_y
        fits_x = (x > window[0] - MARGIN) & (x < window[1] + MARGIN)
        return float((fits_x & (y > lane[0] - MARGIN) & (y < lane[1] + MARGIN)).mean())

    x, y = log.pick[:, 0], log.pick[:, 1]
    if inside(x, y) < 0.5:
        hint = "; pick_x and pick_y look swapped" if inside(y, x) > 0.9 else ""
        belt = config.belt
        raise UsageError(
            f"most picks lie outside of the level's belt, pick_x {belt.pick_x} and lane_y {belt.lane_y} m{hint}"
        )


def _fill(log: ThrowLog, config: ConveyorConfig, free_motion: bool) -> ThrowLog:
    """The log with speed settings and results that follow from the level and from the other columns."""
    percent, sealed = log.percent.copy(), log.sealed.copy()
    if free_motion:
        percent[:] = np.nan
    elif not np.isfinite(percent).all():
        if len(config.limits.percent) > 1:
            raise UsageError(f"percent is empty, and the level has several speed settings, {config.limits.percent}")
        percent[~np.isfinite(percent)] = min(config.limits.percent)
    speed = log.belt_speed[np.isfinite(log.belt_speed)]
    if speed.size and np.abs(speed - config.belt.speed).max() > SPEED_SHARE * config.belt.speed:
        raise UsageError(
            f"belt_speed goes from {speed.min():g} to {speed.max():g} m/s, and belt.speed of the level is "
            f"{config.belt.speed:g}; fit each speed alone, with a level that has it"
        )
    sealed[log.has_landing & ~np.isfinite(sealed)] = 1.0
    if unknown := int((~np.isfinite(sealed)).sum()):
        warnings.warn(f"{unknown} throws have neither a landing nor a word whether the cup sealed", stacklevel=3)
    return ThrowLog(**{**vars(log), "percent": percent, "sealed": sealed})


def _check_landings(log: ThrowLog, config: ConveyorConfig, landed: Bools) -> None:
    """Make sure that landings are near those without air, by their median."""
    rim = np.full(len(log), config.bins.rim)

    def median_miss(landing: Floats, velocity: Floats) -> float:
        plain = landing_point(log.release, velocity, rim)[landed, :2]
        return float(np.median(np.hypot(*(landing[landed] - plain).T)))

    miss = median_miss(log.landing, log.velocity)
    if not miss < ASTRAY:
        swaps = {
            "landing_x and landing_y": median_miss(log.landing[:, ::-1], log.velocity),
            "release_vx and release_vy": median_miss(log.landing, log.velocity[:, [1, 0, 2]]),
        }
        name = min(swaps, key=lambda name: swaps[name])
        hint = f"; {name} look swapped" if swaps[name] < 0.6 * miss else ""
        raise UsageError(
            f"half of the landings lie {miss:.2f} m or farther from where the releases throw without air; check frame, "
            f"units and columns of landings and releases{hint}"
        )
