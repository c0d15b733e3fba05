"""Measure every controller on the same held-out throws: `python -m agents.benchmark`."""

from __future__ import annotations

from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from agents.benchmark.cells import run_cell, settle_worker
from agents.benchmark.compare import assemble
from agents.benchmark.plan import Cell, Plan, cells, read_plan
from agents.cli import at_least, option, run
from agents.files import check_writable, read_json, write_json
from agents.tables import comparison_table, console, throws_bar
from agents.versions import ROOT, versions
from agents.workers import workers


@dataclass(frozen=True)
class Arguments:
    """Let every controller of a plan learn, throw the same held-out objects, and compare them throw by throw.

    Finished pieces are kept and not done again, so an interrupted benchmark goes on where it was.
    """

    config: Path = ROOT / "configs" / "benchmark.yaml"
    """The plan."""
    jobs: int = 2
    """Processes side by side, one thread each."""
    out: Annotated[Path | None, option("results/NAME.json with the plan's name", "FILE")] = None
    """Where all figures and throws go."""
    work: Annotated[Path | None, option("runs/benchmark/NAME", "DIR")] = None
    """Folder of the finished pieces."""


def main(arguments: Arguments) -> None:
    """Do what is missing, write the results, print the tables."""
    at_least("jobs", arguments.jobs, 1)
    plan = read_plan(arguments.config)
    out = arguments.out or ROOT / "results" / f"{plan.name}.json"
    check_writable(out)
    work = arguments.work or ROOT / "runs" / "benchmark" / plan.name
    work.mkdir(parents=True, exist_ok=True)
    planned = cells(plan)
    do_missing(planned, work, arguments.jobs)
    parts = [read_json(path_of(cell, work)) for cell in planned]
    results = [result for part in parts for result in part["results"]]
    found = assemble(plan, results)
    write_json(
        out,
        {
            "plan": plan.model_dump(mode="json"),
            "versions": versions(),
            "seconds": sum(part["seconds"] for part in parts),
            **found,
            "results": results,
        },
        indent=None,
    )
    show(plan, found["table"])
    console().print(f"all figures and throws are in {out}")


def path_of(cell: Cell, work: Path) -> Path:
    """Where a finished cell is kept."""
    return work / f"{cell.name}.json"


def do_missing(planned: list[Cell], work: Path, jobs: int) -> None:
    """Run the cells that are not finished, `jobs` at a time.

    Raises:
        UsageError: a worker died, for instance for lack of memory.
    """
    missing = [cell for cell in planned if not path_of(cell, work).is_file()]
    if not missing:
        return
    with workers(jobs, settle_worker) as pool, throws_bar(console()) as bar:
        task = bar.add_task("throws", total=sum(cell.cost for cell in missing))
        futures = {pool.submit(run_cell, cell, work): cell for cell in missing}
        for future in as_completed(futures):
            future.result()
            cell = futures[future]
            bar.advance(task, cell.cost)
            bar.console.print(f"done: {cell.entry.label}, {cell.throws[-1]} throws, seed {cell.seed}")


def show(plan: Plan, table: list[dict[str, Any]]) -> None:
    """One table per level."""
    for level in plan.levels:
        rows = [(row["label"], row["throws"], row) for row in table if row["level"] == level]
        console().print(comparison_table(f"level {level}, {plan.picks} throws per seed", rows))


if __name__ == "__main__":
    run(main, Arguments, "agents.benchmark")
