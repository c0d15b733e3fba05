"""Compute a paper's figures anew and set them beside the published ones: `python -m agents.reproduce hassan`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from agents.cli import UsageError, at_least, option, run
from agents.files import check_writable, read_json, write_json, write_text
from agents.report.reproduction import headlines
from agents.reproduce.papers import PAPERS, Job, jobs, run_job
from agents.tables import console, grid_table, throws_bar
from agents.versions import ROOT, versions
from agents.workers import workers

ALL = "all"


@dataclass(frozen=True)
class Arguments:
    """Compute a paper's figures anew and print them beside the published ones.

    Finished parts are kept until the code changes, so an interrupted reproduction goes on where it was.
    """

    paper: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="|".join((*PAPERS, ALL)))]
    """The paper, or all of them."""
    json: Annotated[Path | None, option("none", "FILE")] = None
    """Write every figure to this file."""
    figures: Annotated[Path | None, option("none", "FOLDER")] = None
    """Write the drawings to this folder as SVG."""
    jobs: Annotated[int | None, option("number of CPUs", "N")] = None
    """Processes side by side, one thread each."""
    only: Annotated[tuple[str, ...], option("all parts", "PART")] = ()
    """Names of the parts to do."""
    fresh: bool = False
    """Compute everything, finished parts too."""
    work: Annotated[Path | None, option("runs/reproduce", "DIR")] = None
    """Folder of the finished parts."""


def main(arguments: Arguments) -> None:
    """Do what is missing, write what was asked for, print the tables."""
    chosen = check(arguments)
    work = arguments.work or ROOT / "runs" / "reproduce"
    planned = select([job for paper in chosen for job in jobs(paper)], arguments.only)
    do_missing(planned, work, arguments.jobs or available(), fresh=arguments.fresh)
    found = [(job, read_json(path_of(job, work))) for job in planned]
    record = assemble(f"python -m agents.reproduce {arguments.paper}", found)
    for headline, header, rows in headlines(record):
        console().print(grid_table(headline, header, rows))
    if arguments.json is not None:
        write_json(arguments.json, record)
        console().print(f"all {len(record['rows'])} figures are in {arguments.json}")
    if arguments.figures is not None:
        drawings = {name: text for _, part in found for name, text in part["figures"].items()}
        for name, text in drawings.items():
            write_text(arguments.figures / name, text)
        console().print(f"{len(drawings)} drawings are in {arguments.figures}")


def check(arguments: Arguments) -> tuple[str, ...]:
    """Find mistakes before anything is computed; returns the papers.

    Raises:
        UsageError: an unknown paper, a number out of its range, or a place that cannot be written.
    """
    if arguments.paper not in (*PAPERS, ALL):
        raise UsageError(f"unknown paper {arguments.paper!r}; known are {', '.join((*PAPERS, ALL))}")
    if arguments.jobs is not None:
        at_least("jobs", arguments.jobs, 1)
    if arguments.json is not None:
        check_writable(arguments.json)
    if arguments.figures is not None:
        check_writable(arguments.figures / "drawing.svg")
    return tuple(PAPERS) if arguments.paper == ALL else (arguments.paper,)


def select(planned: list[Job], only: Sequence[str]) -> list[Job]:
    """The parts asked for, all when none is named.

    Raises:
        UsageError: there is no such part.
    """
    names = dict.fromkeys(job.part for job in planned)
    unknown = [name for name in only if name not in names]
    if unknown:
        raise UsageError(f"unknown part {unknown[0]!r}; known are {', '.join(names)}")
    return [job for job in planned if not only or job.part in only]


def available() -> int:
    """CPUs that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def path_of(job: Job, work: Path) -> Path:
    """Where the findings of a part are kept."""
    return work / job.paper / job.file


def do_missing(planned: list[Job], work: Path, processes: int, *, fresh: bool) -> None:
    """Run the parts that are not finished, or all of them, `processes` at a time."""
    missing = [job for job in planned if fresh or not path_of(job, work).is_file()]
    if not missing:
        return
    with workers(min(processes, len(missing))) as pool, throws_bar(console()) as bar:
        task = bar.add_task("parts", total=len(planned), completed=len(planned) - len(missing))
        futures = {pool.submit(run_job, job, work / job.paper): job for job in missing}
        for future in as_completed(futures):
            seconds, job = future.result(), futures[future]
            bar.advance(task)
            bar.console.print(f"done: {job.paper}, {job.part} ({seconds:.0f} s)")


def assemble(command: str, found: list[tuple[Job, dict[str, Any]]]) -> dict[str, Any]:
    """All parts as one record."""
    data: dict[str, dict[str, Any]] = {}
    figures: dict[str, list[str]] = {}
    for job, part in found:
        data.setdefault(job.paper, {}).update(part["data"])
        figures.setdefault(job.paper, []).extend(part["figures"])
    return {
        "command": command,
        "versions": versions(),
        "seconds": {f"{job.paper}/{job.part}": part["seconds"] for job, part in found},
        "papers": list(data),
        "figures": figures,
        "data": data,
        "rows": [row for _, part in found for row in part["rows"]],
    }


if __name__ == "__main__":
    run(main, Arguments, "agents.reproduce")
