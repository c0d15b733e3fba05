"""Cartesian and joint-linear moves of Leveziel et al. (section VI-B): the change of the platform's angle.

The change is computed in closed form, and simulated with the robot in MuJoCo and its motors at up to 70 rpm. The moves
have the lengths of the paper's cork cycle; the paper does not print their places in the workspace.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final, NamedTuple

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots, svg
from agents.ground.tables import Grid
from agents.reproduce.finding import Findings, Row
from agents.reproduce.grids import row_grids
from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper import JointLimits
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD

from .cases import (
    ANGLES,
    CLOSED,
    SAMPLES,
    SMOOTH,
    STILL,
    SimulatedMotions,
    follow_motions,
    is_reachable,
    poses_at,
    random_poses,
)
from .motion import Deviation, PoseMotion, joint_deviation, joint_move, line

MOVES: Final = {
    "z": ((0.0, 0.0, -0.230), (0.0, 0.0, -0.180)),
    "y": ((0.0, 0.0, -0.180), (0.0, 0.070, -0.180)),
    "x": ((0.0, 0.0, -0.180), (0.070, 0.0, -0.180)),
}
"""First and last positions of moves 50 mm up and 70 mm sideways, as in Fig. 8 [m]."""
LIMITS: Final = JointLimits(acceleration=150.0)
"""Limits of the motors: 70 rpm as in the paper, and an acceleration [rad/s2] within the servos' torque."""
PAIRS: Final = 2000
"""Number of random moves of 50 to 100 mm."""
PIECES: Final = (2, 4, 8)
"""Numbers of joint-linear moves that replace a line."""


JOINT_LINEAR: Final = "leveziel/moves/joint-linear"
"""The statement that point-to-point motions keep the angle of the halves, which several rows test."""


class Pair(NamedTuple):
    """A move along a line, the joint-linear move between the same poses, and the deviation of the latter."""

    straight: PoseMotion
    joint: PoseMotion
    deviation: Deviation


Moves = Mapping[tuple[str, float], Pair]
"""Pairs of moves by direction and angle of the halves [rad]."""


def move_findings(pairs: int = PAIRS) -> Findings:
    """Angle and path of the platform in moves of both kinds, in closed form and simulated."""
    moves = {(name, theta): _plan_pair(name, theta) for name in MOVES for theta in ANGLES}
    commanded, record = follow_motions([motion for pair in moves.values() for motion in (pair.straight, pair.joint)])
    joint, simulated = tuple(_joint_linear_rows(moves)), tuple(_simulation_rows(moves, commanded, record))
    further_rows = (_cartesian_row(moves), _random_row(pairs), _pieces_row(), *simulated)
    tables = (
        _moves_grid(joint, *(row.details["by_move"] for row in simulated)),
        *row_grids("Cartesian and joint-linear moves", further_rows, drop="leveziel/"),
    )
    data = {
        f"{name}, {np.rad2deg(theta):.0f} deg": {
            "theta_deg": float(np.rad2deg(pair.deviation.theta)),
            "path_m": float(pair.deviation.path),
            "line_s": pair.straight.duration,
            "joint_s": pair.joint.duration,
        }
        for (name, theta), pair in moves.items()
    }
    figures = {"leveziel_moves.svg": svg(moves_figure(moves, record))}
    return Findings((*joint, *further_rows), {"leveziel_moves": data}, figures, tables)


def _plan_pair(name: str, theta: float) -> Pair:
    first, last = (poses_at(np.array(place), theta) for place in MOVES[name])
    straight = line(first, last, limits=LIMITS, profile=SMOOTH, samples=SAMPLES)
    joint = joint_move(first, last, limits=LIMITS, profile=SMOOTH, samples=SAMPLES)
    return Pair(straight, joint, joint_deviation(first, last))


def _moves_grid(joint: Iterable[Row], straight: Mapping[str, float], simulated: Mapping[str, float]) -> Grid:
    """Table of the platform's change of angle in moves of both kinds, one text line per move and angle."""
    lines = [
        [
            f"{row.details['length_mm']:.0f} mm in {name}",
            f"{theta} deg",
            f"{straight[f'{name}, {theta} deg']:.2f} deg",
            f"{turn:.2f} deg",
            f"{simulated[f'{name}, {theta} deg']:.2f} deg",
            f"{1e3 * row.details['path_m'][theta]:.1f} mm",
        ]
        for name, row in zip(MOVES, joint, strict=True)
        for theta, turn in row.details["by_theta"].items()
    ]
    header = (
        "move", "theta", "line, simulated", "joint-linear, closed form", "joint-linear, simulated", "off the line",
    )  # fmt: skip
    return Grid("How far a move turns the platform's halves; by the paper not at all", header, lines)


