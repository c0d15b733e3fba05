"""Drawings of motions: what moves do to the platform's angle, the circle in motor angles, and the closing gripper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from agents.report.figures import COLOURS, subplots
from agents.reproduce.leveziel_model import Followed
from pnt_gym.planning.arrays import Floats
from pnt_gym.robots.gripper4 import MOTOR_SPEED, Motion
from pnt_gym.robots.gripper4.geometry import N_ARMS

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Course(NamedTuple):
    """A move by its closed form (S,), and as the model carried it out (T,): angle [deg], distance from the line [m]."""

    time: Floats
    theta: Floats
    beside: Floats
    done: Floats
    theta_done: Floats
    beside_done: Floats


def moves_figure(courses: Mapping[str, Course]) -> Figure:
    """Angle of the halves and distance from the line over the time."""
    figure, (angle, path) = subplots(1, 2, (11.0, 4.2), sharex=True)
    for k, (name, course) in enumerate(courses.items()):
        colour, style = COLOURS[k // 2], "-" if k % 2 else "--"
        angle.plot(1e3 * course.time, course.theta, style, color=colour, label=name)
        path.plot(1e3 * course.time, 1e3 * course.beside, style, color=colour)
        for panel, values in ((angle, course.theta_done), (path, 1e3 * course.beside_done)):
            panel.plot(1e3 * course.done[::20], values[::20], "o", color=colour, markersize=2.5)
    angle.plot([], [], "o", color="gray", markersize=2.5, label="in MuJoCo")
    angle.set_ylabel("angle of the platform's halves θ [°]")
    path.set_ylabel("distance from the straight line [mm]")
    for panel in (angle, path):
        panel.set_xlabel("time [ms]")
        panel.grid(alpha=0.3)
    figure.legend(*angle.get_legend_handles_labels(), fontsize=8, ncols=4, loc="outside lower center")
    figure.suptitle("50 mm in z, 70 mm in y and in x with θ = -60°, motors at up to 70 rpm", fontsize=11)
    return figure


def turn_figure(turns: Mapping[float, Motion], done: Followed) -> Figure:
    """Motor angles and speeds over a turn of the circle, opened and closed."""
    figure, axes = subplots(2, len(turns), (4.0 * len(turns), 5.4), sharex=True, sharey="row")
    for k, (theta, motion) in enumerate(turns.items()):
        angle, speed = axes[k], axes[len(turns) + k]
        during = done.time <= motion.duration
        for arm in range(N_ARMS):
            angle.plot(motion.time, np.rad2deg(motion.q[:, arm]), color=COLOURS[arm], label=f"motor {arm + 1}")
            angle.plot(
                done.time[during][::60],
                np.rad2deg(done.q[k, during, arm])[::60],
                "o",
                color=COLOURS[arm],
                markersize=2.5,
            )
            speed.plot(motion.time, motion.speed[:, arm] * _RPM, color=COLOURS[arm])
        for limit in (-MOTOR_SPEED, MOTOR_SPEED):
            speed.axhline(limit * _RPM, color="black", linestyle="--", linewidth=0.8)
        angle.set_title(f"θ = {np.rad2deg(theta):.0f}°", fontsize=10)
        speed.set_xlabel("time [s]")
        for panel in (angle, speed):
            panel.grid(alpha=0.3)
    axes[0].plot([], [], "o", color="gray", markersize=2.5, label="in MuJoCo")
    axes[0].set_ylabel("motor angle [°]")
    axes[len(turns)].set_ylabel("motor speed [rpm]")
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=5, loc="outside lower center")
    figure.suptitle("circle of 80 mm at z = -220 mm; dashed: 70 rpm", fontsize=11)
    return figure


def closing_figure(step: float, curves: Mapping[str, Floats], published: float) -> Figure:
    """Angle of the halves over the time for motors that are told to close in different ways."""
    figure, (axes,) = subplots(1, 1, (7.6, 4.4))
    for colour, (name, theta) in zip(("gray", *COLOURS), curves.items(), strict=False):
        axes.plot(1e3 * step * np.arange(1, theta.size + 1), np.rad2deg(theta), color=colour, label=name)
    axes.axvline(1e3 * published, color="black", linestyle="--", linewidth=0.9, label="published, 60 ms")
    axes.axhline(-60.0, color="black", linestyle=":", linewidth=0.8)
    axes.set_xlabel("time [ms]")
    axes.set_ylabel("angle of the platform's halves θ [°]")
    axes.set_xlim(0.0, 120.0)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    axes.set_title("closing at x = y = 0, z = -200 mm, in MuJoCo", fontsize=10)
    return figure


_RPM = 60.0 / (2.0 * np.pi)
