"""Throws with solid stoppers, which push the block while the block leaves the arm.

Computed are the effect of the push, the failure of the paper's learning under the push, and the goals that a release
reaches in spite of the push. Miyashita et al. take the release as instantaneous. The effect of the push depends on
friction and compliance that are assumed here, so all figures are `ours`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.planning.one_joint import plan_throws
from pnt_gym.robots.one_joint.model import STOPPER_HEIGHT

from . import cases
from .reach import ROUNDS, SCANNED, WITHIN, BestReleases, Search, goals_above_arm, size

GOALS: Final = 20
"""Number of goals: the paper's goal and random goals."""
HEIGHTS: Final = (0.0002, 0.0005, 0.001, STOPPER_HEIGHT)
"""Heights of the stoppers [m]; the last height is published."""
REACH_GOALS: Final = 200
"""Number of goals of each kind."""


def contact_findings(goals: int = GOALS) -> Findings:
    """Effect of the push on the spin, and errors of the paper's update under the push."""
    all_goals = np.concatenate([cases.GOAL[None], cases.feasible_goals(goals - 1)[0]])
    learned = cases.learn(
        cases.SimulatedThrower(OneJointConfig.load("contact"), range(goals)), all_goals, np.full(goals, 0.5)
    )
    miss = size(learned.true)
    data = {"miyashita_contact": cases.round_values(np.quantile(miss, (0.25, 0.5, 0.75), axis=1).T)}
    figures = {"miyashita_contact.svg": update_figure(miss)}
    return table_findings(
        "Stoppers that push the block", [*_push_rows(), _update_row(learned)], figures, data, drop="miyashita/"
    )


def _push_rows() -> list[Row]:
    """Rows with the spin that the block loses by the push, by the height of the stoppers."""
    count = len(HEIGHTS)
    plans = plan_throws(np.tile(cases.GOAL, (count, 1)))
    thrower = cases.SimulatedThrower(OneJointConfig.load("contact", mismatch=0.0), range(count))
    sunk = STOPPER_HEIGHT - np.array(HEIGHTS)
    for body in thrower.plant.scene.stoppers or ():
        thrower.plant.batch.expand("body_pos")[:, body, 2] -= sunk
    lost = plans.u[:, 1] - thrower.throw(plans, plans.goal).spin
    return [
        Row.ours(
            f"miyashita/contact/spin-lost-{1e3 * height:g}mm",
            float(value),
            "rad/s",
            beside="0 rad/s" if height == STOPPER_HEIGHT else None,
            note=f"of {u[1]:.2f} rad/s at the paper's goal, with stoppers of {1e3 * height:g} mm and no other error: "
            f"{np.rad2deg(value * u[3]):.0f} deg less at the goal. The outer one pushes from below the centre of mass "
            "until the block has risen past it; the paper takes the release as instantaneous",
        )
        for height, value, u in zip(HEIGHTS, lost, plans.u, strict=True)
    ]


def _update_row(learned: cases.LearningRecord) -> Row:
    first, last = cases.misses(learned.true[0]), cases.misses(learned.true[-1])
    worse = cases.percent(size(learned.true[-1]) > size(learned.true[0]))
    paper_goal = cases.misses(learned.true[:, 0])
    return Row.ours(
        "miyashita/contact/paper-update",
        float(np.median(last.position)),
        "m",
        beside=f"< {cases.POSITION:g} m",
        note=f"median true position error of {len(learned.guarded)} goals (the paper's, random ones of seed 0) at "
        f"throw {cases.TRIALS} with K = 0.5, after {np.median(first.position):.3f} m at the first; the angle goes from "
        f"{np.median(first.angle):.0f} to {np.median(last.angle):.0f} deg, {worse:.0f} % of the goals end farther off "
        f"than they began: more speed means more push. {cases.percent(learned.guarded):.0f} % of the virtual goals had "
        "to be held back at the arm's limits",
        position_paper_goal=paper_goal.position.tolist(),
        angle_paper_goal_deg=paper_goal.angle.tolist(),
        share_worse=worse,
        share_reached=cases.percent(size(learned.true[-1]) < 1.0),
    )


def update_figure(miss: Floats) -> Figure:
    """Drawing of errors (J, N) over throws: median and quartiles over the goals."""
    figure, (panel,) = subplots(1, 1, (6.4, 3.6))
    low, middle, high = np.quantile(miss, (0.25, 0.5, 0.75), axis=1)
    throws = np.arange(1, len(miss) + 1)
    panel.plot(throws, middle, ".-", color=COLOURS[3], label=f"the paper's update, K = 0.5 ({miss.shape[1]} goals)")
    panel.fill_between(throws, low, high, color=COLOURS[3], alpha=0.15, lw=0)
    panel.axhline(1.0, color="black", linestyle="--", linewidth=1, label="5 mm and 2°")
    panel.set_yscale("log")
    title = "block pushed by the stoppers: median and quartiles"
    dress(panel, "throw", "true error / (5 mm, 2°), the larger", title)
    panel.legend(fontsize=8)
    return figure


