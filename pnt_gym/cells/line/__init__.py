"""Robots along one belt: which object each robot takes next."""

from pnt_gym.deferred import defer

defer(__name__, "act_kernel", "choice_kernel", "decision_kernel", "lie", "meeting_kernel", "observation_kernel")
defer(__name__, "outcome_kernel", "throwing_kernel", "turn_kernel")
