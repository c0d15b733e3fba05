"""Tables of the reproduction of Leveziel et al."""

from __future__ import annotations

from typing import Final

from agents.report.grids import ODD, Grid, Row, Rows, below, number, plain

WORKSPACE: Final = ("workspace", "fig-5", "video", "fig-6")
EXPERIMENTS: Final = ("circle", "closing")
SIMULATED: Final = ("cycle", "grasps", "endurance")
_TABLED: Final = tuple(f"leveziel/{folder}/" for folder in (*WORKSPACE, *EXPERIMENTS, *SIMULATED, "toss"))
"""Beginnings of the names that have tables of their own."""
DIRECTIONS: Final = ("z", "y", "x")


def leveziel_grids(rows: Rows) -> list[Grid]:
    """Workspace, moves, experiments, what the simulator made of the cycle, and what else was computed."""
    return [
        Grid("Workspace and manipulability, published and reproduced", *_folders(rows, WORKSPACE)),
        _moves(rows),
        Grid("The circle and the closing of the gripper", *_folders(rows, EXPERIMENTS)),
        Grid("The cork cycle and grasps in the simulator", *_folders(rows, SIMULATED)),
        _tosses(rows),
        _further(rows),
    ]


def _folders(rows: Rows, folders: tuple[str, ...]) -> tuple[list[str], list[list[str]]]:
    shown = [row for folder in folders for row in below(rows, f"leveziel/{folder}").values()]
    return plain(shown, verdict=True)


def _moves(rows: Rows) -> Grid:
    """One line per move and angle: how the platform's angle changes in moves of both kinds."""
    lines: list[list[str]] = []
    straight, joint = (rows.get(f"leveziel/simulated/{kind}") for kind in ("cartesian", "joint-linear"))
    for name in DIRECTIONS:
        row = rows.get(f"leveziel/moves/joint-linear-{name}")
        if row is None:
            continue
        for theta, turned in row["by_theta"].items():
            simulated = [_of(found, f"{name}, {theta} deg") for found in (straight, joint)]
            move = [f"{row['length_mm']:.0f} mm in {name}", f"{theta} deg"]
            away = f"{1e3 * row['path_m'][theta]:.1f} mm"
            lines.append([*move, simulated[0], f"{turned:.2f} deg", simulated[1], away])
    header = [
        "move", "theta", "line, simulated", "joint-linear, closed form", "joint-linear, simulated", "off the line",
    ]  # fmt: skip
    return Grid("How far a move turns the platform's halves; by the paper not at all", header, lines)


def _of(row: Row | None, move: str) -> str:
    return "-" if row is None else f"{row['by_move'][move]:.2f} deg"


def _tosses(rows: Rows) -> Grid:
    """One line per level, controller and practice."""
    lines = [
        [
            row["level"],
            row["controller"],
            str(row["practice"] or "-"),
            f"{row['reproduced']:.1f} %",
            f"{row['success_low']:.1f} to {row['success_high']:.1f} %",
            f"{1e3 * row['landing_error_m']:.1f} mm",
            f"{1e3 * row['release_delay_error_s']:.1f} ms",
            f"{number(row, 'cycle_time_s', 2)} s",
        ]
        for row in below(rows, "leveziel/toss").values()
    ]
    header = [
        "level", "controller", "throws of practice", "success", "95 % interval", "landing error", "off the plan",
        "cycle",
    ]  # fmt: skip
    return Grid("Tosses into the tray's compartments, held-out throws", header, lines)


def _further(rows: Rows) -> Grid:
    """Figures without a table of their own; those that do not agree are listed elsewhere."""
    shown = [row for name, row in rows.items() if not name.startswith(_TABLED) and row["verdict"] not in ODD]
    return Grid("Further figures", *plain(shown))
