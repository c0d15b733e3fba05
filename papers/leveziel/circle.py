"""The 80 mm circle of Leveziel et al. (section VI-B): its share of the reduced workspace, and a turn by the robot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import table_findings
from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper import MOTOR_SPEED
from pnt_gym.robots.gripper.geometry import N_ARMS

from .cases import (
    ANGLES,
    HOME_THETA,
    PIXEL,
    SAMPLES,
    SIDE,
    SMOOTH,
    STILL,
    SimulatedMotions,
    follow_motions,
    is_reachable,
    poses_at,
)
from .motion import CIRCLE_RADIUS, PoseMotion, circle

HEIGHTS: Final = (-0.20, -0.22, -0.24)
"""Heights of the sections in which the circle is drawn [m]."""
TURN_HEIGHT: Final = -0.220
"""Height of the turn [m]: the section contains the circle with the gripper opened and closed."""
PUBLISHED: Final = "almost 80 %"
_RPM: Final = 60.0 / (2.0 * np.pi)


class Shares(NamedTuple):
    """Size of the circle against the workspace's section at one height."""

    area: float
    """Area of the circle over the area of the section."""
    inscribed: float
    """Radius of the largest circle about the z axis that fits into the section [m]."""


def circle_findings(pixel: float = PIXEL) -> Findings:
    """Shares of area and radius at some heights, and a simulated turn with the gripper closed, at home and open."""
    turns = {theta: circle((0.0, 0.0, TURN_HEIGHT), theta, profile=SMOOTH, samples=SAMPLES) for theta in ANGLES}
    commanded, record = follow_motions(list(turns.values()))
    rows = (*_share_rows(pixel), _largest_row(pixel), *_turn_rows(turns, commanded, record))
    drawn = {"leveziel_circle.svg": circle_figure(pixel), "leveziel_turn.svg": turn_figure(turns, record)}
    return table_findings("The circle of 80 mm", rows, drawn, drop="leveziel/")


def shares(height: float, theta: float, pixel: float) -> Shares:
    """Area and radius of the circle against the reduced workspace's section at a height; NaN for an empty section.

    The section is sampled in polar coordinates over a quarter, as the robot is symmetric about the x-z and y-z planes.
    """
    width, turn = 0.5 * pixel, np.pi / 180.0
    # Middles of polar cells, so that a sum over cells is the midpoint rule.
    radius = width * (np.arange(round(SIDE / width), dtype=np.float64) + 0.5)
    angle = turn * (np.arange(90, dtype=np.float64) + 0.5)
    x, y = radius * np.cos(angle[:, None]), radius * np.sin(angle[:, None])
    inside = is_reachable(poses_at(np.stack([x, y, np.full_like(x, height)], axis=-1), theta))
    # A polar cell has the area r dr dphi; four quarters.
    area = 4.0 * turn * width * float((inside * radius).sum())
    # The innermost cell outside the section ends the inscribed circle at that cell's inner border.
    fits = float(np.min(np.where(inside, SIDE, radius - 0.5 * width)))
    return Shares(np.pi * CIRCLE_RADIUS**2 / area if area > 0.0 else np.nan, fits)


def fit_circle(theta: float, pixel: float) -> tuple[float, Shares]:
    """The lowest height [m] at which the circle fits, and its shares at that height, by bisection."""
    # The section shrinks downwards: at -0.20 m the circle fits at all angles, at -0.26 m at none.
    low, high = -0.26, -0.20
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        fits = shares(middle, theta, pixel).inscribed >= CIRCLE_RADIUS
        low, high = (low, middle) if fits else (middle, high)
    return high, shares(high, theta, pixel)


def _share_rows(pixel: float) -> Iterator[Row]:
    """Rows with the circle's share of area and radius at the heights that are drawn."""
    home, middle, lower = (shares(height, HOME_THETA, pixel) for height in HEIGHTS)
    yield Row.missing(
        "leveziel/circle/area",
        PUBLISHED,
        "-",
        reproduced=f"{100.0 * home.area:.0f} %",
        note="the paper names no height, and the share depends on it: of the reduced workspace's section at -45 deg "
        f"and z = -200 mm; at z = -240 mm it has {100.0 * lower.area:.1f} % of the section's area but does not fit: "
        f"only {1e3 * lower.inscribed:.0f} mm of radius do",
        share=100.0 * home.area,
        share_240=100.0 * lower.area,
        inscribed_240_m=lower.inscribed,
    )
    yield Row.ours(
        "leveziel/circle/radius",
        f"{100.0 * CIRCLE_RADIUS / middle.inscribed:.0f} %",
        "-",
        note=f"of the radius that fits at -45 deg and z = -220 mm, {1e3 * middle.inscribed:.0f} mm; "
        f"{100.0 * CIRCLE_RADIUS / home.inscribed:.0f} % at z = -200 mm. The paper names no height",
        inscribed_m=middle.inscribed,
        inscribed_home_m=home.inscribed,
    )


def _largest_row(pixel: float) -> Row:
    """Row with the circle's largest share of a section's area, at heights where the circle just fits."""
    best = {f"{np.rad2deg(a):.0f}": fit_circle(a, pixel) for a in ANGLES}
    deepest = max(height for height, _ in best.values())
    areas = {name: 100.0 * shares(deepest, np.deg2rad(float(name)), pixel).area for name in best}
    name, (height, best_share) = max(best.items(), key=lambda item: item[1][1].area)
    return Row.ours(
        "leveziel/circle/largest-area",
        f"{100.0 * best_share.area:.0f} %",
        "-",
        beside=PUBLISHED,
        note="the most of all heights and of -60, -45 and -30 deg, so searched for and no proof: where the section "
        f"just holds the circle, z = {1e3 * height:.0f} mm at {name} deg; opened and closed at one height it covers "
        f"{min(areas.values()):.0f} to {max(areas.values()):.0f} % (z = {1e3 * deepest:.0f} mm)",
        by_angle={key: [h, 100.0 * s.area] for key, (h, s) in best.items()},
        all_angles=areas,
    )


