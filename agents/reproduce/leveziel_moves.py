"""Cartesian and joint-linear moves of Leveziel et al. (section VI-B): what they do to the platform's angle.

In closed form, and carried out by the robot in MuJoCo with the motors at up to 70 rpm. The moves have the lengths of
the paper's cork cycle; where in the workspace they were made is not printed.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from agents.report.figures import svg
from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.leveziel_cases import CLOSED, HOME_THETA, OPEN, held, posed, random_poses
from agents.reproduce.leveziel_model import Followed, follow_motions
from agents.reproduce.leveziel_motion_drawings import Course, moves_figure
from pnt_gym.planning.arrays import Floats
from pnt_gym.robots.gripper4 import (
    Deviation,
    JointLimits,
    Motion,
    Profile,
    joint_deviation,
    joint_move,
    line,
)
from pnt_gym.robots.gripper4.build import PROTOTYPE_BUILD

MOVES: Final = {
    "z": ((0.0, 0.0, -0.230), (0.0, 0.0, -0.180)),
    "y": ((0.0, 0.0, -0.180), (0.0, 0.070, -0.180)),
    "x": ((0.0, 0.0, -0.180), (0.070, 0.0, -0.180)),
}
"""50 mm up and 70 mm aside, as in Fig. 8 [m]."""
ANGLES: Final = (CLOSED, HOME_THETA, OPEN)
LIMITS: Final = JointLimits(acceleration=150.0)
"""70 rpm as in the paper; with this acceleration the servos keep within their torque [rad/s2]."""
SMOOTH: Final = Profile("s-curve", 0.5)
PAIRS: Final = 2000
"""Random moves of 50 to 100 mm."""
PIECES: Final = (2, 4, 8)
"""Joint-linear moves that a line is cut into."""
SAMPLES: Final = 2001


class Pair(NamedTuple):
    """A move made both ways."""

    straight: Motion
    joint: Motion
    deviation: Deviation


def move_findings(pairs: int = PAIRS) -> Findings:
    """Angle and path of the platform in moves of both kinds, in closed form and simulated."""
    moves = {(name, theta): _pair(name, theta) for name in MOVES for theta in ANGLES}
    told, done = follow_motions([motion for pair in moves.values() for motion in (pair.straight, pair.joint)])
    rows = [*_closed_form(moves), _random(pairs), _pieces(), *_simulated(moves, told, done)]
    figures = {"leveziel_moves.svg": svg(moves_figure(_courses(moves, told, done)))}
    return Findings(tuple(rows), {"leveziel_moves": _data(moves)}, figures)


def _pair(name: str, theta: float) -> Pair:
    first, last = (posed(np.array(place), theta) for place in MOVES[name])
    straight = line(first, last, limits=LIMITS, profile=SMOOTH, samples=SAMPLES)
    joint = joint_move(first, last, limits=LIMITS, profile=SMOOTH, samples=SAMPLES)
    return Pair(straight, joint, joint_deviation(first, last))


def _data(moves: dict[tuple[str, float], Pair]) -> dict[str, dict[str, float]]:
    return {
        f"{name}, {np.rad2deg(theta):.0f} deg": {
            "theta_deg": float(np.rad2deg(pair.deviation.theta)),
            "path_m": float(pair.deviation.path),
            "line_s": pair.straight.duration,
            "joint_s": pair.joint.duration,
        }
        for (name, theta), pair in moves.items()
    }


def _closed_form(moves: dict[tuple[str, float], Pair]) -> list[Row]:
    still = max(float(np.abs(pair.straight.pose[:, 3] - theta).max()) for (_, theta), pair in moves.items())
    rows = [
        Row(
            "leveziel/moves/cartesian",
            0.0,
            float(np.rad2deg(still)),
            "deg",
            "reproduced",
            "largest change of theta in moves along lines, which hold it by construction",
        )
    ]
    claw = 1e3 * PROTOTYPE_BUILD.claws.length
    for name, (first, last) in MOVES.items():
        found = {theta: moves[name, theta].deviation for theta in ANGLES}
        turned = {f"{np.rad2deg(a):.0f}": float(np.rad2deg(one.theta)) for a, one in found.items()}
        worst = max(turned.values(), key=abs)
        listed = ", ".join(f"{value:.2f} at {angle} deg" for angle, value in turned.items())
        away = 1e3 * max(float(one.path) for one in found.values())
        path = f"the path leaves the line by up to {away:.1f} mm" if away > 1e-6 else "the path stays on the line"
        length = 1e3 * float(np.linalg.norm(np.subtract(last, first)))
        rows.append(
            Row(
                f"leveziel/moves/joint-linear-{name}",
                0.0,
                worst,
                "deg",
                "differs",
                f"largest change of theta in a point-to-point motion of the motors over {length:.0f} mm in {name}: "
                f"{listed}; {path}, "
                f"and each pad, {claw:.0f} mm below its axis, moves by {claw * np.deg2rad(abs(worst)):.1f} mm",
                {
                    "by_theta": turned,
                    "path_m": {f"{np.rad2deg(a):.0f}": float(one.path) for a, one in found.items()},
                    "length_mm": length,
                },
            )
        )
    return rows


def random_moves(count: int, seed: int = 0) -> tuple[Floats, Floats]:
    """Ends (count, 4) of moves of 50 to 100 mm within the reduced workspace at one angle each."""
    rng = np.random.default_rng(seed)
    first = random_poses(6 * count, seed)
    way = rng.normal(size=(len(first), 3))
    way *= rng.uniform(0.05, 0.10, (len(first), 1)) / np.linalg.norm(way, axis=1, keepdims=True)
    last = first + np.column_stack([way, np.zeros(len(first))])
    inside = held(last)
    return first[inside][:count], last[inside][:count]


def _random(pairs: int) -> Row:
    first, last = random_moves(pairs)
    found = joint_deviation(first, last)
    turned, path = np.rad2deg(np.abs(found.theta)), 1e3 * found.path
    return Row(
        "leveziel/moves/joint-linear-anywhere",
        0.0,
        float(np.median(turned)),
        "deg",
        "differs",
        f"median over {len(first):,} random moves of 50 to 100 mm in the reduced workspace, theta -60 to -30 deg, "
        f"seed 0: one in twenty changes theta by more than {np.quantile(turned, 0.95):.1f} deg; the path leaves the "
        f"line by {np.median(path):.1f} mm, one in twenty by more than {np.quantile(path, 0.95):.1f} mm",
        {"quantile_95_deg": float(np.quantile(turned, 0.95)), "path_median_m": 1e-3 * float(np.median(path))},
    )


def _pieces() -> Row:
    """The worst of the moves as several shorter ones."""
    first, last = (posed(np.array(place), CLOSED) for place in MOVES["z"])
    left: dict[str, float] = {}
    for count in PIECES:
        via = np.linspace(first, last, count + 1)
        left[str(count)] = float(np.rad2deg(np.abs(joint_deviation(via[:-1], via[1:]).theta).max()))
    listed = ", ".join(f"{value:.2f} deg with {count}" for count, value in left.items())
    return Row(
        "leveziel/moves/joint-linear-in-pieces",
        None,
        left[str(PIECES[-1])],
        "deg",
        "ours",
        f"largest change of theta over 50 mm in z at -60 deg, cut into {PIECES[-1]} joint-linear moves alike; {listed}",
        {"by_pieces": left},
    )


def _simulated(moves: dict[tuple[str, float], Pair], told: Floats, done: Followed) -> list[Row]:
    turned = np.rad2deg(done.pose[..., 3] - told[:, :1, 3])
    worst = np.take_along_axis(turned, np.abs(turned).argmax(axis=1)[:, None], axis=1)[:, 0]
    away = 1e3 * np.linalg.norm(done.pose[:, :-1, :3] - told[:, 1:, :3], axis=-1).max(axis=1)
    names = [f"{name}, {np.rad2deg(theta):.0f} deg" for name, theta in moves]
    closed = np.array([float(np.rad2deg(pair.deviation.theta)) for pair in moves.values()])
    torque = float(np.abs(done.torque).max())
    joint = worst[1::2]
    most = int(np.abs(joint).argmax())
    return [
        Row(
            "leveziel/simulated/cartesian",
            0.0,
            float(np.abs(worst[0::2]).max()),
            "deg",
            "reproduced",
            f"largest change of theta in {len(names)} moves along lines by the robot in MuJoCo, motors at up to 70 rpm "
            f"and empty claws; the platform stays within {away[0::2].max():.2f} mm, torque within {torque:.1f} N m",
            {"by_move": dict(zip(names, worst[0::2].tolist(), strict=True)), "torque": torque},
        ),
        Row(
            "leveziel/simulated/joint-linear",
            0.0,
            float(joint[most]),
            "deg",
            "differs",
            f"largest change of theta in {len(names)} joint-linear moves by the robot in MuJoCo, {names[most]}; "
            f"{np.abs(joint - closed).max():.2f} deg off the closed form at most",
            {"by_move": dict(zip(names, joint.tolist(), strict=True)), "gap": float(np.abs(joint - closed).max())},
        ),
    ]


def _courses(moves: dict[tuple[str, float], Pair], told: Floats, done: Followed) -> dict[str, Course]:
    """What is drawn of the moves with the gripper closed: angle and distance from the line over the time."""
    courses: dict[str, Course] = {}
    for k, ((name, theta), pair) in enumerate(moves.items()):
        if theta != CLOSED:
            continue
        ends = told[2 * k, 0, :3], told[2 * k, -1, :3]
        for row, kind, motion in ((2 * k, "line", pair.straight), (2 * k + 1, "joint-linear", pair.joint)):
            during = done.time <= motion.duration
            courses[f"{name}, {kind}"] = Course(
                motion.time,
                np.rad2deg(motion.pose[:, 3]),
                beside(motion.pose[:, :3], *ends),
                done.time[during],
                np.rad2deg(done.pose[row, during, 3]),
                beside(done.pose[row, during, :3], *ends),
            )
    return courses


def beside(points: Floats, first: Floats, last: Floats) -> Floats:
    """Distances (S,) of points (S, 3) from the line through two others [m]."""
    way = (last - first) / np.linalg.norm(last - first)
    return np.linalg.norm(np.cross(points - first, way), axis=1)


PARTS = (Part("moves", move_findings),)
