"""The conveyor cell: a T3KR-class robot picks objects off a moving belt and throws them into bins (Hassan 2022)."""

from pnt_gym.deferred import defer

defer(__name__, "scene_kernel")
