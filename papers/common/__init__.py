"""What several papers share: bounds by nonlinear programming, which need casadi."""
