"""Plan view of a line to scale: belt, windows, bins, reach, and in red where no throw arrives."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.scene import belt_extent
from pnt_gym.robots.t3kr.geometry import T3krGeometry

from ..ground.drawings import COLOURS, Axes, dress

GRID: Final = (15, 7)
"""Places along and across a window from which throws are planned."""
WINDOW: Final = "#c9d9ef"
RED: Final = "#d62728"
PALE_RED: Final = "#f4b6b6"


def draw_line(part: Any, config: LineConfig, title: str) -> None:
    """Draw a line from above, to scale, into a part of a figure."""
    from matplotlib.patches import Ellipse, Rectangle  # noqa: PLC0415 - heavy, needed for reports only

    axes: Axes = part.subplots()
    cell, belt, geometry = LineCell(config, 1), config.cell.belt, T3krGeometry()
    (low, high), (right, left) = belt_extent(config), belt.lane_y
    middle, width, (begin, end) = (right + left) / 2.0, left - right, belt.pick_x
    axes.add_patch(Rectangle((low, right), high - low, width, color="#e4e4e4", zorder=0))
    arrow = {"arrowstyle": "<-"}
    axes.annotate("belt", (low + 0.1, middle), (low + 0.3, middle), va="center", fontsize=8, arrowprops=arrow)
    for index, robot in enumerate(config.robots):
        axes.add_patch(Rectangle((robot.x + begin, right), end - begin, width, color=WINDOW, zorder=1))
        reach = 2.0 * geometry.workspace_x, 2.0 * geometry.workspace_y
        axes.add_patch(Ellipse((robot.x, 0.0), *reach, fill=False, linestyle="--", linewidth=0.7, color="#4c72b0"))
        axes.annotate(robot.name, (robot.x, right - 0.04), ha="center", va="top", fontsize=8, color="#4c72b0")
        _draw_bins(axes, config, index, _arriving(cell, index))
    _explain(axes, title)
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
        size = _spacing(config)
        for (x, y), reached in zip(places[:, :2] - size / 2.0, count, strict=True):
            if reached < len(arrives):
                colour = PALE_RED if reached else RED
                axes.add_patch(Rectangle((robot.x + x, y), *size, color=colour, linewidth=0.0, zorder=2))


def _spacing(config: LineConfig) -> Floats:
    """Distances of the places from which throws are planned, along and across the belt (2,) [m]."""
    belt = config.cell.belt
    return np.array([np.ptp(belt.pick_x) / GRID[0], np.ptp(belt.lane_y) / GRID[1]])


def _explain(axes: Axes, title: str) -> None:
    """Name the axes and colours."""
    for colour, words in ((WINDOW, "window"), (PALE_RED, "not every bin is reached"), (RED, "no throw arrives")):
        axes.scatter([], [], s=30, marker="s", color=colour, label=words)
    axes.plot([], [], linestyle="--", linewidth=0.7, color="#4c72b0", label="reach of the hand")
    dress(axes, "along the belt [m]", "across [m]", title)
    axes.set_aspect("equal")
    axes.autoscale_view()


def _arriving(cell: LineCell, robot: int) -> dict[int, tuple[Floats, Bools]]:
    """Places in a robot's window (G, 3), and from which of them a throw arrives (G,), by each bin that the robot uses.

    An object of the first accepted item that the robot takes stands for all; the fastest speed setting decides.
    """
    planner, config = cell.chooser.planner_of(robot), cell.config
    accepts, objects = planner.config.acceptance(), cell.stream.objects
    belt, percent = planner.config.belt, max(planner.config.limits.percent)
    ends, spacing = (belt.pick_x[0], belt.lane_y[0]), _spacing(config)
    grid = np.meshgrid(*(end + step * (np.arange(n) + 0.5) for end, step, n in zip(ends, spacing, GRID, strict=True)))
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
