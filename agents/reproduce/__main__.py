"""Compute a paper's figures anew and compare them with the published ones: `python -m agents.reproduce hassan`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Annotated

import tyro

from ..ground.cli import about, at_least, check_known, check_libraries, check_once, option, run
from ..ground.outputs import check_writable, deliver_json, deliver_text
from ..ground.places import MADE
from ..ground.tables import console
from ..ground.work import Job, do_missing, processes
from . import papers
from .papers import OPTIMA, PAPERS, duration, jobs
from .record import assemble, headlines

ALL = "all"
PARTS_HELP = "Parts to compute, with their processor time; may be given more than once. " + " ".join(
    f"{name.capitalize()}: {papers.describe(name)}." for name in PAPERS
)
"""The help of `--only`."""


@dataclass(frozen=True)
class Arguments:
    """Compute a paper's figures anew and print them beside the published ones.

    Finished parts are kept until the code changes, so an interrupted reproduction goes on where it stopped.
    """

    paper: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="|".join((*PAPERS, ALL)))]
    """The paper, or all papers."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write every figure to this file."""
    figures: Annotated[Path | None, option("none", "FOLDER")] = None
    """Write the drawings to this folder as SVG."""
    jobs: Annotated[int | None, option("number of CPUs", "N")] = None
    """Processes side by side, one thread each."""
    only: Annotated[
        tuple[tuple[str, ...], ...],
        tyro.conf.UseAppendAction,
        tyro.conf.arg(metavar="PART ...", help=PARTS_HELP, help_behavior_hint="(default: all parts)"),
    ] = ()
    fresh: bool = False
    """Compute every part again, finished parts too."""
    work: Annotated[Path | None, option("runs/reproduce", "DIR")] = None
    """Folder of the finished parts."""


def main(arguments: Arguments) -> None:
    """Compute the missing parts, print the tables, and write the files asked for."""
    chosen = check(arguments)
    work = arguments.work or MADE / "runs" / "reproduce"
    planned = select([job for paper in chosen for job in jobs(paper)], [*chain(*arguments.only)])
    if any(job.name in OPTIMA for job in planned):
        check_libraries("casadi")
    allowed = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    parts = do_missing(planned, work, processes(arguments.jobs or allowed), fresh=arguments.fresh)
    findings = {job.name: part for job, part in zip(planned, parts, strict=True)}
    record, drawings = assemble(f"python -m agents.reproduce {arguments.paper}", findings)
    for grid in headlines(record):
        console().print(grid.terminal())
    took = duration(sum(part["seconds"] for part in parts))
    console().print(f"{len(parts)} parts, {took} of processor time in all; finished parts are kept in {work}")
    if arguments.json is not None:
        deliver_json(arguments.json, record)
        console().print(f"all {len(record['rows'])} figures are in {arguments.json}")
    if arguments.figures is not None:
        for name, text in drawings.items():
            deliver_text(arguments.figures / name, text)
        console().print(f"{len(drawings)} drawings are in {arguments.figures}")


def check(arguments: Arguments) -> tuple[str, ...]:
    """Check the options before any computation; returns the names of the papers.

    Raises:
        UsageError: a paper is unknown, a number is out of its range, or a file cannot be written.
    """
    check_known("paper", [arguments.paper], (*PAPERS, ALL))
    at_least(vars(arguments), jobs=1)
    check_libraries("matplotlib")
    check_writable(arguments.json, arguments.figures and arguments.figures / "drawing.svg")
    return tuple(PAPERS) if arguments.paper == ALL else (arguments.paper,)


def select(planned: Sequence[Job], only: Sequence[str]) -> list[Job]:
    """Jobs of the parts asked for; all jobs when no part is named.

    Raises:
        UsageError: there is no such part, or a part is given twice.
    """
    names = [job.name.split("/")[1] for job in planned]
    with about("--only"):
        check_known("part", only, dict.fromkeys(names))
    check_once({"only": only})
    return [job for job, name in zip(planned, names, strict=True) if not only or name in only]


if __name__ == "__main__":
    run(main, Arguments, "agents.reproduce")
