"""Tables of the reproduction of Hassan et al. 2022."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from agents.report.grids import ODD, Grid, Row, Rows, number, plain, value

COLUMNS: Final = (
    ("inside", 15),
    ("inside", 30),
    ("inside", 40),
    ("outside", 35),
    ("outside", 40),
    ("outside", 45),
)
"""Zones and percentages of the paper's Table I."""
METHODS: Final = {
    "pick-and-place": "pick-and-place",
    "horizontal-throw": "horizontal throw",
    "min-time-throw": "minimum-time throw",
}
PROTOCOLS: Final = {"paper-clock": "paper clock", "limits-respected": "within the limits"}
FREE: Final = {
    "free-direction-throw": "free direction, optimum",
    "free-direction-per-pick": "free direction, planned per pick",
}
HEADROOM: Final = {
    "hand-cap-0": "hand not above the release ceiling",
    "hand-cap-0.05": "hand at most 0.05 m above it",
    "window-10ms": "window of 10 ms after the release",
    "window-30ms": "window of 30 ms",
}


def hassan_grids(rows: Rows) -> list[Grid]:
    """Tables of Hassan et al. 2022."""
    return [
        table1(rows),
        simulated(rows),
        headroom(rows),
        per_pick(rows),
        sums(rows),
        dwells(rows),
        methods(rows),
        claims(rows),
    ]


def table1(rows: Rows) -> Grid:
    """Picks per minute, published and by both protocols, and of the free direction."""
    lines: list[list[str]] = []
    for method, name in METHODS.items():
        cells = [rows.get(f"table1/paper-clock/{method}/{zone}/{percent}") for zone, percent in COLUMNS]
        if not any(cells):
            continue
        lines.append([f"{name}, published", *(number(row, "published", 0) for row in cells), "-"])
        lines += [_line(rows, protocol, method, f"{name}, {label}") for protocol, label in PROTOCOLS.items()]
    lines += [_line(rows, "limits-respected", method, name) for method, name in FREE.items()]
    header = ["picks/min", *_columns(), "peak acceleration"]
    return Grid("Table I, published and reproduced", header, [line for line in lines if set(line[1:]) != {"-"}])


def _columns() -> list[str]:
    return [f"{zone} {percent} %" for zone, percent in COLUMNS]


def _cells(rows: Rows, folder: str) -> list[Row | None]:
    return [rows.get(f"{folder}/{zone}/{percent}") for zone, percent in COLUMNS]


def _line(rows: Rows, protocol: str, method: str, name: str) -> list[str]:
    """Values of one method, and the largest acceleration of any of its cells over the limit."""
    cells = _cells(rows, f"table1/{protocol}/{method}")
    peaks = [row["peak_acceleration_ratio"] for row in cells if row is not None and "peak_acceleration_ratio" in row]
    return [name, *(number(row, "reproduced", 1) for row in cells), f"{max(peaks):.2f} A" if peaks else "-"]


def simulated(rows: Rows) -> Grid:
    """What the closed-chain cell gave for the cells of Table I."""
    lines = [
        _simulated_line(rows, f"table1/{protocol}/{method}", f"{name}, {label}")
        for method, name in METHODS.items()
        for protocol, label in PROTOCOLS.items()
    ]
    lines += [_simulated_line(rows, f"table1/limits-respected/{method}", name) for method, name in FREE.items()]
    return Grid(
        "Table I in the simulator: worst landing error without mismatch, and how many are sorted with it",
        ["landing, sorted", *_columns(), "touched again", "touched with mismatch", "peak torque"],
        [line for line in lines if line],
    )


def _simulated_line(rows: Rows, folder: str, name: str) -> list[str]:
    """Cells, objects touched again without and with mismatch, and torque; nothing where nothing was simulated."""
    cells = [(row or {}).get("simulated") for row in _cells(rows, folder)]
    done = [cell for cell in cells if cell is not None]
    if not done:
        return []
    touched = [f"{sum(c[m]['recontacts'] for c in done)}/{sum(c[m]['trials'] for c in done)}" for m in ("0", "1")]
    torque = max(cell[m]["peak_torque"] for cell in done for m in ("0", "1"))
    return [name, *(_landing(cell) for cell in cells), *touched, f"{torque:.0f} N m"]


