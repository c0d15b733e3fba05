"""Measure what a plan asks for: controllers on the same held-out throws or work shifts, or a study of cases."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from ..ground.cli import UsageError, at_least, option, run
from ..ground.cluster import Needs, pool
from ..ground.places import MADE, SHIPPED
from ..ground.tables import console
from ..ground.work import keep_missing
from ..results import study
from ..results.plan import read_plan
from ..results.study import StudyPlan
from .comparison import Comparison
from .study import Study


@dataclass(frozen=True)
class Arguments:
    """Let every controller of a plan learn, evaluate all controllers on the same objects, and compare throw by throw.

    Controllers of a line work the same held-out shifts and are compared shift by shift. Finished pieces are kept and
    not computed again, so an interrupted benchmark goes on where it stopped. In a checkout the plan may be that of a
    study, whose cases functions of benchmarks/studies measure.
    """

    config: Path = SHIPPED / "configs" / "benchmark.yaml"
    """File of the plan."""
    jobs: int = 2
    """Processes side by side, one thread each."""
    cluster: Annotated[str | None, option("this machine alone", "HOST:PORT|auto")] = None
    """Compute on the machines of a Ray cluster instead of in --jobs processes here: the address of its head."""
    out: Annotated[Path | None, option("results/NAME.json with the plan's name", "FILE")] = None
    """File of all figures; throws and policies lie in the folder of its name beside it."""
    work: Annotated[Path | None, option("runs/benchmark/NAME", "DIR")] = None
    """Folder of the finished pieces."""
    only: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, option("all entries", "LABEL")] = ()
    """Compute only the entry of this label, of a study the part of this name, and keep the other rows of --out; may be
    given more than once."""
    missing: bool = False
    """Of a study: measure only cases of which --out has no row, as after axes of the plan have grown."""
    data: Annotated[Path | None, option("none", "DIR")] = None
    """Folder of measured data, for a study that compares with some."""


def main(arguments: Arguments) -> None:
    """Compute the missing pieces, write the results, print them."""
    at_least(vars(arguments), jobs=1)
    plan = study.read(arguments.config) if study.is_plan(arguments.config) else read_plan(arguments.config)
    out = arguments.out or MADE / "results" / f"{plan.name}.json"
    work = arguments.work or MADE / "runs" / "benchmark" / plan.name
    only = arguments.only
    is_study = isinstance(plan, StudyPlan)
    if arguments.data is not None and not (is_study and plan.needs_data):
        raise UsageError(f"--data is for studies that compare with measured data; {str(arguments.config)!r} has none")
    if arguments.missing and not is_study:
        raise UsageError(f"--missing is for studies; {str(arguments.config)!r} is the plan of a comparison")
    planned = (
        Study(plan, out, only, arguments.data, is_missing=arguments.missing)
        if is_study
        else Comparison(plan, out, only)
    )
    workers = pool(arguments.jobs, arguments.cluster, planned.needs() if arguments.cluster else Needs())
    planned.write(keep_missing(planned.jobs, work, workers, unit=planned.unit))
    console().print(f"all figures and throws are in {out}")


if __name__ == "__main__":
    run(main, Arguments, "agents.benchmark")
