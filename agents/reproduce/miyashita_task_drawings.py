"""Drawings of sorting and assembly: flights past the pallets, arm motions, and pictures from the simulator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from agents.report.figures import COLOURS, subplots
from agents.reproduce.miyashita_cases import ARM
from agents.reproduce.miyashita_drawings import draw_arm, draw_flight, draw_pallets
from pnt_gym.cells.pallet.pallets import SORTING
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.one_joint import ThrowPlans

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES = 14
"""Of the block along a flight: the swept block."""


def sorting_figure(u: Floats) -> Figure:
    """The flights (3, 4) into the three pallets, each past the others (Fig. 13)."""
    figure, axes = subplots(1, 3, (13.0, 4.8), sharey=True)
    for k, panel in enumerate(axes):
        draw_arm(panel, float(u[k, 0]), facecolor="#c8c8c8", edgecolor="gray", linewidth=0.5)
        draw_pallets(panel, SORTING)
        draw_flight(panel, u[k], COLOURS[k], PICTURES)
        panel.plot(0.0, 0.0, "o", color="black", markersize=4)
        x, y, phi, dy = SORTING[k].goal
        panel.set_title(f"({x:g} m, {y:g} m, {np.rad2deg(phi):.0f}°, {dy:g} m/s)", fontsize=10)
        panel.set_xlim(-0.52, 0.36)
        panel.set_ylim(-0.30, 0.56)
        panel.set_aspect("equal")
        panel.set_xlabel("x [m]")
        panel.grid(alpha=0.3)
    axes[0].set_ylabel("y [m]")
    return figure


def task_motions_figure(sorting: ThrowPlans, assembly: Sequence[ThrowPlans]) -> Figure:
    """The arm's planned motions to the releases (Figs. 14 and 17)."""
    figure, axes = subplots(1, 3, (12.5, 3.6))
    named = [(f"sorting, throw {k + 1}", sorting.take(np.array([k]))) for k in range(len(sorting.u))]
    named += [(f"assembly, throw {k + 1}", plans) for k, plans in enumerate(assembly)]
    for colour, (name, plans) in zip(COLOURS, named, strict=False):
        times = np.linspace(0.0, float(plans.motion.duration[0]), 300)
        state = plans.motion.sample(times)
        for panel, values in zip(axes, (np.rad2deg(state.angle), state.speed, state.acceleration), strict=True):
            panel.plot(times, values[0], color=colour, label=name)
            panel.plot(times[-1], values[0, -1], "o", color=colour, markersize=4)
    axes[1].axhline(ARM.speed, color="black", linestyle="--", linewidth=1)
    for panel, name in zip(axes, ("angle [°]", "speed [rad/s]", "acceleration [rad/s²]"), strict=True):
        panel.set_xlabel("time [s]")
        panel.set_ylabel(f"arm's {name}")
        panel.grid(alpha=0.3)
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=5, loc="outside lower center")
    return figure
