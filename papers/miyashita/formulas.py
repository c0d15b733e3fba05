"""Formulas of Miyashita et al.: a check against independent mechanics, and misprints."""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.reproduce.finding import Findings, Row, printed
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.one_joint import landing_state, release_states
from pnt_gym.planning.one_joint.grasp import (
    acceleration_window,
    braking_acceleration,
    reactions,
    tipping_margin,
    torque_limit,
)
from pnt_gym.planning.one_joint.margins import motion_margins
from pnt_gym.planning.one_joint.weights import weights_of

from .cases import ARM, BLOCK, GOAL
from .planning.plan import ThrowPlan, plan_throw, solve
from .planning.programme import Programme, Throw, Weighing

STATES: Final = 200
"""Number of random states at which formulas are compared."""
STEPS: Final = 64
"""Time steps of a flight that is stepped through."""
INTERVALS: Final = 10
"""Number n of the paper's spline intervals."""
ROUNDING: Final = 1e-12
"""Largest difference of equal formulas by rounding, for numbers of the order of 1 to 100 in double precision."""


def formula_findings() -> Findings:
    """Rows that compare Eqs. 1-3 and 11 with independent mechanics, and rows that show every misprint."""
    plan = plan_throw(GOAL)
    rows = [
        _grasp_row(),
        _flight_row(),
        _control_points_row(plan),
        _sign_row(plan),
        _time_row(plan),
        _torque_row(plan),
        _jump_row(plan),
        _knots_row(plan),
        _wrap_row(),
        _rest_row(),
    ]
    return table_findings("Formulas", rows, drop="miyashita/")


def _grasp_row() -> Row:
    rng = np.random.default_rng(0)
    angle, speed, rate = rng.uniform(-1.5, 1.5, STATES), rng.uniform(0, 12, STATES), rng.uniform(-200, 200, STATES)
    radius = rng.uniform(0.05, 0.28, STATES)
    values = reactions(angle, speed, rate, radius, BLOCK)
    expected = newton_euler(angle, speed, rate, radius)
    gap = max(float(np.abs(a - b).max()) for a, b in zip(values, expected, strict=True))
    note = (
        f"largest difference of N, M_A and M_B from forces and moments about the centre of mass at {STATES} "
        "random states; A is the outer vertex, B the inner one"
    )
    return Row.compared("miyashita/formula/eqs-1-3", "Eqs. 1 to 3", gap, "N, N m", holds=gap < ROUNDING, note=note)


def newton_euler(angle: Floats, speed: Floats, rate: Floats, radius: Floats) -> tuple[Floats, Floats, Floats]:
    """N [N], M_A and M_B [N m] by Newton and Euler: from the acceleration of the centre of mass in the world frame."""
    d, side, mass = BLOCK.half_height, BLOCK.half_length, BLOCK.mass
    along = np.stack([np.cos(angle), np.sin(angle)])
    up = np.stack([-np.sin(angle), np.cos(angle)])
    arm = radius * along + d * up
    perpendicular = np.stack([-arm[1], arm[0]])
    # A point on a turning arm: tangential acceleration by the rate, centripetal by speed^2; the force carries the
    # weight.
    force = mass * (rate * perpendicular - speed**2 * arm) - mass * GRAVITY * np.array([[0.0], [-1.0]])
    normal, pull = (force * up).sum(axis=0), (force * along).sum(axis=0)
    # Forces act in the surface, d below the centre of mass; M = J theta'' minus the forces' moment about each vertex.
    spin = BLOCK.inertia * rate
    return normal, spin - pull * d - side * normal, spin - pull * d + side * normal


def _flight_row() -> Row:
    rng = np.random.default_rng(1)
    low, high = np.array([-1.4, 1.0, 0.05, 0.05]), np.array([1.4, 12.5, 0.28, 0.6])
    u = rng.uniform(low, high, (STATES, 4))
    gap = float(np.abs(landing_state(u, BLOCK.half_height) - step_flights(u)).max())
    return Row.compared(
        "miyashita/formula/eq-11",
        "Eq. 11",
        gap,
        "m, rad, m/s",
        holds=gap < ROUNDING,
        note=f"largest difference from the flight stepped through, {STATES} random releases",
    )


