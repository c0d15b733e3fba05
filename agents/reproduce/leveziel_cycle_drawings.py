"""Drawings of the cork's cycle of Leveziel et al. (Fig. 8): courses over time, and pictures from the simulator."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from agents.report.figures import COLOURS, subplots
from agents.reproduce.leveziel_cycle_run import Cycles
from pnt_gym.engine import mujoco
from pnt_gym.render.canvas import Canvas, Frame
from pnt_gym.robots.gripper4.build import PROTOTYPE_BUILD

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MILLI: Final = 1e3
SIZE: Final = (400, 340)
"""Height and width of a picture [pixels]."""
PICTURES: Final = (
    ("before", "lower", 0.0),
    ("lowered", "lower", 1.0),
    ("gripped", "close", 1.0),
    ("50 mm up", "lift", 1.0),
    ("half across", "across", 0.5),
    ("70 mm across", "stand", 1.0),
    ("opened", "open", 1.0),
    ("back", "rest", 1.0),
)
"""Title, phase, and the share of the phase that is over."""


def cycle_figure(cycles: Cycles) -> Figure:
    """Motor angles, positions, the halves' angle and the grip of the first cycle, commanded and simulated."""
    figure, axes = subplots(4, 1, (9.5, 10.5), sharex=True)
    time, course = cycles.time, cycles.course
    asked = cycles.recording.control[:, 0:12:3]
    for k in range(4):
        # Motors 1 and 3 move alike in the plane between them.
        width = 3.5 if k == 0 else 1.5
        axes[0].plot(time, np.rad2deg(cycles.angle[0, :, k]), color=COLOURS[k], lw=width, label=f"motor {k + 1}")
        asked_label = "commanded" if k == 3 else None
        axes[0].plot(time, np.rad2deg(asked[:, k]), "--", color="black", linewidth=0.8, label=asked_label)
    _places(axes[1], cycles)
    axes[2].plot(time, np.rad2deg(cycles.platform[0, :, 3]), color=COLOURS[0], label="simulated")
    axes[2].plot(time, np.rad2deg(course.pose[:, 3]), "--", color="black", linewidth=0.8, label="commanded")
    claws = PROTOTYPE_BUILD.claws
    force = np.abs(cycles.bend[0]) * claws.stiffness / claws.length
    for k, side in enumerate(("right", "left")):
        axes[3].plot(time, force[:, k], color=COLOURS[k], label=f"{side} finger")
        _contacts(axes[3], time, cycles.pads[0, :, k], -0.35 - 0.35 * k, COLOURS[k], side)
    names = (
        "motor angle [°]",
        "position [mm]",
        "angle of the halves [°]",
        "force of the finger's spring\nat its pad [N]",
    )
    for panel, name in zip(axes, names, strict=True):
        panel.set_ylabel(name)
        panel.grid(alpha=0.3)
        panel.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
        for end in course.ends.values():
            panel.axvline(end, color="gray", linewidth=0.7)
    _phases(axes[0], cycles)
    axes[3].set_xlabel("time [s]")
    return figure


def _places(panel: Axes, cycles: Cycles) -> None:
    time = cycles.time
    for axis, name, colour in ((1, "y", COLOURS[2]), (2, "z", COLOURS[3])):
        panel.plot(time, MILLI * cycles.platform[0, :, axis], color=colour, label=f"platform, {name}")
        panel.plot(time, MILLI * cycles.cork[0, :, axis], ":", color=colour, label=f"cork, {name}")
    panel.plot(time, MILLI * cycles.course.pose[:, 1:3], "--", color="black", linewidth=0.8)


def _contacts(panel: Axes, time: Any, touching: Any, level: float, colour: str, side: str) -> None:
    """A bar as long as a pad touches the cork."""
    panel.plot(time, np.where(touching, level, np.nan), color=colour, linewidth=3, label=f"{side} pad touches")


def _phases(panel: Axes, cycles: Cycles) -> None:
    """Names of the phases above a panel."""
    begin = 0.0
    for name, end in cycles.course.ends.items():
        panel.text(
            0.5 * (begin + end), 1.02, name, ha="center", va="bottom", fontsize=8, transform=panel.get_xaxis_transform()
        )
        begin = end


def pictures(cycles: Cycles) -> list[tuple[str, Frame]]:
    """Pictures of the first cycle with their titles (Fig. 8 shows such photographs).

    Raises:
        ConfigError: this machine cannot draw.
    """
    course, step = cycles.course, cycles.config.timestep
    begins = dict(zip(course.ends, [0.0, *course.ends.values()], strict=False))
    wanted = {title: begins[phase] + share * (course.ends[phase] - begins[phase]) for title, phase, share in PICTURES}
    canvas, found = Canvas(camera(), SIZE), list[tuple[str, Frame]]()
    coming = iter(wanted.items())
    title, moment = next(coming)
    try:
        for data, _ in cycles.recording.play(step):
            while title and data.time >= min(moment, float(cycles.time[-1])) - 0.5 * step:
                found.append((f"{title}, {MILLI * moment:.0f} ms", canvas.draw(cycles.recording.model, data, ())))
                title, moment = next(coming, ("", np.inf))
    finally:
        canvas.close()
    return found


def camera() -> Any:
    """Along -x: y runs to the right."""
    view = mujoco.MjvCamera()
    view.lookat[:] = [0.0, 0.0, -0.205]
    view.distance, view.azimuth, view.elevation = 0.60, 170.0, -24.0
    return view
