"""Plans in closed form: numbers in, numbers out, N at a time."""

from pnt_gym.planning.ballistics import GRAVITY, apex, flight_state, flight_time, landing_point
from pnt_gym.planning.intercept import Intercept, InterceptReason, plan_intercept
from pnt_gym.planning.limits import MotionLimits
from pnt_gym.planning.plan import InfeasibleThrow, Reason, Release, ReleaseBatch
from pnt_gym.planning.release import (
    plan_release,
    plan_release_batch,
    release_at_elevation,
    release_at_point,
)
from pnt_gym.planning.scurve import SCurve, min_time_scurve, speed_at
from pnt_gym.planning.segments import accelerate, brake, brake_distance, coast, line_segments, rest_to_rest
from pnt_gym.planning.trajectory import HandPath, JerkTrajectory, PeakRatios, Samples, Segments
from pnt_gym.planning.workspace import EllipticWorkspace

__all__ = [
    "GRAVITY",
    "EllipticWorkspace",
    "HandPath",
    "InfeasibleThrow",
    "Intercept",
    "InterceptReason",
    "JerkTrajectory",
    "MotionLimits",
    "PeakRatios",
    "Reason",
    "Release",
    "ReleaseBatch",
    "SCurve",
    "Samples",
    "Segments",
    "accelerate",
    "apex",
    "brake",
    "brake_distance",
    "coast",
    "flight_state",
    "flight_time",
    "landing_point",
    "line_segments",
    "min_time_scurve",
    "plan_intercept",
    "plan_release",
    "plan_release_batch",
    "release_at_elevation",
    "release_at_point",
    "rest_to_rest",
    "speed_at",
]
