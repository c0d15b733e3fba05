"""The release of a throw along a straight line from the pick (Hassan et al. 2022)."""

from pnt_gym.deferred import defer

defer(__name__, "kernel")
