"""Physical constants that all cells share, and the revision of the physics."""

from __future__ import annotations

from typing import Final

WORLD: Final = 2
"""Revision of the simulated physics; results of different worlds are not compared.

1: one restitution and friction an item; drag of lying cylinders 0.80 to 0.85, slender drag 0.35, Magnus lift 0.3;
   friction of PET 0.35 and PP 0.40; up to 1.5 masses of residue in two of five containers; a 1 l carton of 31 g.
2: restitution and friction drawn for every throw; drag of lying cylinders 0.67 and 0.72, slender drag 0.02, Magnus lift
   0.7; friction of PET 0.27 and PP 0.28; a lognormal residue about each item's mean; a 1 l carton of 29 g.
"""
GRAVITY: Final = 9.81
"""Gravity [m/s2]; z points up."""
AIR_DENSITY: Final = 1.2
"""Density of air at 20 deg C [kg/m3]."""
AIR_VISCOSITY: Final = 1.8e-5
"""Dynamic viscosity of air at 20 deg C [Pa s]."""
