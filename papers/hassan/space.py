"""The S-curve of Fig. 1 and the experiments' motions in space, from P_initial and back (Figs. 8 to 10), drawn anew."""

from __future__ import annotations

from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats
from pnt_gym.planning import MotionLimits, flight_state, flight_time, min_time_scurve
from pnt_gym.planning.motion.scurve import rest_to_rest
from pnt_gym.planning.motion.trajectory import JerkTrajectory

from .cases import INITIAL, METHODS, PICKS, PROTOCOLS, TARGETS, TITLES, WORKSPACE, scene
from .planning.cycle import Cycle, CycleTask

PROTOCOL: Final = "constant-jerk-stops"
"""Protocol of the drawn motions: every move is straight and ends before the next move begins."""
PERCENT: Final = 30
"""Percentage of the drawn motions."""
SAMPLES: Final = 400
"""Number of points of a drawn motion."""
STROKE: Final = 0.35
"""Stroke of the drawn S-curve, long enough for all seven segments [m]."""
VIEW: Final = {"elev": 24.0, "azim": -55.0}
"""Direction of the drawings in space [deg]."""


class Experiment(NamedTuple):
    """Motion of the hand from P_initial over the three picks and back."""

    first_leg: JerkTrajectory
    """From P_initial to rest at the first pick."""
    cycles: Cycle
    """The three cycles; the last cycle leads to below P_initial."""
    last_end: float
    """Time of the last cycle at which the hand has reached P_initial [s]."""

    @property
    def duration(self) -> float:
        """Time from P_initial to P_initial [s]."""
        return float(self.first_leg.duration[0] + self.cycles.duration[:2].sum()) + self.last_end


def experiment(method: str, zone: str = "inside", percent: float = PERCENT) -> Experiment:
    """The experiment of section IV-B by a method: the paper's three picks, and both ways between them and P_initial.

    The paper says nothing about these ways: here they are straight, with the vertical part that the method has at every
    other pick.

    Raises:
        InfeasibleThrow: if a cycle is infeasible.
    """
    rules, limits = PROTOCOLS[PROTOCOL].rules, PROTOCOLS[PROTOCOL].limits(percent)
    drop = np.array([0.0, 0.0, rules.approach if method == "min-time-throw" else rules.lift])
    start, picks, following = np.array([INITIAL]), *scene(zone)[::2]
    way, descent = rest_to_rest(picks[:1] + drop - start, limits), rest_to_rest(-drop[None], limits)
    # The hand reaches P_initial at the end of its return; the vertical part below P_initial is not run.
    following[2] = start[0] - drop
    cycles = METHODS[method](CycleTask.of(picks, scene(zone)[1], following, limits, rules, WORKSPACE)).require()
    last_end = float(cycles.phase_ends[2, cycles.phases.index("return")])
    return Experiment(JerkTrajectory.concatenate(start, [way, descent]), cycles, last_end)


def space_findings() -> Findings:
    """Drawings of Fig. 1 and, in space with P_initial, of Figs. 8 to 10, and the times of the whole experiments."""
    drawn = {"hassan_segments.svg": segments_figure(), "hassan_space.svg": space_figure()}
    note = (
        f"from P_initial over three picks and back at {PERCENT} % inside, {PROTOCOLS[PROTOCOL].label}; the ways "
        "from and to P_initial are straight, which the paper leaves open"
    )
    rows = [Row.ours(f"hassan/experiment/{method}", experiment(method).duration, "s", note=note) for method in METHODS]
    return table_findings("Whole experiments, from P_initial and back", rows, drawn, drop="hassan/experiment/")


def segments_figure() -> Figure:
    """Drawing of jerk, acceleration, speed and position of an S-curve with its seven segments (Fig. 1)."""
    limits = MotionLimits.t3kr(PERCENT)
    curve = min_time_scurve(STROKE, limits)
    borders = np.concatenate([[0.0], np.cumsum(curve.durations)])
    times = np.linspace(0.0, curve.duration, SAMPLES)
    path = JerkTrajectory.concatenate(np.zeros((1, 3)), [rest_to_rest(np.array([[STROKE, 0.0, 0.0]]), limits)])
    values = (path.jerk(times), *reversed(path.sample(times)))
    names = ("jerk [m/s³]", "acceleration [m/s²]", "speed [m/s]", "position [m]")
    figure, panels = subplots(4, 1, (WIDTH, 7.0), sharex=True)
    for k, (panel, name, value) in enumerate(zip(panels, names, values, strict=True)):
        panel.plot(times, value[0, :, 0], color=COLOURS[k], drawstyle="steps-post" if k == 0 else "default")
        dress(panel, "time [s]" if k == 3 else "", name)
        for border in borders:
            panel.axvline(border, color="gray", linewidth=0.7)
    style = {"ha": "center", "va": "bottom", "fontsize": 8, "transform": panels[0].get_xaxis_transform()}
    for k, (begin, end) in enumerate(pairwise(borders)):
        panels[0].text(0.5 * (begin + end), 1.02, ("$d_j$", "$d_a$", "$d_j$", "$d_v$")[k if k < 4 else 6 - k], **style)
    return figure


def space_figure() -> Figure:
    """Drawing of the three experiments in space, as the paper's Figs. 8, 9 and 10 draw them."""
    figure, panels = subplots(3, 1, (WIDTH, 11.0), subplot_kw={"projection": "3d"})
    for panel, method in zip(panels, METHODS, strict=True):
        _draw_experiment(panel, experiment(method), is_throw=method != "pick-and-place")
        panel.set_title(TITLES[method], fontsize=10)
        panel.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]", xlim=(-0.4, 0.5), ylim=(-0.8, 0.5), zlim=(-0.9, 0.0))
        panel.set_box_aspect((0.9, 1.3, 0.9))  # pyright: ignore[reportArgumentType] - of axes in space
        panel.view_init(**VIEW)  # pyright: ignore[reportAttributeAccessIssue] - of axes in space
    figure.legend(*panels[-1].get_legend_handles_labels(), fontsize=8, ncols=4, loc="outside lower center")
    return figure


def _draw_experiment(panel: Axes, run: Experiment, *, is_throw: bool) -> None:
    """Draw the hand's motion, one colour a cycle, the flights, and the named points."""

    def draw(points: Floats, *style: str, **options: object) -> None:
        panel.plot(*points.T, *style, **options)  # pyright: ignore[reportArgumentType] - axes in space take x, y, z

    times = np.linspace(0.0, float(run.first_leg.duration[0]), SAMPLES)
    draw(run.first_leg.sample(times).position[0], color="gray", label="from and to P_initial")
    ends, target = [*run.cycles.duration[:2], run.last_end], np.array(TARGETS["inside"])
    for k, end in enumerate(ends):
        position = run.cycles.sample(np.linspace(0.0, end, SAMPLES)).position[k]
        draw(position, color=COLOURS[k], label=f"pick {k + 1} to {'P_initial' if k == 2 else f'pick {k + 2}'}")
        if is_throw:
            start, velocity = run.cycles.release_position[k], run.cycles.release_velocity[k]
            flight = np.linspace(0.0, float(flight_time(start, velocity, target[2])), 60)
            draw(flight_state(start, velocity, flight)[0], ":", color=COLOURS[k], label="flight" if k == 0 else None)
            draw(start[None], "o", color=COLOURS[k], markersize=4)
    draw(np.array(PICKS), "s", color="black", markersize=4, label="picks")
    draw(target[None], "v", color=COLOURS[3], label="target")
    draw(np.array([INITIAL]), "*", color="black", label="P_initial")