def _turn_rows(turns: Mapping[float, PoseMotion], commanded: Floats, record: SimulatedMotions) -> Iterator[Row]:
    # Against the first command, as the halves are commanded to keep one angle for the whole turn.
    still = np.rad2deg(np.abs(record.pose[..., 3] - commanded[:, :1, 3]).max(axis=1))
    wide = float(np.abs(np.hypot(record.pose[..., 0], record.pose[..., 1]) - CIRCLE_RADIUS).max())
    reach = np.rad2deg(np.concatenate([m.q for m in turns.values()]))
    seconds = {f"{np.rad2deg(a):.0f}": m.duration for a, m in turns.items()}
    note = (
        f"largest change of theta in one turn by the robot in MuJoCo at z = {1e3 * TURN_HEIGHT:.0f} mm, opened and "
        f"closed; the radius stays within {1e3 * wide:.2f} mm of 80 mm"
    )
    details = {"by_theta": dict(zip(seconds, still.tolist(), strict=True)), "radius_error_m": wide}
    yield Row.compared("leveziel/circle/theta", 0.0, float(still.max()), "deg", within=STILL, note=note, **details)
    note = (
        "from rest to rest with the motors at up to 70 rpm, the slowest of -60, -45 and -30 deg; they turn between "
        f"{reach.min():.0f} and {reach.max():.0f} deg"
    )
    yield Row.ours("leveziel/circle/time-of-a-turn", max(seconds.values()), "s", note=note, by_theta=seconds)


def circle_figure(pixel: float) -> Figure:
    """Drawing of the circle in sections at some heights, and of its share of area and radius over the height."""
    figure, (plane, parts) = subplots(2, 1, (WIDTH, 9.6), height_ratios=(1.3, 1.0))
    axis = pixel * np.arange(-round(SIDE / pixel), round(SIDE / pixel) + 1, dtype=np.float64)
    x, y = np.meshgrid(axis, axis)
    for colour, height in zip(COLOURS, HEIGHTS, strict=False):
        inside = is_reachable(poses_at(np.stack([x, y, np.full_like(x, height)], axis=-1), HOME_THETA))
        plane.contour(1e3 * axis, 1e3 * axis, inside.astype(float), levels=[0.5], colors=[colour])
        plane.plot([], [], color=colour, label=f"z = {1e3 * height:.0f} mm")
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    rim = 1e3 * CIRCLE_RADIUS * np.array([np.cos(turn), np.sin(turn)])
    plane.plot(*rim, "--", color="black", linewidth=1.2, label="circle of 80 mm")
    limits = {"aspect": "equal", "xlim": (-160, 160), "ylim": (-135, 135)}
    dress(plane, "x [mm]", "y [mm]", "reduced workspace at θ = -45°", legend="lower left", **limits)
    heights = np.arange(-0.270, -0.1649, 0.0025)
    for colour, theta in zip(COLOURS[4:], ANGLES, strict=False):
        degrees, values = np.rad2deg(theta), np.array([shares(float(z), theta, pixel) for z in heights])
        fits = values[:, 1] >= CIRCLE_RADIUS
        area = 100.0 * np.where(fits, values[:, 0], np.nan)
        radius = 100.0 * np.where(fits, CIRCLE_RADIUS / values[:, 1], np.nan)
        parts.plot(1e3 * heights, area, color=colour, label=f"of the area, θ = {degrees:.0f}°")
        parts.plot(1e3 * heights, radius, "--", color=colour, label=f"of the radius that fits, θ = {degrees:.0f}°")
    parts.axhline(80.0, color="black", linewidth=0.8, linestyle=":", label="published: almost 80 %")
    limits = {"xlim": (-255, -160), "ylim": (20.0, 105.0)}
    dress(parts, "height z [mm]", "share of the circle [%]", "where the circle fits", legend="best", **limits)
    return figure


def turn_figure(turns: Mapping[float, PoseMotion], record: SimulatedMotions) -> Figure:
    """Drawing of motor angles and speeds over a turn of the circle, opened and closed."""
    figure, axes = subplots(2, len(turns), (WIDTH, 5.4), sharex=True, sharey="row")
    for k, (theta, motion) in enumerate(turns.items()):
        angle, speed = axes[k], axes[len(turns) + k]
        during = record.time <= motion.duration
        for arm in range(N_ARMS):
            angle.plot(motion.time, np.rad2deg(motion.q[:, arm]), color=COLOURS[arm], label=f"motor {arm + 1}")
            places = np.rad2deg(record.q[k, during, arm])[::60]
            angle.plot(record.time[during][::60], places, "o", color=COLOURS[arm], markersize=2.5)
            speed.plot(motion.time, motion.speed[:, arm] * _RPM, color=COLOURS[arm])
        for limit in (-MOTOR_SPEED, MOTOR_SPEED):
            speed.axhline(limit * _RPM, color="black", linestyle="--", linewidth=0.8)
        dress(angle, "", "motor angle [°]" if k == 0 else "", f"θ = {np.rad2deg(theta):.0f}°")
        dress(speed, "time [s]", "motor speed [rpm]" if k == 0 else "")
    axes[0].plot([], [], "o", color="gray", markersize=2.5, label="in MuJoCo")
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=3, loc="outside lower center")
    figure.suptitle("circle of 80 mm at z = -220 mm; dashed: 70 rpm", fontsize=11)
    return figure
