"""Dispatchers of lines: which robot takes which object next."""

from pnt_gym.deferred import defer

defer(__name__, "clairvoyant")
