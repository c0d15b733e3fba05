"""The throw in a free direction drawn beside the straight one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.reproduce.hassan_cases import PICKS, PROTOCOLS, TARGETS, cell_cycle
from pnt_gym.planning import MotionLimits, flight_state
from pnt_gym.planning.arrays import Floats, length
from pnt_gym.planning.ballistics import flight_time
from pnt_gym.planning.cycle import Cycle

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EXAMPLE: Final = ("outside", 45)
"""Zone and percentage that are drawn, from the first pick."""
RATE: Final = 2000.0
"""Samples per second of the drawn motions [Hz]."""


def free_figure(free: Callable[[str, float], Cycle]) -> str:
    """Side view, speed and acceleration of both throws, as SVG."""
    cycles = {
        "straight throw": cell_cycle("limits-respected", "min-time-throw", *EXAMPLE),
        "free direction": free(*EXAMPLE),
    }
    figure, axes = subplots(2, 2, (12.5, 5.6), width_ratios=(1.3, 1.0))
    for k, (name, cycle) in enumerate(cycles.items()):
        _side_view(axes[2 * k], cycle, f"{name}: pick to pick in {cycle.duration[0]:.3f} s")
    handles = axes[0].get_legend_handles_labels()
    axes[2].legend(*handles, fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.28))
    limits = MotionLimits.t3kr(EXAMPLE[1]).numbers()
    for k, name in enumerate(("speed [m/s]", "acceleration [m/s²]")):
        _over_time(axes[2 * k + 1], cycles, k, name, limits[k])
    axes[1].legend(fontsize=8)
    figure.suptitle(f"first pick, target {EXAMPLE[0]}, {EXAMPLE[1]} % of the robot's limits", fontsize=11)
    for panel in axes:
        panel.grid(alpha=0.3)
    return svg(figure)


def _side_view(axes: Axes, cycle: Cycle, title: str) -> None:
    """The hand before and after the release, the object in flight, and the ceiling of the release."""
    target = TARGETS[EXAMPLE[0]]
    released, ended = float(cycle.release_time[0]), float(cycle.duration[0])
    for k, (begin, end, label) in enumerate(((0.0, released, "hand and object"), (released, ended, "hand alone"))):
        points = cycle.sample(np.linspace(begin, end, 400)).position[0]
        axes.plot(*_side(points), color=COLOURS[k], label=label)
    start, velocity = cycle.release_position[0], cycle.release_velocity[0]
    steps = np.linspace(0.0, float(flight_time(start, velocity, target[2])), 100)
    axes.plot(*_side(flight_state(start, velocity, steps)[0]), ":", color="black", label="object in flight")
    axes.plot(*_side(start), "o", color="black", markersize=4, label="release")
    axes.plot(*_side(np.array(target)), "v", color=COLOURS[3], label="target")
    rise = PROTOCOLS["limits-respected"].rules.rise
    if rise is not None:
        axes.axhline(PICKS[0][2] + rise, color=COLOURS[3], linewidth=1, label="ceiling of the release")
    axes.set_title(title, fontsize=10)
    axes.set_xlabel("distance from the pick towards the target [m]")
    axes.set_ylabel("height z [m]")
    axes.set_aspect("equal")
    axes.set_ylim(-0.88, -0.56)


def _side(points: Floats) -> tuple[Floats, Floats]:
    """Horizontal distance from the pick towards the target, and height."""
    pick, target = np.array(PICKS[0]), np.array(TARGETS[EXAMPLE[0]])
    line = (target - pick)[:2] / np.hypot(*(target - pick)[:2])
    return (points - pick)[..., :2] @ line, points[..., 2]


def _over_time(axes: Axes, cycles: dict[str, Cycle], row: int, name: str, limit: float) -> None:
    """Speed (row 0) or acceleration (row 1) of both hands, and their limit."""
    for colour, (title, cycle) in zip((COLOURS[2], COLOURS[4]), cycles.items(), strict=True):
        times = np.arange(0.0, cycle.duration[0], 1.0 / RATE)
        motion = cycle.sample(times)
        axes.plot(times, length((motion.velocity, motion.acceleration)[row][0]), color=colour, label=title)
        axes.axvline(cycle.release_time[0], color=colour, linestyle=":", linewidth=1)
    axes.axhline(limit, color=COLOURS[3], linestyle="--", linewidth=1, label="limit")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("time [s]; dotted: release")
    axes.set_ylabel(name)