def _landing(cell: Mapping[str, Any] | None) -> str:
    if cell is None:
        return "-"
    ideal, realistic = cell["0"], cell["1"]
    return f"{1000 * ideal['landing_error_max']:.1f} mm, {realistic['sorted']}/{realistic['trials']}"


def headroom(rows: Rows) -> Grid:
    """The free direction beside the best straight throw, and what further bounds cost."""
    best = _cells(rows, "table1/paper-clock/min-time-throw")
    straight = _cells(rows, "table1/limits-respected/min-time-throw")
    lines = [
        ["published, minimum-time throw", *(number(row, "published", 0) for row in best), "-", "-"],
        ["straight throw, within the limits", *(number(row, "reproduced", 1) for row in straight), *_outcome(straight)],
    ]
    folders = {f"table1/limits-respected/{method}": name for method, name in FREE.items()}
    folders |= {f"headroom/{variant}": name for variant, name in HEADROOM.items()}
    for folder, name in folders.items():
        cells = _cells(rows, folder)
        if any(row is not None for row in cells):
            lines.append([name, *(_feasible(row) for row in cells), *_outcome(cells)])
    header = ["picks/min", *_columns(), "touched again", "sorted with mismatch"]
    return Grid("Release in a free direction, and what bounds cost", header, lines if len(lines) > 2 else [])


def _feasible(row: Row | None) -> str:
    return "infeasible" if row is not None and row["verdict"] == "infeasible" else number(row, "reproduced", 1)


def _outcome(cells: Sequence[Row | None]) -> list[str]:
    """Touched again without mismatch, and sorted with it, over all cells of a line."""
    done = [row["simulated"] for row in cells if row is not None and "simulated" in row]
    if not done:
        return ["-", "-"]
    share = sum(cell["1"]["sorted"] for cell in done) / sum(cell["1"]["trials"] for cell in done)
    trials = sum(cell["0"]["trials"] for cell in done)
    return [f"{sum(cell['0']['recontacts'] for cell in done)}/{trials}", f"{100 * share:.0f} %"]


def dwells(rows: Rows) -> Grid:
    """Picks per minute with a gripper that waits at every pick."""
    names = {f"table1/{p}/{m}": f"{name}, {label}" for m, name in METHODS.items() for p, label in PROTOCOLS.items()}
    names |= {f"table1/limits-respected/{method}": name for method, name in FREE.items()}
    lines: list[list[str]] = []
    for folder, name in names.items():
        cells = _cells(rows, folder)
        if any(row is not None and "picks_per_min_dwell_0.1" in row for row in cells):
            lines.append([name, *(_dwell(row) for row in cells)])
    return Grid("With a gripper that waits 0.1 s or 0.2 s at every pick", ["picks/min", *_columns()], lines)


def _dwell(row: Row | None) -> str:
    values = [number(row, f"picks_per_min_dwell_{wait}", 1) for wait in ("0.1", "0.2")]
    return " / ".join(values) if row is not None else "-"


def methods(rows: Rows) -> Grid:
    """The paper's ways to find a release beside the exact solver, on the same throws."""
    header = ["method", "agree", "wrong", "failed", "invented", "slowest answer", "median", "over exact"]
    lines: list[list[str]] = []
    for folder, bound in (("no-ceiling", "no ceiling"), ("ceiling", "under a ceiling")):
        base = f"hassan/methods/{folder}"
        if f"{base}/exact/median-time" not in rows:
            continue
        exact = value(rows, f"{base}/exact/median-time", "{:.0f} us")
        lines.append([f"exact, {bound}", "-", "-", "-", "-", "-", exact, "1"])
        rate = value(rows, f"{base}/exact-batch/plans-per-second", "{:,.0f} per s")
        ratio = value(rows, f"{base}/exact-batch/time-ratio", "{:.2f}")
        lines.append([f"exact in batches, {bound}", "-", "-", "-", "-", "-", rate, ratio])
        lines += [_method_line(rows, f"{base}/{name}", f"{label}, {bound}") for name, label in _METHOD_NAMES.items()]
    return Grid("Ways to find the release, on the same throws", header, lines)


