"""The programme of a throw for the interior-point solver IPOPT, in the paper's variables.

The unknowns are the spline's control points, Delta t and the margins, and the ends of the motion are equations, as in
Eqs. 15-32 of Miyashita et al. casadi is an optional dependency.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.planning.one_joint.family import FORCED
from pnt_gym.planning.one_joint.margins import STATIC_ROOM
from pnt_gym.planning.one_joint.shapes import INTERVALS

from ...common.casadi_module import QUIET, load_casadi
from .programme import ACCELERATION, OTHERS, ForceCoefficients, Programme

ITERATIONS = 300


def solve_interior(programme: Programme, start: Floats) -> tuple[Floats, float, bool, int, str]:
    """Solve a programme by IPOPT.

    Args:
        programme: programme to solve.
        start: first guess (K,), as the programme's x.

    Returns:
        x (K,), cost of x, whether x is a solution, number of iterations, and IPOPT's message.

    Raises:
        PntGymError: casadi is not installed.
    """
    ca = load_casadi()
    knots, step, margins, least = ca.SX.sym("p", INTERVALS + 3), ca.SX.sym("dt"), ca.SX.sym("m", 6), ca.SX.sym("s")
    first = programme.motion(start)
    unit = float(first.time_step[0])
    equal, above = _equations(programme, knots, unit * step), _inequalities(programme, knots, unit * step, margins)
    if programme.weighing.objective == "max_min":
        above = ca.vertcat(above, *(margins[k] - least for k in FORCED))
        cost = -least - OTHERS * ca.sum1(margins)
    else:
        above = ca.vertcat(above, least)
        cost = -0.5 * ca.dot(ca.DM(programme.weighing.weights), margins * margins)
    problem = {
        "x": ca.vertcat(knots, step, margins, least),
        "f": cost,
        "g": ca.vertcat(equal, above),
    }
    solver = ca.nlpsol("throw", "ipopt", problem, {**QUIET, "ipopt.max_iter": ITERATIONS})
    margin_bounds = programme.bounds()[INTERVALS + 1 : INTERVALS + 7]
    low = [*[-np.inf] * (INTERVALS + 3), 1e-3, *(bound[0] for bound in margin_bounds), 0.0]
    top = [*[np.inf] * (INTERVALS + 3), programme.arm.time_step / unit, *(bound[1] for bound in margin_bounds), np.inf]
    count = equal.numel()
    guess = np.concatenate([first.knots[0], [1.0], start[INTERVALS + 1 : INTERVALS + 7], [programme.least]])
    solution = solver(
        x0=np.clip(guess, low, top),
        lbx=low,
        ubx=top,
        lbg=np.zeros(count + above.numel()),
        ubg=np.concatenate([np.zeros(count), np.full(above.numel(), np.inf)]),
    )
    state = solver.stats()
    values = np.asarray(solution["x"], dtype=np.float64).ravel()
    x = np.zeros(programme.size)
    x[: INTERVALS + 1] = np.diff(values[: INTERVALS + 3], 2) / (unit * values[INTERVALS + 3]) ** 2 / ACCELERATION
    x[INTERVALS + 1 :] = values[INTERVALS + 4 :][: programme.size - INTERVALS - 1]
    return x, float(solution["f"]), bool(state["success"]), int(state["iter_count"]), str(state["return_status"])


def _equations(programme: Programme, knots: Any, step: Any) -> Any:
    """Values that must be zero: errors of angle and speed at the release, and speed at the start (Eqs. 29, 32)."""
    throw, end = programme.throw, INTERVALS + 2
    return load_casadi().vertcat(
        (knots[end - 2] + 4.0 * knots[end - 1] + knots[end]) / 6.0 - throw.angle,
        (knots[end] - knots[end - 2]) / (2.0 * step * throw.speed) - 1.0,
        knots[2] - knots[0],
    )


def _inequalities(programme: Programme, knots: Any, step: Any, margins: Any) -> Any:
    """Values that must not be negative (Eqs. 15-20), at `per_interval` places of every interval."""
    ca, arm, block = load_casadi(), programme.arm, programme.block
    angle, speed, rate = _spline(knots, step, programme.per_interval)
    bend = ForceCoefficients.of(programme.throw.radius, arm, block)
    forces = [
        float(a) * rate + float(w) * speed**2 + float(c) * ca.cos(angle) + float(s) * ca.sin(angle)
        for a, w, c, s in zip(*(column[:, 0] for column in bend), strict=True)
    ]
    torque = forces[3] + arm.friction / arm.torque
    half = 0.5 * (arm.angle[1] - arm.angle[0])
    # Eq. 10: above the knee the torque limit falls linearly with the speed to that at the largest speed.
    fall = (1.0 - min(arm.torque_at_speed, arm.torque) / arm.torque) / (1.0 - arm.knee)
    line = 1.0 + fall * (arm.knee - speed / arm.speed)
    rows = [forces[k] - margins[k] for k in range(3)]
    rows += [(angle - arm.angle[0]) / half - margins[3], (arm.angle[1] - angle) / half - margins[3]]
    rows += [1.0 - sign * speed / arm.speed - margins[4] for sign in (1.0, -1.0)]
    rows += [limit + sign * torque - margins[5] for limit in (1.0, line) for sign in (1.0, -1.0)]
    if programme.static_start:
        start, height = angle[0], block.half_height / block.half_length
        rows += [ca.cos(start) + sign * height * ca.sin(start) - STATIC_ROOM for sign in (1.0, -1.0)]
    return ca.vertcat(*rows)


def _spline(knots: Any, step: Any, per_interval: int) -> tuple[Any, Any, Any]:
    """Angle, speed and acceleration of Eq. 13 at even places, by its basis functions."""
    ca = load_casadi()
    angle: list[Any] = []
    speed: list[Any] = []
    rate: list[Any] = []
    for place in range(INTERVALS * per_interval + 1):
        index = min(place // per_interval, INTERVALS - 1)
        # Local parameter of the interval, from 0 to 1: time over the step.
        s = place / per_interval - index
        four = knots[index : index + 4]
        # Uniform cubic B-splines times 6, their slopes times 2, and their second derivatives, by s.
        basis = [(1.0 - s) ** 3, 3.0 * s**3 - 6.0 * s**2 + 4.0, -3.0 * s**3 + 3.0 * s**2 + 3.0 * s + 1.0, s**3]
        slope = [-((1.0 - s) ** 2), 3.0 * s**2 - 4.0 * s, -3.0 * s**2 + 2.0 * s + 1.0, s**2]
        bend = [1.0 - s, 3.0 * s - 2.0, 1.0 - 3.0 * s, s]
        angle.append(ca.dot(ca.DM(basis), four) / 6.0)
        speed.append(ca.dot(ca.DM(slope), four) / (2.0 * step))
        rate.append(ca.dot(ca.DM(bend), four) / step**2)
    return ca.vertcat(*angle), ca.vertcat(*speed), ca.vertcat(*rate)
