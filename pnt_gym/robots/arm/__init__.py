"""A serial arm from a model file: MJCF or URDF of any maker."""

from pnt_gym.deferred import defer

defer("pnt_gym.robots.arm", "kernel")
