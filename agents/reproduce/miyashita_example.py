"""The example of Miyashita et al. 2010: goal (0, 0.4 m, 150 deg, 0), its releases, plans and margins."""

from __future__ import annotations

import time
from functools import cache
from typing import Any, Final

import numpy as np

from agents.report.figures import svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.miyashita_cases import ARM, BLOCK, GOAL
from agents.reproduce.miyashita_drawings import margins_figure, motion_figure, trajectories_figure
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.one_joint import release_states
from pnt_gym.planning.one_joint.grasp import acceleration_window, braking, reactions
from pnt_gym.planning.one_joint.plan import ThrowPlan, plan_throw
from pnt_gym.planning.one_joint.weights import WEIGHTS

RELEASE: Final = ("theta_t", "omega_t", "l_t", "t_f")
UNITS: Final = ("rad", "rad/s", "m", "s")
STARTS: Final = 20
"""Random first guesses of each solver."""
SOLVERS: Final = ("slsqp", "ipopt")
PRESETS: Final = tuple(name for name in WEIGHTS if name != "none")
CARELESS: Final = 9
"""Motions that only keep their limits, from as many first guesses (Fig. 7b)."""


def example_findings(starts: int = STARTS) -> Findings:
    """Releases, the plan by both solvers, the weights, and the margin with and without maximising it."""
    rows = [*_releases(), *_solvers(starts), *_presets(), *_margin()]
    plan = _plan("balanced")
    figures = {
        "miyashita_motion.svg": svg(motion_figure(plan)),
        "miyashita_trajectories.svg": svg(trajectories_figure({name: _plan(name) for name in PRESETS})),
        "miyashita_margin.svg": svg(margins_figure(plan, _careless())),
    }
    return Findings(tuple(rows), {"miyashita_example": _data(plan)}, figures)


@cache
def _plan(weights: str) -> ThrowPlan:
    return plan_throw(GOAL, weights=WEIGHTS[weights], starts=4)


@cache
def _careless() -> tuple[ThrowPlan, ...]:
    """Motions that keep every limit and look for no margin."""
    return tuple(plan_throw(GOAL, weights="none", guesses="random", starts=1, seed=seed) for seed in range(CARELESS))


def _data(plan: ThrowPlan) -> dict[str, Any]:
    motion = plan.motion
    return {
        "release": plan.u.tolist(),
        "control_points": motion.knots[0].tolist(),
        "time_step": float(motion.time_step[0]),
        "margins": plan.delta.tolist(),
    }


def _releases() -> list[Row]:
    found = release_states(GOAL, BLOCK.half_height)
    best = found.u[found.feasible][0]
    across = best[2] * np.cos(best[0] + np.arcsin(BLOCK.half_height / best[2]))
    climbs = best[2] * np.sin(best[0] + np.arcsin(BLOCK.half_height / best[2]))
    rows = [
        Row(f"miyashita/example/{name}", None, float(value), unit, "ours", "the one feasible release")
        for name, value, unit in zip(RELEASE, best, UNITS, strict=True)
    ]
    rows.append(
        Row(
            "miyashita/example/dx-at-goal",
            None,
            float(-climbs * best[1]),
            "m/s",
            "ours",
            f"horizontal speed at the goal, which no parameter is left for; released at x = {across:.4f} m",
        )
    )
    rows.append(
        Row(
            "miyashita/claim/release-is-unique",
            "unique",
            f"{len(found.u)} releases, {int(found.feasible.sum())} feasible",
            "-",
            "differs",
            "Eq. 11 taken the other way has one solution for each number of extra whole turns from -2 to 2; limits "
            "leave one",
            {
                "releases": [
                    {"u": u.tolist(), "turns": int(turns), "reasons": list(why)}
                    for u, turns, why in zip(found.u, found.turns, found.reasons, strict=True)
                ]
            },
        )
    )
    window = acceleration_window(best[:1], best[1:2], _radius(best), ARM, BLOCK)
    rows.append(
        Row(
            "miyashita/example/least-acceleration",
            None,
            float(window.low[0]),
            "rad/s2",
            "ours",
            f"what the dynamic grasp needs at the release; the motor gives up to {float(window.high[0]):.0f} rad/s2, "
            f"and brakes the empty arm with {float(-braking(best[1:2], ARM)[0]):.0f} rad/s2 then",
            {"most": float(window.high[0])},
        )
    )
    return rows


