"""The T3KR-class robot: kinematics and dynamics in closed form, its MuJoCo model, and motor references."""

from pnt_gym.deferred import defer

defer(__name__, "kernel")