def step_flights(u: Floats) -> Floats:
    """States x, y, phi, dy (N, 4) after flights from releases (N, 4), by time steps that are exact for a parabola."""
    # The centre of mass is l_t from the pivot and d above the arm, and so arcsin(d / l_t) further round.
    elevation = u[:, 0] + np.arcsin(BLOCK.half_height / u[:, 2])
    x, y = u[:, 2] * np.cos(elevation), u[:, 2] * np.sin(elevation)
    vx, vy, phi = -u[:, 1] * y, u[:, 1] * x, u[:, 0].copy()
    dt = u[:, 3] / STEPS
    for _ in range(STEPS):
        x, y, phi = x + vx * dt, y + vy * dt - 0.5 * GRAVITY * dt**2, phi + u[:, 1] * dt
        vy = vy - GRAVITY * dt
    return np.stack([x, y, phi, vy], axis=1)


def _control_points_row(plan: ThrowPlan) -> Row:
    as_printed = {j for i in range(INTERVALS + 1) for j in range(i - 1, i + 3)}
    return Row.compared(
        "miyashita/misprint/eq-13",
        f"{INTERVALS + 3} control points",
        f"{len(as_printed)} control points",
        "-",
        note="Eq. 14 has n + 3; Eq. 13 as printed, with segments i = 0..n of control points i-1 to i+2, needs one "
        "more. Between 0 and t_n lie n intervals with n + 1 knots: with segments i = 0..n-1 the two agree",
    ).explain(f"{plan.motion.knots.shape[1]} control points")


def _sign_row(plan: ThrowPlan) -> Row:
    """Row on the objective's maximum over Delta M_A, with the constraints as printed and with the sign of the text."""
    weight, margin = float(weights_of("balanced")[1]), float(plan.delta[1])
    # Eq. 28 over Delta M_A alone: at the plan's margin, at 0, and at two values that the print allows.
    values = {delta: 0.5 * weight * delta**2 for delta in (margin, 0.0, 1.0, 100.0)}
    as_printed = [value for delta, value in values.items() if delta >= margin]
    with_sign = [value for delta, value in values.items() if margin <= delta <= 0.0]
    return Row.compared(
        "miyashita/misprint/eqs-16-28",
        "a maximum exists",
        _maximum(as_printed),
        "-",
        note=f"printed without Delta M_A <= 0 in Eqs. 27 to 32, M_A = {1e3 * margin:.1f} mN m also satisfies Delta M_A "
        "= 1 or 100 N m, and the squares of the objective reward these; the text has the sign, the others need >= 0",
        objective_by_delta={f"{delta:g}": value for delta, value in values.items()},
    ).explain(_maximum(with_sign))


def _maximum(values: list[float]) -> str:
    """Whether values at rising arguments have a maximum before the last argument, in words."""
    return "unbounded" if values[-1] >= max(values) else "a maximum exists"


def _time_row(plan: ThrowPlan) -> Row:
    run_up, flight = float(plan.motion.duration[0]), float(plan.u[3])
    ends = "t_f = t_n" if abs(run_up - flight) < printed(4) else "t_t = t_n"
    note = (
        f"t_n is the time of the release t_t = {run_up:.4f} s; t_f = {flight:.4f} s is that of the flight. As "
        f"printed the motion of the example would have to take {flight / run_up:.2f} times as long. The text to Fig. 6 "
        "has t_i for t_t"
    )
    return Row.compared("miyashita/misprint/eq-23", "t_f = t_n", ends, "-", note=note).explain(
        ends.replace("t_t", "t_f")
    )


