"""The speed law of Choe et al. 2023 along the ellipse, and what it asks of our robot's joints."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.reproduce.choe_cases import ASKEW, HALF_RISE, LIMITS, RATE, Case, across, example, example_cases, motion
from agents.reproduce.findings import Findings, Part, Row
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.paths import NodeList
from pnt_gym.planning.timing import TimedPath
from pnt_gym.robots.t3kr.kinematics import inverse_kinematics

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ARMS: Final = ("+x +y", "-x +y", "-x -y", "+x -y")
"""Quadrants of the four arms."""


def speed_findings() -> Findings:
    """The radius of curvature, the node list, and the time it takes."""
    rows = [*_curvature(), *_nodes(), *_units(), *_time()]
    return Findings(tuple(rows), figures={"choe_nodes.svg": svg(nodes_figure())})


def _curvature() -> list[Row]:
    e = example()
    theta = np.linspace(e.theta_t2, e.theta_t1, 1_000_001)
    rho = e.radius_of_curvature(theta)
    peak, top = float(theta[np.argmax(rho)]), e.point(theta)[:, 1].argmax()
    place = e.point(peak)
    ratio = float(rho.max() / rho.min()) ** (4.0 / 3.0)
    return [
        Row(
            "choe/claim/speed-peaks-at-the-top",
            e.top[0],
            float(place[0]),
            "m",
            "differs",
            f"x of the largest radius of curvature: {rho.max():.4f} m at the end of the minor axis, "
            f"{float(rho[top]):.4f} m at the top",
        ),
        Row(
            "choe/claim/least-radius-at-the-start",
            "T1",
            "just before T2",
            "-",
            "differs",
            f"the least radius is b^2 / a = {1000.0 * float(rho.min()):.3f} mm at the end of the major axis, at T1 "
            f"{1000.0 * float(e.radius_of_curvature(e.theta_t1)):.3f} mm",
            {"least_m": float(rho.min()), "at_t1_m": float(e.radius_of_curvature(e.theta_t1))},
        ),
        Row(
            "choe/speed-law/ratio",
            None,
            ratio,
            "-",
            "ours",
            "a step r rho of the polar angle is a speed in proportion to rho^(4/3): fastest over slowest is (a / b)^4; "
            "equal centripetal acceleration would need rho^(1/2)",
        ),
    ]


def _nodes() -> list[Row]:
    printed, clipped = example().nodes(RATE, clip=False), example().nodes(RATE)
    over = math.degrees(example().theta_t2 - printed.theta[-1])
    share = printed.steps[0] / printed.steps.max()
    return [
        Row(
            "choe/nodes/count", None, float(printed.theta.size), "-", "ours", "r = 0.77 rad/m; the paper shows a figure"
        ),
        Row(
            "choe/nodes/shortest-step",
            None,
            float(printed.steps.min()),
            "m",
            "ours",
            f"the path starts at {100.0 * share:.1f} % of its greatest speed: almost from rest, which hides that the "
            "vertical parts before it are left open",
        ),
        Row("choe/nodes/longest-step", None, float(printed.steps.max()), "m", "ours"),
        Row(
            "choe/nodes/last-angle",
            math.degrees(example().theta_t2),
            math.degrees(float(printed.theta[-1])),
            "deg",
            "differs",
            f"steps 6 and 7 as printed run {over:.2f} deg past T2; clipped, the last chord is "
            f"{1000.0 * clipped.steps[-1]:.2f} mm",
        ),
    ]


def _units() -> list[Row]:
    """Step 6 sets an angle equal to a length times r: the list depends on the units."""
    e = example()
    counts = {
        "m and rad": e.nodes(RATE).theta.size,
        "mm and rad": e.nodes(1000.0 * RATE).theta.size,
        "mm and deg": e.nodes(1000.0 * math.radians(RATE)).theta.size,
    }
    return [
        Row(
            "choe/misprint/step-6-units",
            RATE,
            float(counts["mm and rad"]),
            "nodes",
            "misprint",
            "r carries 1/m and the control period, neither is given: with rho in millimetres the same r leaves "
            f"{counts['mm and rad']} nodes, with degrees too {counts['mm and deg']}, in metres and radians "
            f"{counts['m and rad']} as in the figures",
            {"nodes_by_units": counts},
        )
    ]


def _time() -> list[Row]:
    """The list read at a fixed period, as quick as the speed limit lets it, against the quickest motion."""
    speed, acceleration, jerk = LIMITS.numbers()
    nodes = example().nodes(RATE, clip=False)
    period = float(nodes.steps.max()) / speed
    total = period * (nodes.theta.size - 1)
    arc = motion(_case("arc"))
    quick = float(arc.duration[0])
    third = np.linalg.norm(np.diff(nodes.points, 3, axis=0), axis=1).max() / period**3
    return [
        Row(
            "choe/claim/shorter-cycle",
            "shorter",
            total,
            "s",
            "differs",
            f"node list at a fixed period of {1000.0 * period:.1f} ms, where its longest step reaches {speed} m/s; the "
            f"quickest motion over the same arc within {speed} m/s, {acceleration} m/s2 and {jerk} m/s3 takes "
            f"{quick:.3f} s",
            {"quickest_s": quick, "times_slower": total / quick},
        ),
        Row(
            "choe/claim/smooth-motion",
            "smooth",
            float(third),
            "m/s3",
            "not reproducible",
            "argued from rho, rho', rho'' over the angle, not over time, and neither period nor limits are given; here "
            "the largest jerk of that node list by third differences",
        ),
    ]


def _case(name: str) -> Case:
    return next(case for case in example_cases() if case.name == name)


def nodes_figure() -> Figure:
    """Nodes on the path, and radius and speed along it, beside the quickest motion (the paper's Figs. 5 and 6)."""
    figure, (path, law, time) = subplots(1, 3, (13.5, 3.8))
    e, nodes = example(), example().nodes(RATE)
    arc = 1000.0 * e.point(np.linspace(e.theta_t1, e.theta_t2, 400))
    path.plot(arc[:, 0], arc[:, 1], color=COLOURS[3], linewidth=1)
    path.plot(*(1000.0 * nodes.points.T), ".", color=COLOURS[0], label=f"{nodes.theta.size} nodes, r = {RATE} rad/m")
    path.plot(1000.0 * e.top[0], 1000.0 * e.top[1], "^", color="black", label="top")
    path.set_aspect("equal", adjustable="datalim")
    _dress(path, "x [mm]", "y [mm]", "node list")
    path.legend(fontsize=8, loc="lower right")
    _draw_law(law, nodes)
    period = float(nodes.steps.max()) / LIMITS.numbers()[0]
    time.plot(period * (0.5 + np.arange(nodes.steps.size)), nodes.steps / period, color=COLOURS[0], label="node list")
    quick = motion(_case("arc"))
    times = np.linspace(0.0, float(quick.duration[0]), 400)
    speed = np.linalg.norm(quick.sample(times).velocity[0], axis=1)
    time.plot(times, speed, color=COLOURS[1], label="quickest motion")
    _dress(time, "time [s]", "speed [m/s]", "the same arc within 1.8 m/s, 36 m/s², 900 m/s³")
    time.legend(fontsize=8)
    return figure


def _draw_law(axes: Axes, nodes: NodeList) -> None:
    e = example()
    theta = np.linspace(e.theta_t1, e.theta_t2, 600)
    x = 1000.0 * e.point(theta)[:, 0]
    axes.plot(x, 1000.0 * e.radius_of_curvature(theta), color=COLOURS[0], label="radius of curvature [mm]")
    middle = 500.0 * (nodes.points[1:, 0] + nodes.points[:-1, 0])
    axes.plot(middle, 1e4 * nodes.steps, ".-", color=COLOURS[1], label="10 x step to the next node [mm]")
    axes.axvline(1000.0 * e.top[0], color="gray", linewidth=1, linestyle=":", label="top of the path")
    axes.set_ylim(0.0, 1050.0)
    _dress(axes, "x [mm]", "[mm]", "the speed law: fastest left of the top")
    axes.legend(fontsize=7, loc="upper right")


def joint_findings() -> Findings:
    """Arm angles of our robot along the example, at the paper's nodes and in the quickest motion."""
    angles = _node_angles()
    case = _case("ellipse-10deg-relaxed")
    quick = TimedPath.of(across(case.path), motion(case).progress)
    times = np.arange(0.0, float(quick.duration[0]), 1e-3)
    swept = np.degrees(inverse_kinematics(quick.sample(times).position[0]))
    rows = [
        Row(
            f"choe/joints/arm-{k + 1}-swing",
            None,
            float(np.ptp(angles[:, k])),
            "deg",
            "not reproducible",
            f"arm in the quadrant {ARMS[k]} over the ellipse at the paper's nodes; the geometry of its Delta robot is "
            f"not given, ours stands in: T1 at {ASKEW} m, T2 opposite and {2000.0 * HALF_RISE:.0f} mm higher",
        )
        for k in range(4)
    ]
    steps = np.abs(np.diff(angles, axis=0)).max(axis=1)
    rows.append(
        Row(
            "choe/joints/largest-step",
            None,
            float(steps.max()),
            "deg",
            "ours",
            f"of an arm from one node to the next; the smallest is {float(steps[:-1].min()):.3f} deg",
        )
    )
    data = {"joint_angles_deg": angles.tolist()}
    return Findings(tuple(rows), {"choe_joints": data}, {"choe_joints.svg": svg(joints_figure(angles, times, swept))})


def _node_angles() -> Floats:
    """Arm angles (n, 4) [deg] at the paper's nodes."""
    whole = across(_case("arc").path)
    points = example().nodes(RATE).points - example().point(example().theta_t1)
    return np.degrees(inverse_kinematics(whole.positions(points)))


def joints_figure(angles: Floats, times: Floats, swept: Floats) -> Figure:
    """The paper's Fig. 7 on our robot, and the arms in the quickest motion with the vertical parts."""
    figure, (left, right) = subplots(1, 2, (11.0, 3.8))
    for k, name in enumerate(ARMS):
        left.plot(np.arange(1, len(angles) + 1), angles[:, k], color=COLOURS[k], label=f"arm {k + 1}, {name}")
        right.plot(times, swept[:, k], color=COLOURS[k])
    _dress(left, "node", "arm angle [°]", "ellipse at the paper's nodes (its Fig. 7)")
    _dress(right, "time [s]", "arm angle [°]", "quickest motion with 25 mm verticals, relaxed")
    figure.legend(*left.get_legend_handles_labels(), fontsize=8, loc="outside right center")
    return figure


def _dress(axes: Axes, across: str, up: str, title: str) -> None:
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_title(title, fontsize=10)
    axes.grid(alpha=0.3)


PARTS = (Part("speed", speed_findings), Part("joints", joint_findings))
