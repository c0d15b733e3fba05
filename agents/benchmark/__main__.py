"""Measure every controller on the same held-out throws, or work shifts of a line: `python -m agents.benchmark`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from ..ground.cli import at_least, option, run
from ..ground.outputs import check_writable, deliver_json
from ..ground.places import MADE, SHIPPED
from ..ground.tables import console
from ..ground.versions import versions
from ..jobs.cluster import Needs, pool
from ..jobs.work import do_missing
from ..results.compare import assemble
from ..results.plan import Plan, needs, pieces, read_plan, trial_of_plan
from .kept import KeptRows, choose_pieces, keep_rows
from .run import jobs
from .stored import POLICIES, stored_policies


@dataclass(frozen=True)
class Arguments:
    """Let every controller of a plan learn, evaluate all controllers on the same objects, and compare throw by throw.

    Controllers of a line work the same held-out shifts and are compared shift by shift. Finished pieces are kept and
    not computed again, so an interrupted benchmark goes on where it stopped.
    """

    config: Path = SHIPPED / "configs" / "benchmark.yaml"
    """File of the plan."""
    jobs: int = 2
    """Processes side by side, one thread each."""
    cluster: Annotated[str | None, option("this machine alone", "HOST:PORT|auto")] = None
    """Compute on the machines of a Ray cluster instead of in --jobs processes here: the address of its head."""
    out: Annotated[Path | None, option("results/NAME.json with the plan's name", "FILE")] = None
    """File of all figures and throws."""
    work: Annotated[Path | None, option("runs/benchmark/NAME", "DIR")] = None
    """Folder of the finished pieces."""
    only: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, option("all entries", "LABEL")] = ()
    """Compute only the entry of this label, and keep the other rows of --out; may be given more than once."""


def main(arguments: Arguments) -> None:
    """Compute the missing pieces, write the results, print the tables."""
    at_least(vars(arguments), jobs=1)
    plan = read_plan(arguments.config)
    out = arguments.out or MADE / "results" / f"{plan.name}.json"
    check_writable(out)
    work = arguments.work or MADE / "runs" / "benchmark" / plan.name
    planned = jobs(choose_pieces(pieces(plan), arguments.only))
    kept = keep_rows(out, plan, arguments.only) if arguments.only else KeptRows((), 0.0, {})
    workers = pool(arguments.jobs, arguments.cluster, needs(plan) if arguments.cluster else Needs())
    parts = do_missing(planned, work, workers, unit=f"{trial_of_plan(plan).step}s")
    results = [*kept.rows, *(result for part in parts for result in part["results"])]
    policies = {**kept.policies, **stored_policies(parts)}
    comparison = assemble(plan, results)
    head = {"plan": plan.model_dump(mode="json"), "versions": versions()}
    seconds = kept.seconds + sum(part["seconds"] for part in parts)
    deliver_json(out, {**head, "seconds": seconds, **comparison, POLICIES: policies, "results": results}, indent=None)
    show(plan, comparison["table"])
    console().print(f"all figures and throws are in {out}")


def show(plan: Plan, table: list[dict[str, Any]]) -> None:
    """Print one table per level, with gains over the first reference, or over the first entry."""
    base = next(iter((*plan.references, *plan.entries))).label
    trial = trial_of_plan(plan)
    for level in plan.levels:
        rows = [(row["label"], row["throws"], row) for row in table if row["level"] == level]
        title = f"level {level}, {plan.count_of(trial, level)} {trial.unit} per seed"
        console().print(trial.record.comparison(title, rows, base))


if __name__ == "__main__":
    run(main, Arguments, "agents.benchmark")
