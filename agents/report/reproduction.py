"""What a reproduction of papers found, as tables: for the terminal, the report and a README."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from agents.report.choe import choe_grids
from agents.report.grids import ODD, Grid, Row, Rows, plain
from agents.report.hassan import hassan_grids, table1
from agents.report.leveziel import leveziel_grids
from agents.report.miyashita import miyashita_grids

Data = Mapping[str, Any]
TITLES: Final = {
    "hassan": "Hassan et al. 2022",
    "choe": "Choe et al. 2023",
    "miyashita": "Miyashita et al. 2010",
    "leveziel": "Leveziel et al.",
}
GRIDS: Final[Mapping[str, Callable[[Rows], list[Grid]]]] = {
    "hassan": hassan_grids,
    "choe": choe_grids,
    "miyashita": miyashita_grids,
    "leveziel": leveziel_grids,
}
"""What makes the tables of a paper; other papers get one table of all their figures."""
SHOWN: Final = {"hassan": 3, "choe": 3, "miyashita": 5, "leveziel": 5}
"""How many of them the terminal shows."""
USED: Final = ("python", "pnt_gym", "mujoco", "numpy", "scipy", "casadi")
"""Packages that a reproduction depends on."""


def is_reproduction(data: Data) -> bool:
    """Whether a file of results is that of `python -m agents.reproduce`."""
    return {"papers", "rows", "figures"} <= set(data)


def of_paper(data: Data, paper: str) -> Rows:
    """Rows of one paper by quantity."""
    return {row["quantity"]: row for row in data["rows"] if row["paper"] == paper}


def headlines(data: Data) -> list[Grid]:
    """The tables worth a terminal: the first ones of every paper, what is odd, and the verdicts."""
    grids: list[Grid] = []
    for paper in data["papers"]:
        rows = of_paper(data, paper)
        grids += [*_special(paper, rows)[: SHOWN.get(paper, 1)], oddities(paper, rows), verdicts(paper, rows)]
    return [grid for grid in grids if grid.rows]


def paper_grids(paper: str, rows: Rows) -> list[Grid]:
    """Every table of a paper."""
    return [grid for grid in (*_special(paper, rows), oddities(paper, rows)) if grid.rows]


def _special(paper: str, rows: Rows) -> list[Grid]:
    if paper in GRIDS:
        return GRIDS[paper](rows)
    return [Grid("All figures", *plain(rows.values(), verdict=True))]


def oddities(paper: str, rows: Rows) -> Grid:
    """What does not agree with the paper, each with what shows it; single cells of Table I have their own table."""
    shown = [row for name, row in rows.items() if row["verdict"] in ODD and not _is_cell(name)]
    return Grid(f"{TITLES.get(paper, paper)}: what does not agree", *plain(shown, verdict=True))


def _is_cell(name: str) -> bool:
    return name.startswith(("table1/", "headroom/")) and name.rsplit("/", 1)[1].isdigit()


def verdicts(paper: str, rows: Rows) -> Grid:
    """How many figures got which verdict."""
    found = [row["verdict"] for row in rows.values()]
    lines = [[verdict, str(found.count(verdict))] for verdict in sorted(set(found))]
    return Grid(f"{TITLES.get(paper, paper)}: verdicts", ["verdict", "figures"], lines)


def reproduction_note(paper: str, data: Data) -> str:
    """What the figures were made with, and what the verdicts count."""
    counts = ", ".join(f"{count} {verdict}" for verdict, count in verdicts(paper, of_paper(data, paper)).rows)
    seconds = sum(value for name, value in data["seconds"].items() if name.startswith(f"{paper}/"))
    versions = ", ".join(f"{package} {data['versions'][package]}" for package in USED if package in data["versions"])
    return (
        f'{data["command"]}: {counts}; {seconds:.0f} s of work. Verdict "ours" marks figures that the paper does not '
        f"give. Versions: {versions}."
    )


def table1_block(data: Data) -> str:
    """Table I as Markdown."""
    return table1(of_paper(data, "hassan")).markdown()


def table1_note(data: Data) -> str:
    """How far the paper's clock is off, and what the lines mean."""
    rows = of_paper(data, "hassan")
    mean, worst = (rows[f"table1/paper-clock/{name}-difference"]["reproduced"] for name in ("mean", "worst"))
    heights = [
        row["hand_above_ceiling_m"] for name, row in rows.items() if name.startswith("table1/") and _is_free(row)
    ]
    height = f" In the free direction the hand rises up to {max(heights):.2f} m above it." if heights else ""
    return (
        f"Paper clock: {mean:.1f} % off on average, {worst:.1f} % at worst. Its moves overlap by whole ramps, so the "
        "acceleration exceeds its limit A where the hand turns round (last column); the lines within the limits and of "
        "the free direction keep speed, acceleration and jerk at all times. Every release lies below the same ceiling."
        + height
    )


def _is_free(row: Row) -> bool:
    return "hand_above_ceiling_m" in row
