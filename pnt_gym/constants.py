"""Physical constants that all cells share."""

from __future__ import annotations

from typing import Final

GRAVITY: Final = 9.81
"""Gravity [m/s2]; z points up."""
AIR_DENSITY: Final = 1.2
"""Density of air at 20 deg C [kg/m3]."""
AIR_VISCOSITY: Final = 1.8e-5
"""Dynamic viscosity of air at 20 deg C [Pa s]."""
