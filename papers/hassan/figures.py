"""Figures of Hassan et al. 2022, drawn anew from the reproduced motions, and the paper's numbers on Fig. 12."""

from __future__ import annotations

import textwrap
from dataclasses import replace
from typing import Final

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row, printed, share
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats, concatenate_records, length, take
from pnt_gym.constants import GRAVITY
from pnt_gym.planning import MotionLimits, flight_state, flight_time, min_time_scurve, release_at_elevation, speed_at

from .cases import CLOSE, JERK, METHODS, PERCENTAGES, PICKS, PROTOCOLS, PUBLISHED, SHOWN, TARGETS, TITLES, cell_cycle
from .planning.cycle import Cycle, CycleSamples

RATE: Final = 1000.0
"""Samples per second of drawn motions [Hz]."""
EXAMPLE: Final = 30
"""Percentage of the cycle shown in Fig. 12."""
PEAKS: Final = (1.8, 36.0)
"""Greatest speed [m/s] and acceleration [m/s2] that section IV-C1 reads off Fig. 12."""
AXIS_END: Final = 3.0
"""End of the time axis of Fig. 12 [s]."""
INSTANT: Final = 1e-7
"""Time before and after a border at which the motion is compared [s]."""
TITLE_WIDTH: Final = 17
"""Characters of a line of a panel's title."""


def figures_findings() -> Findings:
    """Drawings of Figs. 2, 4, 5 and 8 to 14, and rows on Fig. 12."""
    drawn = {
        "hassan_scurve.svg": scurve_figure(),
        "hassan_paths.svg": paths_figure(),
        "hassan_positions_place_inside.svg": positions_figure("inside", ("pick-and-place", "min-time-throw")),
        "hassan_positions_inside.svg": positions_figure("inside", ("horizontal-throw", "min-time-throw")),
        "hassan_positions_outside.svg": positions_figure("outside", ("horizontal-throw", "min-time-throw")),
        "hassan_motion.svg": motion_figure(),
    }
    rows = [row for protocol in SHOWN for row in figure_12(protocol)]
    return table_findings("Fig. 12, by reading", rows, drawn, drop="hassan/figure-12/")


def figure_12(protocol: str) -> list[Row]:
    """Rows that compare the paper's numbers on the proposed loop at 30 % with the loop by one protocol."""
    cycle, reading = cell_cycle(protocol, "min-time-throw", "inside", EXAMPLE).require(), PROTOCOLS[protocol]
    peaks, bounds = cycle.peak_ratios(reading.limits(EXAMPLE)), reading.limits(EXAMPLE).numbers()
    speed, push = (float(ratio.max()) * bound for ratio, bound in zip(peaks[:2], bounds[:2], strict=True))
    period, published = float(cycle.duration.sum()), float(PUBLISHED["min-time-throw", "inside", EXAMPLE])
    condition, on_axis = f"at {EXAMPLE} %, {reading.label}", f"on an axis of {AXIS_END:g} s"
    rows = {
        "peak-speed": Row.compared("", PEAKS[0], speed, "m/s", within=printed(1), note=condition),
        "peak-acceleration": Row.compared("", PEAKS[1], push, "m/s2", within=printed(0), note=condition),
        "picks-per-min": Row.compared(
            "",
            published,
            180.0 / period,
            "picks/min",
            within=share(published, CLOSE),
            note=f"{condition}; the figure's cell of Table I",
            statement=f"table1/min-time-throw/inside/{EXAMPLE}",
        ),
        "loop": Row.compared(
            "",
            on_axis,
            period,
            "s",
            holds=period <= AXIS_END,
            note=f"{condition}; the closed loop over the three picks",
        ),
        "continuous": _continuity_row(cycle, condition),
    }
    return [_judge(row, protocol, name) for name, row in rows.items()]


def _continuity_row(cycle: Cycle, condition: str) -> Row:
    """Row on "V_s and A_s are continuous" (IV-C1): what both change by in the instant around any border of phases."""
    borders = cycle.path.knot_times
    before, after = cycle.path.sample(borders - INSTANT), cycle.path.sample(borders + INSTANT)
    speed, acceleration = (float(length(b - a).max()) for a, b in list(zip(before, after, strict=True))[1:])
    # A step of the acceleration stays, however short the instant; a ramp of bounded jerk vanishes with the instant.
    holds = acceleration < 4.0 * INSTANT * JERK and speed < 4.0 * INSTANT * float(length(cycle.path.knots[2]).max())
    note = f"{condition}; largest change of the acceleration in {2e6 * INSTANT:g} us around any border of segments"
    return Row.compared("", "continuous", acceleration, "m/s2", holds=holds, note=note, speed_step=speed)


