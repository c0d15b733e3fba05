"""What the cells of all robots share, once: config, core, actions, items, air, physics in stages, and pictures."""

from pnt_gym.deferred import defer

defer(__name__, "freefall", "settle_kernel")
