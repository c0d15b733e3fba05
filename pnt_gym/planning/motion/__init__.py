"""Motion within limits of speed, acceleration and jerk: S-curves, belt intercepts, transfers, and ballistic flight."""

from pnt_gym.deferred import defer

defer(__name__, "hunt", "kernel")
