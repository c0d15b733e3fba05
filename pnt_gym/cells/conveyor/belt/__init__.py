"""The belt: the stream of objects, the choice of the next pick, and collisions of a carried object with others."""

from pnt_gym.deferred import defer

defer(__name__, "sweep")
