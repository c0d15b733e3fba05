"""Tables of the reproduction of Choe et al. 2023."""

from __future__ import annotations

from typing import Final

from agents.report.grids import ODD, Grid, Row, Rows, number, plain, value

CURVES: Final = {
    "symmetric-ellipse": "symmetric ellipse",
    "lame-d50mm": "Lamé, d = 50 mm",
    "lame-d150mm": "Lamé, d = 150 mm",
}
"""Curves of the paper's Fig. 8."""
READINGS: Final = ("same-ends", "same-ends-and-top", "curves-only", "curves-only-25mm")
"""What the comparison of Fig. 8 may mean."""
_TABLED: Final = (
    *(f"choe/{folder}/" for folder in ("example", "time", "saving", "above-bound", "simulated")),
    *(f"choe/fig-8/{reading}/" for reading in READINGS),
)
"""Beginnings of the names that have tables of their own."""


def choe_grids(rows: Rows) -> list[Grid]:
    """The example, lengths, times, and what else was computed."""
    return [_example(rows), _lengths(rows), _long_times(rows), _example_times(rows), _further(rows)]


def _example(rows: Rows) -> Grid:
    shown = [row for name, row in rows.items() if name.startswith("choe/example/")]
    return Grid("The published example", *plain(shown, verdict=True))


def _lengths(rows: Rows) -> Grid:
    """One line per way to read the comparison of Fig. 8."""
    lines: list[list[str]] = []
    for reading in READINGS:
        base = f"choe/fig-8/{reading}"
        proposed = rows.get(f"{base}/proposed")
        if proposed is not None:
            cells = [value(rows, f"{base}/{curve}", "{:.4f} m") for curve in CURVES]
            own = f"{number(proposed, 'length_m', 4)} m"
            lines.append([reading.replace("-", " "), own, *cells, proposed["reproduced"], proposed["note"]])
    header = ["compared", "proposed", *CURVES.values(), "proposed is", "note"]
    return Grid("Lengths of the curves, by what the comparison is taken to mean", header, lines)


def _long_times(rows: Rows) -> Grid:
    """Time, shape and peaks of every path, how it compares, and what the robot made of it."""
    lines = [
        [
            *_motion(name, row),
            value(rows, f"choe/saving/{name}", "{:.1f} %"),
            value(rows, f"choe/above-bound/{name}", "{:.1f} %"),
            value(rows, f"choe/simulated/{name}/tracking", "{:.5f} m"),
            value(rows, f"choe/simulated/{name}/torque", "{:.0f} N m"),
        ]
        for name, row in _timed(rows, "long").items()
    ]
    more = ["saved over rectangle", "above bound", "tracking", "torque"]
    return Grid("Time of a pick-and-place within the limits, one way", [*_MOTION, *more], lines)


def _example_times(rows: Rows) -> Grid:
    lines = [_motion(name, row) for name, row in _timed(rows, "example").items()]
    return Grid("Time of the example's path with short vertical parts, one way", _MOTION, lines)


_MOTION: Final = ("path", "time", "length", "height", "peak v, a, j")


def _timed(rows: Rows, group: str) -> dict[str, Row]:
    folder = f"choe/time/{group}/"
    return {name.removeprefix(folder): row for name, row in rows.items() if name.startswith(folder)}


def _motion(name: str, row: Row) -> list[str]:
    peaks = [number(row, f"peak_{what}", 2) for what in ("velocity", "acceleration", "jerk")]
    return [
        name.replace("-", " "),
        f"{number(row, 'reproduced', 3)} s",
        _metres(row, "length_m"),
        _metres(row, "top_m"),
        "-" if peaks == ["-"] * 3 else ", ".join(peaks),
    ]


def _metres(row: Row, name: str) -> str:
    return "-" if row.get(name) is None else f"{row[name]:.3f} m"


def _further(rows: Rows) -> Grid:
    """Figures without a table of their own; those that do not agree are listed elsewhere."""
    shown = [row for name, row in rows.items() if not name.startswith(_TABLED) and row["verdict"] not in ODD]
    return Grid("Further figures", *plain(shown))