def _cartesian_row(moves: Moves) -> Row:
    still = max(float(np.abs(pair.straight.pose[:, 3] - theta).max()) for (_, theta), pair in moves.items())
    note = "largest change of theta in moves along lines, which hold it by construction"
    return Row.compared("leveziel/moves/cartesian", 0.0, float(np.rad2deg(still)), "deg", within=STILL, note=note)


def _joint_linear_rows(moves: Moves) -> Iterator[Row]:
    claw = 1e3 * PROTOTYPE_BUILD.claws.length
    for name, (first, last) in MOVES.items():
        deviations = {f"{np.rad2deg(a):.0f}": moves[name, a].deviation for a in ANGLES}
        turns = {angle: float(np.rad2deg(deviation.theta)) for angle, deviation in deviations.items()}
        worst = max(turns.values(), key=abs)
        listed = ", ".join(f"{value:.2f} at {angle} deg" for angle, value in turns.items())
        distance = 1e3 * max(float(deviation.path) for deviation in deviations.values())
        path = (
            f"the path leaves the line by up to {distance:.1f} mm" if distance > 1e-6 else "the path stays on the line"
        )
        length = 1e3 * float(np.linalg.norm(np.subtract(last, first)))
        yield Row.compared(
            f"leveziel/moves/joint-linear-{name}",
            0.0,
            worst,
            "deg",
            within=STILL,
            note=f"largest change of theta in a point-to-point motion of the motors over {length:.0f} mm in {name}: "
            f"{listed}; {path}, and each pad, {claw:.0f} mm below its axis, moves by "
            f"{claw * np.deg2rad(abs(worst)):.1f} mm",
            statement=JOINT_LINEAR,
            by_theta=turns,
            path_m={angle: float(deviation.path) for angle, deviation in deviations.items()},
            length_mm=length,
        )


def random_moves(count: int) -> tuple[Floats, Floats]:
    """First and last poses (count, 4) of random moves of 50 to 100 mm within the reduced workspace, theta constant."""
    rng = np.random.default_rng(0)
    first = random_poses(6 * count, 0)
    way = rng.normal(size=(len(first), 3))
    way *= rng.uniform(0.05, 0.10, (len(first), 1)) / np.linalg.norm(way, axis=1, keepdims=True)
    last = first + np.column_stack([way, np.zeros(len(first))])
    inside = is_reachable(last)
    return first[inside][:count], last[inside][:count]


def _random_row(pairs: int) -> Row:
    first, last = random_moves(pairs)
    deviation = joint_deviation(first, last)
    turns, path = np.rad2deg(np.abs(deviation.theta)), 1e3 * deviation.path
    note = (
        f"median over {len(first):,} random moves of 50 to 100 mm in the reduced workspace, theta -60 to -30 deg, seed "
        f"0: one in twenty changes theta by more than {np.quantile(turns, 0.95):.1f} deg; the path leaves the line by "
        f"{np.median(path):.1f} mm, one in twenty by more than {np.quantile(path, 0.95):.1f} mm"
    )
    details = {"quantile_95_deg": float(np.quantile(turns, 0.95)), "path_median_m": 1e-3 * float(np.median(path))}
    median = float(np.median(turns))
    return Row.ours("leveziel/moves/joint-linear-anywhere", median, "deg", beside=0.0, note=note, **details)


def _pieces_row() -> Row:
    """Row with the change of theta when the worst move is cut into several shorter moves."""
    first, last = (poses_at(np.array(place), CLOSED) for place in MOVES["z"])
    vias = {str(count): np.linspace(first, last, count + 1) for count in PIECES}
    turns = {n: float(np.rad2deg(np.abs(joint_deviation(v[:-1], v[1:]).theta).max())) for n, v in vias.items()}
    listed = ", ".join(f"{value:.2f} deg with {count}" for count, value in turns.items())
    note = (
        f"largest change of theta over 50 mm in z at -60 deg, cut into {PIECES[-1]} joint-linear moves alike; {listed}"
    )
    return Row.ours("leveziel/moves/joint-linear-in-pieces", turns[str(PIECES[-1])], "deg", note=note, by_pieces=turns)