_METHOD_NAMES: Final = {
    "method-1-slsqp": "Method 1 (SLSQP)",
    "method-1-trust-constr": "Method 1 (trust-constr)",
    "method-2": "Method 2",
}


def _method_line(rows: Rows, folder: str, name: str) -> list[str]:
    forms = {
        "agreements": "{:.0f}",
        "wrong-answers": "{:.0f}",
        "failures": "{:.0f}",
        "invented": "{:.0f}",
        "slowest-answer": "{:.3g}",
        "median-time": "{:,.0f} us",
        "time-ratio": "{:.0f}",
    }
    return [name, *(value(rows, f"{folder}/{quantity}", form) for quantity, form in forms.items())]


def per_pick(rows: Rows) -> Grid:
    """What planning per pick loses against the optimum, and how it did on random picks of the belt."""
    base = "table1/limits-respected/free-direction-per-pick"
    loss = rows.get(f"{base}/loss-max", {}).get("loss_by_cell", {})
    timed = [rows.get(f"{base}/time-per-pick-{zone}-{percent}") for zone, percent in COLUMNS]
    counts = {"planned": "planned", "straight": "of them straight", "limits_kept": "of them within limits and rules"}
    lines = [
        [
            "loss of picks/min against the optimum",
            *(_share(loss.get(f"{zone}/{percent}")) for zone, percent in COLUMNS),
        ],
        ["random picks of the belt in one batch", *(number(row, "picks", 0) for row in timed)],
        *([name, *(number(row, entry, 0) for row in timed)] for entry, name in counts.items()),
        ["processor time per pick", *("-" if row is None else f"{row['reproduced']:.0f} us" for row in timed)],
    ]
    return Grid("Free direction, planned per pick", ["", *_columns()], lines if loss else [])


def _share(percent: float | None) -> str:
    return "-" if percent is None else f"{percent:.1f} %"


def sums(rows: Rows) -> Grid:
    """How far each protocol is from the published table, what holds across it, and how it keeps to the limits."""
    names = {"mean": "mean-difference", "worst": "worst-difference", "off the fold": "worst-difference-off-the-fold"}
    counts = {"ordered columns": "ordered-columns", "rising rows": "rising-rows"}
    peaks = {"peak v": "peak-velocity", "peak a": "peak-acceleration", "peak j": "peak-jerk"}
    lines: list[list[str]] = []
    for protocol in dict.fromkeys(name.split("/")[1] for name in rows if name.startswith("table1/")):
        base = f"table1/{protocol}"
        if f"{base}/mean-difference" in rows:
            line = [value(rows, f"{base}/{name}", "{:.1f} %") for name in names.values()]
            line += [_of(rows.get(f"{base}/{name}")) for name in counts.values()]
            line += [value(rows, f"{base}/{name}", "{:.2f}") for name in peaks.values()]
            lines.append([PROTOCOLS.get(protocol, protocol.replace("-", " ")), *line])
    return Grid("Table I as a whole", ["difference to the published table", *names, *counts, *peaks], lines)


def _of(row: Row | None) -> str:
    return "-" if row is None else f"{row['reproduced']:.0f} of {row['published']:.0f}"


def claims(rows: Rows) -> Grid:
    """What the paper states of its throws, and what the rules it leaves open change."""
    folders = ("hassan/claim/", "hassan/sensitivity/")
    shown = [row for name, row in rows.items() if name.startswith(folders) and row["verdict"] not in ODD]
    return Grid("Claims, and what open choices change", *plain(shown))
