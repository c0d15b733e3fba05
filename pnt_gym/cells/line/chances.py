"""Table of throws: shares of cups that seal on each item, and shares of throws that end in their bin.

A table is computed with the full physics (`pnt-gym line calibrate`). Tables of shipped levels lie beside these, and
tables that commands make in the working folder. The name of a table depends on the cell and the robots' bins and
speeds, not on the arrivals or on the dispatcher.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.rows import ChanceTable
from pnt_gym.cells.line.sections import TableEntries
from pnt_gym.errors import ConfigError
from pnt_gym.reading import AccessError, json_of

DISTANCES: Final = 4
"""Classes of throws by distance, each with the same number of the calibration's throws."""
PRIOR: Final = 10.0
"""Throws with an item's mean share that are added to the counted throws of each class."""


@final
@dataclass(frozen=True)
class ThrowClasses:
    """Classes of N throws: by speed setting P, and by distance D, each distance with the same number of throws."""

    settings: Floats
    """Speed settings (P,) [%]."""
    edges: Floats
    """Borders between the distance classes (D - 1,) [m]."""
    middles: Floats
    """Middles of the distance classes (D,) [m]."""
    of_throw: tuple[Ints, Ints]
    """Classes of each throw (N,)."""

    @classmethod
    def of(cls, percent: Floats, distance: Floats) -> Self:
        """Classes of throws at settings (N,) [%] and distances (N,) [m], equally many at each class of distance."""
        settings, places = np.unique(percent), (np.arange(DISTANCES) + 0.5) / DISTANCES
        edges = np.quantile(distance, np.arange(1, DISTANCES) / DISTANCES)
        middles = np.quantile(distance, places)
        return cls(settings, edges, middles, (np.searchsorted(settings, percent), np.searchsorted(edges, distance)))

    def count(self, kind: Ints, rows: Bools, items: int) -> Floats:
        """Numbers of some of the throws by item K, setting and distance (K, P, D)."""
        counts = np.zeros((items, len(self.settings), DISTANCES))
        setting, part = self.of_throw
        np.add.at(counts, (kind[rows], setting[rows], part[rows]), 1.0)
        return counts


@final
@dataclass(frozen=True)
class Chances:
    """Shares by item K, speed setting P and distance class D."""

    percent: Floats
    """Speed settings (P,) [%]."""
    edges: Floats
    """Borders between the distance classes (D - 1,) [m]."""
    picked: Floats
    """Share of picks in which the cup seals (K,)."""
    landed: Floats
    """Share of held objects that cross the opening and lie in their bin (K, P, D)."""

    @classmethod
    def certain(cls, config: ConveyorConfig) -> Self:
        """Table in which no pick and no throw ever fails."""
        items = len(config.items)
        return cls(np.zeros(1), np.zeros(0), np.ones(items), np.ones((items, 1, 1)))

    @classmethod
    def of(
        cls, sealing: Floats, kind: Ints, percent: Floats, distance: Floats, hits: Bools, near: Self | None = None
    ) -> Self:
        """Table from N simulated throws of held objects; the chances to seal are known.

        The shares of few throws have no bias. An item's mean is counted, with one throw of the mean of all items, so an
        item that nobody threw has a share too. Each class is shrunk by PRIOR throws towards the mean of its item, or
        towards a table of a similar line.

        Args:
            sealing: chance that the cup seals on each item (K,).
            kind: index of the item (N,).
            percent: speed setting (N,) [%].
            distance: horizontal distance of the throw (N,) [m].
            hits: whether the object crossed the opening and lies in its bin (N,).
            near: table of a line with the same items; None for no such line.
        """
        classes = ThrowClasses.of(percent, distance)
        throws, counts = (classes.count(kind, rows, len(sealing)) for rows in (np.ones_like(hits), hits))
        mean = (counts.sum(axis=(1, 2)) + hits.mean()) / (throws.sum(axis=(1, 2)) + 1.0)
        usual = mean[:, None, None] if near is None else near.at(classes.settings, classes.middles)
        return cls(classes.settings, classes.edges, sealing, (counts + PRIOR * usual) / (throws + PRIOR))

    def at(self, percent: Floats, distance: Floats) -> Floats:
        """Shares of held objects that end in their bin, at speed settings P [%] and distances D [m], (K, P, D)."""
        settings = np.abs(percent[:, None] - self.percent).argmin(axis=1)
        return self.landed[:, settings][:, :, np.searchsorted(self.edges, distance)]

    @property
    def entries(self) -> dict[str, Any]:
        """The table as values of JSON."""
        columns: dict[str, Floats] = asdict(self)
        return {name: values.tolist() for name, values in columns.items()}

    def check(self, items: int) -> None:
        """Check that the table holds shares of `items` items.

        Raises:
            ValueError: the shapes do not fit each other, or a number is not a share.
        """
        shape = items, len(self.percent), len(self.edges) + 1
        shares = np.concatenate([self.picked.ravel(), self.landed.ravel()])
        if self.picked.shape != (items,) or self.landed.shape != shape or not ((shares >= 0) & (shares <= 1)).all():
            raise ValueError("no shares")
        if not (np.isfinite(self.percent).all() and np.isfinite(self.edges).all()):
            raise ValueError("no settings or distances")
        if not self.percent.size or (np.diff(self.edges) < 0.0).any():
            raise ValueError("no setting, or distances that do not rise")

    @property
    def table(self) -> ChanceTable:
        """The table for compiled functions."""
        return ChanceTable(*(np.ascontiguousarray(shares) for shares in vars(self).values()))


