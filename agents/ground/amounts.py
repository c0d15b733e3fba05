"""How much is judged and practised unless other amounts are asked for."""

from __future__ import annotations

from typing import Final

NUM_ENVS: Final = 16
"""Cells simulated side by side."""
PICKS: Final = 200
"""Throws of an evaluation."""
PRACTICE: Final = 120
"""Throws that a controller practises before it."""
SHIFTS: Final = 32
"""Shifts of an evaluation at a line."""
