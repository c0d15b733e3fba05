"""Folders: of files that ship with the code, and of files that commands write."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

SHIPPED: Final = Path(__file__).resolve().parents[2]
"""Folder of configs/ and results/policies/: the checkout, or the installed package pnt_gym with `agents` as a part."""
CHECKOUT: Final = (SHIPPED / "pyproject.toml").is_file()
MADE: Final = SHIPPED if CHECKOUT else Path()
"""Folder in which commands write results/ and runs/: the checkout, else the working folder."""
CODE: Final = SHIPPED if CHECKOUT else SHIPPED.parent
"""Folder of the package pnt_gym."""
POLICY: Final = SHIPPED / "results" / "policies" / "PnTRelease-v0-waste-sac-seed0"
"""Folder of the shipped policy."""


def at(path: str | Path) -> Path:
    """A path in the working folder, or below `SHIPPED` if it exists there alone."""
    # `os.path.exists` is False for a name too long to be a path, where `Path.exists` fails.
    return SHIPPED / path if os.path.exists(SHIPPED / path) and not os.path.exists(path) else Path(path)


def module_name(name: str) -> str:
    """Name of a module of `agents` for `python -m`: `agents.train` in a checkout, else `pnt_gym.agents.train`."""
    return name if CHECKOUT else f"pnt_gym.{name}"


ADAPTIVE: Final = SHIPPED / "results" / "policies" / "PnTAdapt-v0-day"
"""Folder of the pre-trained states of adaptive controllers, for the cell that drifts."""
GRASPING: Final = SHIPPED / "results" / "policies" / "PnTGrasp-v0-grasp"
"""Folder of the pre-trained residual with which objects are thrown after a grasp, and of the network of places."""