def _radius(u: Floats) -> Floats:
    return np.sqrt(u[2:3] ** 2 - BLOCK.half_height**2)


def _solvers(starts: int) -> list[Row]:
    """Random first guesses, as in the paper, by both solvers."""
    plans: dict[str, ThrowPlan] = {}
    seconds: dict[str, float] = {}
    for name in SOLVERS:
        plan_throw(GOAL, solver=name, starts=1)  # what the first call loads is not counted
        began = time.perf_counter()
        plans[name] = plan_throw(GOAL, solver=name, guesses="random", starts=starts)
        seconds[name] = (time.perf_counter() - began) / plans[name].starts
    rows = [
        Row(
            f"miyashita/example/{name}/converged",
            None,
            100.0 * plan.solved / plan.starts,
            "%",
            "ours",
            f"of {plan.starts} random first guesses; {1e3 * seconds[name]:.0f} ms each with the checks at 1 kHz",
            {"seconds_per_start": seconds[name], "cost": plan.cost, "iterations": plan.iterations},
        )
        for name, plan in plans.items()
    ]
    gap = float(np.abs(plans["slsqp"].margins - plans["ipopt"].margins).max())
    motion = plans["slsqp"].motion.sample(np.linspace(0.0, 1.0, 200) * plans["slsqp"].motion.duration[:, None]).angle
    other = plans["ipopt"].motion.sample(np.linspace(0.0, 1.0, 200) * plans["ipopt"].motion.duration[:, None]).angle
    rows.append(
        Row(
            "miyashita/example/solvers-agree",
            None,
            gap,
            "-",
            "ours",
            f"largest difference of the six margins as shares of their units between SLSQP and IPOPT; the arm's angle "
            f"differs by at most {np.rad2deg(np.abs(motion - other).max()):.1e} deg",
        )
    )
    return rows


def _presets() -> list[Row]:
    rows: list[Row] = []
    for name in PRESETS:
        plan = _plan(name)
        n, a, b, _, speed, torque = (float(v) for v in plan.delta)
        rows.append(
            Row(
                f"miyashita/weights/{name}",
                None,
                float(plan.motion.duration[0]),
                "s",
                "ours",
                f"W = ({', '.join(f'{w:g}' for w in WEIGHTS[name])}): from "
                f"{np.rad2deg(plan.motion.start_angle[0]):.1f} "
                f"deg; margins {n:.2f} N, {1e3 * a:.1f} and {1e3 * b:.1f} mN m, {speed:.2f} rad/s, {torque:.1f} N m",
                {"margins": plan.margins.tolist(), "delta": plan.delta.tolist()},
            )
        )
    return rows


def moment_a(plan: ThrowPlan, count: int = 400) -> tuple[Floats, Floats]:
    """Times (count,) [s] and M_A (count,) [N m] of a plan up to its release."""
    times = np.linspace(0.0, float(plan.motion.duration[0]), count)
    state = plan.motion.sample(times)
    return times, reactions(*state, np.array([[plan.radius]]), BLOCK).moment_a[0]


def _margin() -> list[Row]:
    with_it = 1e3 * float(moment_a(_plan("balanced"))[1].max())
    without = np.array([1e3 * float(moment_a(plan)[1].max()) for plan in _careless()])
    return [
        Row(
            "miyashita/fig-7/with-margin",
            "wide",
            with_it,
            "mN m",
            "reproduced",
            "largest M_A before the release; it has to stay below zero",
        ),
        Row(
            "miyashita/fig-7/without-margin",
            "often near zero",
            float(np.median(without)),
            "mN m",
            "reproduced" if np.median(without) > 0.5 * with_it else "differs",
            f"median of {len(without)} motions that keep every limit and maximise nothing; from {without.min():.1f} to "
            f"{without.max():.1e}",
            {"largest": without.tolist()},
        ),
    ]


PARTS = (Part("example", example_findings),)
