"""Where things lie: what ships with the code, and where what commands make goes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

SHIPPED: Final = Path(__file__).resolve().parents[2]
"""Holds configs/ and results/policies/: the checkout, or the installed package pnt_gym, whose part `agents` then is."""
CHECKOUT: Final = (SHIPPED / "pyproject.toml").is_file()
MADE: Final = SHIPPED if CHECKOUT else Path()
"""What commands make goes to results/ and runs/ below it: in a checkout, else in the working folder."""
CODE: Final = SHIPPED if CHECKOUT else SHIPPED.parent
"""Holds the package pnt_gym."""
POLICY: Final = SHIPPED / "results" / "policies" / "PnTRelease-v0-waste-sac-seed0"
"""The trained policy that ships."""


def at(path: str | Path) -> Path:
    """What lies at a path: in the working folder, else with what ships."""
    # `os.path.exists` is False for a name too long to be a path, where `Path.exists` fails.
    return SHIPPED / path if os.path.exists(SHIPPED / path) and not os.path.exists(path) else Path(path)


def module_name(name: str) -> str:
    """How Python finds a module of `agents` on its command line: by `python -m agents.train` in a checkout."""
    return name if CHECKOUT else f"pnt_gym.{name}"


def code_pattern(pattern: str) -> str:
    """A glob below `CODE` for one of a checkout, such as agents/*.py."""
    return pattern if CHECKOUT or not pattern.startswith("agents/") else f"pnt_gym/{pattern}"


ADAPTIVE: Final = SHIPPED / "results" / "policies" / "PnTAdapt-v0-day"
"""What the controllers of a cell that drifts know beforehand."""
