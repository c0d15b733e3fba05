"""Formulas of Miyashita et al. 2010: checked against mechanics written out anew, and what is misprinted in them."""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.miyashita_cases import ARM, BLOCK, GOAL
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.planning.one_joint import landing_state, release_states
from pnt_gym.planning.one_joint.grasp import acceleration_window, braking, reactions, rests, torque_limit
from pnt_gym.planning.one_joint.interior import solve_interior
from pnt_gym.planning.one_joint.margins import motion_margins
from pnt_gym.planning.one_joint.plan import ThrowPlan, plan_throw
from pnt_gym.planning.one_joint.programme import Programme, Throw, Weighing
from pnt_gym.planning.one_joint.weights import weights_of

STATES: Final = 200
"""Random states at which formulas are compared."""
INTERVALS: Final = 10
"""n of the paper."""


def formula_findings() -> Findings:
    """Eqs. 1-3 and 11 against independent mechanics, and every misprint with what shows it."""
    plan = plan_throw(GOAL)
    rows = [
        _grasp_row(),
        _flight_row(),
        _control_points(plan),
        _sign_row(plan),
        _time_row(plan),
        _torque_row(plan),
        _jump_row(plan),
        _knots_row(plan),
        _wrap_row(),
        _rest_row(),
    ]
    return Findings(tuple(rows))


def _grasp_row() -> Row:
    rng = np.random.default_rng(0)
    angle, speed, rate = rng.uniform(-1.5, 1.5, STATES), rng.uniform(0, 12, STATES), rng.uniform(-200, 200, STATES)
    radius = rng.uniform(0.05, 0.28, STATES)
    found = reactions(angle, speed, rate, radius, BLOCK)
    expected = newton_euler(angle, speed, rate, radius)
    gap = max(float(np.abs(a - b).max()) for a, b in zip(found, expected, strict=True))
    return Row(
        "miyashita/formula/eqs-1-3",
        "Eqs. 1 to 3",
        gap,
        "N, N m",
        "reproduced",
        f"largest difference of N, M_A and M_B from forces and moments about the centre of mass at {STATES} random "
        "states; "
        "A is the outer vertex, B the inner one",
    )


def newton_euler(angle: Floats, speed: Floats, rate: Floats, radius: Floats) -> tuple[Floats, Floats, Floats]:
    """N, M_A and M_B from the acceleration of the centre of mass in the world, not from the paper."""
    d, side, mass = BLOCK.half_height, BLOCK.half_length, BLOCK.mass
    along = np.stack([np.cos(angle), np.sin(angle)])
    up = np.stack([-np.sin(angle), np.cos(angle)])
    arm = radius * along + d * up
    turned = np.stack([-arm[1], arm[0]])
    force = mass * (rate * turned - speed**2 * arm) - mass * GRAVITY * np.array([[0.0], [-1.0]])
    normal, pull = (force * up).sum(axis=0), (force * along).sum(axis=0)
    # Forces act in the surface, d below the centre of mass; M = J theta'' less what they do about each vertex.
    spin = BLOCK.inertia * rate
    return normal, spin - pull * d - side * normal, spin - pull * d + side * normal


def _flight_row() -> Row:
    rng = np.random.default_rng(1)
    low, high = np.array([-1.4, 1.0, 0.05, 0.05]), np.array([1.4, 12.5, 0.28, 0.6])
    u = rng.uniform(low, high, (STATES, 4))
    lifted = u[:, 0] + np.arcsin(BLOCK.half_height / u[:, 2])
    x, y = u[:, 2] * np.cos(lifted), u[:, 2] * np.sin(lifted)
    vx, vy, phi = -u[:, 1] * y, u[:, 1] * x, u[:, 0].copy()
    steps = 64
    for _ in range(steps):  # a parabola is stepped exactly
        dt = u[:, 3] / steps
        x, y, phi = x + vx * dt, y + vy * dt - 0.5 * GRAVITY * dt**2, phi + u[:, 1] * dt
        vy = vy - GRAVITY * dt
    gap = float(np.abs(landing_state(u, BLOCK.half_height) - np.stack([x, y, phi, vy], axis=1)).max())
    return Row(
        "miyashita/formula/eq-11",
        "Eq. 11",
        gap,
        "m, rad, m/s",
        "reproduced",
        f"largest difference from the flight stepped through, {STATES} random releases",
    )


def _control_points(plan: ThrowPlan) -> Row:
    return Row(
        "miyashita/misprint/eq-13",
        f"segments i = 0..n, {INTERVALS + 4} control points",
        f"i = 0..n-1, {plan.motion.knots.shape[1]} control points",
        "-",
        "misprint",
        "each segment needs control points i-1 to i+2: a segment n would need one more than the n + 3 of Eq. 14; "
        "between "
        "0 and t_n lie n intervals with n + 1 knots",
    )


