"""What becomes of throws by a table: how often cups seal on each item, and how often its throws end in their bin.

A table is made with the full physics (`pnt-gym line calibrate`) and kept beside the levels, named by what it depends
on: the cell and its robots' bins and speeds, and nothing of what comes along the belt or who takes it.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError
from pnt_gym.reading import AccessError, json_of

DISTANCES: Final = 4
"""Classes of throws by distance, each with as many of the calibration's throws."""
PRIOR: Final = 10.0
"""So many throws of an item's mean are added to what was counted in each class."""
_UNCONCERNED: Final = {"name", "mix", "fidelity", "dispatch", "patience", "picks_per_shift", "reward", "timestep"}
"""What a cell's throws do not depend on, or not in the table's sense."""


@final
@dataclass(frozen=True)
class Chances:
    """Shares by item K, speed setting P and class of distance D."""

    percent: Floats
    """The speed settings (P,) [%]."""
    edges: Floats
    """Between the classes of distance (D - 1,) [m]."""
    picked: Floats
    """How often the cup seals (K,)."""
    landed: Floats
    """How often what is held crosses the opening and lies in its bin (K, P, D)."""

    @classmethod
    def certain(cls, config: ConveyorConfig) -> Self:
        """Nothing ever fails."""
        items = len(config.items)
        return cls(np.zeros(1), np.zeros(0), np.ones(items), np.ones((items, 1, 1)))

    @classmethod
    def counted(
        cls, config: ConveyorConfig, kind: Ints, percent: Floats, distance: Floats, won: Bools, picked: Bools
    ) -> Self:
        """Of throws (N,) that were made.

        Args:
            config: the cell.
            kind: what was thrown.
            percent: at which speed setting [%].
            distance: how far [m].
            won: whether it crossed the opening and lies in its bin.
            picked: whether the cup sealed.
        """
        settings, items = np.unique(percent), len(config.items)
        edges = np.quantile(distance[picked], np.arange(1, DISTANCES) / DISTANCES)
        at = np.searchsorted(settings, percent), np.searchsorted(edges, distance)
        throws, hits = np.zeros((2, items, len(settings), DISTANCES))
        np.add.at(throws, (kind[picked], at[0][picked], at[1][picked]), 1.0)
        np.add.at(hits, (kind[won], at[0][won], at[1][won]), 1.0)
        mean = (hits.sum(axis=(1, 2)) + 1.0) / (throws.sum(axis=(1, 2)) + 2.0)
        landed = (hits + PRIOR * mean[:, None, None]) / (throws + PRIOR)
        tries = np.bincount(kind, minlength=items)
        sealed = (np.bincount(kind[picked], minlength=items) + 1.0) / (tries + 2.0)
        return cls(settings, edges, np.where(config.pick.fails, sealed, 1.0), landed)

    def check(self, items: int) -> None:
        """Make sure that these are shares of so many items.

        Raises:
            ValueError: shapes that do not fit each other, or numbers that are no shares.
        """
        wanted = items, len(self.percent), len(self.edges) + 1
        shares = np.concatenate([self.picked.ravel(), self.landed.ravel()])
        if self.picked.shape != (items,) or self.landed.shape != wanted or not ((shares >= 0) & (shares <= 1)).all():
            raise ValueError("no shares")
        if not (np.isfinite(self.percent).all() and np.isfinite(self.edges).all()):
            raise ValueError("no settings or distances")

    def land(self, kind: Ints, percent: Floats, distance: Floats) -> Floats:
        """Chance that what is held ends in its bin, S; of the table's next speed setting where it has not that one."""
        setting = np.abs(percent[..., None] - self.percent).argmin(axis=-1)
        return self.landed[kind, setting, np.searchsorted(self.edges, distance)]

    def success(self, kind: Ints, percent: Floats, distance: Floats) -> Floats:
        """Chance that an attempt ends in the bin, S."""
        return self.picked[kind] * self.land(kind, percent, distance)


def digest(config: LineConfig) -> str:
    """Name of the table of a line: what its throws depend on."""
    cells = [config.cell_of(index).model_dump(mode="json", exclude=_UNCONCERNED) for index in range(len(config.robots))]
    different = sorted({json.dumps(cell, sort_keys=True) for cell in cells})
    return hashlib.sha256("\n".join(different).encode()).hexdigest()[:16]


def place_of(config: LineConfig) -> Path:
    """Where the table of a line is kept."""
    return LineConfig.file_of("nominal").parent / "chances" / f"{digest(config)}.json"


def read(config: LineConfig) -> Chances | None:
    """The table of a line; None where nobody has made it.

    Raises:
        ConfigError: the level names a file that is no table, or that of another line.
    """
    place = place_of(config) if config.chances is None else Path(config.chances)
    if config.chances is None and not place.is_file():
        return None
    try:
        told: dict[str, Any] = json_of(place)
        made = Chances(**{name: np.array(told[name], dtype=np.float64) for name in Chances.__dataclass_fields__})
        made.check(len(config.cell.items))
    except AccessError as error:
        raise ConfigError(f"chances: cannot read {str(place)!r}: {error}") from None
    except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError):
        raise ConfigError(f"chances: {str(place)!r} is no table as `pnt-gym line calibrate` writes it") from None
    if told.get("digest") != digest(config):
        raise ConfigError(f"chances: {str(place)!r} is the table of other cells than those of level {config.name!r}")
    return made


def needed(config: LineConfig) -> Chances:
    """The table of a line.

    Raises:
        ConfigError: its throws go by a table, and nobody has made it; or it is not its table.
    """
    found = read(config)
    if found is not None:
        return found
    if config.throws == "table":
        raise ConfigError(
            f"level {config.name!r} has no table of throws; make it with `pnt-gym line calibrate`, or set `throws` to "
            "'flight' or 'full'"
        )
    return Chances.certain(config.cell)


def written(chances: Chances, **told: Any) -> str:
    """A table as its file holds it, with what else is told of it."""
    columns: dict[str, Floats] = asdict(chances)
    rows = {name: np.round(value, 5).tolist() for name, value in columns.items()}
    return json.dumps({**told, **rows}, indent=1) + "\n"
