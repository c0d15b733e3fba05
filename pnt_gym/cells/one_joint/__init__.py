"""The cell of the one-joint thrower: arm, parts, pallets, and the outcome of a throw (Miyashita et al.)."""
