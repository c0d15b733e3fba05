"""Drawings of planned throws: arm, block and flight in the plane, and the arm's motion over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from agents.report.figures import COLOURS, subplots
from agents.reproduce.miyashita_cases import ARM, BLOCK
from pnt_gym.cells.pallet.pallets import Pallet, flight_poses
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.one_joint.grasp import joint_torque, reactions, torque_limit
from pnt_gym.planning.one_joint.plan import ThrowPlan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BEFORE, AFTER = 6, 9
"""Pictures of the block on the arm and in flight."""
WOOD: Final = "#e3c878"


def draw_box(axes: Axes, box: Floats, **style: Any) -> None:
    """A box (5,) = centre x, y, half sizes [m], angle [rad]."""
    from matplotlib.patches import Polygon  # noqa: PLC0415 - heavy, needed for drawings only

    x, y, half_u, half_v, angle = (float(v) for v in box)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (half_u, half_v)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    axes.add_patch(Polygon(corners @ turn + (x, y), closed=True, **style))


def draw_arm(axes: Axes, angle: float, **style: Any) -> None:
    """The plate whose upper surface passes through the pivot."""
    thickness = ARM.thickness
    centre = 0.5 * thickness * np.array([np.sin(angle), -np.cos(angle)])
    draw_box(axes, np.array([*centre, 0.5 * ARM.length, 0.5 * thickness, angle]), **style)


def draw_pallets(axes: Axes, pallets: Sequence[Pallet]) -> None:
    """The walls of pallets."""
    for pallet in pallets:
        for wall in pallet.walls:
            draw_box(axes, wall, facecolor="#9e7649", edgecolor="black", linewidth=0.5)


def draw_flight(axes: Axes, u: Floats, colour: str, pictures: int, label: str | None = None) -> None:
    """The block along its flight from the release u (4,)."""
    poses = flight_poses(u[None], BLOCK.half_height)[0]
    axes.plot(poses[:, 0], poses[:, 1], ":", color=colour, linewidth=1.2, label=label)
    for x, y, phi in flight_poses(u[None], BLOCK.half_height, pictures)[0]:
        box = np.array([x, y, BLOCK.half_length, BLOCK.half_height, phi])
        draw_box(axes, box, facecolor=WOOD, edgecolor=colour, linewidth=1.0, alpha=0.75)


def motion_figure(plan: ThrowPlan) -> Figure:
    """Arm and block from rest to the goal (the paper's Fig. 5)."""
    figure, (axes,) = subplots(1, 1, (6.2, 6.6))
    times = np.linspace(0.0, float(plan.motion.duration[0]), BEFORE)
    for angle in plan.motion.sample(times).angle[0]:
        draw_arm(axes, float(angle), facecolor="#c8c8c8", edgecolor="gray", linewidth=0.5)
        along, up = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        centre = plan.radius * along + BLOCK.half_height * up
        box = np.array([*centre, BLOCK.half_length, BLOCK.half_height, angle])
        draw_box(axes, box, facecolor=WOOD, edgecolor=COLOURS[0], linewidth=1.0)
    draw_flight(axes, plan.u, COLOURS[3], AFTER, "path of the centre of mass")
    axes.plot(*plan.goal[:2], "x", color="black", label="goal: 150°, no vertical speed")
    axes.plot(0.0, 0.0, "o", color="black", markersize=4, label="pivot")
    _plane(axes, (-0.36, 0.36), (-0.20, 0.52))
    axes.legend(fontsize=8, loc="lower left")
    return figure


def _plane(axes: Axes, across: tuple[float, float], up: tuple[float, float]) -> None:
    axes.set_xlim(*across)
    axes.set_ylim(*up)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.grid(alpha=0.3)


def trajectories_figure(plans: Mapping[str, ThrowPlan]) -> Figure:
    """Angle, speed, acceleration and torque up to the release (Fig. 6), for several weights W."""
    figure, axes = subplots(2, 2, (10.5, 5.8), sharex=True)
    for colour, (name, plan) in zip(COLOURS, plans.items(), strict=False):
        times = np.linspace(0.0, float(plan.motion.duration[0]), 400)
        state = plan.motion.sample(times)
        torque = joint_torque(*state, np.array([[plan.radius]]), ARM, BLOCK)
        before = times - times[-1]
        for panel, values in zip(axes, (np.rad2deg(state.angle), *state[1:], torque), strict=True):
            panel.plot(before, values[0], color=colour, label=f"weights {name}")
            panel.plot(before[-1], values[0, -1], "o", color=colour, markersize=4)
        limit = torque_limit(state.speed, ARM)[0]
        axes[3].plot(before, limit, "--", color=colour, linewidth=0.8)
    axes[1].axhline(ARM.speed, color="black", linestyle="--", linewidth=0.8)
    names = ("angle [°]", "speed [rad/s]", "acceleration [rad/s²]", "torque [N m]")
    for panel, name in zip(axes, names, strict=True):
        panel.set_ylabel(name)
        panel.grid(alpha=0.3)
    for panel in axes[2:]:
        panel.set_xlabel("time before the release [s]")
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=4, loc="outside lower center")
    figure.suptitle("arm's motion to the release; dashed: limits", fontsize=10)
    return figure


def margins_figure(plan: ThrowPlan, careless: Sequence[ThrowPlan]) -> Figure:
    """M_A up to the release, with and without a margin that is maximised (Fig. 7)."""
    figure, axes = subplots(1, 2, (10.0, 3.6), sharey=True)
    for panel, plans, title in (
        (axes[0], (plan,), "margin maximised"),
        (axes[1], careless, "limits kept, nothing maximised"),
    ):
        for k, each in enumerate(plans):
            times = np.linspace(0.0, float(each.motion.duration[0]), 400)
            moment = reactions(*each.motion.sample(times), np.array([[each.radius]]), BLOCK).moment_a[0]
            panel.plot(times / times[-1], 1e3 * moment, color=COLOURS[k % len(COLOURS)], linewidth=1.2)
            if len(plans) == 1:
                panel.fill_between(times / times[-1], 1e3 * moment.max(), 0.0, color=COLOURS[2], alpha=0.25)
        panel.axhline(0.0, color="black", linewidth=1)
        panel.set_title(title, fontsize=10)
        panel.set_xlabel("share of the time to the release")
        panel.grid(alpha=0.3)
    axes[0].set_ylabel("moment about the outer vertex M_A [mN m]")
    return figure
