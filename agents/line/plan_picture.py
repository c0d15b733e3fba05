"""Picture of a line's plans: the line to scale, fates of objects, energy, and where each item lands."""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.scene import belt_extent

from ..ground.drawings import COLOURS, Axes, dress, stacked_panels, svg
from ..ground.tables import percent
from ..judging.losses import FATES, WORDS
from . import sensitivity
from .goal import Goal
from .plans import Planned
from .verdict import Verdict

GRID: Final = (15, 7)
"""Places along and across a window from which throws are planned."""
WINDOW: Final = "#c9d9ef"
RED: Final = "#d62728"
PALE_RED: Final = "#f4b6b6"


def _draw(part: Any, config: LineConfig, title: str) -> None:
    """Draw a line from above, to scale, into a part of a figure."""
    from matplotlib.patches import Ellipse, Rectangle  # noqa: PLC0415 - heavy, needed for reports only

    axes: Axes = part.subplots()
    cell, belt, sheets = LineCell(config, 1), config.cell.belt, config.sheets()
    (low, high), (right, left) = belt_extent(config), belt.lane_y
    middle, width, (begin, end) = (right + left) / 2.0, left - right, belt.pick_x
    axes.add_patch(Rectangle((low, right), high - low, width, color="#e4e4e4", zorder=0))
    arrow = {"arrowstyle": "<-"}
    axes.annotate("belt", (low + 0.1, middle), (low + 0.3, middle), va="center", fontsize=8, arrowprops=arrow)
    for index, robot in enumerate(config.robots):
        axes.add_patch(Rectangle((robot.x + begin, right), end - begin, width, color=WINDOW, zorder=1))
        reach = sheets[index].reach
        outlines = [reach.semi_axes, *([(reach.hole, reach.hole)] if reach.hole else [])]
        for along, across in outlines:
            border = Ellipse((robot.x + reach.x, reach.y), 2.0 * along, 2.0 * across, fill=False, linestyle="--")
            border.set(linewidth=0.7, edgecolor="#4c72b0")
            axes.add_patch(border)
        axes.annotate(robot.name, (robot.x, right - 0.04), ha="center", va="top", fontsize=8, color="#4c72b0")
        _draw_bins(axes, config, index, arriving(cell, index))
    for colour, words in ((WINDOW, "window"), (PALE_RED, "not every bin is reached"), (RED, "no throw arrives")):
        axes.scatter([], [], s=30, marker="s", color=colour, label=words)
    axes.plot([], [], linestyle="--", linewidth=0.7, color="#4c72b0", label="reach of the hand")
    dress(axes, "along the belt [m]", "across [m]", title)
    axes.set_aspect("equal")
    axes.autoscale_view()
    part.legend(*axes.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=2)


def _draw_bins(axes: Axes, config: LineConfig, index: int, arrives: dict[int, tuple[Floats, Bools]]) -> None:
    """Draw a robot's bins, and the places of its window from which no throw arrives."""
    from matplotlib.patches import Rectangle  # noqa: PLC0415 - heavy, needed for reports only

    robot, bins = config.robots[index], config.cell_of(index).bins.fixed
    for number, bin_ in enumerate(bins):
        used, size = number in arrives, bin_.size
        reached = used and bool(arrives[number][1].any())
        colour = COLOURS[number % len(COLOURS)] if reached else RED if used else "#999999"
        corner = robot.x + bin_.x - size[0] / 2, bin_.y - size[1] / 2
        axes.add_patch(Rectangle(corner, *size, fill=used, facecolor=f"{colour}40", edgecolor=colour, linewidth=1.2))
        axes.annotate(bin_.name, (robot.x + bin_.x, bin_.y), ha="center", va="center", fontsize=6, rotation=90)
    if arrives:
        places = next(iter(arrives.values()))[0]
        count = np.sum([feasible for _, feasible in arrives.values()], axis=0)
        size = spacing(config)
        for (x, y), reached in zip(places[:, :2] - size / 2.0, count, strict=True):
            if reached < len(arrives):
                colour = PALE_RED if reached else RED
                axes.add_patch(Rectangle((robot.x + x, y), *size, color=colour, linewidth=0.0, zorder=2))


