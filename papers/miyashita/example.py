"""The example of Miyashita et al.: goal (0, 0.4 m, 150 deg, 0), its releases and plans."""

from __future__ import annotations

import time
from collections.abc import Mapping
from functools import cache
from typing import Final

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats
from pnt_gym.planning.one_joint import landing_state, release_states
from pnt_gym.planning.one_joint.grasp import acceleration_window, braking_acceleration, joint_torque, torque_limit
from pnt_gym.planning.one_joint.weights import WEIGHTS

from .cases import ARM, BLOCK, GOAL
from .drawings import draw_arm, draw_block, draw_flight, draw_plane
from .planning.plan import ThrowPlan, plan_throw

RELEASE: Final = {"theta_t": "rad", "omega_t": "rad/s", "l_t": "m", "t_f": "s"}
"""Names and units of a release."""
STARTS: Final = 20
"""Number of random first guesses of the solver."""
PRESETS: Final = tuple(name for name in WEIGHTS if name != "none")
BEFORE, AFTER = 6, 9
"""Numbers of pictures of the block on the arm and in flight."""


def example_findings(starts: int = STARTS) -> Findings:
    """Rows on releases, and on the plans from random first guesses and by all weights."""
    plan = _plan("balanced")
    rows = [*_release_rows(), _solver_row(starts), *map(_preset_row, PRESETS), _critical_row(plan)]
    figures = {
        "miyashita_motion.svg": motion_figure(plan),
        "miyashita_trajectories.svg": trajectories_figure({name: _plan(name) for name in PRESETS}),
    }
    data = {
        "release": plan.u.tolist(),
        "control_points": plan.motion.knots[0].tolist(),
        "time_step": float(plan.motion.time_step[0]),
        "margins": plan.delta.tolist(),
    }
    return table_findings(
        "Goal (0, 0.4 m, 150 deg, 0 m/s)", rows, figures, {"miyashita_example": data}, drop="miyashita/"
    )


@cache
def _plan(weights: str) -> ThrowPlan:
    return plan_throw(GOAL, weights=WEIGHTS[weights], starts=4)


def _release_rows() -> list[Row]:
    """Rows on the releases by the inverse of Eq. 11, of which a single release is feasible."""
    releases = release_states(GOAL, BLOCK.half_height)
    best = releases.u[releases.feasible][0]
    start = landing_state(np.array([*best[:3], 0.0]), BLOCK.half_height)
    count, feasible = len(releases.u), int(releases.feasible.sum())
    solutions = zip(releases.u, releases.turns, releases.reasons, strict=True)
    return [
        *(
            Row.ours(f"miyashita/example/{name}", float(value), unit, note="the one feasible release")
            for (name, unit), value in zip(RELEASE.items(), best, strict=True)
        ),
        Row.ours(
            "miyashita/example/dx-at-goal",
            float((GOAL[0] - start[0]) / best[3]),
            "m/s",
            note=f"horizontal speed at the goal, which no parameter is left for; released at x = {start[0]:.4f} m",
        ),
        Row.compared(
            "miyashita/claim/release-is-unique",
            "unique",
            f"{feasible} of {count} releases",
            "-",
            holds=feasible == 1,
            note="releases that keep the limits of section 3.1, which are the paper's; without them Eq. 11 has one "
            "solution for each number of extra whole turns from -2 to 2",
            releases=[{"u": u.tolist(), "turns": int(turns), "reasons": list(why)} for u, turns, why in solutions],
        ),
        _least_acceleration_row(best),
    ]


def _least_acceleration_row(u: Floats) -> Row:
    radius = np.sqrt(u[2:3] ** 2 - BLOCK.half_height**2)
    window = acceleration_window(u[:1], u[1:2], radius, ARM, BLOCK)
    note = (
        f"what the dynamic grasp needs at the release; the motor gives up to {window.high[0]:.0f} rad/s2, "
        f"and brakes the empty arm with {-braking_acceleration(u[1:2], ARM)[0]:.0f} rad/s2 then"
    )
    return Row.ours(
        "miyashita/example/least-acceleration", float(window.low[0]), "rad/s2", note=note, most=float(window.high[0])
    )


