"""The paper's learning where the stoppers stay solid: the block is pushed while it leaves the arm.

Miyashita et al. 2010 take the release as instantaneous. What the push does depends on friction and compliance that are
assumed, so nothing here is judged by the paper.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.planning.one_joint import plan_throws
from pnt_gym.robots.one_joint.model import STOPPER_HEIGHT

from ...ground.drawings import COLOURS, Figure, dress, subplots
from ..finding import Findings, Row
from ..grids import listed
from .cases import GOAL, POSITION, TRIALS, Learned, Thrower, feasible_goals, learn, misses, percent, rounded
from .reach import size

GOALS: Final = 20
"""The paper's goal and random ones."""
HEIGHTS: Final = (0.0002, 0.0005, 0.001, STOPPER_HEIGHT)
"""Of stoppers [m]; the last one is published."""


def contact_findings(goals: int = GOALS) -> Findings:
    """What the push does, and how the paper's update fails that knows nothing of it."""
    every = np.concatenate([GOAL[None], feasible_goals(goals - 1)[0]])
    learned = learn(Thrower(OneJointConfig.load("contact"), range(goals)), every, np.full(goals, 0.5))
    missed = size(learned.true)
    data = {"miyashita_contact": rounded(np.quantile(missed, (0.25, 0.5, 0.75), axis=1).T)}
    figures = {"miyashita_contact.svg": update_figure(missed)}
    return listed("Stoppers that push the block", [*_push(), _update_row(learned)], figures, data, drop="miyashita/")


def _push() -> list[Row]:
    """Spin that the block has lost when it is free, by the height of the stoppers."""
    count = len(HEIGHTS)
    plans = plan_throws(np.tile(GOAL, (count, 1)))
    thrower = Thrower(OneJointConfig.load("contact", mismatch=0.0), range(count))
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


def _update_row(learned: Learned) -> Row:
    first, last = misses(learned.true[0]), misses(learned.true[-1])
    worse = percent(size(learned.true[-1]) > size(learned.true[0]))
    own = misses(learned.true[:, 0])
    return Row.ours(
        "miyashita/contact/paper-update",
        float(np.median(last.position)),
        "m",
        beside=f"< {POSITION:g} m",
        note=f"median true position error of {len(learned.guarded)} goals (the paper's, random ones of seed 0) at "
        f"throw {TRIALS} with K = 0.5, after {np.median(first.position):.3f} m at the first; the angle goes from "
        f"{np.median(first.angle):.0f} to {np.median(last.angle):.0f} deg, {worse:.0f} % of the goals end farther off "
        f"than they began: more speed means more push. {percent(learned.guarded):.0f} % of the virtual goals had to be "
        "held back at the arm's limits",
        position_paper_goal=own.position.tolist(),
        angle_paper_goal_deg=own.angle.tolist(),
        share_worse=worse,
        share_reached=percent(size(learned.true[-1]) < 1.0),
    )


def update_figure(missed: Floats) -> Figure:
    """Errors (J, N) from throw to throw: median and quartiles over the goals."""
    figure, (panel,) = subplots(1, 1, (6.4, 3.6))
    low, middle, high = np.quantile(missed, (0.25, 0.5, 0.75), axis=1)
    throws = np.arange(1, len(missed) + 1)
    panel.plot(throws, middle, ".-", color=COLOURS[3], label=f"the paper's update, K = 0.5 ({missed.shape[1]} goals)")
    panel.fill_between(throws, low, high, color=COLOURS[3], alpha=0.15, lw=0)
    panel.axhline(1.0, color="black", linestyle="--", linewidth=1, label="5 mm and 2°")
    panel.set_yscale("log")
    title = "block pushed by the stoppers: median and quartiles"
    dress(panel, "throw", "true error / (5 mm, 2°), the larger", title)
    panel.legend(fontsize=8)
    return figure
