"""Fig. 7 of Miyashita et al., and the paper's second contribution: throws with margin withstand disturbances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats, take
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.hidden import draw_hidden
from pnt_gym.planning.one_joint import ThrowPlans
from pnt_gym.planning.one_joint.grasp import reactions
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.planning.one_joint.weights import WEIGHTS

from .cases import ARM, BLOCK, GOAL, feasible_goals, make_plant, misses, percent, simulate_flights
from .planning.gauss_newton import careless_motion, random_unknowns
from .planning.plan import ThrowPlan, plan_throw
from .planning.programme import Throw

STARTS: Final = 400
"""Number of random first guesses of Gauss-Newton steps for the paper's throw, in one sample."""
SAMPLES: Final = 10
"""Number of these samples, each with a seed of its own."""
BY_SQP: Final = 20
"""Number of motions by sequential quadratic programming without an objective."""
NEAR: Final = 1.0
"""Distance of the largest M_A from zero that counts as near zero [mN m]."""
MOST: Final = 50.0
"""Share of motions without margin that decides what "often" and "wide" mean [%]."""
GOALS: Final = 40
"""Number of random goals whose throws are disturbed."""
TRIES: Final = 20
"""Number of random first guesses for each of these goals."""
ROLLED: Final = 0.5
"""Turn of the block against the arm before the release from which the block counts as rolled [deg]."""
LATE: Final = 0.005
"""Delay of the release, in which the arm already brakes [s]."""
SHOWN: Final = 9
"""Number of motions without margin in the drawing."""
_NO_ERRORS: Final = dict.fromkeys(
    ("radius", "inertia", "friction", "viscous", "drag", "delay", "placement", "timing"), 0.0
)


class Disturbance(NamedTuple):
    """Errors of the level `contact` that the plan does not know, and the words for them."""

    words: str
    errors: Mapping[str, float]


DISTURBANCES: Final = {
    "friction": Disturbance("3 N m of friction in the gear", {**_NO_ERRORS, "friction": 3.0}),
    "lost-acceleration": Disturbance(
        "a third of the acceleration missing, as half as much inertia again takes it", {**_NO_ERRORS, "inertia": 0.5}
    ),
    "all-effects": Disturbance("every unmodelled effect at its realistic strength", {}),
}


class ThrowPair(NamedTuple):
    """Plans of the same throws with the largest margins, and without any."""

    wide: ThrowPlans
    careless: ThrowPlans


def margin_findings(starts: int = STARTS, count: int = SAMPLES, goals: int = GOALS) -> Findings:
    """Fig. 7 with the paper's Gauss-Newton method, and disturbed throws with and without margin."""
    plan = plan_throw(GOAL, weights=WEIGHTS["balanced"], starts=4)
    throw = Throw(float(plan.u[0]), float(plan.u[1]), plan.radius)
    samples = [careless_motions(throw, starts, seed) for seed in range(count)]
    motions = [motion for sample in samples for motion in sample]
    pair = throw_pair(goals)
    rows = [
        *figure_rows(plan, samples, starts),
        _sqp_row(),
        acceleration_row(plan, motions),
        *(disturbed_row(name, pair) for name in DISTURBANCES),
        _late_row(pair),
    ]
    figures = {"miyashita_margin.svg": margins_figure(plan, motions[:SHOWN])}
    return table_findings("Margins: Fig. 7 and disturbed throws", rows, figures, drop="miyashita/")


def careless_motions(throw: Throw, starts: int, seed: int) -> tuple[ArmMotion, ...]:
    """Motions of a throw that Gauss-Newton steps find from random first guesses."""
    generator = np.random.default_rng(seed)
    guesses = (random_unknowns(ARM, generator) for _ in range(starts))
    return tuple(m for guess in guesses if (m := careless_motion(throw, ARM, BLOCK, guess)) is not None)


def moment_a(motion: ArmMotion, radius: float, count: int = 400) -> Floats:
    """Moment M_A (count,) [mN m] of a motion at even times up to its release."""
    times = np.linspace(0.0, float(motion.duration[0]), count)
    return 1e3 * reactions(*motion.sample(times), np.array([[radius]]), BLOCK).moment_a[0]


def _moment_at_knots(motion: ArmMotion, radius: float) -> float:
    """Largest M_A [mN m] at the knots, where the paper keeps its limits."""
    return float(moment_a(motion, radius, motion.intervals + 1).max())