def _torque_row(plan: ThrowPlan) -> Row:
    speeds = np.linspace(0.0, ARM.speed, 101)
    needed = float(torque_limit(plan.u[1], ARM))
    return Row.compared(
        "miyashita/misprint/eq-10",
        ARM.torque,
        float(torque_limit(np.array(ARM.speed), ARM)),
        "N m",
        within=printed(0),
        note="tau_max = xi(dtheta_max) as printed is one number for all speeds, that at the largest one, and not the "
        f"18 N m of section 6.1; Fig. 3 means xi(dtheta), which begins there and is {needed:g} N m at the release of "
        "the example",
    ).explain(float(torque_limit(speeds, ARM).max()))


def _jump_row(plan: ThrowPlan) -> Row:
    u, radius = plan.u[None], np.array([plan.radius])
    window = acceleration_window(u[:, 0], u[:, 1], radius, ARM, BLOCK)
    return Row.ours(
        "miyashita/statement/maximally-decelerated-at-the-release",
        float(plan.motion.release_acceleration[0] - braking_acceleration(u[:, 1], ARM)[0]),
        "rad/s2",
        beside="at t_t",
        note=f"Eqs. 15 to 17 hold at knot n too and ask for more than {window.low[0]:.1f} rad/s2 there; letting go "
        "needs braking: the acceleration jumps by this much just after t_n, outside the twice differentiable spline",
    )


def _knots_row(plan: ThrowPlan) -> Row:
    """Row on a motion that keeps its limits at the knots only, as in the paper, and its margins between the knots."""
    throw = Throw(float(plan.u[0]), float(plan.u[1]), plan.radius)
    weighing = Weighing("squares", weights_of("bang"))
    programme = Programme(throw, ARM, BLOCK, weighing, static_start=True, per_interval=1)
    x = solve(programme, programme.start(np.linspace(120.0, 100.0, INTERVALS + 1)))[0]
    motion, radius = programme.motion(x), np.array([plan.radius])
    # One sample per interval: the knots and nothing between.
    knot_rate = INTERVALS / float(motion.duration[0])
    at_knots = motion_margins(motion, radius, ARM, BLOCK, knot_rate)[0]
    between = motion_margins(motion, radius, ARM, BLOCK, 20000.0)[0]
    worst = int((at_knots - between).argmax())
    names = ("N", "M_A", "M_B", "angle", "speed", "torque")
    return Row.ours(
        "miyashita/statement/limits-at-knots-only",
        float((at_knots - between)[worst]),
        "-",
        beside="at the knots",
        note=f"how much smaller the margin of the {names[worst]} is between the knots than at them, as a share of its "
        f"unit ({between[worst]:.4f} instead of {at_knots[worst]:.4f}), in the quickest motion; limits are kept and "
        "checked in between here",
        at_knots=at_knots.tolist(),
        between=between.tolist(),
    )


def _wrap_row() -> Row:
    turned_goal = GOAL + np.array([0.0, 0.0, 2.0 * np.pi, 0.0])
    releases = release_states(turned_goal, BLOCK.half_height)
    return Row.ours(
        "miyashita/statement/phi-not-wrapped",
        float(releases.u[releases.turns == 0, 1].min()),
        "rad/s",
        beside="-90 to 90 deg",
        note=f"the same pose one turn further, 510 deg, needs this speed and {ARM.speed:.1f} rad/s is the limit: the "
        "angle of the arm is bounded, that of the goal must not be wrapped",
    )


def _rest_row() -> Row:
    free = plan_throw(GOAL, weights="torque", static_start=False, starts=4)
    start = free.motion.start_angle
    # A block tips when its weight's line leaves the support: tan = l / d.
    tips = -np.rad2deg(np.arctan2(BLOCK.half_length, BLOCK.half_height))
    return Row.ours(
        "miyashita/statement/block-must-rest-before-the-throw",
        float(np.rad2deg(start[0])),
        "deg",
        note="start of the motion that asks least of the motor under the printed constraints; a resting block tips "
        f"over below {tips:.1f} deg (its share of room is {tipping_margin(start, BLOCK)[0]:.2f}), so here it must rest",
    )
