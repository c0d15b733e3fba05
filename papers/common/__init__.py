"""Code that several papers share: the quickest motions by nonlinear programming, which need casadi."""