def _judge(row: Row, protocol: str, name: str) -> Row:
    """The row under its name: `ours` where the protocol is no reading, or where a fit to Table I decides the figure."""
    quantity, reading = f"hassan/figure-12/{protocol}/{name}", PROTOCOLS[protocol]
    if not reading.reading or (reading.fitted and name.startswith("peak-")):
        return Row.ours(quantity, row.reproduced, row.unit, beside=row.published, note=row.note)
    return replace(row, quantity=quantity, statement=row.statement or f"hassan/figure-12/{name}")


def scurve_figure() -> Figure:
    """Drawing of time and peak speed over the stroke (Fig. 2), and of the release as a crossing (Figs. 4 and 5)."""
    figure, (times, speeds, *crossings) = subplots(4, 1, (WIDTH, 12.0))
    strokes = np.linspace(1e-4, 0.8, 400)
    for k, (jerk, label) in enumerate(((450.0, "case 1: √(J V) < A"), (3000.0, "case 2: √(J V) ≥ A"))):
        curve = min_time_scurve(strokes, MotionLimits(1.8, 36.0, jerk))
        times.plot(strokes, curve.duration, color=COLOURS[k], label=label)
        speeds.plot(strokes, curve.velocity, color=COLOURS[k], label=label)
    dress(times, "stroke P [m]", "time T [s]", "duration of a stroke", legend="best")
    dress(speeds, "stroke P [m]", "peak speed V [m/s]", "peak speed of a stroke")
    _draw_crossing(crossings[0], MotionLimits(4.5, 90.0, 1500.0), "case 1")
    _draw_crossing(crossings[1], MotionLimits(2.4, 48.0, 3000.0), "case 2, 40 % with J constant")
    return figure


def _draw_crossing(axes: Axes, limits: MotionLimits, case: str) -> None:
    """Draw release speed over release distance: the speed of the S-curve, and the speed that the flight needs."""
    reach = 0.8
    distances = np.linspace(1e-4, 0.32, 400)
    axes.plot(distances, speed_at(distances, limits), color="black", label="S-curve: speed at mid-stroke")
    angles = np.radians(np.linspace(5.0, 60.0, 1101))
    zero, target = np.zeros((len(angles), 3)), np.tile([reach, 0.0, 0.0], (len(angles), 1))
    release = release_at_elevation(zero, target, limits, angles)
    best = int(np.nanargmin(release.distance))
    for k, angle in enumerate(np.radians([12.0, 20.0, np.degrees(angles[best]), 55.0])):
        flight = np.sqrt(2.0 * reach * np.tan(angle) / GRAVITY)
        label = f"flight at {np.degrees(angle):.1f}°" + (" (optimum)" if angle == angles[best] else "")
        axes.plot(distances, (reach / np.cos(angle) - distances) / flight, color=COLOURS[k], label=label)
    axes.plot(release.distance[best], release.speed[best], "o", color="black")
    names, title = ("release distance $P_r$ [m]", "release speed $V_r$ [m/s]"), f"release: S-curve meets flight, {case}"
    dress(axes, *names, title, legend="lower right", ylim=(0.0, 5.0))


def paths_figure() -> Figure:
    """Drawing of the first cycle inside at 30 %, from the side: hand and thrown object."""
    figure, panels = subplots(3, 1, (WIDTH, 7.0), sharex=True)
    for axes, method in zip(panels, METHODS, strict=True):
        for protocol, style in (("paper-clock", "-"), ("constant-jerk-overlap", "--")):
            cycle, label = cell_cycle(protocol, method, "inside", EXAMPLE), f"hand, {PROTOCOLS[protocol].label}"
            run = cycle.sample(np.linspace(0.0, cycle.duration[0], 800))
            axes.plot(*side_view(run.position[0], "inside"), style, color=COLOURS[0], label=label)
        draw_flight(axes, cell_cycle("paper-clock", method, "inside", EXAMPLE), "inside", COLOURS[1])
        dress(axes, "", "height z [m]", TITLES[method], aspect="equal", ylim=(-0.88, -0.63))
    panels[-1].set_xlabel("distance from the pick towards the target [m]")
    figure.legend(*panels[-1].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=2)
    return figure


