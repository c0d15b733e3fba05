"""Picture of a line's plans: the line to scale, fates of objects, energy, and where each item lands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Floats

from ..ground.drawings import COLOURS, Axes, dress, stacked_panels, svg
from ..ground.tables import percent
from ..judging.work_shifts.fates import FATES, WORDS
from .plan_view import draw_line
from .planned import Planned

WIDTH: Final = 6.4
"""Width of the picture, at which its words are read on a narrow screen too [in]."""
FATE_COLOURS: Final = ("#55a868", "#8172b3", "#c44e52", "#dd8452", "#ccb974", "#b0b0b0")
"""Colours of the fates, in their order."""
ROW: Final = 0.3
"""Height of a plan's bar [in]."""
EDGE: Final = 1.5
"""Half width of a landing's panel over half the opening."""


def plan_picture(
    plans: Sequence[Planned], plan: Planned, releases: tuple[str, str], twin: Planned, recovery: float
) -> str:
    """Picture of all plans and, in more detail, of one plan, as SVG.

    Args:
        plans: all plans.
        plan: the plan that is drawn to scale.
        releases: name of the plans' release, and of the twin's.
        twin: the drawn plan with another release.
        recovery: recovery to reach.
    """
    ordered = sorted(plans, key=lambda each: _place(each.row))
    items, bars = len(plan.config.cell.items), ROW * len(plans)
    landing_rows = -(-items // 2)
    figure, (view, fates, energy, landings) = stacked_panels(WIDTH, (2.9, 1.5 + bars, 0.9 + bars, 2.9 * landing_rows))
    draw_line(view.subplots(), plan.config, f"{_row_text(plan.row, plans)}, to scale")
    _draw_fates(fates.subplots(), ordered, recovery)
    _draw_energy(energy.subplots(), ordered)
    panels = np.ravel(landings.subplots(landing_rows, 2, squeeze=False))
    for item, axes in enumerate(panels[:items]):
        _draw_landings(axes, item, ((releases[0], plan), (releases[1], twin)))
    for axes in panels[items:]:
        axes.set_visible(False)
    return svg(figure)


def _place(row: dict[str, Any]) -> tuple[Any, ...]:
    """Order of plans from top to bottom."""
    return row["robots"], row["skills"], row["percent"], row["belt_speed"]


def _row_text(row: dict[str, Any], plans: Sequence[Planned]) -> str:
    """Words for a plan: what differs among the plans, and robots, belt speed and limits always."""
    skills = {plan.row["skills"] for plan in plans}
    robots = "1 robot" if row["robots"] == 1 else f"{row['robots']} robots"
    text = f"{robots}, {row['belt_speed']:.2f} m/s, {row['percent']:g} %"
    return text if len(skills) == 1 else f"{text}, skills {row['skills']}"


def _label_rows(axes: Axes, plans: Sequence[Planned]) -> None:
    axes.set_yticks(np.arange(len(plans)), labels=[_row_text(plan.row, plans) for plan in plans], fontsize=8)
    axes.invert_yaxis()


def _draw_fates(axes: Axes, plans: Sequence[Planned], recovery: float) -> None:
    """Recovery by number of robots and belt speed, with the causes of losses stacked behind it."""
    left = np.zeros(len(plans))
    splits = any(plan.row["fates"]["lost"] > 0.0 for plan in plans)
    for fate, colour in zip(FATES, FATE_COLOURS, strict=True):
        share = np.array([100.0 * plan.row["fates"][fate] for plan in plans])
        words = WORDS[fate] if splits or fate != "missed" else "thrown, missed the bin or lost"
        axes.barh(np.arange(len(plans)), share, left=left, color=colour, label=words, height=0.75)
        left += share
    for index, plan in enumerate(plans):
        axes.text(1.0, index, percent(plan.row["recovery"]), va="center", fontsize=8, color="white")
    axes.axvline(100.0 * recovery, color="black", linewidth=0.8, linestyle="--")
    _label_rows(axes, plans)
    title = f"What became of the objects (dashed: recovery to reach, {percent(recovery)})"
    dress(axes, "share of the objects that came [%]", "", title, xlim=(0.0, 100.0))
    axes.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.3, -0.45 / max(ROW * len(plans), 0.5)), ncols=2)


def _draw_energy(axes: Axes, plans: Sequence[Planned]) -> None:
    """Joules for each sorted object."""
    joules = [plan.row["energy_per_sorted_j"] for plan in plans]
    values = [0.0 if value is None else value for value in joules]
    axes.barh(np.arange(len(plans)), values, color=COLOURS[0], height=0.75)
    for index, value in enumerate(joules):
        axes.text(0.0, index, "  not counted" if value is None else f"  {value:.1f} J", va="center", fontsize=8)
    _label_rows(axes, plans)
    dress(axes, "energy of the motors for a sorted object [J]", "", "What a sorted object costs in energy")


def _draw_landings(axes: Axes, item: int, releases: Sequence[tuple[str, Planned]]) -> None:
    """Where an item comes down around the middle of its bin's opening, with two releases."""
    plan = releases[0][1]
    name, opening = plan.config.cell.items[item], 1000.0 * _opening(plan, item)
    half = EDGE * opening.max() / 2.0
    from matplotlib.patches import Rectangle  # noqa: PLC0415 - heavy, needed for reports only

    axes.add_patch(Rectangle((-opening[0] / 2, -opening[1] / 2), *opening, fill=False, linewidth=1.5))
    for (release, planned), colour, mark in zip(releases, (COLOURS[3], COLOURS[0]), ("x", "o"), strict=True):
        points = 1000.0 * planned.counted.landings[item] if planned.counted else np.zeros((0, 2))
        inside = np.clip(points, -half, half)
        words = f"{release}: {percent(planned.thrown_badly(item))} miss"
        axes.scatter(*inside.T, s=10, color=colour, marker=mark, alpha=0.7, linewidths=0.8, label=words)
    dress(axes, "along the belt [mm]", "across [mm]", f"{name}: landings around the opening", legend="upper center")
    axes.set(xlim=(-half, half), ylim=(-half, 1.5 * half), aspect="equal")


def _opening(plan: Planned, item: int) -> Floats:
    """Opening of the first bin that takes an item [m]."""
    name, config = plan.config.cell.items[item], plan.config
    bins = [bin_ for index in range(len(config.robots)) for bin_ in config.cell_of(index).bins.fixed]
    return np.array(next(bin_.size for bin_ in bins if not bin_.accepts or name in bin_.accepts))
