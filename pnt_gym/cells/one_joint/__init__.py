"""The cell of the one-joint thrower: arm, parts and pallets, and what becomes of a throw (Miyashita et al. 2010)."""
