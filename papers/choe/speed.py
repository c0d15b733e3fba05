"""The speed law of Choe et al. 2023 along the ellipse, and the joint angles of our robot under that law.

The paper chooses the speed by the radius of curvature. Computed are the radius's derivatives, the profile, the nodes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Axes, Figure, dress, subplots, svg, tile_panels
from agents.reproduce.finding import Findings, Row, printed
from agents.reproduce.grids import row_grids, table_findings
from pnt_gym.arrays import Floats
from pnt_gym.planning.paths import EllipsePath, NodeList
from pnt_gym.robots.t3kr.kinematics import inverse_kinematics

from .cases import ASKEW, HALF_RISE, HALF_WIDTH, LIMITS, RATE, example, example_cases, motion, path_askew
from .planning.timing import TimedPath

ARMS: Final = ("+x +y", "-x +y", "-x -y", "+x -y")
"""Quadrants of the four arms."""
FIG_3: Final = EllipsePath.with_top(0.3, 0.0, 0.05)
"""The ellipse of Fig. 3: a = 0.3 m and b = 0.05 m."""
SMOOTH: Final = 0.6
"""Greatest ratio of the largest steps of a continuous curve when it is sampled twice as often; without noise 0.5."""

BUSY: Final = 5
"""Number of periods with the longest steps that one row adds up."""


def speed_findings() -> Findings:
    """The radius of curvature along the example, the node list, and the time that the node list takes."""
    rows = (*_curvature_rows(), *_node_rows(), _unit_row(), *_time_rows())
    return table_findings("The speed law and its node list", rows, {"choe_nodes.svg": nodes_figure()}, drop="choe/")


def _curvature_rows() -> Iterator[Row]:
    e = example()
    theta = np.linspace(e.theta_t2, e.theta_t1, 1_000_001)
    rho = e.radius_of_curvature(theta)
    least, at_start = float(rho.min()), float(e.radius_of_curvature(e.theta_t1))
    peak = float(e.point(theta[np.argmax(rho)])[0])
    # The polar angle falls from T1 to T2, so an angle above that of T2 lies before T2 on the path.
    before = math.degrees(theta[np.argmin(rho)] - e.theta_t2)
    note = (
        f"x of the largest radius of curvature, to be within a twentieth of the path's width: {rho.max():.4f} m at the "
        f"end of the minor axis, {float(rho[e.point(theta)[:, 1].argmax()]):.4f} m at the top"
    )
    yield Row.compared("choe/claim/speed-peaks-at-the-top", 0.08617, peak, "m", within=0.1 * HALF_WIDTH, note=note)
    yield Row.compared(
        "choe/claim/least-radius-at-the-start",
        "T1",
        "T1" if at_start <= least else f"{before:.1f} deg before T2",
        "-",
        note=f"the least radius is b^2 / a = {1000.0 * least:.3f} mm at the end of the major axis, at T1 "
        f"{1000.0 * at_start:.3f} mm",
        least_m=least,
        at_t1_m=at_start,
    )
    note = (
        "a step r rho of the polar angle is a speed in proportion to rho^(4/3): fastest over slowest is (a / b)^4; "
        "equal centripetal acceleration would need rho^(1/2)"
    )
    # A step of the polar angle r rho has the length r rho ds/dtheta, and ds/dtheta = (a b rho)^(1/3) by Eq. 51.
    yield Row.ours("choe/speed-law/ratio", float(rho.max() / least) ** (4.0 / 3.0), "-", note=note)


def _node_rows() -> Iterator[Row]:
    as_printed, clipped = example().nodes(RATE, clip=False), example().nodes(RATE)
    last, end = math.degrees(as_printed.theta[-1]), math.degrees(example().theta_t2)
    steps = as_printed.steps
    note = "r = 0.77 rad/m; the paper shows a figure"
    yield Row.ours("choe/nodes/count", float(as_printed.theta.size), "-", note=note)
    note = (
        f"the path starts at {100.0 * steps[0] / steps.max():.1f} % of its greatest speed: almost from rest, which "
        "hides that the vertical parts before it are left open"
    )
    yield Row.ours("choe/nodes/shortest-step", float(steps.min()), "m", note=note)
    yield Row.ours("choe/nodes/longest-step", float(steps.max()), "m")
    note = (
        f"steps 6 and 7 as printed run {end - last:.2f} deg past T2; clipped, the last chord is "
        f"{1000.0 * clipped.steps[-1]:.2f} mm"
    )
    yield Row.compared("choe/nodes/last-angle", end, last, "deg", within=printed(3), note=note)


def _unit_row() -> Row:
    """Row with the number of nodes by unit: step 6 sets an angle equal to a length times r."""
    # rho in millimetres is 1000 times the number; steps in degrees are pi / 180 of those in radians.
    rates = {"m and rad": RATE, "mm and rad": 1000.0 * RATE, "mm and deg": 1000.0 * math.radians(RATE)}
    counts = {units: float(example().nodes(rate).theta.size) for units, rate in rates.items()}
    return Row.ours(
        "choe/statement/step-6-units",
        counts["mm and rad"],
        "nodes",
        beside=f"r = {RATE}",
        note="r carries 1/m and the control period, neither is given: with rho in millimetres the same r leaves "
        f"{counts['mm and rad']:.0f} nodes, with degrees too {counts['mm and deg']:.0f}, in metres and radians "
        f"{counts['m and rad']:.0f} as in the figures",
        nodes_by_units=counts,
    )


def _time_rows() -> Iterator[Row]:
    """Rows with the time of the node list at its shortest period within the speed limit, and of the quickest motion."""
    speed, acceleration, jerk = LIMITS.numbers()
    nodes = example().nodes(RATE, clip=False)
    period = float(nodes.steps.max()) / speed
    total = period * (nodes.theta.size - 1)
    quick = float(motion(example_cases()["arc"]).duration[0])
    # Third differences of the positions over the cube of the period estimate the jerk.
    third = np.linalg.norm(np.diff(nodes.points, 3, axis=0), axis=1).max() / period**3
    yield Row.ours(
        "choe/claim/shorter-cycle",
        total,
        "s",
        beside="may be smaller",
        note="the paper gives no time, only that it may be smaller than along other paths. The node list at a fixed "
        f"period of {1000.0 * period:.1f} ms, where its longest step reaches {speed} m/s; with another speed law, the "
        f"quickest within {speed} m/s, {acceleration} m/s2 and {jerk} m/s3, the arc takes {quick:.3f} s",
        quickest_s=quick,
        times_slower=total / quick,
    )
    note = (
        "argued from rho, rho', rho'' over the angle, not over time, and neither period nor limits are given; here the "
        "largest jerk of that node list by third differences"
    )
    yield Row.missing("choe/claim/smooth-motion", "smooth", "m/s3", reproduced=float(third), note=note)


def nodes_figure() -> Figure:
    """Drawing of the nodes, of radius and speed along the path, and of the quickest motion (the paper's Fig. 6)."""
    figure, (path, law, time) = subplots(3, 1, (WIDTH, 10.5))
    e, nodes = example(), example().nodes(RATE)
    arc = 1000.0 * e.point(np.linspace(e.theta_t1, e.theta_t2, 400))
    path.plot(arc[:, 0], arc[:, 1], color=COLOURS[3], linewidth=1)
    path.plot(*(1000.0 * nodes.points.T), ".", color=COLOURS[0], label=f"{nodes.theta.size} nodes, r = {RATE} rad/m")
    path.plot(1000.0 * e.top[0], 1000.0 * e.top[1], "^", color="black", label="top")
    path.set_aspect("equal", adjustable="datalim")
    dress(path, "x [mm]", "y [mm]", "node list", legend="lower right")
    _draw_law(law, nodes)
    period = float(nodes.steps.max()) / LIMITS.numbers()[0]
    # A chord's mean speed belongs to the middle of its period.
    time.plot(period * (0.5 + np.arange(nodes.steps.size)), nodes.steps / period, color=COLOURS[0], label="node list")
    quick = motion(example_cases()["arc"])
    times = np.linspace(0.0, float(quick.duration[0]), 400)
    speed = np.linalg.norm(quick.sample(times).velocity[0], axis=1)
    time.plot(times, speed, color=COLOURS[1], label="quickest motion")
    dress(time, "time [s]", "speed [m/s]", "the same arc within 1.8 m/s, 36 m/s², 900 m/s³", legend="best")
    return figure


def _draw_law(axes: Axes, nodes: NodeList) -> None:
    e = example()
    theta = np.linspace(e.theta_t1, e.theta_t2, 600)
    x = 1000.0 * e.point(theta)[:, 0]
    axes.plot(x, 1000.0 * e.radius_of_curvature(theta), color=COLOURS[0], label="radius of curvature [mm]")
    middle = 500.0 * (nodes.points[1:, 0] + nodes.points[:-1, 0])
    axes.plot(middle, 1e4 * nodes.steps, ".-", color=COLOURS[1], label="10 x step to the next node [mm]")
    axes.axvline(1000.0 * e.top[0], color="gray", linewidth=1, linestyle=":", label="top of the path")
    dress(axes, "x [mm]", "[mm]", "the speed law: fastest left of the top", ylim=(0.0, 1050.0))
    axes.legend(fontsize=7, loc="upper right")


def joint_findings() -> Findings:
    """Arm angles of our robot along the example, at the paper's nodes and in the quickest motion."""
    nodes = example().nodes(RATE).points - example().point(example().theta_t1)
    angles = np.degrees(inverse_kinematics(path_askew(example_cases()["arc"].path).positions(nodes)))
    case = example_cases()["ellipse-10deg-relaxed"]
    quick = TimedPath.of(path_askew(case.path), motion(case).progress)
    times = np.arange(0.0, float(quick.duration[0]), 1e-3)
    quick_angles = np.degrees(inverse_kinematics(quick.sample(times).position[0]))
    swings = [
        Row.ours(
            f"choe/joints/arm-{k + 1}-swing",
            float(np.ptp(angles[:, k])),
            "deg",
            note=f"arm in the quadrant {ARMS[k]} over the ellipse at the paper's nodes; the geometry of its Delta "
            f"robot is not given, ours stands in: T1 at {ASKEW} m, T2 opposite and {2000.0 * HALF_RISE:.0f} mm higher",
        )
        for k in range(4)
    ]
    steps = np.abs(np.diff(angles, axis=0)).max(axis=1)
    note = f"of an arm from one node to the next; the smallest is {float(steps[:-1].min()):.3f} deg"
    rows = (*swings, Row.ours("choe/joints/largest-step", float(steps.max()), "deg", note=note))
    return Findings(
        rows,
        {"choe_joints": {"joint_angles_deg": angles.tolist()}},
        {"choe_joints.svg": svg(joints_figure(angles, times, quick_angles))},
        row_grids("Arms of our robot along the example", rows, drop="choe/"),
    )


def joints_figure(angles: Floats, times: Floats, quick_angles: Floats) -> Figure:
    """Drawing of the paper's Fig. 7 on our robot, and of the arm angles in the quickest motion with vertical parts."""
    figure, (upper, lower) = subplots(2, 1, (WIDTH, 7.4))
    for k, name in enumerate(ARMS):
        upper.plot(np.arange(1, len(angles) + 1), angles[:, k], color=COLOURS[k], label=f"arm {k + 1}, {name}")
        lower.plot(times, quick_angles[:, k], color=COLOURS[k])
    dress(upper, "node", "arm angle [°]", "ellipse at the paper's nodes (its Fig. 7)")
    dress(lower, "time [s]", "arm angle [°]", "quickest motion with 25 mm verticals, relaxed")
    figure.legend(*upper.get_legend_handles_labels(), fontsize=8, ncols=2, loc="outside lower center")
    return figure


def curvature_findings() -> Findings:
    """Whether the speed law is bounded, continuous and smooth, as the paper concludes from its Figs. 3 and 5."""
    rows = (*_angle_rows(), *_profile_rows())
    figures = {"choe_curvature.svg": curvature_figure(), "choe_profile.svg": profile_figure()}
    return table_findings("The law of curvature and its profile (Figs. 3 and 5)", rows, figures, drop="choe/")


def radius_derivatives(ellipse: EllipsePath, theta: Floats) -> tuple[Floats, Floats, Floats]:
    """The radius of curvature rho (N,) [m] at polar angles (N,) [rad], and its first and second derivative by angle.

    rho = q^(3/2) / (a b) with q = a^2 sin^2 + b^2 cos^2 (Eq. 51).
    """
    a, b = ellipse.semi_major, ellipse.semi_minor
    q = (a * np.sin(theta)) ** 2 + (b * np.cos(theta)) ** 2
    # q' and q'' by the angle.
    first = (a * a - b * b) * np.sin(2.0 * theta)
    second = 2.0 * (a * a - b * b) * np.cos(2.0 * theta)
    # Chain rule for q^(3/2).
    slope, bend = 1.5 * np.sqrt(q) * first, 1.5 * np.sqrt(q) * second + 0.75 * first**2 / np.sqrt(q)
    return ellipse.radius_of_curvature(theta), slope / (a * b), bend / (a * b)


@final
@dataclass(frozen=True, eq=False)
class Profile:
    """The motion at the knots of a node list, one period from each to the next (the paper's Fig. 5)."""

    curvature: Floats
    """Radius of curvature at the knots (n,) [m]."""
    displacement: Floats
    """Way along the chords (n,) [m]."""
    velocity: Floats
    """(n - 1,) [m per period]"""
    acceleration: Floats
    """(n - 2,) [m per period^2]"""
    jerk: Floats
    """(n - 3,) [m per period^3]"""

    @classmethod
    def of(cls, ellipse: EllipsePath, nodes: NodeList) -> Profile:
        """The profile of a node list of an ellipse."""
        displacement = np.concatenate([[0.0], np.cumsum(nodes.steps)])
        differences = [np.diff(displacement, order) for order in (1, 2, 3)]
        return cls(ellipse.radius_of_curvature(nodes.theta), displacement, *differences)


def _angle_rows() -> Iterator[Row]:
    names = ("rho", "first-derivative", "second-derivative")
    fine = radius_derivatives(FIG_3, np.linspace(0.0, np.pi, 20_001))
    for name, values in zip(names, fine, strict=True):
        # Twice as many samples halve the largest step of a continuous curve; a jump keeps its size.
        jumps = [float(np.abs(np.diff(values[::every])).max()) for every in (2, 1)]
        smooth = bool(np.isfinite(values).all() and jumps[1] < SMOOTH * jumps[0])
        yield Row.compared(
            f"choe/fig-3/{name}",
            "bounded, continuous",
            "bounded, continuous" if smooth else "jumps",
            "m",
            note=f"a = 0.3 m, b = 0.05 m, theta from 0 to 180 deg: from {values.min():.4g} to {values.max():.4g} m",
            least=float(values.min()),
            greatest=float(values.max()),
        )


def _profile_rows() -> Iterator[Row]:
    profile = Profile.of(example(), example().nodes(RATE, clip=False))
    top = float(profile.velocity.max())
    busiest = float(np.sort(profile.velocity)[-BUSY:].sum() / profile.displacement[-1])
    note = f"of the way, in {BUSY} of {profile.velocity.size} periods: the law hurries over the top, in few large steps"
    yield Row.ours("choe/fig-5/way-of-the-busiest-periods", busiest, "-", note=note)
    for name, values in (("acceleration", profile.acceleration), ("jerk", profile.jerk)):
        note = (
            f"largest at a knot, as a share of the greatest step of {1000.0 * top:.1f} mm a period; the paper's axes "
            "have no period"
        )
        yield Row.ours(f"choe/fig-5/largest-{name}", float(np.abs(values).max()) / top, "-", note=note)
    note = (
        "the step at the first knot is a speed that the arm has to have there already: with the vertical part left "
        "open, the profile begins and ends with a jump of the acceleration"
    )
    yield Row.ours("choe/fig-5/speed-at-the-first-knot", float(profile.velocity[0]) / top, "-", note=note)


def curvature_figure() -> Figure:
    """Drawing of the paper's Fig. 3."""
    figure, axes = subplots(3, 1, (WIDTH, 8.0), sharex=True)
    theta = np.linspace(0.0, np.pi, 721)
    titles = ("radius of curvature", "its first derivative", "its second derivative")
    for k, (ax, values, title) in enumerate(zip(axes, radius_derivatives(FIG_3, theta), titles, strict=True)):
        ax.plot(np.degrees(theta), values, color=COLOURS[k])
        dress(ax, "", "[m]", title)
    axes[-1].set_xlabel("θ [°]")
    return figure


def profile_figure() -> Figure:
    """Drawing of the paper's Fig. 5, all five panels."""
    figure, axes = tile_panels(5, 2, (WIDTH / 2, 2.7))
    profile = Profile.of(example(), example().nodes(RATE, clip=False))
    panels = (
        ("(a) curvature", "[mm]", profile.curvature),
        ("(b) displacement", "[mm]", profile.displacement),
        ("(c) velocity", "[mm / period]", profile.velocity),
        ("(d) acceleration", "[mm / period²]", profile.acceleration),
        ("(e) jerk", "[mm / period³]", profile.jerk),
    )
    for ax, (title, unit, values) in zip(axes, panels, strict=True):
        ax.plot(np.arange(1, len(values) + 1), 1000.0 * values, ".-", markersize=3, linewidth=1, color=COLOURS[0])
        dress(ax, "knot", unit, title)
    return figure
