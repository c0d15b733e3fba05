"""The name of a line's table of throws, which follows from the cells of the robots alone."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

from pnt_gym.cells.conveyor.config import ConveyorConfig

MADE: Final = Path("runs") / "chances"
"""Folder of the tables that commands make, in the working folder."""
_UNCONCERNED: Final = {"name", "mix", "fidelity", "dispatch", "patience", "picks_per_shift", "reward", "timestep"}
"""Fields of a cell on which its table does not depend."""


def table_name(cells: Iterable[ConveyorConfig]) -> str:
    """Name of the table of a line with these cells: a digest of everything on which the throws depend."""
    different = sorted({json.dumps(_throwing_keys(cell), sort_keys=True) for cell in cells})
    return hashlib.sha256("\n".join(different).encode()).hexdigest()[:16]


def _throwing_keys(cell: ConveyorConfig) -> dict[str, Any]:
    """Settings on which a cell's throws depend; `bias` only where it applies, as shipped tables are older."""
    return cell.model_dump(mode="json", exclude=_UNCONCERNED if cell.bias.applies else {*_UNCONCERNED, "bias"})