def _simulation_rows(moves: Moves, commanded: Floats, record: SimulatedMotions) -> Iterator[Row]:
    turns = np.rad2deg(record.pose[..., 3] - commanded[:, :1, 3])
    worst = np.take_along_axis(turns, np.abs(turns).argmax(axis=1)[:, None], axis=1)[:, 0]
    distances = 1e3 * np.linalg.norm(record.pose[:, :-1, :3] - commanded[:, 1:, :3], axis=-1).max(axis=1)
    names = [f"{name}, {np.rad2deg(theta):.0f} deg" for name, theta in moves]
    closed = np.array([float(np.rad2deg(pair.deviation.theta)) for pair in moves.values()])
    torque = float(np.abs(record.torque).max())
    straight, joint = worst[0::2], worst[1::2]
    worst_move = int(np.abs(joint).argmax())
    gap = float(np.abs(joint - closed).max())
    along = (
        f"largest change of theta in {len(names)} moves along lines by the robot in MuJoCo, motors at up to 70 rpm and "
        f"empty claws; the path stays within {distances[0::2].max():.2f} mm, torque below {torque:.1f} N m"
    )
    turning = (
        f"largest change of theta in {len(names)} joint-linear moves by the robot in MuJoCo, {names[worst_move]}; "
        f"{gap:.2f} deg off the closed form at most"
    )
    for kind, figure, by_move, note, further in (
        ("cartesian", float(np.abs(straight).max()), straight, along, {"torque": torque}),
        ("joint-linear", float(joint[worst_move]), joint, turning, {"gap": gap}),
    ):
        details = {"by_move": dict(zip(names, by_move.tolist(), strict=True)), **further}
        yield Row.compared(
            f"leveziel/simulated/{kind}",
            0.0,
            figure,
            "deg",
            within=STILL,
            note=note,
            statement=f"leveziel/moves/{kind}",
            **details,
        )


def line_distance(points: Floats, first: Floats, last: Floats) -> Floats:
    """Distances (S,) [m] of points (S, 3) from the line through the points ``first`` and ``last``."""
    way = (last - first) / np.linalg.norm(last - first)
    return np.linalg.norm(np.cross(points - first, way), axis=1)


def moves_figure(moves: Moves, record: SimulatedMotions) -> Figure:
    """Drawing of the halves' angle and of the distance from the line over time, with the gripper closed."""
    figure, (angle, path) = subplots(2, 1, (WIDTH, 7.6), sharex=True)
    dots: dict[str, Any] = {"linestyle": "", "marker": "o", "markersize": 2.5}
    for k, name in enumerate(MOVES):
        pair = moves[name, CLOSED]
        first, last = pair.straight.pose[[0, -1], :3]
        row = 2 * list(moves).index((name, CLOSED))
        for way, kind, motion, style in (
            (row, "line", pair.straight, "--"),
            (row + 1, "joint-linear", pair.joint, "-"),
        ):
            samples = np.flatnonzero(record.time <= motion.duration)[::20]
            options: dict[str, Any] = {"linestyle": style, "label": f"{name}, {kind}"}
            for time, pose, look in (
                (motion.time, motion.pose, options),
                (record.time[samples], record.pose[way, samples], dots),
            ):
                angle.plot(1e3 * time, np.rad2deg(pose[:, 3]), color=COLOURS[k], **look)
                path.plot(1e3 * time, 1e3 * line_distance(pose[:, :3], first, last), color=COLOURS[k], **look)
    angle.plot([], [], color="gray", label="in MuJoCo", **dots)
    dress(angle, "", "angle of the platform's halves θ [°]")
    dress(path, "time [ms]", "distance from the straight line [mm]")
    figure.legend(*angle.get_legend_handles_labels(), fontsize=8, ncols=2, loc="outside lower center")
    figure.suptitle("50 mm in z, 70 mm in y and in x with θ = -60°, motors at up to 70 rpm", fontsize=11)
    return figure