def _solver_row(starts: int) -> Row:
    """Row with success and time of the solver from random first guesses, as in the paper."""
    plan_throw(GOAL, starts=1)  # the first call loads modules, which is not timed
    began = time.perf_counter()
    plan = plan_throw(GOAL, guesses="random", starts=starts)
    seconds = (time.perf_counter() - began) / plan.starts
    return Row.ours(
        "miyashita/example/slsqp/converged",
        100.0 * plan.solved / plan.starts,
        "%",
        note=f"of {plan.starts} random first guesses; {1e3 * seconds:.0f} ms each with the checks at 1 kHz",
        seconds_per_start=seconds,
        cost=plan.cost,
        iterations=plan.iterations,
    )


def _preset_row(name: str) -> Row:
    plan = _plan(name)
    n, a, b, _, speed, torque = (float(v) for v in plan.delta)
    return Row.ours(
        f"miyashita/weights/{name}",
        float(plan.motion.duration[0]),
        "s",
        note=f"W = ({', '.join(f'{w:g}' for w in WEIGHTS[name])}): from {np.rad2deg(plan.motion.start_angle[0]):.1f} "
        f"deg; margins {n:.2f} N, {1e3 * a:.1f} and {1e3 * b:.1f} mN m, {speed:.2f} rad/s, {torque:.1f} N m",
        margins=plan.margins.tolist(),
        delta=plan.delta.tolist(),
    )


def _critical_row(plan: ThrowPlan) -> Row:
    """Row on section 4.5: to keep the un-rolling constraint about the vertex A is crucial."""
    shares = dict(zip(("N", "A", "B"), plan.margins[:3].tolist(), strict=True))
    return Row.compared(
        "miyashita/claim/vertex-A-is-crucial",
        "A",
        min(shares, key=lambda name: shares[name]),
        "-",
        note=f"the smallest margin of the planned motion: A {shares['A']:.2f} and B {shares['B']:.2f} of weight times "
        f"half length, N {shares['N']:.2f} of the weight",
        margins=shares,
    )


def motion_figure(plan: ThrowPlan) -> Figure:
    """Drawing of arm and block from rest to the goal (the paper's Fig. 5)."""
    figure, (axes,) = subplots(1, 1, (6.2, 6.6))
    times = np.linspace(0.0, float(plan.motion.duration[0]), BEFORE)
    for angle in plan.motion.sample(times).angle[0]:
        draw_arm(axes, float(angle))
        along, up = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        centre = plan.radius * along + BLOCK.half_height * up
        draw_block(axes, np.array([*centre, angle]), COLOURS[0])
    draw_flight(axes, plan.u, COLOURS[3], AFTER, "path of the centre of mass")
    axes.plot(*plan.goal[:2], "x", color="black", label="goal: 150°, no vertical speed")
    draw_plane(axes, (-0.36, 0.36), (-0.20, 0.52))
    axes.legend(fontsize=8, loc="lower left")
    return figure


def trajectories_figure(plans: Mapping[str, ThrowPlan]) -> Figure:
    """Drawing of angle, speed, acceleration and torque up to the release (Fig. 6), for several weights W."""
    figure, axes = subplots(2, 2, (WIDTH, 5.8), sharex=True)
    for colour, (name, plan) in zip(COLOURS, plans.items(), strict=False):
        times = np.linspace(0.0, float(plan.motion.duration[0]), 400)
        state = plan.motion.sample(times)
        torque = joint_torque(*state, np.array([[plan.radius]]), ARM, BLOCK)
        before = times - times[-1]
        for panel, values in zip(axes, (np.rad2deg(state.angle), *state[1:], torque), strict=True):
            panel.plot(before, values[0], color=colour, label=f"weights {name}")
            panel.plot(before[-1], values[0, -1], "o", color=colour, markersize=4)
        axes[3].plot(before, torque_limit(state.speed, ARM)[0], "--", color=colour, linewidth=0.8)
    axes[1].axhline(ARM.speed, color="black", linestyle="--", linewidth=0.8)
    for panel, name in zip(axes, ("angle [°]", "speed [rad/s]", "acceleration [rad/s²]", "torque [N m]"), strict=True):
        dress(panel, "time before the release [s]", name)
    for panel in axes[:2]:
        panel.set_xlabel("")
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=4, loc="outside lower center")
    figure.suptitle("arm's motion to the release; dashed: limits", fontsize=10)
    return figure
