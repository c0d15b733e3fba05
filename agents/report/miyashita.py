"""Tables of the reproduction of Miyashita et al. 2010."""

from __future__ import annotations

from typing import Final

from agents.report.grids import ODD, Grid, Rows, below, number, plain, value

DELAYS: Final = (0, 5, 10)
"""How late the block comes free [ms]."""
_TABLED: Final = tuple(
    f"miyashita/{folder}/" for folder in ("example", "learning", "acceptance", "scatter", "sorting", "assembly")
)
"""Beginnings of the names that have tables of their own."""


def miyashita_grids(rows: Rows) -> list[Grid]:
    """The example, learning, random goals, tasks, and what else was computed."""
    return [_example(rows), _learning(rows), _acceptance(rows), _contact(rows), _tasks(rows), _further(rows)]


def _example(rows: Rows) -> Grid:
    return Grid("Goal (0, 0.4 m, 150 deg, 0 m/s)", *plain(below(rows, "miyashita/example").values(), verdict=True))


def _learning(rows: Rows) -> Grid:
    """One line per delay and gain: the errors at the paper's goal."""
    lines: list[list[str]] = [["published, 10th throw", "-", "-", "< 2.5 mm", "< 0.10 deg", "< 0.010 m/s", "-"]]
    for delay in DELAYS:
        for name, row in below(rows, f"miyashita/learning/delay-{delay}ms").items():
            if name.startswith("K-"):
                first = f"{1e3 * row['position_first']:.1f} mm, {number(row, 'angle_first', 1)} deg"
                last = [f"{1e3 * row['reproduced']:.1f} mm", f"{number(row, 'angle_deg', 2)} deg"]
                line = [f"{delay} ms late", name.removeprefix("K-"), first, *last, f"{number(row, 'speed', 3)} m/s"]
                lines.append([*line, row["verdict"]])
    header = ["block comes free", "K", "first throw", "position", "angle", "vertical speed", "verdict"]
    return Grid("Learning the paper's goal: mean errors of the 10th throw, as the camera saw them", header, lines)


def _acceptance(rows: Rows) -> Grid:
    """One line per delay and gain: how many of many goals are learned."""
    lines: list[list[str]] = []
    for delay in DELAYS:
        for name, row in below(rows, f"miyashita/acceptance/delay-{delay}ms").items():
            shares = [
                f"{row[key]:.1f} %"
                for key in (
                    "reproduced",
                    "share_at_least_once",
                    "share_with_reserve",
                    "share_true_state",
                    "share_position_true",
                    "share_angle",
                )
            ]
            missed = f"{row['failed_out_of_reach']} of {row['failed']}"
            gain = name.removeprefix("K-").replace("any-release", "1-to-0.5, any release")
            lines.append([f"{delay} ms late", gain, *shares, missed])
        floor = value(rows, f"miyashita/scatter/delay-{delay}ms/share", "{:.1f} %")
        angle = rows.get(f"miyashita/scatter/delay-{delay}ms/share")
        if angle is not None:
            shared = f"{angle['share_angle']:.1f} %"
            lines.append([f"{delay} ms late", "scatter alone", floor, "-", "-", "-", "-", shared, "-"])
    header = [
        "block comes free", "K", "learned, by camera", "once in ten", "with reserve", "by true state",
        "position alone, true", "angle < 0.1 deg", "out of reach",
    ]  # fmt: skip
    return Grid("200 random goals, 10th throw: position < 2.5 mm and vertical speed < 0.01 m/s", header, lines)


def _contact(rows: Rows) -> Grid:
    return Grid("Stoppers that push the block", *plain(below(rows, "miyashita/contact").values(), verdict=True))


def _tasks(rows: Rows) -> Grid:
    shown = [*below(rows, "miyashita/sorting").values(), *below(rows, "miyashita/assembly").values()]
    return Grid("Sorting and assembly in the simulator", *plain(shown, verdict=True))


def _further(rows: Rows) -> Grid:
    """Figures without a table of their own; those that do not agree are listed elsewhere."""
    tabled = (*_TABLED, "miyashita/contact/")
    shown = [row for name, row in rows.items() if not name.startswith(tabled) and row["verdict"] not in ODD]
    return Grid("Further figures", *plain(shown))
