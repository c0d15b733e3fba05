"""Throwing a block to a pose with one joint (Miyashita et al. 2010)."""

from pnt_gym.planning.one_joint.batch import ThrowPlans, plan_releases, plan_throws
from pnt_gym.planning.one_joint.estimate import Arrival, FittedFlight, arrival, fit_flight
from pnt_gym.planning.one_joint.feasibility import ThrowReason, UnreachableGoal
from pnt_gym.planning.one_joint.goals import GoalBatch, ReleaseBox, random_goals
from pnt_gym.planning.one_joint.landing import landing_state, release_states, release_states_batch
from pnt_gym.planning.one_joint.motion import ArmMotion, ArmSample
from pnt_gym.planning.one_joint.parameters import Arm, Block
from pnt_gym.planning.one_joint.plan import ThrowPlan, plan_throw
from pnt_gym.planning.one_joint.virtual_goal import next_virtual_goal, pull_back

__all__ = [
    "Arm",
    "ArmMotion",
    "ArmSample",
    "Arrival",
    "Block",
    "FittedFlight",
    "GoalBatch",
    "ReleaseBox",
    "ThrowPlan",
    "ThrowPlans",
    "ThrowReason",
    "UnreachableGoal",
    "arrival",
    "fit_flight",
    "landing_state",
    "next_virtual_goal",
    "plan_releases",
    "plan_throw",
    "plan_throws",
    "pull_back",
    "random_goals",
    "release_states",
    "release_states_batch",
]
