"""What a caller of the planning functions gets wrong: one sentence of ours that names the argument."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from pnt_gym.errors import PntGymError
from pnt_gym.planning import (
    EllipticWorkspace,
    MotionLimits,
    accelerate,
    apex,
    brake,
    brake_distance,
    coast,
    flight_state,
    flight_time,
    landing_point,
    min_time_scurve,
    plan_intercept,
    plan_release,
    plan_release_batch,
    release_at_elevation,
    release_at_point,
    rest_to_rest,
    speed_at,
)
from pnt_gym.planning.one_joint import (
    Arm,
    Block,
    arrival,
    fit_flight,
    landing_state,
    plan_releases,
    plan_throws,
    release_states,
    release_states_batch,
)
from pnt_gym.planning.paths import EllipsePath, approximate_half_circumference, half_circumference
from pnt_gym.robots.gripper import JointLimits, conditioning, forward_kinematics, inverse_kinematics, travel_time
from pnt_gym.robots.t3kr import kinematics

LIMITS = MotionLimits.t3kr(40.0)
PICK, TARGET, UP = [-0.2, -0.25, -0.85], [0.3, 0.4, -0.85], [[0.5, 1.0, 2.0]]
POSE = [[0.0, 0.0, -0.2, -0.78]]
TIMES = np.linspace(0.0, 0.2, 5)
ELLIPSE = EllipsePath.with_top(0.15, 0.025, 0.0435)
CALLS: dict[Callable[..., Any], Mapping[str, Any]] = {
    plan_release: {"pick": PICK, "target": TARGET, "limits": LIMITS, "ceiling": -0.75, "tolerance": 0.0},
    plan_release_batch: {"picks": [PICK], "targets": [TARGET], "limits": LIMITS, "ceiling": -0.75, "tolerance": 0.0},
    release_at_elevation: {"picks": [PICK], "targets": [TARGET], "limits": LIMITS, "elevation": 0.6},
    release_at_point: {"picks": [PICK], "points": [[-0.1, -0.1, -0.8]], "limits": LIMITS, "plane_z": -0.85},
    min_time_scurve: {"distance": 0.8, "limits": LIMITS},
    speed_at: {"distance": 0.8, "limits": LIMITS},
    rest_to_rest: {"displacement": UP, "limits": LIMITS},
    accelerate: {"direction": [[1.0, 0.0, 0.0]], "distance": [0.3], "limits": LIMITS},
    brake: {"direction": [[1.0, 0.0, 0.0]], "speed": [0.3], "limits": LIMITS},
    brake_distance: {"speed": [0.3], "limits": LIMITS},
    coast: {"duration": [0.3]},
    plan_intercept: {
        "start": [PICK], "positions": [PICK], "belt_velocity": [0.3, 0.0, 0.0], "limits": LIMITS, "clearance": 0.05,
        "window": (-0.3, 0.3), "times": (0.0, 30.0), "axis": 0,
    },
    apex: {"position": [PICK], "velocity": UP},
    flight_state: {"position": [PICK], "velocity": UP, "time": 0.1},
    flight_time: {"position": [PICK], "velocity": UP, "plane_z": -0.9},
    landing_point: {"position": [PICK], "velocity": UP, "plane_z": -0.9},
    MotionLimits: {"velocity": 1.0, "acceleration": 10.0, "jerk": 100.0},
    MotionLimits.t3kr: {"percent": 40.0},
    LIMITS.with_scale: {"factor": 0.5},
    EllipticWorkspace: {"semi_x": 0.4, "semi_y": 0.8, "z_min": -1.0, "z_max": 0.0},
    EllipticWorkspace().contains: {"points": [PICK]},
    min_time_scurve(0.8, LIMITS).sample: {"t": 0.1},
    EllipsePath.with_top: {"half_width": 0.15, "half_rise": 0.025, "top": 0.0435},
    EllipsePath.with_angle: {"half_width": 0.15, "half_rise": 0.025, "angle": 0.5},
    EllipsePath.paper: {"half_width": 0.15, "half_rise": 0.025},
    ELLIPSE.point: {"theta": 0.1},
    ELLIPSE.radius_of_curvature: {"theta": 0.1},
    ELLIPSE.nodes: {"rate": 0.1},
    approximate_half_circumference: {"semi_major": 0.2, "semi_minor": 0.1},
    half_circumference: {"semi_major": 0.2, "semi_minor": 0.1},
    landing_state: {"u": [0.3, 5.0, 0.5, 0.2], "half_height": 0.015},
    release_states: {"z": [0.8, 0.0, 0.3, -2.0], "half_height": 0.015, "arm": Arm(), "block": Block()},
    release_states_batch: {"z": [[0.8, 0.0, 0.3, -2.0]], "arm": Arm(), "block": Block()},
    plan_throws: {"goals": [[0.8, 0.0, 0.3, -2.0]], "arm": Arm(), "block": Block()},
    plan_releases: {"u": [[0.3, 5.0, 0.5, 0.2]], "arm": Arm(), "objective": "max_min", "weights": "balanced"},
    Arm: {"length": 0.62, "friction": 0.0, "knee": 0.8, "angle": (-1.0, 1.0)},
    Block: {"mass": 0.03, "half_height": 0.015},
    fit_flight: {"times": TIMES, "x": [TIMES], "y": [TIMES], "phi": [TIMES]},
    arrival: {"flight": fit_flight(TIMES, [TIMES], [TIMES], [TIMES]), "goal": [[0.8, 0.0, 0.3, -2.0]]},
    conditioning: {"pose": POSE},
    inverse_kinematics: {"pose": POSE, "branch": 1},
    forward_kinematics: {"q": inverse_kinematics(POSE)},
    travel_time: {"start": POSE, "end": POSE, "speed": 7.0},
    JointLimits: {"speed": 7.0, "acceleration": 100.0},
    kinematics.inverse_kinematics: {"tcp": PICK},
    kinematics.forward_kinematics: {"q": [0.1] * 4},
    kinematics.jacobian: {"tcp": PICK},
}  # fmt: skip
"""Arguments that are right, by function; `flight` of `arrival` is no input of users."""
CASES = [(call, name) for call, right in CALLS.items() for name in right if name != "flight"]
WRONG = ["text", [[1.0], [1.0, 2.0]], 1j, {}, 10**400, object(), np.zeros((2, 5, 7))]
"""Values that no argument can have."""
SHAPELESS = {"theta", "semi_major", "semi_minor", "t", "plane_z", "time"}
"""Arguments of any shape."""


@pytest.mark.parametrize(("call", "name"), CASES)
def test_a_wrong_value_is_named(call: Callable[..., Any], name: str) -> None:
    call(**CALLS[call])
    for value in WRONG[:-1] if name in SHAPELESS else WRONG:
        if value is WRONG[-1] and name in ("axis", "objective"):
            continue  # NumPy compares the array entry by entry
        with pytest.raises(PntGymError) as refusal:
            call(**{**CALLS[call], name: value})
        assert "\n" not in str(refusal.value)


def test_lists_do_where_arrays_do() -> None:
    np.testing.assert_array_equal(
        landing_point(PICK, UP[0], -0.9), landing_point(np.array(PICK), np.array(UP[0]), -0.9)
    )
    np.testing.assert_array_equal(rest_to_rest(UP, LIMITS).durations, rest_to_rest(np.array(UP), LIMITS).durations)
