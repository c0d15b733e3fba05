"""Motions as optima of nonlinear programmes (needs casadi): bounds for the papers, not flown in cells."""
