"""Which goals some release reaches although the stoppers push the block; beside it, where nothing is pushed."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.one_joint.config import OneJointConfig

from ...ground.drawings import COLOURS, Axes, Figure, dress, subplots
from ..finding import Findings, Row
from ..grids import listed
from .cases import GOAL, drawn_goals, late, percent, rounded
from .reach import ROUNDS, SCANNED, WITHIN, Reached, Search, goals_above_arm

GOALS: Final = 200
"""Of each kind."""


def reach_findings(goals: int = GOALS, scanned: int = SCANNED) -> Findings:
    """What is reached of the goals that the cell draws, and of those of any release."""
    own, others = np.concatenate([GOAL[None], drawn_goals(goals)]), goals_above_arm(goals)
    pushed, free = Search(OneJointConfig.load("contact"), scanned), Search(late(0.0), scanned)
    count = len(pushed)
    here, control = pushed.reach(own), free.reach(own)
    there, control_there = pushed.reach(others), free.reach(others)
    rows = (
        _row("own-goals", "goals, those that OneJointThrow-v0 draws and the paper's,", here, control, count),
        _row("any-goals", "goals of random releases (seed 0) above the braked arm", there, control_there, count),
        _paper_goal_row(here),
    )
    sizes = {
        "the cell's goals, pushed": here.size,
        "the cell's goals, ideal release": control.size,
        "goals of any release, pushed": there.size,
        "goals of any release, ideal release": control_there.size,
    }
    figures = {"miyashita_contact_reach.svg": reach_figure(sizes, own, others, there)}
    data = {name: rounded(np.sort(values), 3) for name, values in sizes.items()}
    headline = "What any release reaches although the block is pushed"
    return listed(headline, rows, figures, {"miyashita_contact_reach": data}, drop="miyashita/")


def _row(name: str, what: str, found: Reached, control: Reached, count: int) -> Row:
    free = percent(control.size < 1.0)
    return Row.ours(
        f"miyashita/contact/reachable/{name}",
        percent(found.size < 1.0),
        "%",
        note=f"of {len(found.size)} {what} that some release reaches within {1e3 * WITHIN[0]:g} mm and {WITHIN[1]:g} "
        f"deg although the block is pushed, whatever its vertical speed: best of {count} simulated releases all over "
        f"the arm's range and {ROUNDS} rounds of Gauss-Newton steps from there. The same search with an ideal release "
        f"reaches {free:.1f} %. The median goal is missed by {np.median(found.size):.1f} times that much, the nearest "
        f"by {found.size.min():.1f} times",
        goals=len(found.size),
        share_ideal=free,
        missed_quartiles=rounded(np.quantile(found.size, (0.0, 0.25, 0.5, 0.75)), 4),
    )


def _paper_goal_row(found: Reached) -> Row:
    missed = float(found.size[0])
    note = (
        f"times {1e3 * WITHIN[0]:g} mm or {WITHIN[1]:g} deg, the larger, by which the best release of all misses "
        f"the paper's goal: {1e3 * WITHIN[0] * missed:.0f} mm or {WITHIN[1] * missed:.0f} deg"
    )
    return Row.ours("miyashita/contact/reachable/paper-goal", missed, "-", note=note)


def reach_figure(sizes: dict[str, Floats], own: Floats, others: Floats, there: Reached) -> Figure:
    """How near the best release comes to how many goals, and where the goals lie."""
    figure, (left, right) = subplots(1, 2, (11.0, 3.8))
    styles = (("-", 3), ("-", 0), ("--", 3), ("--", 0))
    for (name, values), (style, colour) in zip(sizes.items(), styles, strict=True):
        share = 100.0 * np.arange(1, len(values) + 1) / len(values)
        left.step(np.sort(values), share, style, color=COLOURS[colour], label=name, where="post")
    left.axvline(1.0, color="black", linestyle=":", linewidth=1)
    left.set_xscale("log")
    dress(left, "best release's miss / (5 mm, 2°), the larger", "goals [%]")
    figure.legend(*left.get_legend_handles_labels(), fontsize=8, ncols=2, loc="outside lower left")
    _places(right, own, others, there.size < 1.0)
    return figure


def _places(panel: Axes, own: Floats, others: Floats, reached: Bools) -> None:
    """Distance and angle of goals, by whether a pushed block reaches them."""
    for goals, colour, label in (
        (own[1:], COLOURS[7], "the cell's goals"),
        (others[~reached], COLOURS[1], "goals of any release: out of reach"),
        (others[reached], COLOURS[2], "goals of any release: within reach"),
    ):
        away = np.hypot(goals[:, 0], goals[:, 1])
        panel.scatter(away, np.rad2deg(goals[:, 2]), s=12, color=colour, alpha=0.7, linewidths=0, label=label)
    panel.scatter(np.hypot(*GOAL[:2]), np.rad2deg(GOAL[2]), s=80, marker="*", color="black", label="the paper's goal")
    dress(panel, "goal's distance from the pivot [m]", "goal's angle [°]")
    panel.legend(fontsize=8)