def shipped_table(config: LineConfig) -> Path:
    """File of a line's table, if it ships."""
    return LineConfig.file_of("nominal").parent / "chances" / f"{config.digest()}.json"


def table_path(config: LineConfig) -> Path:
    """File of a line's table: the file that the level names, the shipped file, or the file that a command makes."""
    if isinstance(config.chances, str):
        return Path(config.chances)
    shipped = shipped_table(config)
    return shipped if shipped.is_file() else config.made_table()


def read_table(config: LineConfig) -> Chances | None:
    """The table of a line; None where the table has not been made.

    Raises:
        ConfigError: the level's table is not a table, or is the table of another line.
    """
    path, given = table_path(config), config.chances
    name = "the level's table" if isinstance(given, TableEntries) else repr(str(path))
    if given is None and not os.path.lexists(path):
        return None
    try:
        entries: dict[str, Any] = dict(given) if isinstance(given, TableEntries) else json_of(path)
        table = Chances(**{name: np.array(entries[name], dtype=np.float64) for name in Chances.__dataclass_fields__})
        table.check(len(config.cell.items))
    except AccessError as error:
        raise ConfigError(f"chances: cannot read {name}: {error}") from None
    except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError):
        raise ConfigError(f"chances: {name} is not a table from `pnt-gym line calibrate`") from None
    if entries.get("digest") != config.digest():
        raise ConfigError(f"chances: {name} was made for other cells than those of level {config.name!r}")
    return table


def required_table(config: LineConfig) -> Chances:
    """The table of a line; shares of 1 where throws are simulated and no table exists.

    Raises:
        ConfigError: the line's throws need a table that is missing or belongs to another line.
    """
    table = read_table(config)
    if table is not None:
        return table
    if config.throws == "table":
        raise ConfigError(
            f"level {config.name!r} has no table of throws; make it with `pnt-gym line calibrate --level FILE.yaml`, "
            "or simulate the throws with `throws: flight` or `throws: full`"
        )
    return Chances.certain(config.cell)


def format_table(chances: Chances, **figures: Any) -> str:
    """Text of a table's file, with further entries."""
    columns: dict[str, Floats] = asdict(chances)
    rows = {name: np.round(value, 5).tolist() for name, value in columns.items()}
    return json.dumps({**figures, **rows}, indent=1) + "\n"
