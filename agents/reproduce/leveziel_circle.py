"""The 80 mm circle of Leveziel et al. (section VI-B): its share of the reduced workspace, and a turn by the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from agents.report.figures import svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.leveziel_cases import CENTRE, CLOSED, HOME_THETA, OPEN, held, posed
from agents.reproduce.leveziel_drawings import circle_figure
from agents.reproduce.leveziel_model import Followed, follow_motions
from agents.reproduce.leveziel_motion_drawings import turn_figure
from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.robots.gripper4 import CIRCLE_RADIUS, Motion, Profile, circle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PIXEL: Final = 0.001
"""Spacing of the sections [m]."""
ANGLES: Final = (CLOSED, HOME_THETA, OPEN)
HEIGHTS: Final = (-0.20, -0.22, -0.24)
"""At which the circle is drawn in its section [m]."""
TURN_HEIGHT: Final = -0.220
"""Of the turn: the section holds it with the gripper opened and closed [m]."""
SMOOTH: Final = Profile("s-curve", 0.5)
SAMPLES: Final = 2001
_REACH: Final = 0.235
"""Beyond the workspace's extent to the side [m]."""


class Shares(NamedTuple):
    """The circle in the section at one height."""

    area: float
    """Its area over the section's."""
    inscribed: float
    """Radius of the largest circle about the z axis that fits [m]."""


def circle_findings(pixel: float = PIXEL) -> Findings:
    """Shares of area and radius at some heights, and a turn with the gripper closed, at home and open."""
    turns = {theta: circle((0.0, 0.0, TURN_HEIGHT), theta, profile=SMOOTH, samples=SAMPLES) for theta in ANGLES}
    told, done = follow_motions(list(turns.values()))
    rows = [*_circle(pixel), *_turn(turns, told, done)]
    figures = {
        "leveziel_circle.svg": svg(_circle_drawing(pixel)),
        "leveziel_turn.svg": svg(turn_figure(turns, done)),
    }
    return Findings(tuple(rows), {}, figures)


def level(height: float, theta: float, pixel: float) -> tuple[Floats, Bools]:
    """Coordinates (M,) along x and y [m], and where the reduced workspace is at a height (M, M)."""
    axis = pixel * np.arange(-round(_REACH / pixel), round(_REACH / pixel) + 1, dtype=np.float64)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    return axis, held(posed(np.stack([x, y, np.full_like(x, height)], axis=-1), theta))


def shares(height: float, theta: float, pixel: float) -> Shares:
    """How the circle compares with the reduced workspace's section at a height; NaN where there is none.

    In polar coordinates over a quarter, as the robot mirrors itself in the x-z and y-z planes.
    """
    width, turn = 0.5 * pixel, np.pi / 180.0
    radius = width * (np.arange(round(_REACH / width), dtype=np.float64) + 0.5)
    angle = turn * (np.arange(90, dtype=np.float64) + 0.5)
    x, y = radius * np.cos(angle[:, None]), radius * np.sin(angle[:, None])
    inside = held(posed(np.stack([x, y, np.full_like(x, height)], axis=-1), theta))
    area = 4.0 * turn * width * float((inside * radius).sum())
    fits = float(np.min(np.where(inside, _REACH, radius - 0.5 * width)))
    return Shares(np.pi * CIRCLE_RADIUS**2 / area if area > 0.0 else np.nan, fits)


def fitting(theta: float, pixel: float) -> tuple[float, Shares]:
    """The lowest height at which the circle fits, and its shares there."""
    low, high = -0.26, -0.20
    while high - low > 1e-4:
        middle = 0.5 * (low + high)
        fits = shares(middle, theta, pixel).inscribed >= CIRCLE_RADIUS
        low, high = (low, middle) if fits else (middle, high)
    return high, shares(high, theta, pixel)


