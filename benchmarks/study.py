"""What the studies share: their command line, and seeded conveyor cells and their throws."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from agents.judging.throws import results
from benchmarks.checks import check_parser
from pnt_gym.cells.base.core import Cell, Core
from pnt_gym.cells.conveyor.cell import ConveyorCell, Picks
from pnt_gym.cells.conveyor.config import ConveyorConfig

Floats = np.ndarray[Any, np.dtype[np.float64]]
CellT = TypeVar("CellT", bound=Cell[Any, Any, Any, Any])


def study_parser(doc: str | None, throws: int, each: str) -> argparse.ArgumentParser:
    """The options that every study of throws has; so many throws unless another number is given."""
    parser = check_parser(doc)
    parser.add_argument("--throws", type=int, default=throws, help=f"throws per {each}")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=2, help="physics threads; results do not depend on it")
    parser.add_argument("--json", type=Path, help="file to write the figures to")
    return parser


def study_options(parser: argparse.ArgumentParser) -> argparse.Namespace:
    """What was asked for; ends the process where that is no throw."""
    options = parser.parse_args()
    if options.throws < 1:
        parser.error(f"--throws is {options.throws}; at least 1 throw is needed")
    return options


def seeded_cells(config: ConveyorConfig, picks: Picks, cells: int, seed: int, threads: int) -> Core:
    """Cells whose first picks are drawn; the same seed gives the same objects."""
    core = Core(ConveyorCell(config, cells, picks, threads))
    core.reset(np.arange(cells), generators(cells, seed), seeded=True)
    return core


def draw_first(cell: CellT, seed: int) -> CellT:
    """The same cell, of any robot, with the first throws of its rows drawn; the same seed gives the same objects."""
    cell.reset(np.arange(cell.count), generators(cell.count, seed))
    return cell


def generators(count: int, seed: int) -> list[np.random.Generator]:
    """A generator for each of `count` rows."""
    return [np.random.default_rng([seed, row]) for row in range(count)]


def infos(core: Core, act: Callable[[int], Any], count: int) -> dict[str, Floats]:
    """What is told of `count` throws, with the actions that `act` gives for each step; landings are those of throws."""
    steps = [results(core.step(act(step)).info, core.count) for step in range(-(-count // core.count))]
    return {name: np.concatenate([info[name] for info in steps])[:count] for name in steps[0]}
