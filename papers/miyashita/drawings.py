"""Drawings of the one-joint thrower: arm, pallets and flights in the plane, and the arm's motion over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from agents.ground.drawings import Axes, dress
from pnt_gym.arrays import Floats
from pnt_gym.cells.one_joint.pallets import Pallet
from pnt_gym.planning.one_joint import ArmMotion

from .cases import ARM, BLOCK
from .passing import flight_poses

WOOD: Final = "#e3c878"


def draw_box(axes: Axes, box: Floats, **style: Any) -> None:
    """Draw a box (5,) = centre x, y, half sizes [m], angle [rad]."""
    from matplotlib.patches import Polygon  # noqa: PLC0415 - heavy, needed for drawings only

    x, y, half_u, half_v, angle = (float(v) for v in box)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (half_u, half_v)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    axes.add_patch(Polygon(corners @ turn + (x, y), closed=True, **style))


def draw_arm(axes: Axes, angle: float) -> None:
    """Draw the arm's plate, whose upper surface passes through the pivot."""
    thickness = ARM.thickness
    centre = 0.5 * thickness * np.array([np.sin(angle), -np.cos(angle)])
    box = np.array([*centre, 0.5 * ARM.length, 0.5 * thickness, angle])
    draw_box(axes, box, facecolor="#c8c8c8", edgecolor="gray", linewidth=0.5)


def draw_block(axes: Axes, pose: Floats, colour: str, **style: Any) -> None:
    """Draw the block at a pose x, y, phi (3,)."""
    x, y, phi = pose
    box = np.array([x, y, BLOCK.half_length, BLOCK.half_height, phi])
    draw_box(axes, box, facecolor=WOOD, edgecolor=colour, linewidth=1.0, **style)


def draw_pallets(axes: Axes, pallets: Sequence[Pallet]) -> None:
    """Draw the walls of pallets."""
    for pallet in pallets:
        for wall in pallet.walls:
            draw_box(axes, wall, facecolor="#9e7649", edgecolor="black", linewidth=0.5)


def draw_flight(axes: Axes, u: Floats, colour: str, pictures: int, label: str | None = None) -> None:
    """Draw the block along its flight from the release u (4,)."""
    poses = flight_poses(u[None], BLOCK.half_height)[0]
    axes.plot(poses[:, 0], poses[:, 1], ":", color=colour, linewidth=1.2, label=label)
    for pose in flight_poses(u[None], BLOCK.half_height, pictures)[0]:
        draw_block(axes, pose, colour, alpha=0.75)


def draw_plane(axes: Axes, across: tuple[float, float], up: tuple[float, float], title: str = "") -> None:
    """Draw the pivot, and set the axes to a part of the plane of the throw [m]."""
    axes.plot(0.0, 0.0, "o", color="black", markersize=4, label="pivot")
    axes.set(xlim=across, ylim=up, aspect="equal")
    dress(axes, "x [m]", "y [m]", title)


def draw_motion(panels: Sequence[Axes], motion: ArmMotion, end: float, **style: Any) -> None:
    """Draw angle, speed and acceleration of a motion (1 row) from its beginning to `end` [s], one in each panel."""
    times = np.linspace(0.0, end, 400)
    angle, speed, acceleration = motion.sample(times)
    names = ("angle [°]", "speed [rad/s]", "acceleration [rad/s²]")
    for panel, name, values in zip(panels, names, (np.rad2deg(angle), speed, acceleration), strict=True):
        panel.plot(times, values[0], **style)
        dress(panel, "time [s]", f"arm's {name}")
