"""Motion within limits of speed, acceleration and jerk: S-curves, belt intercepts, transfers, and ballistic flight."""
