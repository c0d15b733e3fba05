"""Default numbers of cells, evaluated units and practice throws."""

from __future__ import annotations

from typing import Final

NUM_ENVS: Final = 16
"""Cells simulated side by side."""
PICKS: Final = 200
"""Throws of an evaluation."""
PRACTICE: Final = 120
"""Practice throws of a controller before an evaluation."""
SHIFTS: Final = 32
"""Work shifts of an evaluation on a line."""