def reach_findings(goals: int = REACH_GOALS, scanned: int = SCANNED) -> Findings:
    """Shares of the cell's goals and of goals of random releases that some release reaches under the push."""
    cell_goals, release_goals = np.concatenate([cases.GOAL[None], cases.draw_cell_goals(goals)]), goals_above_arm(goals)
    pushed, free = Search(OneJointConfig.load("contact"), scanned), Search(cases.config_with_delay(0.0), scanned)
    count = len(pushed)
    pushed_cell, ideal_cell = pushed.reach(cell_goals), free.reach(cell_goals)
    pushed_release, ideal_release = pushed.reach(release_goals), free.reach(release_goals)
    rows = (
        _reach_row(
            "own-goals", "goals, those that OneJointThrow-v0 draws and the paper's,", pushed_cell, ideal_cell, count
        ),
        _reach_row(
            "any-goals", "goals of random releases (seed 0) above the braked arm", pushed_release, ideal_release, count
        ),
        _paper_goal_row(pushed_cell),
    )
    sizes = {
        "the cell's goals, pushed": pushed_cell.miss,
        "the cell's goals, ideal release": ideal_cell.miss,
        "goals of any release, pushed": pushed_release.miss,
        "goals of any release, ideal release": ideal_release.miss,
    }
    figures = {"miyashita_contact_reach.svg": reach_figure(sizes, cell_goals, release_goals, pushed_release)}
    data = {name: cases.round_values(np.sort(values), 3) for name, values in sizes.items()}
    headline = "What any release reaches although the block is pushed"
    return table_findings(headline, rows, figures, {"miyashita_contact_reach": data}, drop="miyashita/")


def _reach_row(name: str, description: str, reached: BestReleases, control: BestReleases, count: int) -> Row:
    free = cases.percent(control.miss < 1.0)
    return Row.ours(
        f"miyashita/contact/reachable/{name}",
        cases.percent(reached.miss < 1.0),
        "%",
        note=f"of {len(reached.miss)} {description} that some release reaches within {1e3 * WITHIN[0]:g} mm and "
        f"{WITHIN[1]:g} deg although the block is pushed, whatever its vertical speed: best of {count} simulated "
        f"releases all over the arm's range and {ROUNDS} rounds of Gauss-Newton steps from there. The same search "
        f"with an ideal release reaches {free:.1f} %. The median goal is missed by {np.median(reached.miss):.1f} "
        f"times that much, the nearest by {reached.miss.min():.1f} times",
        goals=len(reached.miss),
        share_ideal=free,
        missed_quartiles=cases.round_values(np.quantile(reached.miss, (0.0, 0.25, 0.5, 0.75)), 4),
    )


def _paper_goal_row(reached: BestReleases) -> Row:
    miss = float(reached.miss[0])
    note = (
        f"times {1e3 * WITHIN[0]:g} mm or {WITHIN[1]:g} deg, the larger, by which the best release of all misses "
        f"the paper's goal: {1e3 * WITHIN[0] * miss:.0f} mm or {WITHIN[1] * miss:.0f} deg"
    )
    return Row.ours("miyashita/contact/reachable/paper-goal", miss, "-", note=note)


def reach_figure(sizes: dict[str, Floats], cell_goals: Floats, release_goals: Floats, reached: BestReleases) -> Figure:
    """Drawing of the share of goals over the miss of the best release, and of the places of the goals."""
    figure, (upper, lower) = subplots(2, 1, (WIDTH, 8.0))
    styles = (("-", 3), ("-", 0), ("--", 3), ("--", 0))
    for (name, values), (style, colour) in zip(sizes.items(), styles, strict=True):
        share = 100.0 * np.arange(1, len(values) + 1) / len(values)
        upper.step(np.sort(values), share, style, color=COLOURS[colour], label=name, where="post")
    upper.axvline(1.0, color="black", linestyle=":", linewidth=1)
    upper.set_xscale("log")
    dress(upper, "best release's miss / (5 mm, 2°), the larger", "goals [%]")
    upper.legend(fontsize=8)
    _draw_places(lower, cell_goals, release_goals, reached.miss < 1.0)
    return figure


def _draw_places(panel: Axes, cell_goals: Floats, release_goals: Floats, is_reached: Bools) -> None:
    """Draw distance and angle of goals, by whether a pushed block reaches them."""
    for goals, colour, label in (
        (cell_goals[1:], COLOURS[7], "the cell's goals"),
        (release_goals[~is_reached], COLOURS[1], "goals of any release: out of reach"),
        (release_goals[is_reached], COLOURS[2], "goals of any release: within reach"),
    ):
        distance = np.hypot(goals[:, 0], goals[:, 1])
        panel.scatter(distance, np.rad2deg(goals[:, 2]), s=12, color=colour, alpha=0.7, linewidths=0, label=label)
    panel.scatter(
        np.hypot(*cases.GOAL[:2]), np.rad2deg(cases.GOAL[2]), s=80, marker="*", color="black", label="the paper's goal"
    )
    dress(panel, "goal's distance from the pivot [m]", "goal's angle [°]")
    panel.legend(fontsize=8)