def _sign_row(plan: ThrowPlan) -> Row:
    weight = float(weights_of("balanced")[1])
    largest = float(plan.delta[1])
    values = {f"{delta:g}": 0.5 * weight * delta**2 for delta in (-largest, 1.0, 100.0)}
    return Row(
        "miyashita/misprint/eqs-16-28",
        "M_A < Delta M_A, max Delta M_A^2",
        "unbounded",
        "-",
        "misprint",
        f"printed without Delta M_A <= 0 in Eqs. 27 to 32, M_A = {1e3 * largest:.1f} mN m also satisfies Delta M_A "
        "= 1 or "
        "100 N m, and the squares of the objective reward these; the text has the sign, and the others need >= 0",
        {"objective_by_delta": values},
    )


def _time_row(plan: ThrowPlan) -> Row:
    run_up, flight = float(plan.motion.duration[0]), float(plan.u[3])
    return Row(
        "miyashita/misprint/eq-23",
        "t_f = t_n",
        f"t_t = {run_up:.4f} s, t_f = {flight:.4f} s",
        "-",
        "misprint",
        "t_n is the time of the release t_t; t_f is that of the flight. As printed the motion of the example would "
        "have to "
        f"take {flight / run_up:.2f} times as long. The text to Fig. 6 has t_i for t_t",
    )


def _torque_row(plan: ThrowPlan) -> Row:
    printed = float(torque_limit(np.array(ARM.speed), ARM))
    needed = float(torque_limit(plan.u[1], ARM))
    return Row(
        "miyashita/misprint/eq-10",
        "tau_max = xi(dtheta_max)",
        printed,
        "N m",
        "misprint",
        f"taken at the largest speed the curve gives one number, here {printed:g} N m, for all speeds; Fig. 3 means "
        f"xi(dtheta), {needed:g} N m at the release of the example",
    )


def _jump_row(plan: ThrowPlan) -> Row:
    u, radius = plan.u[None], np.array([plan.radius])
    window = acceleration_window(u[:, 0], u[:, 1], radius, ARM, BLOCK)
    before = float(plan.motion.release_acceleration[0])
    after = float(braking(u[:, 1], ARM)[0])
    return Row(
        "miyashita/inconsistency/maximally-decelerated-at-the-release",
        "at t_t",
        before - after,
        "rad/s2",
        "misprint",
        f"Eqs. 15 to 17 hold at knot n too and ask for more than {float(window.low[0]):.1f} rad/s2 there; letting "
        "go needs "
        "braking: the acceleration jumps just after t_n, outside the twice differentiable spline",
    )


def _knots_row(plan: ThrowPlan) -> Row:
    """Limits kept at the knots only, by the paper's own variables, and looked at between them."""
    throw = Throw(float(plan.u[0]), float(plan.u[1]), plan.radius)
    weighing = Weighing("squares", weights_of("bang"))
    programme = Programme(throw, ARM, BLOCK, weighing, static_start=True, per_interval=1)
    x, _, _, _, _ = solve_interior(programme, programme.start(np.linspace(120.0, 100.0, INTERVALS + 1)))
    motion, radius = programme.motion(x), np.array([plan.radius])
    knot_rate = INTERVALS / float(motion.duration[0])
    at_knots = motion_margins(motion, radius, ARM, BLOCK, knot_rate)[0]
    between = motion_margins(motion, radius, ARM, BLOCK, 20000.0)[0]
    worst = int((at_knots - between).argmax())
    names = ("N", "M_A", "M_B", "angle", "speed", "torque")
    return Row(
        "miyashita/inconsistency/limits-at-knots-only",
        "at the knots",
        float((at_knots - between)[worst]),
        "-",
        "differs",
        f"how much smaller the margin of the {names[worst]} is between the knots than at them, as a share of its unit "
        f"({between[worst]:.4f} instead of {at_knots[worst]:.4f}), in the quickest motion; limits are kept and "
        "checked in "
        "between here",
        {"at_knots": at_knots.tolist(), "between": between.tolist()},
    )


def _wrap_row() -> Row:
    turned = GOAL + np.array([0.0, 0.0, 2.0 * np.pi, 0.0])
    found = release_states(turned, BLOCK.half_height)
    straight = found.u[found.turns == 0]
    speed = float(straight[:, 1].min())
    return Row(
        "miyashita/inconsistency/phi-not-wrapped",
        "-90 to 90 deg",
        speed,
        "rad/s",
        "differs",
        f"the same pose one turn further, 510 deg, needs this speed and {ARM.speed:.1f} rad/s is the limit: the "
        "angle of the "
        "arm is bounded, that of the goal must not be wrapped",
    )


def _rest_row() -> Row:
    free = plan_throw(GOAL, weights="torque", static_start=False, starts=4)
    start = free.motion.start_angle
    tips = -np.rad2deg(np.arctan2(BLOCK.half_length, BLOCK.half_height))
    return Row(
        "miyashita/inconsistency/block-must-rest-before-the-throw",
        "-",
        float(np.rad2deg(start[0])),
        "deg",
        "differs",
        "start of the motion that asks least of the motor under the printed constraints; a resting block tips over "
        "below "
        f"{tips:.1f} deg (its share of room is {float(rests(start, BLOCK)[0]):.2f}), so a static start is asked for "
        "here",
    )


PARTS = (Part("formulas", formula_findings),)
