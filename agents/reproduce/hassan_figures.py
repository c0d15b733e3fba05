"""Figures like those of Hassan et al. 2022, drawn from the reproduced motions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.reproduce.findings import Findings, Part
from agents.reproduce.hassan_cases import METHODS, PERCENTAGES, PICKS, PUBLISHED, TARGETS, Key, cell_cycle
from pnt_gym.planning import MotionLimits, flight_state, min_time_scurve, release_at_elevation, speed_at
from pnt_gym.planning.arrays import Floats, length
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.planning.cycle import Cycle, CycleSamples

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLES: Final = {
    "pick-and-place": "pick-and-place",
    "horizontal-throw": "horizontal throw",
    "min-time-throw": "minimum-time throw",
}
STYLES: Final = {
    "paper-clock": ("-", "paper clock"),
    "limits-respected": ("--", "within the limits"),
}
RATE: Final = 1000.0
"""Samples per second of drawn motions [Hz]."""
EXAMPLE: Final = 30
"""Percentage of the cycle shown in Fig. 12."""


def figures_findings() -> Findings:
    """Figures 2 and 5, 8 to 10, 11, 12, 13 and 14."""
    drawn = {
        "hassan_scurve.svg": scurve_figure(),
        "hassan_paths.svg": paths_figure(),
        "hassan_positions_place_inside.svg": positions_figure("inside", ("pick-and-place", "min-time-throw")),
        "hassan_positions_inside.svg": positions_figure("inside", ("horizontal-throw", "min-time-throw")),
        "hassan_positions_outside.svg": positions_figure("outside", ("horizontal-throw", "min-time-throw")),
        "hassan_motion.svg": motion_figure(),
    }
    return Findings(figures={name: svg(figure) for name, figure in drawn.items()})


def scurve_figure() -> Figure:
    """Time and peak speed over the stroke in both cases (Fig. 2), and the release as a crossing (Fig. 5)."""
    figure, (times, speeds, release) = subplots(1, 3, (12.0, 3.8))
    strokes = np.linspace(1e-4, 0.8, 400)
    for k, (jerk, label) in enumerate(((450.0, "case 1: √(J V) < A"), (3000.0, "case 2: √(J V) ≥ A"))):
        curve = min_time_scurve(strokes, MotionLimits(1.8, 36.0, jerk))
        times.plot(strokes, curve.duration, color=COLOURS[k], label=label)
        speeds.plot(strokes, curve.velocity, color=COLOURS[k], label=label)
    _dress(times, "stroke P [m]", "time T [s]", "duration of a stroke")
    _dress(speeds, "stroke P [m]", "peak speed V [m/s]", "peak speed of a stroke")
    times.legend(fontsize=8)
    _crossing(release)
    return figure


def _crossing(axes: Axes) -> None:
    """Release speed over release distance: what the S-curve gives and what the flight needs, jerk-limited."""
    limits, reach = MotionLimits(4.5, 90.0, 1500.0), 0.8
    distances = np.linspace(1e-4, 0.32, 400)
    axes.plot(distances, speed_at(distances, limits), color="black", label="S-curve: speed at mid-stroke")
    angles = np.radians(np.linspace(5.0, 60.0, 1101))
    zero, target = np.zeros((len(angles), 3)), np.tile([reach, 0.0, 0.0], (len(angles), 1))
    found = release_at_elevation(zero, target, limits, angles)
    best = int(np.argmin(found.distance))
    for k, angle in enumerate(np.radians([12.0, 20.0, np.degrees(angles[best]), 55.0])):
        flight = np.sqrt(2.0 * reach * np.tan(angle) / GRAVITY)
        label = f"flight at {np.degrees(angle):.1f}°" + (" (optimum)" if angle == angles[best] else "")
        axes.plot(distances, (reach / np.cos(angle) - distances) / flight, color=COLOURS[k], label=label)
    axes.plot(found.distance[best], found.speed[best], "o", color="black")
    _dress(axes, "release distance $P_r$ [m]", "release speed $V_r$ [m/s]", "release: S-curve (case 1) meets flight")
    axes.set_ylim(0.0, 5.0)
    axes.legend(fontsize=8, loc="lower right")


def paths_figure() -> Figure:
    """Side views of the first cycle inside at 30 %: hand and thrown object."""
    figure, panels = subplots(3, 1, (8.5, 7.6), sharex=True)
    for axes, method in zip(panels, METHODS, strict=True):
        for protocol, (style, label) in STYLES.items():
            cycle = cell_cycle(protocol, method, "inside", EXAMPLE)
            run = cycle.sample(np.linspace(0.0, cycle.duration[0], 800))
            along, height = _side(run.position[0])
            axes.plot(along, height, style, color=COLOURS[0], label=f"hand, {label}")
        _flight(axes, cell_cycle("paper-clock", method, "inside", EXAMPLE))
        axes.plot(*_side(np.array(TARGETS["inside"])), "v", color=COLOURS[3], label="target")
        _dress(axes, "", "height z [m]", TITLES[method])
        axes.set_aspect("equal")
        axes.set_ylim(-0.88, -0.63)
    panels[-1].set_xlabel("distance from the pick towards the target [m]")
    figure.legend(*panels[-1].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=5)
    return figure


def _side(points: Floats) -> tuple[Floats, Floats]:
    """Horizontal distance from the first pick towards the inside target, and height."""
    pick, target = np.array(PICKS[0]), np.array(TARGETS["inside"])
    line = (target - pick)[:2] / np.hypot(*(target - pick)[:2])
    return (points - pick)[..., :2] @ line, points[..., 2]


def _flight(axes: Axes, cycle: Cycle) -> None:
    start, velocity = cycle.release_position[0], cycle.release_velocity[0]
    drop = start[2] - TARGETS["inside"][2]
    time = (velocity[2] + np.sqrt(velocity[2] ** 2 + 2.0 * GRAVITY * drop)) / GRAVITY
    steps = np.linspace(0.0, time, 60)
    points, _ = flight_state(np.tile(start, (60, 1)), np.tile(velocity, (60, 1)), steps)
    axes.plot(*_side(points), ":", color=COLOURS[1], label="object in flight")
    axes.plot(*_side(start), "o", color=COLOURS[1], label="release or place")


def positions_figure(zone: str, methods: tuple[str, str]) -> Figure:
    """Desired positions over time for two methods at all percentages of a zone (Figs. 11, 13, 14)."""
    figure, panels = subplots(3, 2, (9.5, 6.4), sharex=True, sharey="row")
    for column, method in enumerate(methods):
        for k, percent in enumerate(PERCENTAGES[zone]):
            run = loop_motion(cell_cycle("paper-clock", method, zone, percent))
            for row in range(3):
                axes = panels[2 * row + column]
                axes.plot(run.time[0], run.position[0, :, row], color=COLOURS[k], label=f"{percent} %")
        _dress(panels[column], "", "", f"{TITLES[method]}, target {zone}")
        panels[4 + column].set_xlabel("time [s]")
    for row, name in enumerate("xyz"):
        panels[2 * row].set_ylabel(f"{name} [m]")
        for axes in panels[2 * row : 2 * row + 2]:
            axes.grid(alpha=0.3)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, title="share of the limits", ncols=3, loc="outside lower center")
    return figure


def motion_figure() -> Figure:
    """Position, speed, acceleration and jerk of the proposed loop at 30 % (Fig. 12), by two protocols."""
    figure, panels = subplots(4, 2, (10.0, 8.4), sharex=True, sharey="row")
    bounds = (None, *MotionLimits.t3kr(EXAMPLE).numbers())
    names = ("position [m]", "speed [m/s]", "acceleration [m/s²]", "jerk [m/s³]")
    for column, (protocol, (_, title)) in enumerate(STYLES.items()):
        run = loop_motion(cell_cycle(protocol, "min-time-throw", "inside", EXAMPLE))
        for axis in range(3):
            panels[column].plot(run.time[0], run.position[0, :, axis], color=COLOURS[axis], label="xyz"[axis])
        for row, values in enumerate((run.velocity, run.acceleration, run.jerk), start=1):
            panels[2 * row + column].plot(run.time[0], length(values[0]), color="black", linewidth=1)
        panels[column].set_title(f"minimum-time throw at {EXAMPLE} %, {title}", fontsize=10)
        panels[6 + column].set_xlabel("time [s]")
    for row, (name, bound) in enumerate(zip(names, bounds, strict=True)):
        panels[2 * row].set_ylabel(name)
        for axes in panels[2 * row : 2 * row + 2]:
            axes.grid(alpha=0.3)
            if bound is not None:
                axes.axhline(bound, color=COLOURS[3], linestyle="--", linewidth=1, label="limit")
                axes.set_ylim(bottom=0.0)
    entries = [panel.get_legend_handles_labels() for panel in (panels[0], panels[2])]
    handles, labels = ([item for part in column for item in part] for column in zip(*entries, strict=True))
    figure.legend(handles, labels, fontsize=8, ncols=4, loc="outside lower center")
    return figure


def table_figure(reproduced: Mapping[str, Mapping[Key, float]]) -> str:
    """Picks per minute over the percentage, published and by both main protocols, as SVG."""
    figure, panels = subplots(1, 2, (10.5, 4.2))
    for axes, (zone, percents) in zip(panels, PERCENTAGES.items(), strict=True):
        for k, method in enumerate(METHODS):
            cells = [(method, zone, percent) for percent in percents if (method, zone, percent) in PUBLISHED]
            if not cells:
                continue
            shares = [cell[2] for cell in cells]
            name = TITLES[method]
            axes.plot(shares, [PUBLISHED[cell] for cell in cells], "o", color=COLOURS[k], label=f"{name}, published")
            for protocol, (style, label) in STYLES.items():
                values = [reproduced[protocol][cell] for cell in cells]
                axes.plot(shares, values, style, color=COLOURS[k], label=f"{name}, {label}")
        _dress(axes, "share of the robot's limits [%]", "picks per minute", f"target {zone} the workspace")
        axes.set_xticks(percents)
        axes.set_ylim(0.0, 130.0)
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, loc="outside right center")
    return svg(figure)


def loop_motion(cycle: Cycle) -> CycleSamples:
    """The cycles of a loop one after the other as a single row."""
    runs = [cycle.path.take(np.array([k])) for k in range(len(cycle))]
    offset, pieces = 0.0, list[CycleSamples]()
    for k, path in enumerate(runs):
        times = np.arange(0.0, path.duration[0], 1.0 / RATE)
        motion = path.sample(times)
        grip = (times < cycle.release_time[k])[None]
        pieces.append(CycleSamples(times[None] + offset, *motion, path.jerk(times), grip))
        offset += float(path.duration[0])
    return CycleSamples(*(np.concatenate(columns, axis=1) for columns in zip(*pieces, strict=True)))


def _dress(axes: Axes, across: str, up: str, title: str) -> None:
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.3)


PARTS = (Part("figures", figures_findings),)
