"""Robots along one belt: which object each robot takes next."""

from pnt_gym.deferred import defer

defer(__name__, "choose", "lie", "observe", "plan", "sight", "simulate")
