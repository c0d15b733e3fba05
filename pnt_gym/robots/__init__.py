"""Robots: kinematics, dynamics and MuJoCo models."""

from pnt_gym.deferred import defer

defer(__name__, "knot_kernel")