def spacing(config: LineConfig) -> Floats:
    """Distances of the places from which throws are planned, along and across the belt (2,) [m]."""
    belt = config.cell.belt
    return np.array([np.ptp(belt.pick_x) / GRID[0], np.ptp(belt.lane_y) / GRID[1]])


def arriving(cell: LineCell, robot: int) -> dict[int, tuple[Floats, Bools]]:
    """Places in a robot's window (G, 3), and from which of them a throw arrives (G,), by each bin that the robot uses.

    An object of the first accepted item that the robot takes stands for all; the fastest speed setting decides.
    """
    planner, config = cell.chooser.planner_of(robot), cell.config
    accepts, objects = planner.config.acceptance(), cell.stream.objects
    belt, percent = planner.config.belt, max(planner.config.limits.percent)
    ends, steps = (belt.pick_x[0], belt.lane_y[0]), spacing(config)
    grid = np.meshgrid(*(end + step * (np.arange(n) + 0.5) for end, step, n in zip(ends, steps, GRID, strict=True)))
    x, y = (values.ravel() for values in grid)
    arriving: dict[int, tuple[Floats, Bools]] = {}
    for number in range(accepts.shape[1]):
        items = np.flatnonzero(accepts[:, number] & config.can_take()[robot])
        rows = np.flatnonzero(np.isin(objects.kind[0], items))
        if rows.size == 0:
            continue
        index = np.zeros(len(x), dtype=np.int64), np.full(len(x), rows[0])
        throws = take(objects, index).replace(percent=np.full(len(x), percent))
        height = planner.height(throws.size, throws.known_depth)
        places = np.stack([x, y, height], axis=-1)
        _, feasible = planner.plan_into(throws, places, np.full(len(x), number))
        arriving[number] = places, feasible
    return arriving


WIDTH: Final = 6.4
"""Width of the picture, at which its words are read on a narrow screen too [in]."""
FATE_COLOURS: Final = ("#55a868", "#8172b3", "#c44e52", "#dd8452", "#ccb974", "#b0b0b0", "#555555")
"""Colours of the fates, in their order."""
ROW: Final = 0.3
"""Height of a plan's bar [in]."""
EDGE: Final = 1.5
"""Least half width of a panel of landings over half the opening."""
FARTHEST: Final = 4.0
"""Largest half width of a panel of landings over half the opening; farther landings are drawn at the edge."""
NOWHERE: Final = np.zeros((0, 2))
"""No landings."""