def _circle(pixel: float) -> list[Row]:
    home, lower = shares(CENTRE[2], HOME_THETA, pixel), shares(HEIGHTS[-1], HOME_THETA, pixel)
    best = {f"{np.rad2deg(a):.0f}": fitting(a, pixel) for a in (CLOSED, HOME_THETA, OPEN)}
    deepest = max(height for height, _ in best.values())
    both = {name: 100.0 * shares(deepest, np.deg2rad(float(name)), pixel).area for name in best}
    name, (height, found) = max(best.items(), key=lambda one: one[1][1].area)
    middle = shares(HEIGHTS[1], HOME_THETA, pixel)
    return [
        Row(
            "leveziel/circle/area",
            "almost 80 %",
            f"{100.0 * home.area:.0f} %",
            "-",
            "differs",
            f"of the reduced workspace's section at -45 deg and z = -200 mm; at z = -240 mm it has "
            f"{100.0 * lower.area:.1f} % of the section's area but does not fit: only "
            f"{1e3 * lower.inscribed:.0f} mm of radius do",
            {"share": 100.0 * home.area, "share_240": 100.0 * lower.area, "inscribed_240_m": lower.inscribed},
        ),
        Row(
            "leveziel/circle/largest-area",
            "almost 80 %",
            f"{100.0 * found.area:.0f} %",
            "-",
            "reproduced" if found.area > 0.75 else "differs",
            f"where the section just holds the circle, z = {1e3 * height:.0f} mm at {name} deg; opened and closed at "
            f"one height it covers {min(both.values()):.0f} to {max(both.values()):.0f} % (z = {1e3 * deepest:.0f} mm)",
            {"by_angle": {key: [h, 100.0 * s.area] for key, (h, s) in best.items()}, "all_angles": both},
        ),
        Row(
            "leveziel/circle/radius",
            None,
            f"{100.0 * CIRCLE_RADIUS / middle.inscribed:.0f} %",
            "-",
            "ours",
            f"of the radius that fits at -45 deg and z = -220 mm, {1e3 * middle.inscribed:.0f} mm; "
            f"{100.0 * CIRCLE_RADIUS / home.inscribed:.0f} % at z = -200 mm. The paper names no height",
            {"inscribed_m": middle.inscribed, "inscribed_home_m": home.inscribed},
        ),
    ]


def _circle_drawing(pixel: float) -> Figure:
    heights = np.arange(-0.270, -0.1649, 0.0025)
    curves = {
        np.rad2deg(a): np.array([shares(float(z), a, pixel) for z in heights]) for a in (CLOSED, HOME_THETA, OPEN)
    }
    return circle_figure(heights, curves, {z: level(z, HOME_THETA, pixel) for z in HEIGHTS})


def _turn(turns: dict[float, Motion], told: Floats, done: Followed) -> list[Row]:
    still = np.rad2deg(np.abs(done.pose[..., 3] - told[:, :1, 3]).max(axis=1))
    wide = np.hypot(*np.moveaxis(done.pose[..., :2], -1, 0)) - CIRCLE_RADIUS
    reach = np.rad2deg(np.concatenate([m.q for m in turns.values()]))
    seconds = {f"{np.rad2deg(a):.0f}": m.duration for a, m in turns.items()}
    by_angle = dict(zip(seconds, still.tolist(), strict=True))
    return [
        Row(
            "leveziel/circle/theta",
            0.0,
            float(still.max()),
            "deg",
            "reproduced",
            f"largest change of theta in one turn by the robot in MuJoCo at z = {1e3 * TURN_HEIGHT:.0f} mm, opened and "
            f"closed; the radius stays within {1e3 * np.abs(wide).max():.2f} mm of 80 mm",
            {"by_theta": by_angle, "radius_error_m": float(np.abs(wide).max())},
        ),
        Row(
            "leveziel/circle/time-of-a-turn",
            None,
            max(seconds.values()),
            "s",
            "ours",
            "from rest to rest with the motors at up to 70 rpm, the slowest of -60, -45 and -30 deg; they turn between "
            f"{reach.min():.0f} and {reach.max():.0f} deg",
            {"by_theta": seconds},
        ),
    ]


PARTS = (Part("circle", circle_findings),)