def figure_rows(plan: ThrowPlan, samples: Sequence[Sequence[ArmMotion]], starts: int) -> list[Row]:
    """Rows with the margin of the optimised motion, and with the margins of motions by the Gauss-Newton method.

    Each sample has the motions of `starts` first guesses, as many as the motions of one figure or one audit.
    """
    with_margin = float(moment_a(plan.motion, plan.radius).max())
    by_sample = [np.array([_moment_at_knots(motion, plan.radius) for motion in motions]) for motions in samples]
    largest, shares = np.concatenate(by_sample), [percent(np.abs(values) < NEAR) for values in by_sample]
    narrower, near = percent(largest > with_margin), percent(np.abs(largest) < NEAR)
    return [
        Row.compared(
            "miyashita/fig-7/with-margin",
            "wide",
            with_margin,
            "mN m",
            holds=narrower >= MOST,
            note=f"largest M_A before the release, which has to stay below zero; {narrower:.0f} % of the motions of "
            f"Fig. 7b come nearer to zero, and from {MOST:.0f} % on it counts as wide",
        ),
        Row.compared(
            "miyashita/fig-7/without-margin",
            "often near zero",
            round(float(np.median(largest)), 9) + 0.0,
            "mN m",
            holds=near >= MOST,
            note=f"median largest M_A at the knots of {largest.size} motions that Gauss-Newton steps find for Eqs. 29 "
            f"to 32 from {len(samples)} samples of {starts} random control points and Delta t; three quarters lie "
            f"above {np.quantile(largest, 0.25):.2g} mN m, and {near:.1f} % within {NEAR:g} mN m of zero: broken "
            "limits are solved as equations, so the motions end on them. By sample "
            f"{min(shares):.1f} to {max(shares):.1f} % lie within {NEAR:g} mN m, and "
            f"{min(map(len, by_sample))} to {max(map(len, by_sample))} guesses lead to a motion",
            starts=starts,
            largest=float(largest.max()),
            shares_by_sample=shares,
            motions_by_sample=[values.size for values in by_sample],
        ),
    ]


@cache
def _motions_by_sqp() -> tuple[ThrowPlan, ...]:
    return tuple(plan_throw(GOAL, weights="none", guesses="random", starts=1, seed=seed) for seed in range(BY_SQP))


def _sqp_row() -> Row:
    plans = _motions_by_sqp()
    largest = np.array([moment_a(plan.motion, plan.radius).max() for plan in plans])
    return Row.ours(
        "miyashita/fig-7/without-margin-by-sqp",
        float(np.median(largest)),
        "mN m",
        beside="often near zero",
        note=f"the same by SQP without an objective, which is not what the paper did for Fig. 7b; {len(plans)} motions "
        f"from {largest.min():.1f} to {largest.max():.1f} mN m",
    )


def lost_acceleration(moment: float, radius: float) -> float:
    """Acceleration [rad/s2] that the arm may lose before M_A [mN m] vanishes and the block rolls about A (Eq. 2)."""
    spin = BLOCK.inertia + BLOCK.mass * BLOCK.half_height**2
    return -1e-3 * moment / (BLOCK.mass * BLOCK.half_length * radius - spin)


def acceleration_row(plan: ThrowPlan, motions: Sequence[ArmMotion]) -> Row:
    """Row on the second contribution by Eq. 2: the acceleration that a throw may lose with and without margin."""
    reserve = lost_acceleration(float(moment_a(plan.motion, plan.radius).max()), plan.radius)
    without = np.array([lost_acceleration(_moment_at_knots(motion, plan.radius), plan.radius) for motion in motions])
    smaller = percent(without < reserve)
    return Row.compared(
        "miyashita/claim/margins-withstand-lost-acceleration",
        "robust",
        reserve,
        "rad/s2",
        holds=smaller >= MOST,
        note="acceleration that the arm may lose at any time before the block rolls about A, by Eq. 2; "
        f"{np.abs(np.median(without)):.2f} rad/s2 is the median of the motions of Fig. 7b, and {smaller:.0f} % of "
        "these withstand less",
        median_without_margin=float(np.median(without)),
    )


