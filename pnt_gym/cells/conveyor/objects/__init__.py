"""The objects: true and measured values, random draws, outlines, and how objects fill bins."""

from pnt_gym.deferred import defer

defer(__name__, "kernel")
