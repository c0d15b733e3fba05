"""Throwing a block to a pose with one joint (Miyashita et al.)."""

from typing import TYPE_CHECKING

from pnt_gym.errors import refuse_moved_names
from pnt_gym.planning.one_joint.batch import ThrowPlans, plan_releases, plan_throws
from pnt_gym.planning.one_joint.estimate import Arrival, FittedFlight, arrival, fit_flight
from pnt_gym.planning.one_joint.feasibility import ThrowReason, UnreachableGoal
from pnt_gym.planning.one_joint.landing import landing_state, release_states, release_states_batch
from pnt_gym.planning.one_joint.motion import ArmMotion, ArmSample
from pnt_gym.planning.one_joint.parameters import Arm, Block

__all__ = [
    "Arm",
    "ArmMotion",
    "ArmSample",
    "Arrival",
    "Block",
    "FittedFlight",
    "ThrowPlans",
    "ThrowReason",
    "UnreachableGoal",
    "arrival",
    "fit_flight",
    "landing_state",
    "plan_releases",
    "plan_throws",
    "release_states",
    "release_states_batch",
]

if not TYPE_CHECKING:
    _GOALS = ("GoalBatch", "ReleaseBox", "next_virtual_goal", "pull_back", "random_goals")
    __getattr__ = refuse_moved_names(
        __name__,
        {
            **dict.fromkeys(_GOALS, "papers.miyashita.planning.goals"),
            **dict.fromkeys(("ThrowPlan", "plan_throw"), "papers.miyashita.planning.plan"),
        },
    )
