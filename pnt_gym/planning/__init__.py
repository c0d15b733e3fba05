"""Plans of motions and throws in closed form: arrays in, arrays out, N at a time.

========== =========================================================== ==========================================
folder     subject                                                     cells that fly these plans
========== =========================================================== ==========================================
motion     limits, S-curves, transfers, meetings with a belt, roots    all cells
straight   the throw on a straight line (Hassan et al. 2022)           conveyor
free       the throw in a free direction                               conveyor, level `fast`
one_joint  the one-joint throw to a pose (Miyashita et al.)            one_joint
paths      the ellipse (Choe et al. 2023) and motions over it          conveyor, where objects are put down
========== =========================================================== ==========================================
"""

from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.ballistics import apex, flight_state, flight_time, landing_point
from pnt_gym.planning.motion.intercept import Intercept, plan_intercept
from pnt_gym.planning.motion.limits import EllipticWorkspace, MotionLimits
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.scurve import (
    SCurve,
    accelerate,
    brake,
    brake_distance,
    coast,
    min_time_scurve,
    rest_to_rest,
    speed_at,
)
from pnt_gym.planning.motion.trajectory import HandPath, JerkTrajectory, PeakRatios, Samples
from pnt_gym.planning.reasons import InterceptReason
from pnt_gym.planning.straight.plan import InfeasibleThrow, Reason, Release, ReleaseBatch
from pnt_gym.planning.straight.release import plan_release, plan_release_batch, release_at_elevation, release_at_point

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
    "min_time_scurve",
    "plan_intercept",
    "plan_release",
    "plan_release_batch",
    "release_at_elevation",
    "release_at_point",
    "rest_to_rest",
    "speed_at",
]