def side_view(points: Floats, zone: str) -> tuple[Floats, Floats]:
    """Horizontal distance from the first pick towards the target, and height, each (...) [m], of points (..., 3)."""
    pick, target = np.array(PICKS[0]), np.array(TARGETS[zone])
    line = (target - pick)[:2] / np.hypot(*(target - pick)[:2])
    return (points - pick)[..., :2] @ line, points[..., 2]


def draw_flight(axes: Axes, cycle: Cycle, zone: str, colour: str) -> None:
    """Draw the flight of the first cycle's object from release to target, from the side."""
    start, velocity, target = cycle.release_position[0], cycle.release_velocity[0], np.array(TARGETS[zone])
    steps = np.linspace(0.0, float(flight_time(start, velocity, target[2])), 100)
    axes.plot(*side_view(flight_state(start, velocity, steps)[0], zone), ":", color=colour, label="object in flight")
    axes.plot(*side_view(start, zone), "o", color=colour, markersize=4, label="release or place")
    axes.plot(*side_view(target, zone), "v", color=COLOURS[3], label="target")


def positions_figure(zone: str, methods: tuple[str, str]) -> Figure:
    """Drawing of desired positions over time for two methods at all percentages of a zone (Figs. 11, 13, 14)."""
    figure, panels = subplots(3, 2, (WIDTH, 6.4), sharex=True, sharey="row")
    for column, method in enumerate(methods):
        for k, percent in enumerate(PERCENTAGES[zone]):
            run = loop_motion(cell_cycle("paper-clock", method, zone, percent))
            for row, axes in enumerate(panels[column::2]):
                axes.plot(run.time[0], run.position[0, :, row], color=COLOURS[k], label=f"{percent} %")
        for name, axes in zip("xyz", panels[column::2], strict=True):
            dress(axes, "", f"{name} [m]" if column == 0 else "")
        panels[column].set_title(f"{TITLES[method]}, target {zone}", fontsize=10)
        panels[4 + column].set_xlabel("time [s]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, title="share of the limits", ncols=3, loc="outside lower center")
    return figure


def motion_figure() -> Figure:
    """Drawing of position, speed, acceleration and jerk of the proposed loop at 30 % (Fig. 12), by three readings."""
    figure, panels = subplots(4, len(SHOWN), (WIDTH, 8.4), sharex=True, sharey="row")
    names = ("position [m]", "speed [m/s]", "acceleration [m/s²]", "jerk [m/s³]")
    for column, protocol in enumerate(SHOWN):
        reading, axes = PROTOCOLS[protocol], panels[column :: len(SHOWN)]
        run = loop_motion(cell_cycle(protocol, "min-time-throw", "inside", EXAMPLE))
        for axis in range(3):
            axes[0].plot(run.time[0], run.position[0, :, axis], color=COLOURS[axis], label="xyz"[axis])
        motions = (run.velocity, run.acceleration, run.jerk)
        for panel, values, bound in zip(axes[1:], motions, reading.limits(EXAMPLE).numbers(), strict=True):
            panel.plot(run.time[0], length(values[0]), color="black", linewidth=1)
            panel.axhline(bound, color=COLOURS[3], linestyle="--", linewidth=1, label="limit")
        dress(axes[0], "", "" if column else names[0], textwrap.fill(f"{EXAMPLE} %, {reading.label}", TITLE_WIDTH))
    for k, panel in enumerate(panels[len(SHOWN) :], start=len(SHOWN)):
        row, column = divmod(k, len(SHOWN))
        dress(panel, "time [s]" if row == 3 else "", "" if column else names[row], ylim=(0.0, None))
    entries = [panel.get_legend_handles_labels() for panel in (panels[0], panels[len(SHOWN)])]
    handles, labels = ([item for part in column for item in part] for column in zip(*entries, strict=True))
    figure.legend(handles, labels, fontsize=8, ncols=4, loc="outside lower center")
    return figure


def loop_motion(cycle: Cycle) -> CycleSamples:
    """Motion samples of a loop's cycles, joined in time to a single row."""
    offset, pieces = 0.0, list[CycleSamples]()
    for k in range(len(cycle)):
        path = take(cycle.path, np.array([k]))
        times = np.arange(0.0, path.duration[0], 1.0 / RATE)
        grip = (times < cycle.release_time[k])[None]
        pieces.append(CycleSamples(times[None] + offset, *path.sample(times), path.jerk(times), grip))
        offset += float(path.duration[0])
    return concatenate_records(pieces, axis=1)