def plan_picture(plans: Sequence[Planned], verdict: Verdict, goal: Goal) -> str:
    """Picture of all plans and, in more detail, of the plan of their verdict, as SVG; with the goal of the plans."""
    plan = verdict.plan
    releases = (verdict.release, plan), (verdict.other_release, verdict.twin)
    order = itemgetter("robots", "skills", "percent", "belt_speed")
    ordered = sorted(plans, key=lambda each: order(each.row))
    items = len(plan.config.cell.items)
    landing_rows = -(-items // 2)
    heights = [2.7, 2.0 + ROW * len(plans), 0.4 + 2.7 * landing_rows]
    numbers = {gain.what for gain in verdict.swings}
    figure, (view, bars, landings, *rest) = stacked_panels(
        WIDTH, [*heights, *([1.0 + ROW * len(numbers)] if numbers else [])]
    )
    for part in rest:
        sensitivity.draw(part, verdict.swings, plan.row["money_per_hour"])
    _draw(view, plan.config, f"The line to scale: {_text(plan.row, plans)}")
    fates, energy = bars.subplots(1, 2, sharey=True, width_ratios=(3, 1))
    # Recovery by number of robots and belt speed, with the causes of losses stacked behind it.
    left = np.zeros(len(ordered))
    splits = any(plan.row["fates"]["lost"] > 0.0 for plan in ordered)
    for fate, colour in zip(FATES, FATE_COLOURS, strict=True):
        share = np.array([100.0 * plan.row["fates"][fate] for plan in ordered])
        words = WORDS[fate] if splits or fate != "missed" else "thrown, missed the bin or lost"
        fates.barh(np.arange(len(ordered)), share, left=left, color=colour, label=words, height=0.75)
        left += share
    for index, each in enumerate(ordered):
        fates.text(1.0, index, percent(each.row["recovery"]), va="center", fontsize=8, color="white")
    title = "What became of the objects"
    if goal.figure == "recovery":
        fates.axvline(100.0 * goal.least, color="black", linewidth=0.8, linestyle="--")
        title += f" (dashed: {percent(goal.least)})"
    dress(fates, "share of the objects that came [%]", "", title, xlim=(0.0, 100.0))
    # Joules for each sorted object.
    joules = [plan.row["energy_per_sorted_j"] for plan in ordered]
    values = [0.0 if value is None else value for value in joules]
    energy.barh(np.arange(len(ordered)), values, color=COLOURS[0], height=0.75)
    for index, value in enumerate(joules):
        energy.text(0.0, index, "  unknown" if value is None else f"  {value:.1f} J", va="center", fontsize=8)
    dress(energy, "energy [J]", "", "Per sorted object", xlim=(0.0, 1.2 * max(values) + 1.0))
    fates.set_yticks(np.arange(len(plans)), labels=[_text(each.row, plans) for each in ordered], fontsize=8)
    fates.invert_yaxis()
    bars.legend(*fates.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=2)
    panels = np.ravel(landings.subplots(landing_rows, 2, squeeze=False))
    for item, axes in enumerate(panels[:items]):
        _landings(axes, item, releases)
    for axes in panels[items:]:
        axes.set_visible(False)
    landings.legend(*panels[0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=3)
    return svg(figure)


def line_picture(config: LineConfig, title: str = "The line to scale") -> str:
    """Picture of a line from above, to scale, as SVG."""
    figure, (view,) = stacked_panels(WIDTH, (2.7,))
    _draw(view, config, title)
    return svg(figure)


def _text(row: dict[str, Any], plans: Sequence[Planned]) -> str:
    """Words for a plan: what differs among the plans, and robots, belt speed and limits always."""
    skills = {plan.row["skills"] for plan in plans}
    robots = "1 robot" if row["robots"] == 1 else f"{row['robots']} robots"
    text = f"{robots}, {row['belt_speed']:.2f} m/s, {row['percent']:g} %"
    return text if len(skills) == 1 else f"{text}, skills {row['skills']}"


def _landings(axes: Axes, item: int, releases: Sequence[tuple[str, Planned]]) -> None:
    """Where an item comes down around the middle of its bin's opening, with two releases; lost objects do not."""
    plan = releases[0][1]
    name, cells = plan.config.cell.items[item], plan.config.cells()
    # The opening of the first bin that takes the item [mm].
    opening = 1000.0 * np.array(next(bin_.size for cell in cells for bin_ in cell.bins.fixed if bin_.takes(name)))
    half = EDGE * opening.max() / 2.0
    from matplotlib.patches import Rectangle  # noqa: PLC0415 - heavy, needed for reports only

    points = [1000.0 * planned.counted.landings[item] if planned.counted else NOWHERE for _, planned in releases]
    half = min(max(half, 1.1 * np.abs(np.concatenate(points)).max(initial=0.0)), FARTHEST * opening.max() / 2.0)
    outline = {"fill": False, "linewidth": 1.5, "label": "opening of the bin"}
    axes.add_patch(Rectangle((-opening[0] / 2, -opening[1] / 2), *opening, **outline))
    for (release, _), places, colour, mark in zip(releases, points, (COLOURS[3], COLOURS[0]), ("x", "o"), strict=True):
        axes.scatter(*np.clip(places, -half, half).T, s=10, color=colour, marker=mark, linewidths=0.8, label=release)
    failed, other = (percent(planned.thrown_badly(item)) for _, planned in releases)
    title = f"{name}: {failed} of throws fail,\n{other} with {releases[1][0]}"
    dress(axes, "along the belt [mm]", "across [mm]", title, xlim=(-half, half), ylim=(-half, half), aspect="equal")