def throw_pair(goals: int) -> ThrowPair:
    """The same throws to random goals with the largest margins, and by Gauss-Newton steps without margin."""
    plans, rows, motions = feasible_goals(goals)[1], list[int](), list[ArmMotion]()
    for row in range(goals):
        throw = Throw(float(plans.u[row, 0]), float(plans.u[row, 1]), float(plans.radius[row]))
        generator = np.random.default_rng(row)
        guesses = (random_unknowns(ARM, generator) for _ in range(TRIES))
        motion = next((m for guess in guesses if (m := careless_motion(throw, ARM, BLOCK, guess)) is not None), None)
        if motion is not None:
            rows.append(row)
            motions.append(motion)
    wide = take(plans, np.array(rows))
    columns = (np.concatenate([getattr(m, name) for m in motions]) for name in ("knots", "time_step", "braking"))
    return ThrowPair(wide, replace(wide, motion=ArmMotion(*columns)))


def _turn_before_release(plans: ThrowPlans, config: OneJointConfig) -> Floats:
    """Largest turn (N,) [deg] of the block against the arm before the planned release, in simulated throws."""
    hidden = draw_hidden([np.random.default_rng(row) for row in range(len(plans.u))], config)
    flight = simulate_flights(make_plant(config, len(plans.u)), plans, hidden)
    turn = np.abs(flight.pose[..., 2] - flight.arm_angle)
    before = np.arange(turn.shape[1]) < flight.clock.release_step[:, None]
    return np.rad2deg(np.where(before, turn, 0.0).max(axis=1))


def disturbed_row(name: str, pair: ThrowPair) -> Row:
    """Row with the share of disturbed throws whose block rolls on the arm, with and without margin."""
    words, errors = DISTURBANCES[name]
    config = OneJointConfig.load("contact", **({"errors": dict(errors)} if errors else {}))
    turns = {kind: _turn_before_release(plans, config) for kind, plans in pair._asdict().items()}
    rolled = {kind: percent(turn > ROLLED) for kind, turn in turns.items()}
    details: dict[str, Any] = {f"largest_turn_{kind}_deg": float(turn.max()) for kind, turn in turns.items()}
    return Row.ours(
        f"miyashita/disturbed/{name}",
        rolled["careless"],
        "%",
        note=f"throws without margin whose block turns on the arm by more than {ROLLED:g} deg before the release, up "
        f"to {turns['careless'].max():.1f} deg; {rolled['wide']:.0f} % of the same throws with margin. Disturbed by "
        f"{words}; stoppers of 2 mm, {len(pair.wide.u)} random goals, seed 0",
        share_with_margin=rolled["wide"],
        **details,
    )


def _late_row(pair: ThrowPair) -> Row:
    """Row on a release that is late, at which a margin cannot help: both throws release from one state."""
    config = OneJointConfig.load("nominal", errors={**_NO_ERRORS, "delay": LATE})
    missed: dict[str, float] = {}
    for kind, plans in pair._asdict().items():
        hidden = draw_hidden([np.random.default_rng(row) for row in range(len(plans.u))], config)
        flight = simulate_flights(make_plant(config, len(plans.u)), plans, hidden)
        error = flight.nearest(plans.goal, config.scale.weights()) - plans.goal
        missed[kind] = float(np.median(misses(error).position))
    return Row.ours(
        "miyashita/disturbed/late-release",
        missed["careless"],
        "m",
        note=f"median position error of throws without margin whose block comes free {1e3 * LATE:g} ms late; "
        f"{1e3 * missed['wide']:.1f} mm with margin: both release from one state, and the margin does not help here",
        with_margin=missed["wide"],
    )


def margins_figure(plan: ThrowPlan, motions: Sequence[ArmMotion]) -> Figure:
    """Drawing of M_A up to the release, with and without a maximised margin (Fig. 7)."""
    figure, axes = subplots(2, 1, (WIDTH, 6.4), sharex=True, sharey=True)
    best, share = moment_a(plan.motion, plan.radius), np.linspace(0.0, 1.0, 400)
    axes[0].plot(share, best, color=COLOURS[0], linewidth=1.2)
    axes[0].fill_between(share, best.max(), 0.0, color=COLOURS[2], alpha=0.25)
    for colour, motion in zip(COLOURS, motions, strict=False):
        axes[1].plot(share, moment_a(motion, plan.radius), color=colour, linewidth=1.2)
    titles = ("(a) margin maximised", "(b) limits kept by Gauss-Newton steps, nothing maximised")
    for panel, title in zip(axes, titles, strict=True):
        panel.axhline(0.0, color="black", linewidth=1)
        dress(panel, "share of the time to the release", "moment M_A [mN m]", title)
        panel.label_outer()
    return figure
